"""What is in the world around the body."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ...common.validation import known_names, number_within, truth_value, whole_number

__all__ = ["Scene"]

_MOST_SEGMENTS = 1000


@dataclass(frozen=True, slots=True)
class Scene:
    """What the crawler meets; the engine models no more than this names.

    Parameters
    ----------
    anchored : bool, default False
        The foot is clamped: the body still computes, but does not travel, and no friction is modelled.
    ratchet : bool, default True
        The foot is a mechanical diode that slides forward only. False gives symmetric Coulomb friction.
    slope : float, default 0
        Weight of payload and foot along the ground, M g sin(angle) / (P_max A_0); positive uphill. The normal force on
        a slope, m_f g cos(angle), is already in the friction groups.
    segments : int, in [1, 1000], default 1
        Equal pieces N of the tube, payload in front and foot behind. Each has N k_1, N^3 k_3, N b and N alpha, so that
        a uniform stretch feels like the crawler's, and all are fed by the one valve with the one lag, so that each
        segment's own pressure is `pressure`.
    tube_mass : float, in [0, inf), default 0
        m_tube / M, where M = m_p + m_f stays the unit of mass: payload 1 - r, foot r, and the tube besides. The two
        ends of a segment bear half its mass each: mass-lumped linear finite elements, which converge to the continuous
        rod with the square of 1 / N. Frictions are forces, and stay as the groups have them however heavy the tube.

    Raises
    ------
    TypeError
        If a field is of the wrong type.
    ValueError
        If a number is not finite or outside its range.

    Notes
    -----
    Segments without mass pull alike, so that any number of them is the crawler itself, and one heavy segment is a
    crawler of other masses: both are integrated as such, and `Trajectory.model` says so. The chain proper costs
    N + 1 equations a step, and its fastest motion bounds the step: neighbours against each other swing at up to
    2 N / sqrt(tube_mass) radians a unit of time, and where that is overdamped settle at up to
    8 damping_ratio N^2 / tube_mass.
    """

    anchored: bool = False
    ratchet: bool = True
    slope: float = 0.0
    segments: int = 1
    tube_mass: float = 0.0

    def __post_init__(self) -> None:
        for name in ("anchored", "ratchet"):
            object.__setattr__(self, name, truth_value(f"scene {name}", getattr(self, name)))
        object.__setattr__(self, "slope", number_within("scene slope", self.slope, "(-inf, inf)"))
        object.__setattr__(self, "segments", whole_number("scene segments", self.segments, 1, _MOST_SEGMENTS))
        object.__setattr__(self, "tube_mass", number_within("scene tube_mass", self.tube_mass, "[0, inf)"))

    @classmethod
    def of(cls, choice: "Scene | Mapping[str, Any] | None") -> "Scene":
        """Scene from a mapping of some of its fields, from None (the default scene), or itself.

        Raises
        ------
        ValueError
            If a field is unknown.
        TypeError
            If `choice` or a field is of the wrong type.
        """
        if choice is None:
            return _DEFAULT
        if isinstance(choice, cls):
            return choice
        if isinstance(choice, Mapping):
            known_names("scene", choice, cls.__slots__)
            return cls(**choice)
        raise TypeError(f"scene must be a Scene or a mapping of its fields, got {choice!r}")

    def to_dict(self) -> dict[str, Any]:
        """Fields by name, ready for JSON."""
        return {name: getattr(self, name) for name in self.__slots__}


_DEFAULT = Scene()
