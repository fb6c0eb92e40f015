"""The page that shows all that the demo made."""

import re
from importlib import resources
from pathlib import Path
from typing import Any

from ..common.extras import optional_import
from ..common.files import write_text

__all__ = ["write_page"]

_UNIT = re.compile(r"\b([zt])_c\b")
_ARROW = re.compile(r" ([↑↓])")


def write_page(file: Path, **content: Any) -> None:
    """Write the page, whole or not at all.

    Parameters
    ----------
    file : Path
        Beside the figures and the clip that it shows.
    **content
        What ``page.html.jinja`` names.
    """
    with optional_import():
        import jinja2
        from markupsafe import escape, Markup

    def units(text: object) -> Markup:
        """Units as they are written: a subscript where plain text has `_`, and an arrow stays with its word."""
        return Markup(_ARROW.sub(r"&nbsp;\1", _UNIT.sub(r"\1<sub>c</sub>", str(escape(text)))))

    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True)
    environment.filters["units"] = units
    template = environment.from_string((resources.files(__package__) / "page.html.jinja").read_text("utf-8"))
    page = template.render(**content)
    write_text(file, page)
