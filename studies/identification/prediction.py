"""What bodies would have done in the place of the one that was measured."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from ...crawler import Actuator, Groups, Scene, sensitivities, simulate, Trajectory
from ...crawler.model.groups import RANGES
from ..halving import by_halves
from .measurements import Measurements

__all__ = ["Body", "predicted", "slopes_of"]

Body = Groups | Actuator

# Samples of a natural unit of time between which the motion is interpolated where it was measured at times of its own,
# and least and most of a hold. Beside a slip a thousandth of a channel's spread may be lost, and less between two.
_FINE = 96
_LEAST, _MOST = 48, 4096
_AT_ONCE = 2**22  # samples of all bodies
# Relative step of differences of groups and scales, which are smooth.
_STEP = 1e-6
# What the rate of each position is the sum of.
_RATES = {"deformation": ("velocity",), "foot": ("foot_velocity",), "payload": ("velocity", "foot_velocity")}


def predicted(
    bodies: Sequence[Body], run: Measurements, scene: Scene, tolerance: float
) -> dict[str, NDArray[np.float64]]:
    """The channels that were measured, as each body would have shown them.

    Parameters
    ----------
    bodies : sequence of Groups, or of Actuators
        Whose units are natural, or SI: those of `run`.
    run : Measurements
    scene : Scene
    tolerance : float
        Of `simulate`.

    Returns
    -------
    dict of str to (bodies, samples) array
        NaN for a body that cannot be simulated.
    """
    found = {name: np.full((len(bodies), run.times.size), np.nan) for name in run.measured}
    each = _samples_per_hold(bodies, run)
    at_once = max(1, _AT_ONCE // (each * run.valve.size))

    def motion(some: Sequence[Body]) -> Trajectory:
        return simulate(
            [body if isinstance(body, Groups) else body.groups for body in some],
            np.tile(run.valve, (len(some), 1)),
            run.hold / np.array([_units(body)[1] for body in some]),
            scene=scene,
            tolerance=tolerance,
            samples_per_hold=each,
        )

    for first in range(0, len(bodies), at_once):
        for rows, moved in by_halves(motion, bodies[first : first + at_once], first):
            for name, values in found.items():
                values[rows] = _channel(name, bodies[rows], moved, run)
    return found


def slopes_of(
    body: Body, run: Measurements, scene: Scene, tolerance: float, names: Sequence[str]
) -> dict[str, NDArray[np.float64]]:
    """Derivatives of the channels that were measured by parameters of the body, through slips and stops.

    Parameters
    ----------
    body : Groups or Actuator
    run : Measurements
    scene : Scene
        Any but a chain of heavy segments.
    tolerance : float
    names : sequence of str
        Fields of the body.

    Returns
    -------
    dict of str to (samples, names) array

    Raises
    ------
    SolverError
        If the body cannot be simulated.
    """
    length, time, pressure = _units(body)
    groups = body if isinstance(body, Groups) else body.groups
    each = _samples_per_hold([body], run)
    moved = sensitivities(
        groups,
        run.valve,
        run.hold / time,
        scene=scene,
        tolerance=tolerance,
        samples_per_hold=each,
    )
    by_own, by_units = _derivatives(body, names, run.hold)
    motion = moved.motion | {"payload": moved.motion["foot"] + moved.motion["deformation"]}
    grid = np.arange(motion["foot"].size + 1) * run.hold / each
    slopes = {}
    for name in run.measured:
        unit, by_unit = length, by_units[0]
        if name == "pressure":
            unit, by_unit = pressure, by_units[2]
        elif name in ("velocity", "foot_velocity"):
            unit, by_unit = length / time, (by_units[0] - length / time * by_units[1]) / time
        slope = unit * getattr(moved, name) @ by_own + np.outer(motion[name], by_unit)
        if run.samples_per_hold is None:
            slope = np.stack([np.interp(run.times, grid, column) for column in _from_rest(slope.T)], axis=1)
        slopes[name] = slope
    return slopes


def _derivatives(body: Body, names: Sequence[str], hold: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Derivatives of groups and hold, (8, names), and of the units of length, time and pressure, (3, names)."""
    if isinstance(body, Groups):
        places = [list(RANGES).index(name) for name in names]
        return np.eye(len(RANGES) + 1)[:, places], np.zeros((3, len(names)))

    def numbers(one: Actuator) -> NDArray[np.float64]:
        units = _units(one)
        return np.array([*one.groups.to_dict().values(), hold / units[1], *units])

    columns = []
    for name in names:
        value = getattr(body, name)
        # One-sided of the frictions, in which all is linear: they may not pass each other.
        ahead = value * (1.0 if name == "kinetic_friction" else 1.0 + _STEP)
        behind = value * (1.0 if name == "static_friction" else 1.0 - _STEP)
        change = numbers(replace(body, **{name: ahead})) - numbers(replace(body, **{name: behind}))
        columns.append(change / (ahead - behind))
    told = np.stack(columns, axis=1)
    return told[:-3], told[-3:]


def _channel(name: str, bodies: Sequence[Body], moved: Trajectory, run: Measurements) -> NDArray[np.float64]:
    """One channel of every body at the times of the run, in its units."""
    length, time, pressure = np.array([_units(body) for body in bodies]).T[:, :, np.newaxis]
    unit = {"pressure": pressure, "velocity": length / time, "foot_velocity": length / time}.get(name, length)
    values = getattr(moved, name)
    if run.samples_per_hold is not None:
        return values * unit
    if name == "pressure":
        return _pressure(bodies, values, run) * unit
    grid = np.arange(values.shape[1] + 1) * run.hold / (values.shape[1] // run.valve.size)
    values = _from_rest(values)
    if name in _RATES:
        rates = _from_rest(sum(getattr(moved, rate) for rate in _RATES[name]) / time)
        return CubicHermiteSpline(grid, values, rates, axis=1)(run.times) * unit
    return PchipInterpolator(grid, values, axis=1)(run.times) * unit


def _pressure(bodies: Sequence[Body], values: NDArray[np.float64], run: Measurements) -> NDArray[np.float64]:
    """The pressure at the times of the run, as share of its peak, which follows the valve with the lag."""
    lags = np.array([body.deborah if isinstance(body, Groups) else body.lag for body in bodies])[:, np.newaxis]
    each = values.shape[1] // run.valve.size
    begun = _from_rest(values[:, each - 1 :: each])
    k = np.clip(np.ceil(run.times / run.hold).astype(np.int64) - 1, 0, run.valve.size - 1)
    passed, opened = run.times - k * run.hold, run.valve[k] * run.hold
    filled = 1.0 + (begun[:, k] - 1.0) * np.exp(-np.minimum(passed, opened) / lags)
    emptied: NDArray[np.float64] = filled * np.exp(-np.maximum(passed - opened, 0.0) / lags)
    return emptied


def _samples_per_hold(bodies: Sequence[Body], run: Measurements) -> int:
    """Samples that are simulated of each hold: those of the run, or as many as interpolation takes."""
    if run.samples_per_hold is not None:
        return run.samples_per_hold
    longest = max(run.hold / _units(body)[1] for body in bodies)
    return int(np.clip(np.ceil(_FINE * longest), _LEAST, _MOST))


def _from_rest(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Samples with the start before them, at rest."""
    return np.pad(values, ((0, 0), (1, 0)))


def _units(body: Body) -> tuple[float, float, float]:
    """What one natural unit of length, time and pressure is in the units of the measurements."""
    if isinstance(body, Groups):
        return 1.0, 1.0, 1.0
    scales = body.scales
    return scales.length, scales.time, scales.pressure
