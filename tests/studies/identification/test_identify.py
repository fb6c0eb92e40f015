"""Groups from measurements: what made them is found again, and what they cannot tell is said."""

from dataclasses import replace

import numpy as np
import pytest

from stickslip import Actuator, Groups, Scene, simulate
from stickslip.studies.identification import CHANNELS, identify, Measurements
from stickslip.studies.identification.prediction import predicted, slopes_of
from stickslip.tasks import random_bits

TRUTH = Groups(
    duffing=1.1,
    damping_ratio=0.08,
    deborah=0.7,
    radial_coupling=0.3,
    foot_mass_fraction=0.25,
    static_friction=0.35,
    kinetic_friction=0.22,
)


def measured(*channels, holds=200, seed=0, noise=0.01, samples=8):
    motion = simulate(TRUTH, random_bits(holds, seed), 1.0, samples_per_hold=samples)
    return Measurements.of(motion, *channels, noise=noise, seed=seed)


def wrong(seed):
    """The truth, each group off by a factor of three either way."""
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], 7)
    values = {name: value * 3.0**sign for (name, value), sign in zip(TRUTH.to_dict().items(), signs, strict=True)}
    values["kinetic_friction"] = min(values["kinetic_friction"], values["static_friction"])
    return values


@pytest.mark.parametrize("channels", [("foot",), ("payload",), ("deformation",), ("deformation", "pressure", "foot")])
def test_each_group_is_found_within_two_percent_from_a_guess_off_by_three(channels):
    found = identify(measured(*channels), guess=wrong(len(channels)))
    for name in found.names:
        assert getattr(found.groups, name) == pytest.approx(getattr(TRUTH, name), rel=0.02), name
    assert found.warnings == ()
    expected = 0.01 * simulate(TRUTH, random_bits(200, 0), 1.0, samples_per_hold=8).deformation.std()
    assert found.noise[channels[0]] == pytest.approx(expected, rel=0.1)


def test_without_noise_the_groups_are_found_to_the_tolerance():
    found = identify(measured("deformation", "foot", holds=40, noise=0.0))
    for name in found.names:
        assert getattr(found.groups, name) == pytest.approx(getattr(TRUTH, name), rel=1e-5), name


def test_an_interval_is_as_wide_as_the_estimates_scatter():
    runs = [identify(measured("foot", holds=30, seed=seed), guess=TRUTH, starts=1) for seed in range(12)]
    at = [list(run.names).index("kinetic_friction") for run in runs]
    claimed = np.median([np.sqrt(run.covariance[i, i]) for run, i in zip(runs, at, strict=True)])
    scatter = np.std([run.groups.kinetic_friction for run in runs], ddof=1)
    assert 0.5 < scatter / claimed < 2.0
    low, high = runs[0].interval(0.95)["kinetic_friction"]
    assert (high - low) / 2.0 == pytest.approx(1.97 * np.sqrt(runs[0].covariance[at[0], at[0]]), rel=0.01)
    narrow = runs[0].interval(0.5)["kinetic_friction"]
    assert low < narrow[0] < narrow[1] < high


def test_gaps_and_times_of_their_own_make_no_difference_but_to_the_error():
    whole = measured("deformation", "foot", holds=60, samples=48)
    generator = np.random.default_rng(1)
    kept = np.sort(generator.choice(whole.times.size, 400, replace=False))
    deformation = whole.deformation[kept].copy()
    deformation[50:150] = np.nan
    run = Measurements(
        whole.valve, 1.0, times=whole.times[kept] - 0.003, deformation=deformation, foot=whole.foot[kept]
    )
    exact = simulate(TRUTH, whole.valve, 1.0, samples_per_hold=1000)
    foot = np.interp(run.times, exact.time, exact.foot)
    found = identify(replace_channel(run, foot=foot), guess=TRUTH, starts=1)
    for name in found.names:
        assert getattr(found.groups, name) == pytest.approx(getattr(TRUTH, name), rel=0.05), name
    assert found.samples == 400 + 300


