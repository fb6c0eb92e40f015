"""Results of trials, one a line of JSON, written as they come; and faults declared to change nothing."""

import contextlib
import json
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .operators import Mutant, mutants

__all__ = ["Equivalents", "added", "fault_of", "first_seen", "key", "known"]


def key(file: str, mutant: Mutant, source: str) -> str:
    """Names a trial: the fault, and the digest of the module."""
    return f"{file}:{mutant.begin}-{mutant.end}:{mutant.text.decode()}|{source}"


def known(path: Path) -> dict[str, dict[str, Any]]:
    """Results by key, the last of each; a line that was cut off is left out."""
    return {result["key"]: result for result in _all(path)}


def first_seen(path: Path) -> dict[tuple[str, ...], str]:
    """What came of each fault when it was tried for the first time, whatever the code and the tests were then."""
    statuses: dict[tuple[str, ...], str] = {}
    for result in _all(path):
        statuses.setdefault(fault_of(result), result["status"])
    return statuses


def fault_of(result: Mapping[str, Any]) -> tuple[str, ...]:
    """What tells a fault from all others, wherever its line has moved to."""
    return tuple(result[name] for name in ("file", "kind", "before", "after"))


def _all(path: Path) -> Iterator[dict[str, Any]]:
    for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else []:
        with contextlib.suppress(json.JSONDecodeError):
            yield json.loads(line)


def added(path: Path, result: Mapping[str, Any]) -> None:
    """Append a result: one write, so that what two processes write does not mix."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", encoding="utf-8") as file:
        file.write(json.dumps(result) + "\n")


@dataclass(frozen=True)
class Equivalents:
    """Faults that no test can notice, each with the reason.

    Parameters
    ----------
    entries : sequence of mapping
        "file", "before" and "after" (the whole lines, as ``--list`` prints them), and "reason".
    """

    entries: Sequence[Mapping[str, str]]

    @classmethod
    def read(cls, path: Path) -> "Equivalents":
        """Those of a file of TOML."""
        return cls(tomllib.loads(path.read_text(encoding="utf-8")).get("equivalent", []))

    def reason(self, file: str, before: str, after: str) -> str:
        """Why a fault changes nothing; empty if it may change something."""
        fault = (file, before, after)
        same = (each for each in self.entries if (each["file"], each["before"].strip(), each["after"].strip()) == fault)
        return next((each["reason"] for each in same), "")

    def gone(self, root: Path) -> list[str]:
        """Entries that are no fault of today's code, or give no reason."""
        wrong = []
        for each in self.entries:
            file, before, after = each["file"], each["before"].strip(), each["after"].strip()
            made = mutants((root / file).read_bytes()) if (root / file).is_file() else []
            if not each.get("reason") or not any((m.before, m.after) == (before, after) for m in made):
                wrong.append(f"{file}: {before} -> {after}")
        return wrong
