"""The page on hardware: each block runs, and prints what stands below it."""

import re
from pathlib import Path

import pytest

from stickslip.robot import VirtualClock

PAGE = Path(__file__).parents[2] / "docs" / "hardware.md"
BLOCKS = re.compile(r"```python\n(.*?)```\n(?:\n```text\n(.*?)```)?", re.DOTALL)


def test_every_block_prints_what_stands_below_it(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    # A run on a busy machine skips holds: what is judged here is the page.
    monkeypatch.setattr("stickslip.robot.runner.RealClock", VirtualClock)
    found, names = BLOCKS.findall(PAGE.read_text(encoding="utf-8")), {}
    assert len(found) == 5
    for code, printed in found:
        exec(compile(code, str(PAGE), "exec"), names)
        assert capsys.readouterr().out == printed
    assert (tmp_path / "dry.csv").stat().st_size > 10_000


@pytest.mark.parametrize("command", re.findall(r"^stickslip (\w+)", PAGE.read_text(encoding="utf-8"), re.MULTILINE))
def test_its_commands_are_commands(command):
    from stickslip.commands import app

    assert command in {each.name for each in app.registered_commands}
