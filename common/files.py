"""Files written whole or not at all."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

__all__ = ["atomically"]


def atomically(path: Path, write: Callable[[Path], Any]) -> None:
    """Have a file written whole or not at all.

    Parameters
    ----------
    path : Path
        Where the file is to be.
    write : callable
        Writes it at the path it is given, in the same folder and with the same suffix.
    """
    temporary = path.with_name(f".{path.stem}-{os.getpid()}{path.suffix}")
    try:
        write(temporary)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
