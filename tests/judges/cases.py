"""Runs that check themselves, random crawlers, and the comparison with a judge."""

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

from stickslip.crawler import Groups, REST, Scene, simulate, State, Trajectory

__all__ = [
    "BOUNCER",
    "HUNT",
    "WORD",
    "assert_agrees",
    "crawlers",
    "is_free",
    "random_crawler",
    "run",
    "schedules",
    "starts",
]

WORD = [1, 1, 1, 1, 0, 0, 0, 0]
# Linear and undamped but for what a test changes.
BOUNCER = {"duffing": 0.0, "damping_ratio": 0.0, "radial_coupling": 0.0}
HUNT = settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])


def run(
    groups, valve, hold, *, scene=None, tolerance=1e-9, solver="auto", initial=None, samples_per_hold=1
) -> Trajectory:
    """`simulate` one crawler, and check what must hold of every trajectory."""
    scene, start = scene or Scene(), initial or REST
    valve = np.asarray(valve)
    done = simulate(
        groups,
        valve,
        hold,
        scene=scene,
        tolerance=tolerance,
        solver=solver,
        initial=initial,
        samples_per_hold=samples_per_hold,
    )
    _check_clock_and_pressure(done, groups, valve, hold, samples_per_hold, start.pressure)
    _check_events(done, groups, scene, start, tolerance)
    np.testing.assert_array_equal(done.payload, done.foot + done.deformation)
    # Work is stored, or lost in the elastomer and under the foot.
    size = 1.0 + abs(done.work) + abs(done.stored) + done.dissipation
    fastest = 1.0 + np.abs(done.velocity).max()  # energy goes to and fro as fast, and is rounded each time
    rounding = 1e-14 * done.energy_scale  # of what was stored at the start, which may be far more than flowed
    bound = (10.0 * tolerance + 1e-12 * fastest) * size * (1.0 + done.time[-1])
    assert abs(done.energy_residual) < bound + rounding
    assert min(done.viscous_loss, done.friction_loss) > -1e-12 * size
    return done


def _check_clock_and_pressure(done, groups, valve, hold, samples_per_hold, pressure):
    fractions = np.arange(1, samples_per_hold + 1) / samples_per_hold
    np.testing.assert_array_equal(done.time, np.concatenate([(k + fractions) * hold for k in range(len(valve))]))
    for k, u in enumerate(valve):
        window = slice(k * samples_per_hold, (k + 1) * samples_per_hold)
        expected = u + (pressure - u) * np.exp(-fractions * hold / groups.deborah)
        np.testing.assert_allclose(done.pressure[window], expected, rtol=1e-13, atol=1e-15)
        pressure = expected[-1]


def _check_events(done, groups, scene, start, tolerance):
    moments, motions = done.events["time"], done.events["mode"]
    assert (np.diff(moments) >= 0.0).all()
    assert (np.abs(np.diff(motions)) > 0).all(), "an event changes the motion"
    before = np.concatenate([[np.sign(start.foot_velocity)], motions])[:-1]
    # Turning round is a slip only against friction.
    assert done.slips == np.count_nonzero((motions != 0) & ((before == 0) | (groups.static_friction > 0.0)))
    if scene.anchored:
        assert not len(moments)
        assert not done.foot_velocity.any()
        assert (done.foot == start.foot).all()
    # Which motion each sample belongs to, where it is not within rounding of an event.
    motion = np.concatenate([[np.sign(start.foot_velocity)], motions])[np.searchsorted(moments, done.time)]
    near = np.isclose(done.time[:, None], moments[None, :], rtol=1e-12, atol=0.0).any(axis=1)
    assert not done.foot_velocity[(motion == 0) & ~near].any(), "a stuck foot has velocity exactly 0"
    if scene.ratchet:
        slack = max(tolerance, 1e-12)
        assert (motions >= 0).all()
        assert done.foot_velocity.min() >= -slack
        assert np.diff(done.foot, prepend=start.foot).min() >= -slack * (1.0 + np.abs(done.foot).max())


def is_free(groups, scene: Scene) -> bool:
    """Whether the foot is held by nothing either way: it then touches rest as often as rounding has it."""
    return groups.static_friction == 0.0 and not (scene.ratchet or scene.anchored)


def assert_agrees(done: Trajectory, verdict, *, atol: float, free: bool = False) -> None:
    """The trajectory is the judge's: samples, and unless the foot is free events by number, kind and time."""
    for name in ("deformation", "velocity", "pressure", "foot", "foot_velocity"):
        np.testing.assert_allclose(getattr(done, name), getattr(verdict, name), rtol=0, atol=atol, err_msg=name)
    if free:
        return
    assert done.events["mode"].tolist() == [motion for _, motion in verdict.events]
    moments = np.array([float(time) for time, _ in verdict.events])
    np.testing.assert_allclose(done.events["time"], moments, rtol=0, atol=atol)


def random_crawler(rng: np.random.Generator, *, anchored: bool = False):
    """Arguments of `run` for a crawler from anywhere in the ranges that the package is meant for."""

    def spread(low, high):
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    duffing = float(rng.choice([0.0, spread(1e-2, 1e3)]))
    static = float(rng.choice([0.0, rng.uniform(0.0, 1.0), spread(1e-3, 1.0)]))
    groups = Groups(
        duffing=duffing,
        damping_ratio=float(rng.choice([0.0, spread(1e-2, 5.0)])),
        deborah=spread(0.01, 10.0),
        # Without a cubic spring nothing bounds a body whose area grows faster than its spring.
        radial_coupling=float(rng.choice([0.0, rng.uniform(0.0, 2.0 if duffing else 0.9)])),
        foot_mass_fraction=float(rng.choice([rng.uniform(0.05, 0.95), spread(0.01, 0.1), 1.0 - spread(0.01, 0.1)])),
        static_friction=static,
        kinetic_friction=static * float(rng.choice([0.0, 1.0, rng.uniform(0.0, 1.0)])),
    )
    scene = Scene(anchored=anchored, ratchet=bool(rng.random() < 0.6))
    hold = spread(0.05, 20.0)
    options = {"scene": scene, "samples_per_hold": int(rng.integers(1, 4))}
    if rng.random() < 0.3:
        sliding = 0.0 if anchored else float(rng.choice([0.0, rng.uniform(0.0, 1.0)]))
        state = [float(value) for value in rng.uniform(-1.0, 1.0, 2)]
        backward = not scene.ratchet and rng.random() < 0.5
        options["initial"] = State(*state, float(rng.uniform()), 0.5, -sliding if backward else sliding)
    return groups, rng.integers(0, 2, int(np.clip(10.0 / hold, 2, 20))), hold, options


crawlers = st.builds(
    lambda ratio, **groups: Groups(kinetic_friction=ratio * groups["static_friction"], **groups),
    ratio=st.sampled_from([0.0, 0.5, 0.9, 1.0]),
    duffing=st.floats(0.0, 20.0),
    damping_ratio=st.floats(0.0, 1.0),
    deborah=st.floats(0.05, 5.0),
    radial_coupling=st.floats(0.0, 0.9),
    foot_mass_fraction=st.floats(0.05, 0.95),
    static_friction=st.floats(0.0, 0.8),
)
schedules = st.lists(st.integers(0, 1), min_size=1, max_size=6)
starts = st.builds(
    State,
    deformation=st.floats(-1.0, 1.0),
    velocity=st.floats(-1.0, 1.0),
    pressure=st.floats(0.0, 1.0),
    foot=st.floats(-1.0, 1.0),
    foot_velocity=st.sampled_from([0.0, 0.3]),
)
