"""Faults put into the code one at a time, and how many of them the tests notice.

Run ``python benchmarks/mutation.py --folder tasks --count 40 --seed 1``. Each fault is something that somebody could
have written: a comparison, sign or number that is off, an argument forgotten or in the wrong place, a label or field
swapped, a copy, refusal or store left out (`benchmarks/mutating/operators.py`). Lines are drawn alike, and a fault of
each. It is tried in a throw-away copy of the checkout, by the tests of its folder, those that reach its line first;
with ``--thorough`` by those of the folders above too where nothing noticed. Results go to
``runs/mutation/trials.jsonl`` as they come, and what was tried with the same module and tests is not tried again.
``--list`` only prints the faults; ``--changed main`` takes those of the lines changed since a revision. Without
``--folder`` or ``--only`` all folders are tried, ``--minutes`` bounds each. ``--page`` writes ``docs/mutation.md`` from
what was tried: of the folder that is asked for, or of all, the first faults of the seed, as many as have a result with
the modules and tests of now.

Why not a tool that is there: mutmut 3 calls every function through a trampoline that chooses the variant at run time,
which numba cannot compile, and copies the folders it is told without the links by which this package is put together.
cosmic-ray edits the checkout in place, where others work, and its operators know no forgotten argument, swapped label,
missing copy or missing refusal. Neither knows that kernels have to be kept apart by what they were compiled from.
"""

import argparse
import json
import os
import signal
import sys
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

from mutating.campaign import Campaign, FOLDERS, shown
from mutating.page import page, save
from mutating.records import Equivalents
from mutating.sampling import changed_lines, drawn, files_of, revision

ROOT = Path(__file__).parents[1]
TRIALS = ROOT / "runs" / "mutation" / "trials.jsonl"
EQUIVALENTS = Path(__file__).parent / "mutating" / "equivalent.toml"
RESULTS = Path(__file__).parent / "results" / "mutation.json"
PAGE = ROOT / "docs" / "mutation.md"
COUNT = 40


def main() -> None:
    """Try or list the faults that are asked for, or write the page."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # so that the copies are removed
    asked = arguments()
    equivalents = Equivalents.read(EQUIVALENTS)
    if asked.page:
        write_page(asked, equivalents)
        return
    lines = changed_lines(ROOT, asked.changed) if asked.changed else None
    for folder, files in places(asked):
        faults = islice(drawn(ROOT, files, asked.seed, lines), asked.count)
        if asked.list:
            for file, mutant in faults:
                print(shown(file, mutant))
            continue
        campaign = Campaign(ROOT, TRIALS, equivalents, folder, asked.tests, asked.thorough, asked.patience)
        results = campaign.run(faults, asked.jobs, asked.minutes)
        statuses = [result["status"] for result in results]
        counted = len(statuses) - statuses.count("equivalent")
        noticed = counted - statuses.count("survived")
        print(f"{folder}: {noticed} of {counted} noticed, {len(statuses) - counted} equivalent", flush=True)


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Put faults into the code and see whether the tests notice.")
    parser.add_argument("--folder", choices=FOLDERS, help="faults in this folder; all folders if left out")
    parser.add_argument("--only", metavar="FILE", action="append", help="faults in this file; may be repeated")
    parser.add_argument("--changed", metavar="REV", help="faults in lines changed since this revision")
    parser.add_argument("--count", type=int, help=f"faults by folder ({COUNT}, or no bound with --minutes)")
    parser.add_argument("--minutes", type=float, help="begin no trial in a folder after so many minutes of trials")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--tests", metavar="FILE", nargs="+", help="run these test files instead of the folder's")
    parser.add_argument("--thorough", action="store_true", help="then run the tests of the folders above, too")
    parser.add_argument("--patience", type=float, help="seconds a test may take beyond ten times the usual")
    parser.add_argument("--jobs", type=int, default=1, help="trials at once")
    parser.add_argument("--list", action="store_true", help="print the faults and try none")
    parser.add_argument("--page", action="store_true", help="write docs/mutation.md from what was tried")
    asked = parser.parse_args()
    if asked.count is None and asked.minutes is None and not asked.list:
        asked.count = COUNT
    return asked


def places(asked: argparse.Namespace) -> Iterator[tuple[str, list[str]]]:
    """The folders that are asked for, and their modules."""
    only = [Path(os.path.relpath(Path(file).resolve(), ROOT.resolve())).as_posix() for file in asked.only or []]
    for folder in [asked.folder] if asked.folder else FOLDERS:
        files = [file for file in files_of(ROOT, folder) if not only or file in only]
        if files:
            yield folder, files


def write_page(asked: argparse.Namespace, equivalents: Equivalents) -> None:
    """Keep the results that stand, those of other folders as they are kept for this seed, and write the page."""
    from measuring import keep, machine  # slow to import

    kept = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else {}
    if kept.get("seed") != asked.seed:
        kept = {}
    revisions: dict[str, str] = kept.get("revisions", {})
    folders: dict[str, list[dict[str, Any]]] = kept.get("folders", {})
    for folder, files in places(asked):
        revisions[folder], folders[folder] = revision(ROOT), []
        for _, _, result in Campaign(ROOT, TRIALS, equivalents, folder).known(drawn(ROOT, files, asked.seed)):
            if result is None:
                break
            folders[folder].append(
                {name: value for name, value in result.items() if name not in ("key", "seconds", "stamp")}
            )
    results = {
        "machine": machine("pytest", "hypothesis"),
        "command": f"python benchmarks/mutation.py --seed {asked.seed} --minutes N",
        "seed": asked.seed,
        "revisions": {folder: revisions.get(folder, "none yet") for folder in FOLDERS},
        "folders": {folder: folders.get(folder, []) for folder in FOLDERS},
        "equivalent": list(equivalents.entries),
    }
    keep(RESULTS, results)
    save(PAGE, page(results))
    print(f"wrote {PAGE} from {sum(map(len, folders.values()))} faults")


if __name__ == "__main__":
    main()
