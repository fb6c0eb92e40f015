"""The equations of motion at an instant: over floats, and over any numbers of `stickslip.compiling.arithmetic`."""

from ...compiling.arithmetic import exp, where
from ...compiling.compilation import formula
from .state import Body, Coefficients, STUCK

__all__ = [
    "acceleration_at_no_force",
    "elastic_energy",
    "foot_velocity_at",
    "force",
    "force_gradient",
    "force_terms",
    "held_stiffness",
    "is_free",
    "mobility_of",
    "moved",
    "pressure_after",
    "retardation",
    "stiffness_at",
]

# Arithmetic on the denormal numbers that a gap would end in takes a hundred times as long.
_FAINTEST = 1e-250


@formula
def force(coefficients: Coefficients, z: float, v: float, p: float) -> float:
    """F = p (1 + Pi5 z) - z - Pi1 z^3 - 2 Pi2 v."""
    return (
        p * (1.0 + coefficients.radial_coupling * z)
        - z * (1.0 + coefficients.duffing * z * z)
        - coefficients.damping * v
    )


@formula
def stiffness_at(coefficients: Coefficients, z: float, p: float) -> float:
    """K = -dF / dz = 1 + 3 Pi1 z^2 - Pi5 p."""
    return 1.0 + 3.0 * coefficients.duffing * z * z - coefficients.radial_coupling * p


@formula
def held_stiffness(coefficients: Coefficients, z: float) -> float:
    """`stiffness_at` without pressure, rounded otherwise: the lengths of steps depend on the last bit of an error."""
    return 1.0 + 3.0 * (coefficients.duffing * z * z)


@formula
def force_gradient(coefficients: Coefficients, z: float, p: float) -> tuple[float, float, float]:
    """Derivatives of the force with respect to z, v and p; the first is -`stiffness_at`, rounded otherwise."""
    by_z = p * coefficients.radial_coupling - 1.0 - 3.0 * coefficients.duffing * z * z
    return by_z, -coefficients.damping, 1.0 + coefficients.radial_coupling * z


@formula
def elastic_energy(coefficients: Coefficients, z: float) -> float:
    """Work that the springs take to be stretched by z: the integral of -`force` at v = p = 0."""
    return 0.5 * z * z * (1.0 + 0.5 * coefficients.duffing * z * z)


@formula
def force_terms(coefficients: Coefficients, z: float, v: float) -> float:
    """Size of the terms that a force is made of, to which its rounding is relative."""
    return 1.0 + abs(z) * (1.0 + coefficients.duffing * z * z) + coefficients.damping * abs(v)


@formula
def pressure_after(body: Body, coefficients: Coefficients, valve: float, t: float) -> float:
    """Pressure a time `t` after `body`, while the valve holds."""
    gap = (body.pressure - valve) * exp(-t * coefficients.lag_rate)
    return where(abs(gap) > _FAINTEST, valve + gap, valve)


@formula
def mobility_of(coefficients: Coefficients, mode: int) -> float:
    """Rate v' per force: 1 / (1 - r) while the foot sticks, 1 / (r (1 - r)) while it slides."""
    return 1.0 / (coefficients.payload_fraction * where(mode == STUCK, 1.0, coefficients.foot_fraction))


@formula
def acceleration_at_no_force(coefficients: Coefficients, mode: int) -> float:
    """Rate v' of a body without force: its payload runs downhill while the foot sticks; drag tells while it slides."""
    return where(mode == STUCK, -coefficients.slope, mode * coefficients.kinetic_friction / coefficients.foot_fraction)


@formula
def is_free(coefficients: Coefficients) -> bool:
    """Whether nothing holds the foot, forward or backward: it slides alike both ways, and need never rest."""
    return where(coefficients.ratchet, 1.0, coefficients.static_friction) == 0.0


@formula
def retardation(coefficients: Coefficients, mode: int) -> float:
    """Rate at which friction and slope take momentum from a crawler whose foot slides."""
    return mode * coefficients.kinetic_friction + coefficients.slope


@formula
def foot_velocity_at(body: Body, coefficients: Coefficients, velocity: float, t: float) -> float:
    """Velocity of the sliding foot a time `t` into the step, when the body stretches at the rate `velocity`."""
    gained = coefficients.payload_fraction * (body.velocity - velocity)
    return body.foot_velocity + gained - retardation(coefficients, body.mode) * t


@formula
def moved(body: Body, coefficients: Coefficients, z: float, v: float, pressure: float, t: float) -> Body:
    """State a time `t` into a smooth motion that has brought the body to `z` and `v`; the foot by momentum."""
    sliding = body.mode != STUCK
    payload = coefficients.payload_fraction
    momentum = body.foot_velocity + payload * body.velocity
    way = (momentum - 0.5 * retardation(coefficients, body.mode) * t) * t - payload * (z - body.deformation)
    foot = where(sliding, body.foot + way, body.foot)
    # At a stop rounding can leave it a hair beyond zero. A free foot may have begun to turn round.
    speed = body.mode * foot_velocity_at(body, coefficients, v, t)
    foot_velocity = where(sliding & ((speed > 0.0) | is_free(coefficients)), body.mode * speed, 0.0)
    return Body(z, v, pressure, foot, foot_velocity, body.mode, body.slips)
