"""Throw-away copies of the checkout, so that no fault ever stands in the checkout itself."""

import os
import shutil
from pathlib import Path

from .sampling import tracked

__all__ = ["copied", "files_in", "kept_kernels", "twin"]

CACHE = "__pycache__"


def copied(root: Path, tree: Path) -> None:
    """Copy the files and links of a checkout as they stand there, and the compiled kernels that it keeps."""
    for file in tracked(root):
        (tree / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(root / file, tree / file, follow_symlinks=False)
    _copy_kernels(root, tree)


def kept_kernels(tree: Path, root: Path) -> None:
    """Give the checkout the kernels that a copy without faults compiled: each says itself what sources it is for."""
    _copy_kernels(tree, root)


def twin(tree: Path, other: Path) -> None:
    """Copy a copy; what its caches hold is linked, since all who write there put new files in the place of old ones."""

    def copy(source: str, target: str) -> None:
        if Path(source).parent.name == CACHE:
            os.link(source, target)
        else:
            shutil.copy2(source, target, follow_symlinks=False)

    shutil.copytree(tree, other, symlinks=True, copy_function=copy)


def _copy_kernels(source: Path, target: Path) -> None:
    for folder in {path.parent for path in map(Path, files_in(target)) if path.suffix == ".py"}:
        for kernel in (source / folder / CACHE).glob("*.nbc"):
            there = target / folder / CACHE / kernel.name
            if not there.exists() or there.stat().st_mtime < kernel.stat().st_mtime:
                there.parent.mkdir(parents=True, exist_ok=True)
                unfinished = there.with_name(f".{there.name}.{os.getpid()}")
                shutil.copy2(kernel, unfinished)
                unfinished.replace(there)


def files_in(tree: Path) -> list[str]:
    """Files of a tree, relative to it, without those behind links and those that programs leave."""
    found = []
    for folder, below, files in os.walk(tree):
        below[:] = [name for name in below if not name.startswith(".") and name not in (CACHE, "build", "dist", "runs")]
        found += [os.path.relpath(os.path.join(folder, name), tree) for name in files]
    return found