@pytest.mark.parametrize("hold", [0.5, 4.0, 40.0])
@pytest.mark.parametrize("lag", [0.5, 0.02])
def test_bodies_are_predicted_at_times_of_their_own_however_long_a_hold_is(hold, lag):
    body, valve = replace(TRUTH, deborah=lag), [1.0, 0.0, 0.3, 1.0]
    exact = simulate(body, valve, hold, samples_per_hold=4800)
    some = slice(1, None, 13)
    channels = {name: getattr(exact, name)[some] for name in CHANNELS}
    run = Measurements(valve, hold, times=exact.time[some], **channels)
    for name, (values,) in predicted([body], run, Scene(), 1e-9).items():
        error = np.abs(values - channels[name]) / (np.std(channels[name]) or 1.0)
        assert np.sqrt(np.mean(error**2)) < 3e-3, name
        assert error.max() < (1e-12 if name == "pressure" else 0.05), name


def replace_channel(run, **channels):
    told = {name: getattr(run, name) for name in run.measured} | channels
    return Measurements(run.valve, run.hold, times=run.times, **told)


def test_several_runs_are_fitted_together():
    runs = [measured("foot", holds=25, seed=seed) for seed in range(3)]
    together, alone = (identify(each, guess=TRUTH, starts=1) for each in (runs, runs[0]))
    assert together.samples == 3 * alone.samples
    assert np.diag(together.covariance)[2] < np.diag(alone.covariance)[2]
    assert together.groups.deborah == pytest.approx(TRUTH.deborah, rel=0.02)


def test_an_actuator_is_found_in_si():
    true = Actuator.ecoflex()
    hold = 0.06
    motion = simulate(true, random_bits(60, 0), hold / true.scales.time, samples_per_hold=8).in_si(true)
    run = Measurements.of(motion, "deformation", "foot", noise=0.01)
    assert run.hold == pytest.approx(hold)
    free = ("stiffness", "lag", "damping", "static_friction", "kinetic_friction")
    guess = replace(true, stiffness=120.0, lag=0.012, damping=1.1, static_friction=1.5, kinetic_friction=0.4)
    found = identify(run, free=free, guess=guess)
    for name in free:
        assert getattr(found.body, name) == pytest.approx(getattr(true, name), rel=0.02), name
    assert found.body.payload_mass == true.payload_mass
    assert found.groups == found.body.groups


def test_each_channel_is_weighed_by_the_noise_that_is_left_of_it():
    motion = simulate(TRUTH, random_bits(20, 0), 1.0, samples_per_hold=8)
    exact, rough = (Measurements.of(motion, name, noise=noise) for name, noise in (("pressure", 1e-4), ("foot", 3.0)))
    both = replace(exact, times=None, foot=rough.foot)
    alone, together = (identify(run, free=("deborah",), guess=TRUTH, starts=1) for run in (exact, both))
    error = np.sqrt(alone.covariance[0, 0])
    assert abs(together.groups.deborah - alone.groups.deborah) < 0.1 * error
    assert together.covariance[0, 0] == pytest.approx(alone.covariance[0, 0], rel=0.05)


@pytest.mark.parametrize(
    ("free", "other", "value"),
    [("kinetic_friction", "static_friction", 0.2), ("static_friction", "kinetic_friction", 0.4)],
)
def test_one_friction_goes_as_far_as_the_other_which_is_taken_as_it_was_guessed(free, other, value):
    guess = replace(TRUTH, static_friction=value, kinetic_friction=value)
    found = identify(measured("foot", holds=10), free=(free,), guess=guess, starts=8)
    assert getattr(found.groups, other) == value
    assert getattr(found.groups, free) == pytest.approx(value, rel=1e-4)


def test_a_marker_that_was_hidden_at_first_is_fitted_from_when_it_was_seen():
    whole = measured("deformation", "foot", holds=40)
    late = np.where(np.arange(320) < 120, np.nan, whole.foot)
    for run in (replace(whole, times=None, foot=late), Measurements(whole.valve, 1.0, 8, foot=late)):
        found = identify(run, free=("deborah", "kinetic_friction"), guess={**TRUTH.to_dict(), "deborah": 0.5}, starts=8)
        assert found.groups.deborah == pytest.approx(TRUTH.deborah, rel=0.02)


