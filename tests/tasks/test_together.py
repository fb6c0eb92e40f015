"""Bodies that are driven together give what each gives alone."""

import numpy as np
import pytest

from stickslip.crawler import SolverError
from stickslip.tasks import BodyReservoir
from stickslip.tasks.reservoirs import DelayLine, together
from stickslip.tasks.reservoirs.together import drive_together, Remembering, states_of_each

RNG = np.random.default_rng(2)
BODIES = [
    BodyReservoir(),
    BodyReservoir({"duffing": 2.0}, {"slope": 0.05}, hold=0.3),
    BodyReservoir("linear", {"anchored": True}, encoding="threshold"),
    BodyReservoir(virtual_nodes=3, holds_per_sample=2, readings="velocity"),
    BodyReservoir(scene={"segments": 2, "tube_mass": 0.3}),
    BodyReservoir(scene={"segments": 2}),
    BodyReservoir(tolerance=1e-5),
    BodyReservoir({"deborah": 1.0}),
]
SERIES = [RNG.random(length) for length in (9, 9, 9, 9, 9, 9, 9, 12)]


@pytest.fixture
def simulated(monkeypatch):
    """Rows of every call of `simulate`."""
    rows, simulate = [], together.simulate

    def counted(groups, *arguments, **options):
        rows.append(len(groups))
        return simulate(groups, *arguments, **options)

    monkeypatch.setattr(together, "simulate", counted)
    return rows


@pytest.mark.parametrize("most", [4_000_000, 36])
def test_each_has_its_own_states_to_the_bit(simulated, monkeypatch, most):
    monkeypatch.setattr(together, "_MOST_SAMPLES", most)
    together_states = states_of_each(BODIES, SERIES)
    for body, series, states in zip(BODIES, SERIES, together_states, strict=True):
        np.testing.assert_array_equal(states, body(series))
    assert sum(simulated) == len(BODIES)
    assert max(simulated) == (2 if most > 36 else 1)


def test_a_remembered_call_is_not_made_again(simulated):
    calls = [(Remembering(body), series, 3) for body, series in zip(BODIES[:2], SERIES[:2], strict=True)]
    line = Remembering(DelayLine(3))
    drive_together([*calls, calls[0], (line, SERIES[0], 3)])
    assert simulated == [2], "what is asked for twice is driven once, and what is no body not at all"
    assert not line.states
    for each, series, seed in calls:
        states = each.states[series.tobytes(), seed]
        assert each(series, seed) is states
        np.testing.assert_array_equal(states, each.reservoir(series))
        assert each.features == each.reservoir.features


def test_what_a_tuned_reservoir_chooses_among_remembers_too():
    class Tuned(DelayLine):
        candidates = (DelayLine(2), DelayLine(3))

    tuned = Remembering(Tuned(4))
    assert [each.reservoir for each in tuned.candidates] == list(Tuned.candidates)
    for each in tuned.candidates:
        assert each(SERIES[0], 0) is each(SERIES[0], 0)


def test_where_one_fails_the_call_itself_tells(simulated):
    runaway = BodyReservoir({"duffing": 0.0, "radial_coupling": 40.0}, encoding="threshold", hold=5.0)
    ones = np.ones(9)
    calls = [(Remembering(runaway), ones, 0), (Remembering(BodyReservoir(encoding="threshold", hold=5.0)), ones, 0)]
    drive_together(calls)
    assert simulated == [2]
    with pytest.raises(SolverError, match=r"^the motion diverged"):
        calls[0][0](ones, 0)
    assert calls[1][0](ones, 0).shape == (9, 12)
