"""``stickslip map``: what it is asked for, what it writes, and what it refuses."""

import pytest
import xarray as xr

from stickslip import parameter_map
from stickslip.commands import run

ASKED = (
    "--x duffing=0.5,2 --y deborah=0.3:1.2:3:log --measure memory,speed --seeds 2 --holds 160 --washout 40 --delays 4"
)
OTHERS = "--hold 1 --inputs bernoulli:0.4 --nodes 2 --tolerance 1e-7 --processes 1"


def test_a_map_is_made_drawn_and_gone_on_with(capsys, tmp_path):
    options = ["--groups", '{"damping_ratio": 0.1}', "--scene", '{"slope": 0.02}', "--output", str(tmp_path / "map")]
    told = []
    for _ in range(2):
        assert run(["map", *ASKED.split(), *OTHERS.split(), *options]) == 0
        told.append(" ".join(capsys.readouterr().out.split()))
    assert told[0] == told[1]
    assert "6 cells, 2 seeds" in told[0]
    assert sorted(file.name for file in (tmp_path / "map").iterdir()) == ["map.png", "map.svg", "map.zarr"]
    asked = {"seeds": 2, "holds": 160, "washout": 40, "delays": 4, "hold": 1.0, "inputs": "bernoulli:0.4"}
    own = {"groups": {"damping_ratio": 0.1}, "scene": {"slope": 0.02}, "virtual_nodes": 2, "tolerance": 1e-7}
    found = parameter_map("duffing=0.5,2", "deborah=0.3:1.2:3:log", measures=["memory", "speed"], **asked, **own)
    kept = xr.open_zarr(tmp_path / "map" / "map.zarr")
    xr.testing.assert_equal(kept[["memory", "speed", "status"]], found[["memory", "speed", "status"]])
    most = found.memory.mean("seed")
    assert f"{float(most.max()):.3g} [" in told[0]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--measure", "wisdom"], "error: --measure has no 'wisdom'; allowed are ['memory',"),
        (["--x", "wheels=1,2"], "error: x has no 'wheels'; allowed are"),
        (["--x", "duffing=2:1:4"], "error: x duffing must rise from low to high, got '2:1:4'"),
        (["--processes", "0"], "error: --processes must be a whole number >= 1, got 0"),
    ],
)
def test_what_cannot_be_mapped_is_refused_in_one_line(capsys, tmp_path, options, message):
    assert run(["map", "--x", "duffing=1,2", "--output", str(tmp_path / "map"), *options]) == 1
    [line] = capsys.readouterr().err.splitlines()
    assert line.startswith(message)
    assert not (tmp_path / "map").exists()
