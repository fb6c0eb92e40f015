"""A body in SI whose groups are any groups, and the units that a page shows."""

from typing import NamedTuple

from ..crawler import Actuator, Groups
from .setup import Setup

__all__ = ["Units", "actuator_with", "in_si", "units_of"]


class Units(NamedTuple):
    """What a natural unit is in the units shown, and how these are written."""

    length: float
    time: float
    pressure: float
    length_unit: str
    time_unit: str
    pressure_unit: str

    @property
    def speed_unit(self) -> str:
        """Of length a time."""
        return f"{self.length_unit}/{self.time_unit}"


NATURAL = Units(1.0, 1.0, 1.0, "z_c", "t_c", "P_max")


def actuator_with(groups: Groups) -> Actuator:
    """The crawler of Ecoflex with its elastomer, valve and ground changed so that the groups are given ones.

    Mass, stiffness, bore and peak pressure, and so all scales, stay those of `Actuator.ecoflex`.

    Parameters
    ----------
    groups : Groups

    Returns
    -------
    Actuator
        Whose `groups` are these but for roundings.
    """
    model = Actuator.ecoflex()
    scales = model.scales
    foot_mass = groups.foot_mass_fraction * model.mass
    weight = foot_mass * model.gravity
    return Actuator(
        payload_mass=model.mass - foot_mass,
        foot_mass=foot_mass,
        stiffness=model.stiffness,
        cubic_stiffness=groups.duffing * model.stiffness / scales.length**2,
        damping=groups.damping_ratio * 2.0 * (model.mass * model.stiffness) ** 0.5,
        bore_area=model.bore_area,
        peak_pressure=model.peak_pressure,
        lag=groups.deborah * scales.time,
        radial_coupling=groups.radial_coupling / scales.length,
        static_friction=groups.static_friction * scales.force / weight,
        kinetic_friction=groups.kinetic_friction * scales.force / weight,
        gravity=model.gravity,
    )


def units_of(setup: Setup) -> Units:
    """The units that a page shows: natural ones, or millimetres, seconds and kilopascals."""
    if setup.units == "natural":
        return NATURAL
    scales = actuator_with(setup.groups).scales
    return Units(1e3 * scales.length, scales.time, 1e-3 * scales.pressure, "mm", "s", "kPa")


def in_si(setup: Setup) -> dict[str, str]:
    """What each of a setup's numbers is of the body in SI, in words; nothing for what has no unit there.

    Parameters
    ----------
    setup : Setup

    Returns
    -------
    dict of str to str
        By the names of `NUMBERS`.
    """
    body = actuator_with(setup.groups)
    scales = body.scales
    return {
        "duffing": f"k₃ = {1e-3 * body.cubic_stiffness:.3g} kN/m³",
        "damping_ratio": f"b = {body.damping:.3g} N s/m",
        "deborah": f"τ = {1e3 * body.lag:.3g} ms",
        "radial_coupling": f"α = {body.radial_coupling:.3g} /m",
        "foot_mass_fraction": f"m_f = {1e3 * body.foot_mass:.3g} g",
        "static_friction": f"μ_s = {body.static_friction:.3g}",
        "kinetic_friction": f"μ_k = {body.kinetic_friction:.3g}",
        "slope": f"Mg sin = {setup.slope * scales.force:.3g} N",
        "hold": f"h = {1e3 * setup.hold * scales.time:.3g} ms",
    }
