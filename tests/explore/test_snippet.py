"""A program that is copied makes what is seen."""

import numpy as np
import pytest

from stickslip.explore.measures import exponents_of, long_run
from stickslip.explore.motion import shown, trace_of
from stickslip.explore.presets import preset
from stickslip.explore.setup import Setup, setup_of
from stickslip.explore.snippet import program_of

SETUPS = {
    "usual": Setup(),
    "all at once": setup_of(
        {"word": "1101", "duffing": 3.0, "slope": -0.05, "hold": 0.7, "tolerance": 1e-7, "dither": 0.2, "units": "SI"}
    ),
    "no flips": preset("clean-gait"),
    "anchored": setup_of({"anchored": True, "ratchet": False, "slope": 0.1}),
    "no ratchet": preset("no-ratchet"),
    "policy": setup_of({"deborah": 0.3}, preset("knee-policy")),
    "conditioned": setup_of({"policy": "conditioned", "weight": 0.25}, preset("knee-policy")),
    "live": Setup(drive="live", units="SI"),
}
BITS = (0, 1, 1, 1, 0, 0, 1)


@pytest.mark.filterwarnings("ignore:250 scored samples")
@pytest.mark.parametrize("name", sorted(SETUPS))
def test_a_program_reproduces_what_is_seen(name, capsys, monkeypatch):
    setup = SETUPS[name]
    # Runs of the length of a page's take seconds for policies.
    for module in ("measures", "snippet"):
        monkeypatch.setattr(f"stickslip.explore.{module}.LONG", 700)
    told: dict = {}
    program = program_of(setup, BITS)
    exec(compile(program, "program", "exec"), told)
    trace = trace_of(setup, shown(setup, BITS))
    scale = 1e3 if setup.units == "SI" else 1.0
    for column in ("foot", "deformation", "payload"):
        np.testing.assert_allclose(
            scale * getattr(told["motion"], column), trace[column][1:], rtol=1e-14 if scale > 1 else 0, atol=1e-16
        )
    np.testing.assert_allclose(told["motion"].time, trace["time"][1:], rtol=1e-14)
    assert ("in SI" in capsys.readouterr().out) == (setup.units == "SI")
    assert max(map(len, program.splitlines())) <= 120 or "Actuator" in program
    if setup.drive == "live":
        assert "memory" not in told
        return
    run = long_run(setup)
    assert told["speed"] == run.speed
    assert (run.memory is None) == ("memory" not in told)
    if run.memory is not None:
        np.testing.assert_array_equal(told["memory"].profile, run.memory.profile)
    np.testing.assert_array_equal(told["spectrum"].exponents, exponents_of(setup, run.valve).exponents)
