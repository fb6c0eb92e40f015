"""The crawler in SI units, and its map to dimensionless groups."""

import math
from dataclasses import dataclass, fields
from typing import NamedTuple, Self, TYPE_CHECKING

from ...common.validation import number_within, whole_number
from .groups import Groups

if TYPE_CHECKING:
    from .tube_force import Tube

__all__ = ["STANDARD_GRAVITY", "Actuator", "Scales"]

STANDARD_GRAVITY = 9.80665  # m/s^2
# Of any magnitude in SI: of such numbers no scale or group overflows (Pi1 holds their eighth power).
_MAGNITUDES = "[1e-37, 1e37]"
# Of a tube's measures: the stiffness, bore and mass that come of such numbers are magnitudes as above.
_MODULI = "[1e-3, 1e15]"
_LENGTHS = "[1e-6, 1e6]"


class Scales(NamedTuple):
    """What one natural unit is in SI."""

    length: float  # z_c = P_max A_0 / k_1, m
    time: float  # t_c = sqrt(M / k_1), s
    force: float  # P_max A_0, N
    pressure: float  # P_max, Pa

    @property
    def energy(self) -> float:
        """P_max A_0 z_c, J."""
        return self.force * self.length


@dataclass(frozen=True, slots=True, kw_only=True)
class Actuator:
    """One pneumatic actuator with a payload in front and a foot behind, in SI.

    The paper writes A_0 both for the bore that the pressure fills and for the elastomer's wall; they are two areas
    here. The bore carries pressure; the wall gives stiffness and mass (:meth:`from_tube`).

    Parameters
    ----------
    payload_mass, foot_mass : float
        m_p and m_f, kg, > 0, each with its share of the tube's mass. Friction acts on the weight of m_f alone.
    stiffness : float
        k_1 of the whole body, N/m, > 0.
    cubic_stiffness : float
        k_3 of the whole body, N/m^3, >= 0.
    damping : float
        b, N s/m, >= 0.
    bore_area : float
        A_0 under pressure, m^2, > 0.
    peak_pressure : float
        P_max, Pa, > 0.
    lag : float
        tau of the fluid, s, > 0.
    radial_coupling : float
        alpha, 1/m, >= 0.
    static_friction, kinetic_friction : float
        mu_s and mu_k, >= 0, mu_k <= mu_s.
    gravity : float
        g, m/s^2, >= 0.
    segments : int
        N, segments that the tube is thought divided into, >= 1.

    Raises
    ------
    ValueError
        If a value is not finite or out of range; the message names it.
    """

    payload_mass: float
    foot_mass: float
    stiffness: float
    cubic_stiffness: float = 0.0
    damping: float = 0.0
    bore_area: float
    peak_pressure: float
    lag: float
    radial_coupling: float = 0.0
    static_friction: float
    kinetic_friction: float
    gravity: float = STANDARD_GRAVITY
    segments: int = 1

    def __post_init__(self) -> None:
        positive = {"payload_mass", "foot_mass", "stiffness", "bore_area", "peak_pressure", "lag"}
        whole_number("segments", self.segments, 1)
        for field in fields(self):
            if field.name != "segments":
                allowed = "(0, inf)" if field.name in positive else "[0, inf)"
                value = number_within(field.name, getattr(self, field.name), allowed)
                if value:
                    number_within(field.name, value, _MAGNITUDES)
        if self.kinetic_friction > self.static_friction:
            raise ValueError(
                f"kinetic_friction must be in [0, static_friction = {self.static_friction!r}], "
                f"got {self.kinetic_friction!r}"
            )
        if self.foot_mass == self.mass:
            raise ValueError(
                f"payload_mass must be more than a rounding of foot_mass = {self.foot_mass!r}, "
                f"got {self.payload_mass!r}"
            )

    @classmethod
    def from_tube(
        cls,
        *,
        youngs_modulus: float,
        outer_radius: float,
        inner_radius: float,
        density: float,
        length: float,
        payload_mass: float,
        foot_mass: float,
        peak_pressure: float,
        lag: float,
        static_friction: float,
        kinetic_friction: float,
        cubic_stiffness: float = 0.0,
        damping: float = 0.0,
        radial_coupling: float = 0.0,
        gravity: float = STANDARD_GRAVITY,
        segments: int = 1,
        tube_share: float = 0.5,
    ) -> Self:
        """Lump an elastomer tube between a payload and a foot.

        A segment has stiffness E A_w / (L_0 / N) (equation S15), so the body, N of them in series, has E A_w / L_0,
        with the wall's area A_w = pi (R_o^2 - R_i^2). Either end bears a share of the tube's mass rho A_w L_0 (N times
        equation S14), and the bore pi R_i^2 carries the pressure.

        Parameters
        ----------
        youngs_modulus : float
            E, Pa, > 0.
        outer_radius, inner_radius : float
            R_o > R_i > 0, m.
        density : float
            rho, kg/m^3, >= 0.
        length : float
            L_0, m, > 0.
        payload_mass, foot_mass : float
            What is fixed to either end, without the tube, kg, >= 0.
        peak_pressure, lag, static_friction, kinetic_friction, cubic_stiffness, damping, radial_coupling, gravity
            As in :class:`Actuator`, for the whole body.
        segments : int
            N >= 1.
        tube_share : float, in [0, 1/2]
            Of the tube's mass, that either end bears. With 1/2 none of it is lost, neither its inertia where the whole
            slides nor its weight on the foot, and the body is the chain of one segment (equation S14): the default.
            With 1/3 the body swings as fast as the tube does while the foot stands still (Lord Rayleigh, The Theory of
            Sound, section 156), and its crawler is lighter by a third of the tube: the deformation keeps several times
            nearer to that of a chain of segments (docs/claims.md, C2), so take it where the deformation is what counts.

        Returns
        -------
        Actuator

        Raises
        ------
        ValueError
            If a value is out of range; the message names it.
        """
        for name, value in {
            "youngs_modulus": youngs_modulus,
            "outer_radius": outer_radius,
            "inner_radius": inner_radius,
            "length": length,
        }.items():
            number_within(name, value, "(0, inf)")
            number_within(name, value, _MODULI if name == "youngs_modulus" else _LENGTHS)
        _refuse_masses(density=density, payload_mass=payload_mass, foot_mass=foot_mass)
        if inner_radius >= outer_radius:
            raise ValueError(f"inner_radius must be in (0, outer_radius = {outer_radius!r}), got {inner_radius!r}")
        wall_area = math.pi * (outer_radius**2 - inner_radius**2)
        borne = number_within("tube_share", tube_share, "[0, 0.5]") * density * wall_area * length
        return cls(
            payload_mass=payload_mass + borne,
            foot_mass=foot_mass + borne,
            stiffness=youngs_modulus * wall_area / length,
            cubic_stiffness=cubic_stiffness,
            damping=damping,
            bore_area=math.pi * inner_radius**2,
            peak_pressure=peak_pressure,
            lag=lag,
            radial_coupling=radial_coupling,
            static_friction=static_friction,
            kinetic_friction=kinetic_friction,
            gravity=gravity,
            segments=segments,
        )

    @classmethod
    def from_elastomer(
        cls,
        tube: "Tube",
        *,
        density: float,
        payload_mass: float,
        foot_mass: float,
        peak_pressure: float,
        lag: float,
        static_friction: float,
        kinetic_friction: float,
        damping: float = 0.0,
        gravity: float = STANDARD_GRAVITY,
        segments: int = 1,
        tube_share: float = 0.5,
    ) -> Self:
        """Lump a tube whose stiffness, cubic stiffness, area and coupling follow from its elastomer.

        They are those of the lumped body nearest to the tube between rest and where the peak pressure holds it
        (:meth:`Tube.lumped`, which tells how near that is).

        Parameters
        ----------
        tube : Tube
        density, payload_mass, foot_mass, peak_pressure, lag, static_friction, kinetic_friction, damping, gravity
            As in :meth:`from_tube`.
        segments : int
            N >= 1.
        tube_share : float, in [0, 1/2]
            Of the tube's mass, that either end bears, as in :meth:`from_tube`.

        Returns
        -------
        Actuator

        Raises
        ------
        ValueError
            If a value is out of range, the tube balloons under the peak pressure, or pressure does not push it.
        """
        _refuse_masses(density=density, payload_mass=payload_mass, foot_mass=foot_mass)
        if tube.thread_radius is None:
            raise ValueError(
                "tube must have a thread_radius, got None: pressure does not lengthen a tube without threads"
            )
        wall_area = math.pi * (tube.outer_radius**2 - tube.inner_radius**2)
        borne = number_within("tube_share", tube_share, "[0, 0.5]") * density * wall_area * tube.length
        body = tube.lumped((0.0, tube.deformation_at(peak_pressure)), peak_pressure)
        return cls(
            payload_mass=payload_mass + borne,
            foot_mass=foot_mass + borne,
            stiffness=body.stiffness,
            cubic_stiffness=body.cubic_stiffness,
            damping=damping,
            bore_area=body.pressure_area,
            peak_pressure=peak_pressure,
            lag=lag,
            radial_coupling=body.radial_coupling,
            static_friction=static_friction,
            kinetic_friction=kinetic_friction,
            gravity=gravity,
            segments=segments,
        )

    @classmethod
    def ecoflex(cls) -> Self:
        """A crawler of Ecoflex 00-30 whose groups are the defaults, to the last bit.

        A tube of 12.5 cm with 1.14 cm^2 of wall at E = 70 kPa has k_1 = 64 N/m. Its bore of 1 cm^2 at 20 kPa pushes
        with 2 N and stretches it by a quarter of its length, z_c = 1/32 m. With 250 g in all the natural time is
        1/16 s. Static and kinetic friction coefficients of the rubber foot are 0.82 and 0.54. The cubic stiffness,
        the damping, the lag and the radial coupling are those that the default groups stand for.
        """
        foot_mass, force = 0.075, 2.0
        weight = foot_mass * STANDARD_GRAVITY
        return cls(
            payload_mass=0.175,
            foot_mass=foot_mass,
            stiffness=64.0,
            cubic_stiffness=32768.0,
            damping=0.4,
            bore_area=1.0e-4,
            peak_pressure=20.0e3,
            lag=0.03125,
            radial_coupling=6.4,
            static_friction=0.3 * force / weight,
            kinetic_friction=0.2 * force / weight,
        )

    @property
    def mass(self) -> float:
        """M = m_p + m_f, kg."""
        return self.payload_mass + self.foot_mass

    @property
    def segment_stiffness(self) -> float:
        """Linear stiffness of one of the N segments, N k_1 (equation S15), N/m."""
        return self.segments * self.stiffness

    @property
    def scales(self) -> Scales:
        """Natural units of length, time, force and pressure (equations 3 to 6)."""
        force = self.peak_pressure * self.bore_area
        return Scales(
            length=force / self.stiffness,
            time=math.sqrt(self.mass / self.stiffness),
            force=force,
            pressure=self.peak_pressure,
        )

    @property
    def groups(self) -> Groups:
        """The dimensionless groups (equations 3 to 6 and S19 to S22)."""
        scales = self.scales
        weight = self.foot_mass * self.gravity / scales.force
        return Groups(
            duffing=self.cubic_stiffness * scales.length**2 / self.stiffness,
            damping_ratio=self.damping / (2.0 * math.sqrt(self.mass * self.stiffness)),
            deborah=self.lag / scales.time,
            radial_coupling=self.radial_coupling * scales.length,
            foot_mass_fraction=self.foot_mass / self.mass,
            static_friction=self.static_friction * weight,
            kinetic_friction=self.kinetic_friction * weight,
        )


def _refuse_masses(**masses: float) -> None:
    """Refuse what is no density or mass of a tube and of what is fixed to it."""
    for name, value in masses.items():
        number_within(name, value, "[0, inf)")
        number_within(name, value, "[0, 1e15]")
