"""A folder of results, kept one by one so that a crash loses nothing that was finished."""

import json
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from .files import write_text
from .fingerprint import described, refuse_other

__all__ = ["Kept"]

_SETTINGS = "settings"


class Kept:
    """A folder of results, a JSON file each, beside the settings that they were made with.

    Parameters
    ----------
    folder : Path
        Of the results, inside that of the run. Made if it is missing.
    settings : mapping
        What must be equal for results to belong together, as in `stickslip.common.fingerprint`.
    resume : bool
        Whether to go on from what the folder holds.
    growing : collection of str
        Mappings in the settings to which names may be added: what they name must be equal where the folder has it
        already.

    Raises
    ------
    ValueError
        If the folder holds results and is not to be resumed, they were made with other settings, or a file is no JSON.
    """

    def __init__(
        self, folder: Path, settings: Mapping[str, Any], *, resume: bool = False, growing: Collection[str] = ()
    ) -> None:
        self._folder = folder
        wanted = described(settings)
        kept = folder / f"{_SETTINGS}.json"
        if kept.exists() and (resume or self._files()):
            if not resume:
                raise ValueError(f"{folder.parent} holds a run already: resume it, or choose another folder")
            found = _read(kept)
            refuse_other(f"to go on with the run in {folder.parent}", found, wanted, growing=growing)
            wanted |= {name: {**found[name], **wanted[name]} for name in growing if name in wanted}
            if wanted == found:
                return
        folder.mkdir(parents=True, exist_ok=True)
        self._write(_SETTINGS, wanted)

    def keep(self, name: str, result: Any) -> None:
        """Write a result, whole or not at all.

        Parameters
        ----------
        name : str
            Good for a file: without a suffix, other than "settings", and not begun with a dot.
        result : object
            As JSON holds it.
        """
        self._write(name, result)

    def load(self) -> dict[str, Any]:
        """All results in the folder, by name."""
        return {file.stem: _read(file) for file in self._files()}

    def _files(self) -> list[Path]:
        # One that starts with a dot was being written when its process was killed.
        return [file for file in sorted(self._folder.glob("[!.]*.json")) if file.stem != _SETTINGS]

    def _write(self, name: str, content: Any) -> None:
        text = json.dumps(content) + "\n"
        write_text(self._folder / f"{name}.json", text)


def _read(file: Path) -> Any:
    """What a file holds: whole, since they are written so, unless something else has written it."""
    try:
        return json.loads(file.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(f"{file} is no JSON: delete it, or choose another folder") from error
