"""What a page shows: a body, its ground, and what drives the valve; and the numbers of it that have a slider."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

from ..common.validation import known_names, number_within, truth_value
from ..crawler import Groups, Scene
from ..crawler.model.groups import RANGES
from ..train.policies.pretrained import PRETRAINED

__all__ = [
    "DRIVES",
    "LONGEST_WORD",
    "NUMBERS",
    "SWITCHES",
    "UNITS",
    "Number",
    "Setup",
    "Switch",
    "changed",
    "setup_of",
    "without_effect",
]

DRIVES = ("word", "policy", "live")
"""What can drive the valve: a word repeated for ever, a policy that is shipped, or somebody at the space bar."""

UNITS = ("natural", "SI")

LONGEST_WORD = 32
"""Bits of a word that still can be clicked together."""


@dataclass(frozen=True)
class Number:
    """A number with a slider.

    Attributes
    ----------
    label, symbol : str
        In words, and as the paper writes it.
    low, high : float
        Ends of the slider, which are also all that a link may ask for: within them every run ends soon.
    scale : {"linear", "square", "log", "decades"}
        How the slider runs from one end to the other; "decades" stops at powers of ten alone.
    help : str
        What it does to the crawler, in a few words.
    """

    label: str
    symbol: str
    low: float
    high: float
    scale: str
    help: str

    @property
    def interval(self) -> str:
        """Values allowed, in the usual notation."""
        return f"[{self.low:g}, {self.high:g}]"


NUMBERS: Mapping[str, Number] = {
    "duffing": Number("Cubic stiffness", "Π₁", 0.0, 20.0, "square", "How the body stiffens as it stretches"),
    "damping_ratio": Number("Damping", "Π₂", 0.0, 1.0, "square", "Loss in the elastomer"),
    "deborah": Number("Fluid lag", "Π₄", 0.05, 8.0, "log", "How slowly pressure follows the valve"),
    "radial_coupling": Number("Radial coupling", "Π₅", 0.0, 1.0, "linear", "How the bore widens with stretch"),
    "foot_mass_fraction": Number("Foot's share of mass", "r", 0.05, 0.95, "linear", "Foot against the whole"),
    "static_friction": Number("Static friction", "s", 0.0, 1.0, "linear", "Pull at which the foot breaks loose"),
    "kinetic_friction": Number("Kinetic friction", "k", 0.0, 1.0, "linear", "Drag on the foot while it slides"),
    "slope": Number("Slope", "σ", -0.3, 0.3, "linear", "Weight along the ground, uphill positive"),
    "hold": Number("Hold", "h", 0.05, 5.0, "log", "Time between two turns of the valve"),
    "dither": Number("Flips", "ε", 0.0, 0.5, "square", "Probability that a command is flipped: the message"),
    "weight": Number("Weight of memory", "w", 0.0, 1.0, "linear", "What the conditioned policy is asked for"),
    "tolerance": Number("Solver's tolerance", "tol", 1e-15, 1e-2, "decades", "Largest term that a step neglects"),
}
"""Every slider, by the name of its field in a :class:`Setup` or in `Groups`."""


@dataclass(frozen=True)
class Switch:
    """What is so or not.

    Attributes
    ----------
    label, help : str
        In words, and what it does to the crawler.
    """

    label: str
    help: str


SWITCHES: Mapping[str, Switch] = {
    "ratchet": Switch("Ratchet", "The foot slides forward only; without it, either way"),
    "anchored": Switch("Anchored", "The foot is clamped: the body computes, and does not travel"),
}
"""Every switch, by the name of its field in a :class:`Setup` and in `Scene`."""


@dataclass(frozen=True)
class Setup:
    """A body, its ground, and what drives the valve.

    Parameters
    ----------
    groups : Groups
    slope : float, in [-0.3, 0.3]
        As in `Scene`.
    ratchet, anchored : bool
        As in `Scene`.
    hold : float, in [0.05, 5]
        Natural time between two turns of the valve.
    tolerance : float, in [1e-15, 1e-2]
        As in `simulate`.
    drive : {"word", "policy", "live"}
        What drives the valve.
    word : str
        Of 0 and 1, repeated for ever; 1 to 32 bits.
    policy : str
        One of `stickslip.train.policies.pretrained.PRETRAINED`.
    weight : float, in [0, 1]
        Of memory, for the policy that takes one.
    dither : float, in [0, 1/2]
        Probability with which a command of a word or a policy is flipped.
    units : {"natural", "SI"}

    Raises
    ------
    ValueError, TypeError
        If a field is out of its range or of the wrong type; the message names it.
    """

    groups: Groups = field(default_factory=Groups)
    slope: float = 0.0
    ratchet: bool = True
    anchored: bool = False
    hold: float = 0.5
    tolerance: float = 1e-9
    drive: str = "word"
    word: str = "11100111000"
    policy: str = "knee"
    weight: float = 0.4
    dither: float = 0.1
    units: str = "natural"

    def __post_init__(self) -> None:
        for name, number in NUMBERS.items():
            value = getattr(self.groups if name in RANGES else self, name)
            number_within(name, value, number.interval)
        for name in SWITCHES:
            object.__setattr__(self, name, truth_value(name, getattr(self, name)))
        for name, allowed in (("drive", DRIVES), ("policy", PRETRAINED), ("units", UNITS)):
            if getattr(self, name) not in allowed:
                raise ValueError(f"{name} must be one of {list(allowed)}, got {getattr(self, name)!r}")
        if not isinstance(self.word, str) or set(self.word) - {"0", "1"} or not 0 < len(self.word) <= LONGEST_WORD:
            raise ValueError(f"word must be 1 to {LONGEST_WORD} letters 0 and 1, got {self.word!r}")

    @property
    def scene(self) -> Scene:
        """The ground."""
        return Scene(slope=self.slope, ratchet=self.ratchet, anchored=self.anchored)

    def to_dict(self) -> dict[str, Any]:
        """All fields by name, those of the groups among them: what `setup_of` takes."""
        own = {each.name: getattr(self, each.name) for each in fields(self) if each.name != "groups"}
        return {**self.groups.to_dict(), **own}


def setup_of(values: Mapping[str, Any], base: Setup | None = None) -> Setup:
    """A setup from some of its fields by name, those of the groups among them.

    Parameters
    ----------
    values : mapping
        As `Setup.to_dict` gives them.
    base : Setup, optional
        What the others are taken from; the defaults.

    Returns
    -------
    Setup

    Raises
    ------
    ValueError, TypeError
        If a name is unknown or a value not allowed; the message names it.
    """
    start = Setup() if base is None else base
    known_names("setup", values, start.to_dict())
    for name in NUMBERS.keys() & values:
        number_within(name, values[name], NUMBERS[name].interval)
    groups = {name: value for name, value in values.items() if name in RANGES}
    others = {name: value for name, value in values.items() if name not in RANGES}
    return replace(start, groups=Groups(**{**start.groups.to_dict(), **groups}), **others)


def changed(setup: Setup, name: str, value: Any) -> Setup:
    """A setup of which one field is another, and what cannot stay beside it moves with it.

    The kinetic friction is at most the static one: whichever is moved takes the other along.

    Parameters
    ----------
    setup : Setup
    name : str
        Of a field, or of one of the groups.
    value : number or str

    Returns
    -------
    Setup

    Raises
    ------
    ValueError, TypeError
        As `setup_of`.
    """
    values = {name: value}
    if name in ("static_friction", "kinetic_friction"):
        value = number_within(name, value, NUMBERS[name].interval)
    if name == "static_friction":
        values["kinetic_friction"] = min(setup.groups.kinetic_friction, value)
    if name == "kinetic_friction":
        values["static_friction"] = max(setup.groups.static_friction, value)
    return setup_of(values, setup)


def without_effect(setup: Setup) -> list[str]:
    """Sliders and switches that change nothing beside what else is set: a foot that is clamped rubs on nothing."""
    return ["static_friction", "kinetic_friction", "ratchet"] if setup.anchored else []
