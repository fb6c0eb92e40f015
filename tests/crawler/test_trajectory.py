"""What a trajectory says of itself, and what its figure shades."""

import matplotlib as mpl
import numpy as np
import pytest

from stickslip.crawler import Actuator, ChainState, EVENT, Groups, Scene, simulate, State, Trajectory

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


def crawled(**changes):
    """A trajectory of round numbers, made by hand."""
    numbers = {
        "time": np.array([1.0, 2.0, 3.0, 4.0]),
        "deformation": np.array([0.5, 0.25, 0.125, 2.0]),
        "velocity": np.array([1.0, -1.0, 0.5, 0.0625]),
        "pressure": np.array([0.5, 0.75, 0.25, 0.125]),
        "foot": np.array([0.0, 1.0, 2.0, 3.5]),
        "foot_velocity": np.array([0.0, 0.5, 0.0, 0.75]),
        "segment_deformation": np.array([[0.5, 0.25, 0.125, 2.0]]),
        "segment_velocity": np.array([[1.0, -1.0, 0.5, 0.0625]]),
        "valve": np.array([1, 0], np.int8),
        "slips": 7,
        "events": np.array([(0.5, 1, 0)], EVENT),
        "work": 8.0,
        "stored": 4.0,
        "viscous_loss": 2.5,
        "friction_loss": 1.0,
        "energy_scale": 16.0,
        "hold": 2.0,
        "model": "on the ground, by hand",
        "groups": Groups(),
        "scene": Scene(),
        "initial": State(),
    }
    return Trajectory(**numbers | changes)


SEEN = """Trajectory of one crawler in natural units: 2 holds of 2 t_c, 2 samples a hold
  groups  {groups}
  model   on the ground, by hand
  foot    at 3.5 z_c after 7 slips
  energy  work 8, stored 4, viscous loss 2.5, friction loss 1, residual 0.5 of 16 P_max A_0 z_c"""


def test_what_is_printed_word_by_word():
    assert repr(crawled()) == SEEN.format(groups=Groups())
    in_si = SEEN.replace("natural units", "SI").replace(" t_c,", " s,").replace(" z_c after", " m after")
    in_si = in_si.replace("P_max A_0 z_c", "J").format(groups=Groups())
    assert repr(crawled(actuator=Actuator.ecoflex())) == in_si


def test_what_is_printed_of_a_batch_word_by_word():
    names = ("work", "stored", "viscous_loss", "friction_loss", "energy_scale")
    rows = {name: np.stack([getattr(crawled(), name)] * 3) for name in ("deformation", "foot", "valve")}
    rows["foot"][1:, -1] = [4.5, -1.0]
    groups = (Groups(), Groups(duffing=2.0), Groups())
    changes = {name: np.array([1.0, 2.0, 3.0]) * (i + 1) for i, name in enumerate(names)}
    batch = crawled(**rows, **changes, slips=np.array([2, 2, 2]), groups=groups)
    assert repr(batch).splitlines() == [
        "Trajectory of 3 crawlers in natural units: 2 holds of 2 t_c, 2 samples a hold",
        f"  groups  {Groups()} and 1 more",
        "  model   on the ground, by hand",
        "  foot    at -1 to 4.5 z_c after 2 slips",
        "  energy  work 1 to 3, stored 2 to 6, viscous loss 3 to 9, friction loss 4 to 12, residual -24 to -8 of 5 to "
        "15 P_max A_0 z_c",
    ]
    alike = crawled(**{name: np.stack([getattr(crawled(), name)] * 2) for name in rows}, groups=(Groups(),) * 2)
    assert repr(alike).splitlines()[1] == f"  groups  {Groups()}"


def test_what_follows_from_the_numbers():
    done = crawled()
    np.testing.assert_array_equal(done.payload, [0.5, 1.25, 2.125, 5.5])
    assert done.dissipation == 3.5
    assert done.energy_residual == 8.0 - 4.0 - 3.5
    assert done.final_state == State(2.0, 0.0625, 0.125, 3.5, 0.75)
    parts = {"segment_deformation": np.arange(8.0).reshape(2, 4), "segment_velocity": -np.arange(8.0).reshape(2, 4)}
    chain = crawled(**parts).final_state
    assert isinstance(chain, ChainState)
    assert [list(chain[0]), list(chain[1]), *chain[2:]] == [[3.0, 7.0], [-3.0, -7.0], 0.125, 3.5, 0.75]


@pytest.mark.parametrize(
    "changes", [{"actuator": Actuator.ecoflex()}, {"deformation": np.zeros((2, 4))}], ids=["SI", "batch"]
)
def test_only_one_crawler_in_natural_units_has_a_final_state(changes):
    says = r"^final_state is of one crawler in natural units, got a batch or a trajectory in SI$"
    with pytest.raises(ValueError, match=says):
        crawled(**changes).final_state  # noqa: B018


@pytest.mark.parametrize("other", [None, Groups(), "ecoflex", 3.0])
def test_in_si_takes_nothing_but_an_actuator(other):
    with pytest.raises(TypeError, match=r"^actuator must be an Actuator, got "):
        crawled().in_si(other)


def test_in_si_leaves_what_has_no_unit():
    si = crawled().in_si(Actuator.ecoflex())
    # z_c = 1/32 m, t_c = 1/16 s, 2 N and 20 kPa: powers of two but for the pressure.
    np.testing.assert_array_equal(si.deformation * 32.0, crawled().deformation)
    np.testing.assert_array_equal(si.velocity * 2.0, crawled().velocity)
    np.testing.assert_array_equal(si.foot_velocity * 2.0, crawled().foot_velocity)
    np.testing.assert_array_equal(si.foot * 32.0, crawled().foot)
    np.testing.assert_array_equal(si.segment_deformation * 32.0, crawled().segment_deformation)
    np.testing.assert_array_equal(si.segment_velocity * 2.0, crawled().segment_velocity)
    np.testing.assert_array_equal(si.time * 16.0, crawled().time)
    np.testing.assert_array_equal(si.pressure, 20e3 * crawled().pressure)
    assert si.events["time"].tolist() == [0.5 / 16.0]
    assert si.events[["mode", "crawler"]].tolist() == [(1, 0)]
    energies = [si.work, si.stored, si.viscous_loss, si.friction_loss, si.energy_scale]
    assert energies == [0.5, 0.25, 0.15625, 0.0625, 1.0]
    assert (si.hold, si.slips, si.model, si.groups, si.condition) == (
        0.125,
        7,
        "on the ground, by hand",
        Groups(),
        None,
    )
    assert si.valve.tolist() == [1, 0]


@pytest.mark.parametrize(("off", "refused"), [(1e-13, False), (1e-10, True), (1e-7, True)])
def test_in_si_takes_other_groups_for_roundings_alone(off, refused):
    done = crawled(groups=Groups(duffing=0.5 * (1.0 + off)))
    if refused:
        with pytest.raises(
            ValueError, match=r"^actuator must have the groups that were simulated, duffing = 0\.5\d+, got"
        ):
            done.in_si(Actuator.ecoflex())
    else:
        assert done.in_si(Actuator.ecoflex()).actuator == Actuator.ecoflex()
