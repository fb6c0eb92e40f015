"""``stickslip explore``."""

from typing import Annotated

from ..common.extras import optional_import
from ..common.validation import whole_number
from .options import groups_of, GroupsOption

with optional_import():
    import typer

__all__ = ["explore"]


def explore(
    port: Annotated[int, typer.Option(help="Where the page is served, to this machine alone; 0 for any.")] = 5080,
    open_browser: Annotated[bool, typer.Option("--open/--no-open", help="Open it in the browser.")] = True,
    preset: Annotated[str, typer.Option(help="What to begin with, by name.")] = "fastest-word",
    groups: GroupsOption = None,
) -> None:
    """Play with the crawler on a page in the browser: sliders, words, the space bar, policies, and what comes of it."""
    whole_number("--port", port, 0, 65535)
    from ..crawler import Groups
    from ..explore import preset as preset_of
    from ..explore import setup_of
    from ..explore.page.server import serve

    setup = preset_of(preset)
    if groups is not None:
        setup = setup_of(Groups.of(groups_of(groups)).to_dict(), setup)
    serve(setup, port, open_browser, typer.echo)