def test_what_the_data_cannot_tell_is_said():
    # The valve is never opened: nothing moves, and nothing is told.
    still = Measurements(np.zeros(20), 1.0, 4, pressure=1e-3 * np.random.default_rng(0).standard_normal(80))
    found = identify(still, free=("deborah", "duffing"), starts=4)
    assert len(found.warnings) == 2
    assert all("the data hardly tell a body from one" in told for told in found.warnings)
    # Masses, stiffnesses and pressures that grow together move alike.
    true = Actuator.ecoflex()
    motion = simulate(true, random_bits(30, 0), 1.0, samples_per_hold=4).in_si(true)
    free = ("payload_mass", "foot_mass", "stiffness", "cubic_stiffness", "damping", "bore_area")
    told = identify(Measurements.of(motion, "deformation", "foot", noise=0.01), free=free, guess=true, starts=1)
    assert len(told.warnings) == 1
    assert all(name in told.warnings[0] for name in free)


def test_a_wrong_count_of_slips_is_overcome():
    # Of the sum of squares this is near a valley of its own, in which what is left is half as large again.
    near = replace(TRUTH, static_friction=1.08 * TRUTH.static_friction, kinetic_friction=0.99 * TRUTH.kinetic_friction)
    found = identify(measured("deformation", "foot"), guess=near, starts=1)
    assert found.groups.static_friction == pytest.approx(TRUTH.static_friction, rel=0.02)
    assert found.groups.kinetic_friction == pytest.approx(TRUTH.kinetic_friction, rel=2e-3)


def test_a_static_friction_next_to_the_kinetic_one_is_said_to_be_hidden():
    body = replace(TRUTH, static_friction=0.16, kinetic_friction=0.156)
    motion = simulate(body, random_bits(60, 1), 1.0, samples_per_hold=8)
    found = identify(Measurements.of(motion, "deformation", "foot", noise=0.01), guess=body, starts=1)
    (told,) = [warning for warning in found.warnings if warning.startswith("static_friction may be within 5%")]
    low, high = found.interval()["static_friction"]
    assert told.endswith(f"no better than {low:.3g} to {high:.3g}")
    assert low < 0.16 < high
    assert not identify(measured("deformation", holds=30), guess=TRUTH, starts=1).warnings


def test_a_body_that_differs_from_the_model_is_said_to():
    motion = simulate(TRUTH, random_bits(40, 1), 1.0, samples_per_hold=8, scene={"slope": 0.03})
    run = Measurements.of(motion, "deformation", "foot", noise=0.01)
    wrong_scene, right = (
        identify(run, free=("deborah", "kinetic_friction"), guess=TRUTH, starts=1, scene=scene)
        for scene in (None, {"slope": 0.03})
    )
    assert any(warning.startswith("what is left is more than noise") for warning in wrong_scene.warnings)
    assert right.warnings == ()


def test_an_interval_reaches_as_far_as_bodies_beside_the_fit_fit_as_well():
    found = identify(measured("foot", holds=30), free=("deborah", "duffing"), guess=TRUTH, starts=1)
    low, _ = found.interval()["deborah"]
    values, rises = found.profiles["deborah"]
    np.testing.assert_array_equal(rises >= 0.0, True)
    # Where there is no kink the sum of squares is a parabola.
    error = np.sqrt(found.covariance[0, 0])
    near = np.abs(values - found.groups.deborah) < 3.0 * error
    assert near.sum() > 10
    np.testing.assert_allclose(rises[near], ((values[near] - found.groups.deborah) / error) ** 2, rtol=0.2, atol=0.1)
    # As many squares of the noise as the interval's own end has are within it, and more are not.
    further = {name: (np.array([9.0, 11.0]), np.array([3.8, 4.2])) for name in found.names}
    wider = replace(found, profiles=further).interval()["deborah"]
    assert wider == pytest.approx((low, 9.0))


def test_a_chain_is_fitted_too():
    scene = {"segments": 2, "tube_mass": 0.1}
    motion = simulate(TRUTH, random_bits(12, 0), 1.0, samples_per_hold=4, scene=scene)
    run = Measurements.of(motion, "deformation")
    found = identify(run, free=("deborah",), guess={**TRUTH.to_dict(), "deborah": 0.6}, scene=scene, starts=1)
    assert found.groups.deborah == pytest.approx(TRUTH.deborah, rel=1e-6)


