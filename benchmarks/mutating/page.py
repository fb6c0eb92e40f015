"""The page of how many faults the tests notice, from the results of the trials."""

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from .sampling import IN_A_BROWSER

__all__ = ["page", "wilson"]

NOTICED = ("noticed", "hung")
AIMS = {"crawler": 0.97}
AIM = 0.9
Z = 1.959963984540054  # of 95%

_WORDS = """# Do the tests notice?

A fault is put into the code, one at a time, and the tests of its folder are run, but for files of tests that do not
run its line, as far as that can be seen. A fault is something that somebody could have written: a comparison, sign or
number that is off, an argument forgotten or in the wrong place, a label swapped, a copy, refusal or store left out.
Lines are drawn alike, and a fault of each. Faults that nobody could notice are declared, with the reason, in
`benchmarks/mutating/equivalent.toml`, and do not count. The aim is 90% of the others in every folder, and 97% in
`crawler/`. What only a browser can judge, `{browser}`, is left out: its tests are slow ones.

Tests were written for what survived, and so the score of the faults tried is that of the tests of now on faults that
they partly were written for. *At first sight* counts each as it came out when it was first tried: it is a fair sample
of the tests as they stood then, and what the tests of now would do with faults not drawn yet lies between the two.

`{command}` tried them on the revisions that the table names, and
`python benchmarks/mutation.py --page` wrote this page, with seed {seed}; brackets are Wilson's 95% intervals. Without
`--page` it tries more, and goes on where it stopped. After a change of a module, or of the tests of its folder, its
faults are tried anew. A revision that is `-dirty` had what was written for its survivors, too."""


def wilson(noticed: int, tried: int) -> tuple[float, float]:
    """Wilson's 95% interval of a rate (Wilson 1927, https://doi.org/10.1080/01621459.1927.10502953).

    Returns
    -------
    tuple of float
        Lower and upper end, in [0, 1]; that is all of it where nothing was tried.
    """
    if tried == 0:
        return 0.0, 1.0
    rate, spread = noticed / tried, Z * Z / tried
    middle = rate + spread / 2
    half = math.sqrt(spread * (rate * (1 - rate) + spread / 4))
    return max(0.0, (middle - half) / (1 + spread)), min(1.0, (middle + half) / (1 + spread))


def page(results: Mapping[str, Any]) -> str:
    """The whole page, from what ``benchmarks/results/mutation.json`` holds."""
    folders: Mapping[str, Any] = results["folders"]
    faults = [fault for folder in folders.values() for fault in folder]
    survivors = [fault for fault in faults if fault["status"] == "survived"]
    parts = [
        _WORDS.format(command=results["command"], seed=results["seed"], browser=IN_A_BROWSER),
        "## By folder",
        _by_folder(folders, results["revisions"]),
        "## By kind of fault",
        _by_kind(faults),
        "## What survived",
        _list(survivors) or "Nothing.",
        "## What nobody could notice",
        "\n".join(f"- `{each['file']}`: {_change(each)}. {each['reason']}" for each in results["equivalent"])
        or "Nothing is declared.",
    ]
    return "\n\n".join(parts) + "\n"


def save(path: Path, text: str) -> None:
    """Write the page, whole or not at all."""
    from stickslip.common.files import atomically

    atomically(path, lambda unfinished: unfinished.write_text(text, encoding="utf-8"))


def _by_folder(folders: Mapping[str, Sequence[Mapping[str, Any]]], revisions: Mapping[str, str]) -> str:
    columns = ["faults", "noticed", "of these by a hang", "survived", "no test reaches", "equivalent", "score"]
    columns += ["at first sight", "aim"]
    rows = [f"| folder | {' | '.join(columns)} | revision |", f"|---|{'---:|' * len(columns)}---|"]
    for name, faults in folders.items():
        rows.append(f"| `{name}/` | {_counts(faults)} | {AIMS.get(name, AIM):.0%} | {revisions[name]} |")
    rows.append(f"| all | {_counts([fault for faults in folders.values() for fault in faults])} | | |")
    return "\n".join(rows)


def _counts(faults: Sequence[Mapping[str, Any]]) -> str:
    said = [fault["status"] for fault in faults]
    survived = [fault for fault in faults if fault["status"] == "survived"]
    unreached = sum(fault["reached"] is False for fault in survived)
    numbers = [len(said), _noticed(faults), said.count("hung"), len(survived), unreached, said.count("equivalent")]
    return " | ".join([*map(str, numbers), _score(faults), _score(faults, "first")])


def _by_kind(faults: Sequence[Mapping[str, Any]]) -> str:
    kinds = sorted({fault["kind"] for fault in faults})
    rows = ["| kind | tried | score |", "|---|---:|---:|"]
    for kind in kinds:
        own = [fault for fault in faults if fault["kind"] == kind and fault["status"] != "equivalent"]
        rows.append(f"| {kind} | {len(own)} | {_score(own)} |")
    return "\n".join(rows)


def _score(faults: Sequence[Mapping[str, Any]], said: str = "status") -> str:
    counted = [fault for fault in faults if fault["status"] != "equivalent"]
    if not counted:
        return "-"
    noticed = _noticed(counted, said)
    low, high = wilson(noticed, len(counted))
    return f"{noticed / len(counted):.0%} [{low:.0%}, {high:.0%}]"


def _noticed(faults: Iterable[Mapping[str, Any]], said: str = "status") -> int:
    return sum(fault[said] in NOTICED for fault in faults)


def _list(survivors: Sequence[Mapping[str, Any]]) -> str:
    rows = []
    for fault in survivors:
        words = [fault["kind"]]
        if fault["reached"] is False:
            words.append("no test of the folder reaches the line")
        if fault.get("above"):
            words.append(f"noticed by `{fault['above']}`")
        rows.append(f"- `{fault['file']}:{fault['line']}` ({'; '.join(words)}): {_change(fault)}")
    return "\n".join(rows)


def _change(fault: Mapping[str, Any]) -> str:
    before, after = (" ".join(fault[text].split()) for text in ("before", "after"))
    return f"`{before}` became `{after}`"
