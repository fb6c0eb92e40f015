"""Environments of their own, for what cannot share the development environment, laid over it."""

import shutil
import site
import subprocess
import sys
from pathlib import Path

__all__ = ["python_of"]

_REQUIREMENTS = Path(__file__).parent


def python_of(name):
    """The interpreter for a package: this one, or that of the environment that its file of requirements describes.

    Such an environment is made beside this one, the first time and whenever the file has changed. What the file does
    not name it sees in this one: torch is not installed twice.
    """
    requirements = _REQUIREMENTS / f"{name}.txt"
    if not requirements.exists():
        return Path(sys.executable)
    folder = Path(sys.prefix) / "interop" / name
    python = folder / "bin" / "python"
    made_from = folder / "requirements.txt"
    if not made_from.exists() or made_from.read_bytes() != requirements.read_bytes():
        shutil.rmtree(folder, ignore_errors=True)
        _run("-m", "venv", "--without-pip", str(folder))
        (packages,) = folder.glob("lib/python*/site-packages")
        below = "".join(f"import site; site.addsitedir({path!r})\n" for path in site.getsitepackages())
        (packages / "below.pth").write_text(below, encoding="utf-8")
        # All that is needed is named with its version: nothing is resolved, so that nothing else is replaced.
        _run("-m", "pip", "--python", str(python), "install", "--quiet", "--no-deps", "-r", str(requirements))
        shutil.copyfile(requirements, made_from)
    return python


def _run(*arguments):
    subprocess.run([sys.executable, *arguments], check=True)