@pytest.mark.parametrize("each", [4, None], ids=["equally spaced", "at times of their own"])
def test_slopes_are_those_of_bodies_beside_each_other(each):
    true = Actuator.ecoflex()
    hold = 0.06
    motion = simulate(true, random_bits(10, 0), hold / true.scales.time, samples_per_hold=4).in_si(true)
    channels = {name: getattr(motion, name) for name in CHANNELS}
    times = None if each else motion.time - 0.001
    run = Measurements(motion.valve, hold, each, times, **channels)
    names = [name for name in true.__dataclass_fields__ if name != "segments"]
    slopes = slopes_of(true, run, Scene(), 1e-9, names)
    nudge = 1e-4
    for j, name in enumerate(names):
        value = getattr(true, name)
        beside = [replace(true, **{name: value * (1.0 + sign * nudge)}) for sign in (1.0, -1.0)]
        for channel, (there, back) in predicted(beside, run, Scene(), 1e-9).items():
            exact = (there - back) / (2.0 * nudge * value)
            # Between samples of a fine grid slopes are interpolated, and they jump where the foot stops.
            tolerance = 1e-4 if each else 0.3 if channel.endswith("velocity") else 0.03
            size = np.abs(exact).max() + np.abs(channels[channel]).max() / value
            assert np.abs(slopes[channel][:, j] - exact).max() <= tolerance * size, (name, channel)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"valve": [0.0, 2.0]}, r"valve must be in \[0, 1\], got 0.0 to 2.0"),
        ({"samples_per_hold": None}, "samples_per_hold or times must be given, and not both"),
        ({"times": [0.5]}, "samples_per_hold or times must be given, and not both"),
        (
            {"foot": None},
            "one of deformation, velocity, pressure, foot, foot_velocity, payload must have been measured",
        ),
        ({"foot": [1.0]}, r"foot must have 2 samples, one a time, got shape \(1,\)"),
        ({"foot": [np.nan, np.nan]}, "foot must be finite but for gaps"),
        ({"foot": [np.inf, 0.0]}, "foot must be finite but for gaps"),
        ({"samples_per_hold": None, "times": [0.5, 0.5]}, "times must ascend from 0 or later to 2.0"),
        ({"samples_per_hold": None, "times": [0.5, 2.5]}, "times must ascend from 0 or later to 2.0"),
    ],
)
def test_refuses_what_is_no_measurement(change, message):
    whole = {"valve": [0.0, 1.0], "hold": 1.0, "samples_per_hold": 1, "foot": [0.0, 1.0]}
    with pytest.raises(ValueError, match=message):
        Measurements(**whole | change)


def test_refuses_instruments_that_tell_of_no_one_run_from_rest():
    one = simulate(TRUTH, [1, 0], 0.5)
    with pytest.raises(ValueError, match="trajectory must be of one crawler, got 2"):
        Measurements.of(simulate([TRUTH, TRUTH], [1, 0], 0.5), "foot")
    with pytest.raises(ValueError, match="trajectory must begin at rest"):
        Measurements.of(simulate(TRUTH, [1, 0], 0.5, initial=one.final_state), "foot")
    with pytest.raises(ValueError, match="channels has no 'slips'"):
        Measurements.of(one, "slips")
    with pytest.raises(TypeError, match="foot must be an array of real numbers"):
        Measurements([1, 0], 0.5, 1, foot=["a", "b"])


def test_refuses_what_cannot_be_identified():
    run = Measurements([0.0, 1.0], 1.0, 1, foot=[0.0, 1.0])
    with pytest.raises(ValueError, match="measurements must have more samples than the 7 free, got 2"):
        identify(run)
    with pytest.raises(ValueError, match="free must name what to find of an Actuator"):
        identify(run, guess=Actuator.ecoflex())
    for free in ((), ("colour",), ("duffing", "duffing")):
        with pytest.raises(ValueError, match="free "):
            identify(run, free=free)
    with pytest.raises(TypeError, match="measurements must be Measurements or a sequence"):
        identify([])
