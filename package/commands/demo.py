"""``stickslip demo``."""

from pathlib import Path
from typing import Annotated

from ..common.extras import optional_import
from ..common.validation import whole_number

with optional_import():
    import typer

__all__ = ["demo"]


def demo(
    output: Annotated[Path, typer.Option(help="Folder of the report.")] = Path("runs/demo"),
    seed: Annotated[int, typer.Option(help="Of everything random.")] = 0,
    steps: Annotated[int | None, typer.Option(help="Steps of each training, instead of the file's.")] = None,
) -> None:
    """See the crawler crawl, its memory measured, its tasks benchmarked and two policies trained."""
    from ..demo import run_demo

    if steps is not None:
        whole_number("--steps", steps, 1)
    # The benchmark takes the four seeds that follow as well.
    run_demo(output, whole_number("--seed", seed, 0, 2**32 - 5), steps)
