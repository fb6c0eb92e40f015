"""What may be measured of a moving body, and in which units."""

__all__ = ["CHANNEL_UNITS", "TIME_UNITS"]

_LENGTHS = {"m": 1.0, "cm": 1e2, "mm": 1e3, "um": 1e6}
_VELOCITIES = {f"{name}_s": parts for name, parts in _LENGTHS.items()}
_PRESSURES = {"Pa": 1.0, "mbar": 1e-2, "kPa": 1e-3, "bar": 1e-5, "MPa": 1e-6}

CHANNEL_UNITS = {
    "deformation": _LENGTHS,
    "velocity": _VELOCITIES,
    "pressure": _PRESSURES,
    "foot": _LENGTHS,
    "foot_velocity": _VELOCITIES,
    "payload": _LENGTHS,
}
"""By channel, each an attribute of `Trajectory`: the units that follow its name, as in ``deformation_mm``, with how
many of them are one of SI."""

TIME_UNITS = {"s": 1.0, "ms": 1e3, "us": 1e6}
"""The same of time."""
