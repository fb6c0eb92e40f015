"""Which pages show numbers that the tasks, measures or reservoirs of today would not give.

Run ``python benchmarks/stale.py``: it names each such page, what has changed, and the command that makes the page
again, and exits with 1 if there is one. The suite runs it too. What a page was made with is in its JSON as probes,
scores of small reservoirs on short draws (`stickslip.studies.benchmark.probe`); of other pages a few numbers are
measured again.
"""

import json
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import remeasured

from stickslip.common.fingerprint import differences
from stickslip.studies.benchmark.probe import reservoir_probe, task_probe
from stickslip.tasks import known_reservoirs, MEASURES, TASKS

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "benchmarks" / "results"
PAGES = {
    "laboratory.json": ("docs/reservoir.md and README.md", "python benchmarks/laboratory.py"),
    "search.json": ("docs/best.md", "python benchmarks/best.py"),
}
"""Pages and commands by the file that keeps their numbers."""
REMEASURED = {
    "trust.json": ("docs/trust.md", "python benchmarks/trust.py --fresh", remeasured.of_trust),
    "memory_reward.json": ("docs/reward.md", "python benchmarks/memory_reward.py", remeasured.of_reward),
    "encodings.json": ("docs/encodings.md", "python benchmarks/encodings.py", remeasured.of_encodings),
}
"""Likewise, with what measures some of the numbers again."""


def kept_probes(results: Any) -> Iterator[tuple[str, str, Any]]:
    """What of "tasks" and "reservoirs" a file of results was made with: kind, name and probe."""
    if not isinstance(results, Mapping):
        return
    for name, value in results.items():
        if name in ("probes", "made for"):
            for kind in ("tasks", "reservoirs"):
                for each, entry in value[kind].items():
                    yield kind, each, entry["probe"]
        else:
            yield from kept_probes(value)


def changes(results: Any) -> list[str]:
    """What a file of results was made with and is otherwise today."""
    tasks, reservoirs = {**TASKS, **MEASURES}, known_reservoirs()
    kept = list(kept_probes(results))
    today: dict[tuple[str, str], Any] = {}
    for kind, name, _ in kept:
        if (kind, name) in today:
            continue
        if kind == "tasks":
            today[kind, name] = task_probe(tasks[name]) if name in tasks else None
        elif name in reservoirs:  # others are a page's own, of numbers that it shows
            today[kind, name] = reservoir_probe(reservoirs[name])
    found = {
        f"{name}: {difference.kept} then, {difference.asked} today"
        for kind, name, probe in kept
        if (kind, name) in today
        for difference in differences({"probe": probe}, {"probe": today[kind, name]})
    }
    return sorted(found) if kept else ["no probes were kept"]


def stale(folder: Path = RESULTS) -> list[str]:
    """A sentence for each page that is to be made again."""
    sentences = []
    for file, (pages, command) in PAGES.items():
        changed = changes(json.loads((folder / file).read_text(encoding="utf-8")))
        if changed:
            sentences.append(f"{pages}: run `{command}` ({'; '.join(changed)})")
    for file, (pages, command, again) in REMEASURED.items():
        kept = json.loads((folder / file).read_text(encoding="utf-8"))
        changed = [
            f"{name}: {was} then, {now} today"
            for name, was, now in again(kept)
            if differences({"probe": was}, {"probe": now})
        ]
        if changed:
            sentences.append(f"{pages}: run `{command}` ({'; '.join(changed)})")
    return sentences


if __name__ == "__main__":
    found = stale()
    print("\n".join(found) or "no page is stale")
    sys.exit(bool(found))
