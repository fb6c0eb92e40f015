"""What bodies would have done in the place of the one that was measured."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from ...crawler import Actuator, Groups, Scene, simulate, Trajectory
from ..halving import by_halves
from .measurements import Measurements

__all__ = ["Body", "predicted"]

Body = Groups | Actuator

# Samples of a hold between which the motion is interpolated where it was measured at times of its own.
_FINE = 48
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

    def motion(some: Sequence[Body]) -> Trajectory:
        return simulate(
            [body if isinstance(body, Groups) else body.groups for body in some],
            np.tile(run.valve, (len(some), 1)),
            run.hold / np.array([_units(body)[1] for body in some]),
            scene=scene,
            tolerance=tolerance,
            samples_per_hold=run.samples_per_hold or _FINE,
        )

    for rows, moved in by_halves(motion, bodies):
        for name, values in found.items():
            values[rows] = _channel(name, bodies[rows], moved, run)
    return found


def _channel(name: str, bodies: Sequence[Body], moved: Trajectory, run: Measurements) -> NDArray[np.float64]:
    """One channel of every body at the times of the run, in its units."""
    length, time, pressure = np.array([_units(body) for body in bodies]).T[:, :, np.newaxis]
    unit = {"pressure": pressure, "velocity": length / time, "foot_velocity": length / time}.get(name, length)
    values = getattr(moved, name)
    if run.samples_per_hold is not None:
        return values * unit
    grid = np.arange(values.shape[1] + 1) * run.hold / _FINE
    values = _from_rest(values)
    if name in _RATES:
        rates = _from_rest(sum(getattr(moved, rate) for rate in _RATES[name]) / time)
        return CubicHermiteSpline(grid, values, rates, axis=1)(run.times) * unit
    return PchipInterpolator(grid, values, axis=1)(run.times) * unit


def _from_rest(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Samples with the start before them, at rest."""
    return np.pad(values, ((0, 0), (1, 0)))


def _units(body: Body) -> tuple[float, float, float]:
    """What one natural unit of length, time and pressure is in the units of the measurements."""
    if isinstance(body, Groups):
        return 1.0, 1.0, 1.0
    scales = body.scales
    return scales.length, scales.time, scales.pressure
