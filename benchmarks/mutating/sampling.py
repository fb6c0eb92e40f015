"""Which faults are tried: lines are drawn alike, then one of a line's faults."""

import hashlib
import re
import subprocess
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from .operators import Mutant, mutants
from .source import same_code

__all__ = ["IN_A_BROWSER", "changed_lines", "drawn", "files_of", "revision", "tracked"]

Place = tuple[str, Mutant]  # file, fault
IN_A_BROWSER = "explore/page/"


def tracked(root: Path, *folders: str) -> list[str]:
    """Files and links that git knows or would, relative to the checkout."""
    command = ["git", "-C", str(root), "ls-files", "-z", "--cached", "--others", "--exclude-standard", "--", *folders]
    listed = subprocess.run(command, capture_output=True, check=True).stdout.decode().split("\0")
    return sorted({file for file in listed if file and ((root / file).exists() or (root / file).is_symlink())})


def files_of(root: Path, folder: str) -> list[str]:
    """The modules of a folder, but for those that only a browser can judge, whose tests are slow ones."""
    return [file for file in tracked(root, folder) if file.endswith(".py") and not file.startswith(IN_A_BROWSER)]


def revision(root: Path) -> str:
    """The commit that the checkout stands on, and whether it has changes of its own."""
    command = ["git", "-C", str(root), "describe", "--always", "--dirty", "--abbrev=10"]
    return subprocess.run(command, capture_output=True, check=True).stdout.decode().strip()


def changed_lines(root: Path, revision: str) -> dict[str, set[int]]:
    """Lines by file that are not as they were at a revision."""
    command = ["git", "-C", str(root), "diff", "--unified=0", "--no-ext-diff", "--no-renames", revision, "--"]
    lines: dict[str, set[int]] = defaultdict(set)
    file = ""
    for row in subprocess.run(command, capture_output=True, check=True).stdout.decode().splitlines():
        if row.startswith("+++ "):
            file = row.removeprefix("+++ ").removeprefix("b/")
        elif stretch := re.match(r"@@ -\S+ \+(\d+)(?:,(\d+))? @@", row):
            first, count = int(stretch[1]), int(stretch[2] or 1)
            lines[file].update(range(first, first + count))
    return lines


def drawn(root: Path, files: Iterable[str], seed: int, lines: Mapping[str, set[int]] | None = None) -> Iterator[Place]:
    """Faults in the order in which they are tried, each once: the first of every line come before the second of any.

    What stands elsewhere has no part in the place of a fault in that order: a change of one module, or a kind of fault
    more, moves no other.

    Parameters
    ----------
    root : Path
        The checkout.
    files : iterable of str
        Modules, relative to it.
    seed : int
        Of the order; the faults of a seed are the same however many are asked for.
    lines : mapping, optional
        Lines by file that faults may begin on; all if None.
    """
    texts = {file: (root / file).read_bytes() for file in files}
    in_turn: list[tuple[int, bytes, str, Mutant]] = []  # the round, the line's draw
    for file, text in texts.items():
        by_line: dict[int, list[Mutant]] = defaultdict(list)
        for mutant in mutants(text):
            if lines is None or mutant.line in lines.get(file, ()):
                by_line[mutant.line].append(mutant)
        alike: dict[str, int] = defaultdict(int)  # lines of one text are told by their number
        rows = text.decode().splitlines()
        for line, faults in sorted(by_line.items()):
            row = rows[line - 1]
            alike[row] += 1
            place = f"{seed}:{file}:{alike[row]}:{row}"
            faults.sort(key=lambda mutant: _draw(f"{place}:{mutant.kind}:{mutant.before}:{mutant.after}"))
            in_turn += [(k, _draw(f"{place}:{k}"), file, mutant) for k, mutant in enumerate(faults)]
    for _, _, file, mutant in sorted(in_turn, key=lambda each: each[:2]):
        if not same_code(texts[file], mutant.applied(texts[file])):
            yield file, mutant


def _draw(of: str) -> bytes:
    return hashlib.sha256(of.encode()).digest()
