"""Derivatives of the motion by the groups and the hold: by 50 digits, closed forms and SciPy, through every event."""

from decimal import Decimal
from types import SimpleNamespace

import numpy as np
import pytest
from cases import WORD
from decimal_judge import decimal_judge
from scipy.integrate import solve_ivp

from stickslip import Actuator, Groups, sensitivities, simulate
from stickslip.crawler import Scene, State
from stickslip.crawler.derivatives import PARAMETERS

SYMMETRIC = Scene(ratchet=False)
NUDGE = Decimal("1e-20")  # far above the 38 digits of the judge, far below what curvature would show
CHANNELS = ("deformation", "velocity", "foot", "foot_velocity")
CASES = {
    "slips and stops": (Groups(), WORD[:6], 1.0, {}),
    "both ways": (
        Groups(foot_mass_fraction=0.8, static_friction=0.1, kinetic_friction=0.05),
        WORD[:6],
        1.0,
        {"scene": SYMMETRIC},
    ),
    "uphill": (Groups(static_friction=0.2), WORD[2:6], 1.0, {"scene": Scene(ratchet=False, slope=0.3)}),
    "sliding at the start": (Groups(), WORD[2:5], 0.7, {"initial": State(0.2, -0.3, 0.5, 0.1, 0.4)}),
    "turning at once": (
        Groups(damping_ratio=0.01, static_friction=0.05, kinetic_friction=0.04),
        [0],
        2.0,
        {"initial": State(1.0, 0.0, 0.3), "scene": SYMMETRIC},
    ),
}


def judged(groups, valve, hold, options):
    """Derivatives of the end and of the events' times, by differences in 50 digits."""
    numbers = {name: Decimal(value) for name, value in groups.to_dict().items()} | {"hold": Decimal(hold)}

    def run(values):
        given = dict(values)
        length = given.pop("hold")
        return decimal_judge(SimpleNamespace(to_dict=lambda: given), valve, length, **options)

    here = run(numbers)
    ends, times = [], []
    for name in PARAMETERS:
        there = run(numbers | {name: numbers[name] + NUDGE})
        assert [mode for _, mode in there.events] == [mode for _, mode in here.events]
        ends.append([float((b - a) / NUDGE) for a, b in zip(here.last, there.last, strict=True)])
        times.append([float((b[0] - a[0]) / NUDGE) for a, b in zip(here.events, there.events, strict=True)])
    return np.array(ends).T, np.array(times).T, [mode for _, mode in here.events]


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_sensitivities_are_what_differences_in_fifty_digits_find_through_every_event(name):
    groups, valve, hold, options = CASES[name]
    ends, times, modes = judged(groups, valve, hold, options)
    found = sensitivities(groups, valve, hold, tolerance=1e-13, **options)
    assert found.names == PARAMETERS
    np.testing.assert_array_equal(found.event_mode, modes)
    for row, channel in zip(ends, CHANNELS, strict=True):
        np.testing.assert_allclose(getattr(found, channel)[-1], row, rtol=1e-7, atol=1e-8, err_msg=channel)
    np.testing.assert_allclose(found.event_shift, times, rtol=1e-7, atol=1e-8)
    np.testing.assert_array_equal(found.payload, found.foot + found.deformation)


def test_the_cases_are_what_they_are_called():
    def modes(name):
        groups, valve, hold, options = CASES[name]
        return sensitivities(groups, valve, hold, **options).event_mode.tolist()

    assert modes("slips and stops").count(0) >= 2
    assert {-1, 1} <= set(modes("both ways"))
    assert modes("turning at once")[:2] == [1, -1]


def linear(parameters, shares, hold):
    """z of a linear body whose foot is clamped, after its valve was opened at rest."""
    damping, lag, foot = (parameters[name] for name in ("damping_ratio", "deborah", "foot_mass_fraction"))
    t, mass, rate = shares * hold, 1.0 - foot, 1.0 / lag
    forced = -1.0 / (mass * rate**2 - 2.0 * damping * rate + 1.0)
    decay = damping / mass
    swing = np.sqrt(1.0 / mass - decay**2)
    even = -1.0 - forced
    odd = (rate * forced + decay * even) / swing
    return 1.0 + forced * np.exp(-rate * t) + np.exp(-decay * t) * (even * np.cos(swing * t) + odd * np.sin(swing * t))


@pytest.mark.parametrize("tolerance", [1e-6, 1e-12])
def test_a_linear_body_has_the_derivatives_of_its_closed_form(tolerance):
    groups, hold = Groups(duffing=0.0, radial_coupling=0.0, damping_ratio=0.1), 6.0
    found = sensitivities(groups, [1], hold, scene={"anchored": True}, samples_per_hold=9, tolerance=tolerance)
    values, shares = groups.to_dict() | {"hold": hold}, np.arange(1, 10) / 9
    for name in ("damping_ratio", "deborah", "foot_mass_fraction", "hold"):
        changed = values | {name: values[name] + 1e-30j}
        exact = linear(changed, shares, changed["hold"]).imag / 1e-30
        moved = found.deformation[:, PARAMETERS.index(name)]
        np.testing.assert_allclose(moved, exact, rtol=1e3 * tolerance, atol=1e3 * tolerance, err_msg=name)
    np.testing.assert_allclose(found.motion["deformation"], linear(values, shares, hold), atol=10.0 * tolerance)
    assert not found.deformation[:, PARAMETERS.index("static_friction")].any()
    assert not found.foot.any()


