"""What commands print: bars while they work, tables and files at the end."""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..common.extras import optional_import
from ..common.files import write_text

with optional_import():
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.measure import Measurement
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )
    from rich.table import Table

__all__ = ["print_table", "print_whole", "progress", "say", "write_json"]


@contextmanager
def progress(description: str) -> Iterator[Callable[..., None]]:
    """A bar on standard error, told how much is done, of how much, and what comes next if that is worth a word.

    It appears when it is told first: what is refused is refused without a bar above it.
    """
    bar = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True),
    )
    task = bar.add_task(description)

    def show(done: int, of: int, doing: str = description) -> None:
        bar.start()
        bar.update(task, completed=done, total=of, description=doing)

    try:
        yield show
    finally:
        if bar.live.is_started:
            bar.stop()


def say(*lines: str) -> None:
    """Print lines, folded to the terminal's width."""
    console = Console()
    for line in lines:
        console.print(line, highlight=False)


def print_table(title: str, rows: list[list[str]]) -> None:
    """Print a table under its title; the first row is of headings, the first column of names."""
    table = Table(box=SIMPLE_HEAD, padding=(0, 1))
    for index, heading in enumerate(rows[0]):
        table.add_column(heading, justify="right" if index else "left", no_wrap=True)
    for row in rows[1:]:
        table.add_row(*row)
    Console().print(title, highlight=False, soft_wrap=True)
    print_whole(table)


def print_whole(table: Table) -> None:
    """Print a table in its full width: wider than the terminal it is better scrolled or piped than cut."""
    console = Console()
    wide = Measurement.get(console, console.options.update(max_width=1000), table).maximum
    Console(width=max(console.width, wide)).print(table)


def write_json(file: Path, value: dict[str, Any], *, indent: int) -> None:
    """Write a file whole or not at all."""
    text = json.dumps(value, indent=indent) + "\n"
    write_text(file, text)
