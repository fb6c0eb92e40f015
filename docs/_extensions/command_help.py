"""The help of every command, where a page has ``<!-- commands -->``."""

import os
from collections.abc import Iterator

from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata

__all__ = ["setup"]

MARK = "<!-- commands -->"


def setup(app: Sphinx) -> ExtensionMetadata:
    """Fill the page in as it is read."""
    app.connect("source-read", _fill_in)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _fill_in(_app: Sphinx, _document: str, source: list[str]) -> None:
    if MARK in source[0]:
        source[0] = source[0].replace(MARK, "\n".join(_sections()))


def _sections() -> Iterator[str]:
    from stickslip.common.extras import optional_import

    with optional_import():
        import typer

    from stickslip.commands import app

    os.environ["COLUMNS"] = "90"
    program = typer.main.get_command(app)
    context = program.make_context("stickslip", ["list"], resilient_parsing=True)
    for name in program.list_commands(context):
        command = program.get_command(context, name)
        with command.make_context(name, [], parent=context, resilient_parsing=True) as inner:
            yield f"## {name}\n\n```text\n{command.get_help(inner)}\n```\n"
