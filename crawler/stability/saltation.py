"""What an event does to a small change of the motion.

The change moves the event by dt = -dg / g', g the event function, and for that time the one motion takes the place of
the other: with f the rates of the state and J the Jacobian of its jump, J + (f after - J f before) dg / g' (R. I. Leine
and H. Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, Springer 2004, chapter 7). Of the rates
only those of v and w jump, and of the state only w, which a stop sets to 0.
"""

from typing import NamedTuple

from ...compiling.compilation import compiled
from ..model.equations import acceleration_at_no_force, force, force_gradient, mobility_of, retardation
from ..model.state import Body, Coefficients, STUCK

__all__ = ["Saltation", "saltation_of"]


class Saltation(NamedTuple):
    """What a saltation matrix is made of."""

    later_z: float  # how much later the event comes for each unit of a change of z
    later_v: float
    later_w: float
    by_later_v: float  # v' before less v' after the event
    by_later_w: float  # w' likewise
    stops: bool  # whether the foot rests after it: no change of w is left
    moves: float  # how much later the event comes for each unit by which its function is larger


@compiled
def saltation_of(body: Body, mode: int, coefficients: Coefficients, valve: float, time: float) -> Saltation:
    """The saltation of an event.

    Parameters
    ----------
    body : Body
        Just before the event, in the motion that ends.
    mode : int
        That begins.
    coefficients : Coefficients
    valve : float
    time : float
        Of the event in the run. One at the very start does not move.

    Returns
    -------
    Saltation
    """
    z, v, p = body.deformation, body.velocity, body.pressure
    pull = force(coefficients, z, v, p)
    before, after = _acceleration(coefficients, body.mode, pull), _acceleration(coefficients, mode, pull)
    foot_before = _foot_acceleration(coefficients, body.mode, pull)
    foot_after = _foot_acceleration(coefficients, mode, pull)
    by_z, by_v, by_p = force_gradient(coefficients, z, p)
    pull_rate = by_z * v + by_v * before + by_p * (coefficients.lag_rate * (valve - p))
    # How fast the event function falls: of a grip s plus or less F, of a slip its speed.
    falling = -mode * pull_rate if body.mode == STUCK else -body.mode * foot_before
    moves = 1.0 / falling if falling > 0.0 and time > 0.0 else 0.0
    jumps = (before - after, foot_before - foot_after, mode == STUCK, moves)
    if body.mode == STUCK:
        return Saltation(mode * by_z * moves, mode * by_v * moves, 0.0, *jumps)
    return Saltation(0.0, 0.0, body.mode * moves, *jumps)


@compiled
def _acceleration(coefficients: Coefficients, mode: int, pull: float) -> float:
    return mobility_of(coefficients, mode) * pull + acceleration_at_no_force(coefficients, mode)


@compiled
def _foot_acceleration(coefficients: Coefficients, mode: int, pull: float) -> float:
    if mode == STUCK:
        return 0.0
    return -coefficients.payload_fraction * _acceleration(coefficients, mode, pull) - retardation(coefficients, mode)
