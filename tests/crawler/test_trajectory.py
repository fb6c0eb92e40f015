"""What a trajectory says of itself, and what its figure shades."""

import matplotlib as mpl
import numpy as np
import pytest

from stickslip.crawler import Actuator, simulate, State

mpl.use("Agg")

CHAIN = {"segments": 3, "tube_mass": 0.3}
MADE = {
    "one": lambda: simulate("linear", [1, 0] * 500, 0.5, samples_per_hold=3),
    "batch": lambda: simulate(["linear", {"duffing": 2}] * 40, [1, 0] * 50, 0.5),
    "chain": lambda: simulate({}, [1, 0] * 3, 0.5, scene=CHAIN),
    "SI": lambda: simulate({}, [1, 0] * 50, 0.5).in_si(Actuator.ecoflex()),
}


@pytest.mark.parametrize("kind", MADE)
def test_a_trajectory_prints_what_matters_in_ten_lines_of_a_terminal(kind):
    done = MADE[kind]()
    text = repr(done)
    assert sum(-(-len(line) // 80) for line in text.splitlines()) <= 10
    assert f"{done.valve.shape[-1]} holds of {done.hold:.6g}" in text
    assert done.model in text
    for value in (done.foot[..., -1], done.slips, done.work, done.energy_residual):
        assert f"{np.min(value):.6g}" in text
        assert f"{np.max(value):.6g}" in text
    assert ("80 crawlers" in text) == (kind == "batch")
    assert (" m after" in text) == (kind == "SI")


def shaded(trajectory):
    """The stretches of time that the first panel of the figure shades, and the figure."""
    figure = trajectory.plot()
    spans = [patch.get_extents().transformed(figure.axes[0].transData.inverted()) for patch in figure.axes[0].patches]
    return [(span.x0, span.x1) for span in spans], figure


@pytest.mark.parametrize("speed", [0.5, -0.5])
@pytest.mark.parametrize("actuator", [None, Actuator.ecoflex()])
def test_a_slide_under_way_at_the_start_is_shaded(speed, actuator):
    start = State(foot_velocity=speed)
    done = simulate({}, [1, 0] * 4, 1.0, scene={"ratchet": False}, initial=start, samples_per_hold=50)
    fine = done if actuator is None else done.in_si(actuator)
    spans, figure = shaded(fine)
    assert spans[0][0] == pytest.approx(0.0, abs=1e-9)
    # The judge is the sampled velocity: what is shaded slides, what is not does not.
    middle = fine.time - 0.5 * (fine.time[1] - fine.time[0])
    under = np.any([(low < middle) & (middle < high) for low, high in spans], axis=0)
    sliding = np.abs(fine.foot_velocity) > 1e-9
    assert np.mean(under == sliding) > 0.97
    mpl.pyplot.close(figure)


def test_a_slide_that_never_ends_is_shaded_throughout():
    frictionless = {"static_friction": 0.0, "kinetic_friction": 0.0}
    done = simulate(frictionless, [0, 0], 1.0, initial=State(foot_velocity=1.0))
    assert len(done.events) == 0
    spans, figure = shaded(done)
    assert spans == [pytest.approx((0.0, 2.0))]
    mpl.pyplot.close(figure)


def test_nothing_is_shaded_where_nothing_slides():
    spans, figure = shaded(simulate({}, [0, 0], 1.0))
    assert spans == []
    mpl.pyplot.close(figure)
