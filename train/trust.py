"""Which pickles are read: those one is told to trust, and for going on with a run those that the user wrote.

Stable-Baselines3's zips and replay buffers are unpickled, and whoever wrote a pickle runs what they like in the process
that reads it. So the digest of each that a training writes is noted in a file of the user's own, outside the run's
folder: a run is gone on with where every pickle that is needed for it is among those, byte for byte, wherever the
folder lies now and whoever had it in between. There is no key that could be stolen or left in a run's folder, and
nothing to ask the user; who resumes on another machine, or another's run, has to say that it is trusted.
"""

import io
import os
import sys
from collections.abc import Callable
from hashlib import file_digest, sha256
from pathlib import Path
from typing import Any

from ..common.files import atomically

__all__ = ["read_pickle", "record", "write_pickle"]


def record() -> Path:
    """The file that notes what this user wrote: a SHA-256 digest a line.

    It lies in the folder ``stickslip`` of ``$XDG_STATE_HOME``, which is ``~/.local/state`` where that is not set, or of
    ``%LOCALAPPDATA%`` on Windows.
    """
    variable = "LOCALAPPDATA" if sys.platform == "win32" else "XDG_STATE_HOME"
    told = Path(os.environ.get(variable, ""))
    # The specification has relative paths ignored.
    return (told if told.is_absolute() else Path.home() / ".local" / "state") / "stickslip" / "written"


def write_pickle(path: Path, write: Callable[[Path], Any]) -> None:
    """Have a pickle written whole or not at all, and noted as the user's own before it is there.

    Where nothing can be noted the file is written nevertheless, and is another's.

    Parameters
    ----------
    path : Path
    write : callable
        As for `stickslip.common.files.atomically`.
    """

    def written(temporary: Path) -> None:
        write(temporary)
        with temporary.open("rb") as file:
            _note(file_digest(file, "sha256").hexdigest())

    atomically(path, written)


def read_pickle(file: Path, *, trust: bool, own: bool = False) -> io.BytesIO:
    """Content of a file that is about to be unpickled.

    Parameters
    ----------
    file : Path
    trust : bool
        Whether the user said that whoever wrote it is trusted.
    own : bool
        Whether what this user wrote is read without that.

    Returns
    -------
    io.BytesIO
        What was looked at, and not what may stand in the file later.

    Raises
    ------
    ValueError
        If it is not trusted.
    OSError
        If it cannot be read.
    """
    content = file.read_bytes()
    if not trust and not (own and _noted(sha256(content).hexdigest())):
        whose = " and was not written by you on this machine" if own else ""
        raise ValueError(
            f"{file} must be trusted to be read: it is a pickle, which runs what its writer likes{whose}; set trust "
            "(--trust) if you know who wrote it"
        )
    return io.BytesIO(content)


def _note(digest: str) -> None:
    place = record()
    try:
        place.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        # One write, which no other process's can come between; what is left of one that was cut ends its line.
        descriptor = os.open(place, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o600)
        try:
            os.write(descriptor, f"\n{digest}\n".encode())
        finally:
            os.close(descriptor)
    except OSError:
        pass


def _noted(digest: str) -> bool:
    try:
        return digest in record().read_text(encoding="ascii", errors="replace").split()
    except OSError:
        return False
