"""The README's code runs as it stands."""

import re
from pathlib import Path

README = Path(__file__).parents[2] / "README.md"


def test_the_example_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (code,) = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    exec(compile(code, str(README), "exec"), {})
    printed = capsys.readouterr().out
    distance, slips = re.match(r"crawled (\S+) z_c with (\d+) slips", printed).groups()
    assert float(distance) > 100
    assert int(slips) > 100
    assert "NARMA-10" in printed
    assert (tmp_path / "trajectory.png").stat().st_size > 1000


def test_every_picture_is_there():
    for picture in re.findall(r"!\[[^]]*\]\(([^)]+)\)", README.read_text(encoding="utf-8")):
        assert (README.parent / picture).is_file(), picture
