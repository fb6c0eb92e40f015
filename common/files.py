"""Files written whole or not at all."""

import os
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

__all__ = ["atomically", "write_text"]


def atomically(path: Path, write: Callable[[Path], Any]) -> None:
    """Have a file written whole or not at all.

    Parameters
    ----------
    path : Path
        Where the file is to be.
    write : callable
        Writes it at the path it is given, in the same folder and with the same suffix.
    """
    writer = f"{os.getpid()}-{threading.get_ident()}"
    temporary = path.with_name(f".{path.stem}-{writer}{path.suffix}")
    try:
        write(temporary)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a file of text in UTF-8, whole or not at all."""
    atomically(path, lambda unfinished: unfinished.write_text(text, encoding="utf-8"))
