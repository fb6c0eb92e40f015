"""The seven dimensionless groups that fix a crawler, and named choices of them."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from ...common.validation import known_names, number_within

__all__ = ["NONLINEAR", "PRESETS", "RANGES", "Groups", "GroupsLike", "HasGroups", "groups_of_each"]

RANGES = {
    "duffing": "[0, inf)",
    "damping_ratio": "[0, inf)",
    "deborah": "(0, inf)",
    "radial_coupling": "[0, inf)",
    "foot_mass_fraction": "(0, 1)",
    "static_friction": "[0, inf)",
    "kinetic_friction": "[0, inf)",
}
"""Values that each group may take, in the usual notation; `kinetic_friction` at most `static_friction` besides."""

NONLINEAR = ("duffing", "radial_coupling")
"""Groups without which the force is linear in stretch, rate and pressure; each is a field of `Coefficients` too."""


@dataclass(frozen=True, slots=True)
class Groups:
    """Dimensionless groups of the crawler.

    Lengths are measured in z_c = P_max A_0 / k_1, times in t_c = sqrt(M / k_1) with M = m_p + m_f, and forces
    in P_max A_0 (equations 3 to 6 of the paper), which makes Pi3 = 1.

    Parameters
    ----------
    duffing : float, in [0, inf)
        Pi1 = k_3 z_c^2 / k_1, cubic against linear stiffness.
    damping_ratio : float, in [0, inf)
        Pi2 = b / (2 sqrt(M k_1)), viscous loss in the elastomer.
    deborah : float, in (0, inf)
        Pi4 = tau / t_c, lag of the fluid against the period of the body.
    radial_coupling : float, in [0, inf)
        Pi5 = alpha z_c, growth of the pressurised area with stretch.
    foot_mass_fraction : float, in (0, 1)
        r = m_f / M.
    static_friction : float, in [0, inf)
        s = mu_s m_f g / (P_max A_0), pull at which the foot breaks loose.
    kinetic_friction : float, in [0, static_friction]
        k = mu_k m_f g / (P_max A_0), drag on the sliding foot. Above `static_friction` the foot would
        chatter for ever.

    Raises
    ------
    ValueError
        If a group is not finite or outside its range; the message names the group, its value and the range.
    TypeError
        If a group is not a real number.
    """

    duffing: float = 0.5
    damping_ratio: float = 0.05
    deborah: float = 0.5
    radial_coupling: float = 0.2
    foot_mass_fraction: float = 0.3
    static_friction: float = 0.3
    kinetic_friction: float = 0.2

    def __post_init__(self) -> None:
        for name, allowed in RANGES.items():
            object.__setattr__(self, name, number_within(name, getattr(self, name), allowed))
        if self.kinetic_friction > self.static_friction:
            raise ValueError(
                f"kinetic_friction must be in [0, static_friction = {self.static_friction!r}], "
                f"got {self.kinetic_friction!r}"
            )

    @classmethod
    def of(cls, choice: "GroupsLike | None") -> "Groups":
        """Groups from a preset's name, a mapping of some of the fields, an actuator, or groups themselves.

        Parameters
        ----------
        choice : Groups, str, mapping, Actuator or None
            None gives the defaults; a mapping changes the defaults it names.

        Returns
        -------
        Groups

        Raises
        ------
        ValueError
            If the preset or a field is unknown, or a value is out of range.
        TypeError
            If `choice` is none of the above.
        """
        if choice is None:
            return cls()
        if isinstance(choice, cls):
            return choice
        if isinstance(choice, str):
            if choice not in PRESETS:
                raise ValueError(f"groups must be one of the presets {sorted(PRESETS)}, got {choice!r}")
            return PRESETS[choice]
        if isinstance(choice, Mapping):
            known_names("groups", choice, RANGES)
            return cls(**choice)
        groups = getattr(choice, "groups", None)
        if isinstance(groups, cls):
            return groups
        raise TypeError(f"groups must be Groups, a preset's name, a mapping of fields or an Actuator, got {choice!r}")

    def to_dict(self) -> dict[str, float]:
        """Fields by name, ready for JSON."""
        return {name: getattr(self, name) for name in self.__slots__}


class HasGroups(Protocol):
    """What can be made dimensionless, as an `Actuator` can."""

    @property
    def groups(self) -> Groups:
        """Its dimensionless groups."""


GroupsLike = Groups | str | Mapping[str, float] | HasGroups
"""What a function takes for groups: see :meth:`Groups.of`."""


def groups_of_each(choice: Any) -> Groups | list[Groups]:
    """Groups of one crawler, or of each of several.

    Parameters
    ----------
    choice : Groups, str, mapping, Actuator or None, or an iterable of them
        Each as in :meth:`Groups.of`.

    Returns
    -------
    Groups or list of Groups
        A list where `choice` is an iterable of choices.

    Raises
    ------
    ValueError, TypeError
        As :meth:`Groups.of`; TypeError also if there are none.
    """
    if isinstance(choice, str | Mapping) or not isinstance(choice, Iterable):
        return Groups.of(choice)
    several = [Groups.of(one) for one in choice]
    if not several:
        raise TypeError(f"groups must be Groups or several of them, got {choice!r}")
    return several


PRESETS: dict[str, Groups] = {
    "ecoflex-00-30": Groups(),
    "linear": Groups(duffing=0.0, radial_coupling=0.0),
    "high-damping": Groups(damping_ratio=0.5),
    "aggressive-forcing": Groups(duffing=5.0, radial_coupling=0.5),
    "extreme-fluid-lag": Groups(deborah=5.0),
    "fast-valve": Groups(deborah=0.1),
    "low-friction": Groups(static_friction=0.15, kinetic_friction=0.1),
}
"""Named groups. The first equals :meth:`Actuator.ecoflex` made dimensionless; "high-damping" to "extreme-fluid-lag" are
this package's numbers for the paper's three named conditions, for which it states none. With the last two, looking at
the valve gains most in area of speed and memory (`docs/trade_limits.md`)."""
