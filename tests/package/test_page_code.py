"""The Python of the pages, run as it stands there: blocks of a page follow each other, as a reader runs them."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
OTHERWISE = {
    "recipes.md",  # each in an environment of its own: tests/interop
    "extending.md",  # edits of the code
    "hardware.md",  # with what it prints: tests/robot
}
# What a reader has when a page begins.
GIVEN = {
    "training.md": """
from pathlib import Path
import gymnasium as gym, stickslip
from stickslip.train.policies import write_policy
Path("runs/mine").mkdir(parents=True)
policy = stickslip.pretrained("knee")
write_policy(policy, Path("runs/mine/best"))
observation, _ = gym.make("StickSlipCrawler-v0", **policy.env_kwargs).reset()
""",
}
# Hours of search are not tried again.
SHORTER = {"best.md": ("evaluations=300", "evaluations=3")}


def blocks(page):
    text = page.read_text(encoding="utf-8")
    if page.name in SHORTER:
        assert text.count(SHORTER[page.name][0]) == 1
        text = text.replace(*SHORTER[page.name])
    return re.findall(r"^```python\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


PAGES = sorted(page.name for page in DOCS.glob("*.md") if page.name not in OTHERWISE and blocks(page))


def test_there_are_pages():
    assert {"index.md", "measured_data.md", "deployment.md", "training.md", "vector.md"} <= set(PAGES)


@pytest.mark.slow
@pytest.mark.parametrize("name", PAGES)
def test_the_blocks_of_a_page_run(name, tmp_path):
    program = tmp_path / name.replace(".md", "_page.py")
    program.write_text("\n".join([GIVEN.get(name, ""), *blocks(DOCS / name)]), encoding="utf-8")
    subprocess.run([sys.executable, program.name], cwd=tmp_path, check=True, timeout=900)
