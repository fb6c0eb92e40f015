"""The equations of motion at an instant."""

import math

from ..compilation import compiled
from .body import Body, Physics, STUCK

__all__ = ["foot_velocity_at", "force", "inverse_mass", "pressure_after"]

# Arithmetic on the denormal numbers that a gap would end in takes a hundred times as long.
_FAINTEST = 1e-250


@compiled
def force(physics: Physics, z: float, v: float, p: float) -> float:
    """F = p (1 + Pi5 z) - z - Pi1 z^3 - 2 Pi2 v."""
    return p * (1.0 + physics.radial_coupling * z) - z * (1.0 + physics.duffing * z * z) - physics.damping * v


@compiled
def pressure_after(body: Body, physics: Physics, valve: float, t: float) -> float:
    """Pressure a time `t` after `body`, while the valve holds."""
    gap = (body.pressure - valve) * math.exp(-t * physics.lag_rate)
    return valve + gap if abs(gap) > _FAINTEST else valve


@compiled
def inverse_mass(physics: Physics, motion: int) -> float:
    """Rate v' per force: 1 / (1 - r) while the foot sticks, 1 / (r (1 - r)) while it slides."""
    return 1.0 / (physics.payload_fraction * (1.0 if motion == STUCK else physics.foot_fraction))


@compiled
def foot_velocity_at(body: Body, physics: Physics, velocity: float, t: float) -> float:
    """Velocity of the sliding foot a time `t` into the step, when the body stretches at the rate `velocity`."""
    gained = physics.payload_fraction * (body.velocity - velocity)
    return body.foot_velocity + gained - body.motion * physics.kinetic_friction * t
