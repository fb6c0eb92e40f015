"""The one real body that the claims are also told of, in mm, kPa and s."""

from ...crawler import Actuator
from ...crawler.model.elastomer import ECOFLEX_00_30
from ...crawler.model.tube_force import Tube
from .claim import Number

__all__ = ["BODY", "TUBE", "TUBE_MASS", "body_with", "in_millimetres", "in_seconds", "portrait"]

_DENSITY, _PRESSURE = 1070.0, 20e3
TUBE = Tube(material=ECOFLEX_00_30, outer_radius=8.25e-3, inner_radius=5.64e-3, length=0.125, thread_radius=5.64e-3)
"""Of Ecoflex 00-30, wound with threads at the bore (docs/materials.md)."""


def body_with(tube_share: float) -> Actuator:
    """That tube between a payload and a rubber foot, with a share of its mass at either end.

    Its stiffness, area and coupling are those of its elastomer.
    """
    return Actuator.from_elastomer(
        TUBE,
        density=_DENSITY,
        payload_mass=0.167,
        foot_mass=0.067,
        peak_pressure=_PRESSURE,
        lag=0.03,
        static_friction=0.82,
        kinetic_friction=0.54,
        damping=0.4,
        tube_share=tube_share,
    )


BODY = body_with(0.5)
"""The real body of the claims."""
TUBE_MASS = BODY.mass - 0.167 - 0.067
"""Of the tube, kg."""


def in_millimetres(value: float, low: float | None = None, high: float | None = None) -> Number:
    """A length in natural units of the body, in mm."""
    return _scaled(BODY.scales.length * 1e3, "mm", value, low, high)


def in_seconds(value: float) -> Number:
    """A time in natural units of the body, in s."""
    return _scaled(BODY.scales.time, "s", value)


def portrait() -> str:
    """The body in a sentence."""
    scales, groups = BODY.scales, BODY.groups
    return (
        f"a tube of Ecoflex 00-30 of {TUBE.length * 1e3:.0f} mm, {TUBE_MASS * 1e3:.0f} g, under up to "
        f"{BODY.peak_pressure / 1e3:.0f} kPa, between {BODY.payload_mass * 1e3:.0f} g and {BODY.foot_mass * 1e3:.0f} g "
        f"with its mass: z_c = {scales.length * 1e3:.1f} mm, t_c = {scales.time:.4f} s, P_max A_0 z_c = "
        f"{scales.energy * 1e3:.1f} mJ, Pi1 = {groups.duffing:.2g}, Pi2 = {groups.damping_ratio:.2g}, "
        f"Pi4 = {groups.deborah:.2g}, Pi5 = {groups.radial_coupling:.2g}"
    )


def _scaled(unit: float, name: str, value: float, low: float | None = None, high: float | None = None) -> Number:
    return Number(value * unit, None if low is None else low * unit, None if high is None else high * unit, name)