def test_a_nonlinear_body_has_those_that_variational_equations_find():
    groups, valve, hold = Groups(duffing=0.9, radial_coupling=0.5), [1, 0, 1], 1.3
    names = PARAMETERS[:5]
    at = np.array([groups.to_dict()[name] for name in names])

    def rates(y, q, u):
        z, v, p = y
        duffing, damping, lag, coupling, foot = q
        force = p * (1.0 + coupling * z) - z - duffing * z**3 - 2.0 * damping * v
        return np.array([v, force / (1.0 - foot), (u - p) / lag])

    def variational(_, state, u):
        y, by = state[:3], state[3:].reshape(3, 5)
        step = 1e-30j
        in_y = np.stack([rates(y + step * unit, at, u).imag / 1e-30 for unit in np.eye(3)], axis=1)
        in_q = np.stack([rates(y, at + step * unit, u).imag / 1e-30 for unit in np.eye(5)], axis=1)
        return np.concatenate([rates(y, at, u), (in_y @ by + in_q).ravel()])

    found = sensitivities(groups, valve, hold, scene={"anchored": True}, tolerance=1e-12)
    state = np.zeros(18)
    for k, u in enumerate(valve):
        state = solve_ivp(variational, (0.0, hold), state, "DOP853", args=(u,), rtol=1e-11, atol=1e-12).y[:, -1]
        expected = state[3:].reshape(3, 5)
        for row, channel in zip(expected, ("deformation", "velocity", "pressure"), strict=True):
            np.testing.assert_allclose(getattr(found, channel)[k, :5], row, rtol=1e-8, atol=1e-9)


@pytest.mark.parametrize("scene", [{"tube_mass": 0.4}, {"ratchet": False}], ids=["heavy tube", "duty cycles"])
def test_a_heavy_tube_and_duty_cycles_move_as_runs_beside_each_other_do(scene):
    duties, hold, nudge = [1.0, 0.3, 0.0, 0.6, 0.0], 1.1, 1e-5
    groups = Groups(static_friction=0.15, kinetic_friction=0.1)
    found = sensitivities(groups, duties, hold, scene=scene, tolerance=1e-13, samples_per_hold=3)
    values = groups.to_dict() | {"hold": hold}
    plain = simulate(groups, duties, hold, scene=scene, tolerance=1e-13, samples_per_hold=3)
    np.testing.assert_allclose(found.time, plain.time)
    np.testing.assert_allclose(found.event_time, plain.events["time"], atol=1e-10)
    for channel in (*CHANNELS, "pressure"):
        np.testing.assert_allclose(found.motion[channel], getattr(plain, channel), atol=1e-10)
    for j, name in enumerate(PARAMETERS):
        there, back = (
            simulate(
                {key: value for key, value in changed.items() if key != "hold"},
                duties,
                changed["hold"],
                scene=scene,
                tolerance=1e-13,
                samples_per_hold=3,
            )
            for changed in (values | {name: values[name] + sign * nudge} for sign in (1.0, -1.0))
        )
        for channel in (*CHANNELS, "pressure"):
            slope = (getattr(there, channel) - getattr(back, channel)) / (2.0 * nudge)
            np.testing.assert_allclose(getattr(found, channel)[:, j], slope, rtol=1e-5, atol=1e-6, err_msg=name)
        shift = (there.events["time"] - back.events["time"]) / (2.0 * nudge)
        np.testing.assert_allclose(found.event_shift[:, j], shift, rtol=1e-5, atol=1e-6, err_msg=name)


def test_a_run_has_room_for_all_its_events_and_is_that_of_an_actuator_too():
    body = Groups(duffing=20.0, damping_ratio=0.0, deborah=0.01, static_friction=1e-3, kinetic_friction=1e-3)
    found = sensitivities(body, [1, 0] * 2, 30.0, scene=SYMMETRIC)
    assert len(found.event_time) > 80
    assert found.event_shift.shape == (len(found.event_time), 8)
    assert np.isfinite(found.event_shift).all()
    np.testing.assert_array_equal(
        sensitivities(Actuator.ecoflex(), WORD, 1.0).foot, sensitivities(Groups(), WORD, 1.0).foot
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"scene": {"segments": 3, "tube_mass": 0.1}}, "scene must be no chain of heavy segments"),
        ({"valve": [[1, 0]]}, r"valve must have shape \(holds,\)"),
        ({"hold": 0.0}, r"hold must be in \(0, inf\), got 0.0"),
        ({"tolerance": 1.0}, r"tolerance must be in \[1e-15, 1e-2\], got 1.0"),
        ({"samples_per_hold": 0}, "samples_per_hold must be a whole number >= 1, got 0"),
        ({"max_steps": 3}, "max_steps"),
    ],
)
def test_refuses_what_has_no_sensitivities(arguments, message):
    whole = {"groups": Groups(), "valve": WORD, "hold": 1.0} | arguments
    with pytest.raises((ValueError, RuntimeError), match=message):
        sensitivities(**whole)
