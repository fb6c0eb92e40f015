"""The demo in small: every figure, number and policy it promises, and a page that shows them."""

import json
import re

from stickslip.commands import run


def test_the_demo_makes_what_its_page_shows(tmp_path, capsys):
    folder = tmp_path / "demo"
    assert run(["demo", "--output", str(folder), "--steps", "2000"]) == 0
    printed = capsys.readouterr().out
    assert "NARMA-10" in printed
    assert "speed policy" in printed
    assert str(folder / "index.html") in printed.replace("\n", "")

    page = (folder / "index.html").read_text(encoding="utf-8")
    shown = re.findall(r'src="([^"]+)"', page)
    assert set(shown) == {"trajectory.png", "memory.png", "trade.png", "gait.mp4"}
    assert all((folder / name).stat().st_size > 1000 for name in shown)
    assert {path.name for path in folder.iterdir()} == {*shown, "index.html", "results.json", "policies"}

    results = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    assert 0 < results["memory capacity"]["crawler"] < results["memory capacity"]["delay line"]
    assert results["word 11100 without dither"] > 1.05
    assert f"{results['speed policy without dither']:.3f}" in page
    assert {path.name for path in (folder / "policies").iterdir()} == {"speed", "memory"}
