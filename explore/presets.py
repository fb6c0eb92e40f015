"""Setups by name, to begin with."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from .. import crawler
from .setup import Setup, setup_of

__all__ = ["PRESETS", "Preset", "preset"]


class Preset(NamedTuple):
    """A setup with a name."""

    title: str
    kind: str
    """Heading that it stands under."""
    setup: Setup


def _made(kind: str, rows: Mapping[str, tuple[str, Mapping[str, Any]]]) -> dict[str, Preset]:
    return {name: Preset(title, kind, setup_of(values)) for name, (title, values) in rows.items()}


PRESETS: Mapping[str, Preset] = {
    **_made(
        "Gaits",
        {
            "fastest-word": ("Fastest word, 11100111000", {}),
            "clean-gait": ("The same without flips", {"dither": 0.0}),
            "slow-word": ("A slower word that remembers more, 11100", {"word": "11100"}),
            "held-open": ("Valve held open: most memory", {"word": "1"}),
            "coin": ("Fair coin: the paper's random input", {"word": "1", "dither": 0.5}),
            "space-bar": ("You, at the space bar", {"drive": "live"}),
        },
    ),
    **_made(
        "Policies that look",
        {
            "speed-policy": ("Fastest policy", {"drive": "policy", "policy": "speed"}),
            "knee-policy": ("Policy of the knee: fast, and remembers", {"drive": "policy", "policy": "knee"}),
            "memory-policy": ("Policy of most memory", {"drive": "policy", "policy": "memory"}),
        },
    ),
    **{
        name: Preset(name, "Bodies", setup_of(body.to_dict()))
        for name, body in crawler.PRESETS.items()
        if name != "ecoflex-00-30"
    },
    **_made(
        "Grounds",
        {
            "uphill": ("Uphill", {"slope": 0.08}),
            "downhill": ("Downhill", {"slope": -0.08}),
            "no-ratchet": ("Downhill without a ratchet: it slides either way", {"slope": -0.08, "ratchet": False}),
            "anchored": ("Foot clamped: it computes, and does not travel", {"anchored": True}),
            "heavy-foot": ("Heavy foot, light payload", {"foot_mass_fraction": 0.7}),
        },
    ),
}
"""Presets by name; the bodies are those of `stickslip.crawler.PRESETS`, the first of which all others have."""


def preset(name: str) -> Setup:
    """A preset's setup.

    Raises
    ------
    ValueError
        If there is none of that name.
    """
    if name not in PRESETS:
        raise ValueError(f"preset must be one of {list(PRESETS)}, got {name!r}")
    return PRESETS[name].setup
