"""``stickslip lyapunov``: what it is asked for, what it writes, and what it refuses."""

import numpy as np
import pytest

from stickslip import lyapunov_spectrum
from stickslip.commands import run
from stickslip.studies.maps import Inputs

BODY = ["--groups", '{"damping_ratio": 0.1}', "--scene", '{"slope": 0.02}', "--hold", "1", "--holds", "90"]
REST = ["--washout", "30", "--inputs", "bernoulli:0.4", "--seeds", "2", "--tolerance", "1e-10"]


def exponents(**groups):
    valve = np.array([Inputs.of("bernoulli:0.4").drawn(90, seed).valve for seed in (0, 1)])
    return lyapunov_spectrum(
        {"damping_ratio": 0.1, **groups}, valve, 1.0, scene={"slope": 0.02}, washout=30, tolerance=1e-10
    )


def test_exponents_of_one_body_are_printed(capsys):
    assert run(["lyapunov", *BODY, *REST]) == 0
    told = " ".join(capsys.readouterr().out.split())
    found = exponents()
    assert told.startswith("120 natural times; the pressure forgets at -2")
    for value, error in zip(found.exponents, found.standard_error, strict=True):
        assert f"{value:.4f} ± {error:.4f}" in told
    assert f"-inf {found.stops} contracting" in told


def test_a_diagram_is_drawn(capsys, tmp_path):
    assert run(["lyapunov", *BODY, *REST, "--over", "duffing=1,2", "--output", str(tmp_path / "one")]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert sorted(file.name for file in (tmp_path / "one").iterdir()) == ["diagram.png", "diagram.svg"]
    for duffing in (1.0, 2.0):
        assert f"{duffing:g} {exponents(duffing=duffing).exponents[0]:.4f} ±" in told


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--inputs", "noise"], "error: inputs must be 'bits', 'bernoulli:PROBABILITY'"),
        (["--seeds", "0"], "error: --seeds must be a whole number >= 1, got 0"),
        (["--over", "wheels=1,2"], "error: over has no 'wheels'; allowed are"),
        (["--over", "duffing=2:1:4"], "error: over duffing must rise from low to high, got '2:1:4'"),
        (
            ["--over", "duffing=1,2", "--washout", "9000"],
            "error: washout must be a whole number in [0, 4198]",
        ),
    ],
)
def test_what_has_no_exponents_is_refused_in_one_line(capsys, tmp_path, options, message):
    assert run(["lyapunov", "--output", str(tmp_path / "one"), *options]) == 1
    line = capsys.readouterr().err.splitlines()[-1]
    assert line.startswith(message)
