"""The blocks of the page of recipes; as a program, runs the one of the given name and checks what it leaves."""

import os
import re
import subprocess
import sys
from pathlib import Path

__all__ = ["ROOT", "recipes"]

ROOT = Path(__file__).parent.parent.parent
PAGE = ROOT / "docs" / "recipes.md"


def recipes():
    """Name to language and code of every recipe; the code is on the lines that it has on the page."""
    page = PAGE.read_text(encoding="utf-8")
    headings = list(re.finditer(r"^## (.+)$", page, re.MULTILINE))
    ends = [heading.start() for heading in headings[1:]] + [len(page)]
    found = {}
    for heading, end in zip(headings, ends, strict=True):
        (block,) = re.finditer(r"^```(\w+)\n(.*?)^```", page[:end][heading.start() :], re.DOTALL | re.MULTILINE)
        above = page.count("\n", 0, heading.start() + block.start(2))
        found[heading[1]] = block[1], "\n" * above + block[2]
    return found


def _run(name):
    """Run a block, in the current folder, and return what it leaves."""
    language, code = recipes()[name]
    if language == "python":
        left = {"__name__": "__main__"}
        exec(compile(code, str(PAGE), "exec"), left)
        return left
    for folder in ("examples", "train"):  # a shell would stand in the checkout, and leave its runs there
        Path(folder).symlink_to(ROOT / folder)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["sh", "-e", "-c", code], env={**os.environ, "PATH": path}, check=True, stdout=subprocess.PIPE, text=True
    )
    return {"printed": done.stdout, "folder": Path.cwd()}


if __name__ == "__main__":
    from checks import CHECKS

    CHECKS[sys.argv[1]](lambda: _run(sys.argv[1]))
