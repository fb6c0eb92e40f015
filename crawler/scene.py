"""What is in the world around the body."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

from ..validation import known_names

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

    Raises
    ------
    TypeError
        If a field is not a bool.
    """

    anchored: bool = False
    ratchet: bool = True

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not isinstance(value, bool):
                raise TypeError(f"scene {field.name} must be True or False, got {value!r}")

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
            known_names("scene", choice, (field.name for field in fields(cls)))
            return cls(**choice)
        raise TypeError(f"scene must be a Scene or a mapping of its fields, got {choice!r}")

    def to_dict(self) -> dict[str, bool]:
        """Fields by name, ready for JSON."""
        return asdict(self)
