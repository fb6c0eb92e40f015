"""What is in the world around the body."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from ..validation import known_names, number_within

__all__ = ["Scene"]


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

    Raises
    ------
    TypeError
        If a field is of the wrong type.
    ValueError
        If `slope` is not finite.
    """

    anchored: bool = False
    ratchet: bool = True
    slope: float = 0.0

    def __post_init__(self) -> None:
        for name in ("anchored", "ratchet"):
            if not isinstance(getattr(self, name), bool):
                raise TypeError(f"scene {name} must be True or False, got {getattr(self, name)!r}")
        object.__setattr__(self, "slope", number_within("scene slope", self.slope, "(-inf, inf)"))

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
            return cls()
        if isinstance(choice, cls):
            return choice
        if isinstance(choice, Mapping):
            known_names("scene", choice, cls.__slots__)
            return cls(**choice)
        raise TypeError(f"scene must be a Scene or a mapping of its fields, got {choice!r}")

    def to_dict(self) -> dict[str, Any]:
        """Fields by name, ready for JSON."""
        return asdict(self)
