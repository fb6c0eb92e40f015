"""What fixes an environment, single or batched: its arguments, checked once."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.validation import known_names, number_within, whole_number
from ..crawler import Groups, GroupsLike, Scene
from ..crawler.arguments import TOLERANCES
from ..crawler.model.columns import columns_of
from ..crawler.model.groups import RANGES
from ..crawler.model.holds import natural_hold
from ..crawler.model.variations import Range, variations, varied
from ..reservoir.targets import itself, ORDERS, Target, target_of, TARGETS

__all__ = [
    "CRAWLER_OPTIONS",
    "HOLDS",
    "CrawlerChoice",
    "Settings",
    "columns_of_numbers",
    "drawn_numbers",
    "known_options",
    "numbers_of",
    "refuse_unread",
]

HOLDS = "(0, 10000]"
"""Longer holds are for `simulate`: here a hold of 10^4 already takes as long as the 10^4 steps of a policy."""

# Of delays and of virtual nodes: the readout's covariance has the square of the latter.
_MOST = 1000
_MOST_REMEMBERED = 64  # valve states, the bits of a number
_SLOPE = "slope"

CRAWLER_OPTIONS = ("groups", _SLOPE)
"""Options of a reset that say who crawls where in the episode."""


class CrawlerChoice(NamedTuple):
    """What the options of a reset settle of the episode's crawler."""

    groups: Mapping[str, float]
    slope: float | None


_NOTHING = CrawlerChoice({}, None)
_NUMBERED = (*RANGES, _SLOPE)


@dataclass(frozen=True)
class Settings:
    """Arguments of an environment, as its class documents them, in the form that the rest of the code uses."""

    groups: Groups
    scene: Scene
    hold: float
    tolerance: float
    dither: float
    memory_weight: float
    delays: int
    target: str
    target_order: int
    virtual_nodes: int
    valve_history: int
    randomize: Mapping[str, Range]  # in the order of the groups' fields, the slope last

    @classmethod
    def of(
        cls,
        *,
        groups: GroupsLike | None = None,
        scene: Mapping[str, Any] | Scene | None = None,
        hold: float | str = 0.5,
        tolerance: float = 1e-6,
        dither: float = 0.1,
        memory_weight: float = 0.2,
        delays: int = 20,
        target: str = "memory",
        target_order: int = 2,
        virtual_nodes: int = 4,
        valve_history: int = 1,
        randomize: Mapping[str, Sequence[float]] | None = None,
    ) -> "Settings":
        """Check the arguments.

        Raises
        ------
        ValueError, TypeError
            If one is out of range or of the wrong type; the message names it.
        """
        hold = natural_hold(hold, groups, HOLDS)
        groups, scene = Groups.of(groups), Scene.of(scene)
        if scene.segments > 1 or scene.tube_mass > 0.0:
            raise ValueError(
                f"scene of the environment must have segments = 1 and tube_mass = 0, got segments = "
                f"{scene.segments} and tube_mass = {scene.tube_mass!r}: use simulate"
            )
        settings = cls(
            groups,
            scene,
            hold,
            number_within("tolerance", tolerance, TOLERANCES),
            number_within("dither", dither, "[0, 0.5]"),
            number_within("memory_weight", memory_weight, "[0, 1]"),
            whole_number("delays", delays, 1, _MOST),
            target,
            whole_number("target_order", target_order, *ORDERS),
            whole_number("virtual_nodes", virtual_nodes, 1, _MOST),
            whole_number("valve_history", valve_history, 1, _MOST_REMEMBERED),
            _ranges(randomize, groups),
        )
        if target not in TARGETS:
            raise ValueError(f"target must be one of {list(TARGETS)}, got {target!r}")
        if settings.memory_weight > 0.0 and settings.dither == 0.0:
            raise ValueError(
                f"dither must be in (0, 0.5] where memory_weight = {settings.memory_weight!r} > 0, got {dither!r}: "
                "without flips there is no message to remember"
            )
        return settings

    @property
    def features(self) -> int:
        """Of the memory readout: deformation, rate and pressure at each virtual node."""
        return 3 * self.virtual_nodes

    @property
    def samples(self) -> int:
        """Of the body in a hold: where there is no message nobody reads them, and one is enough."""
        return self.virtual_nodes if self.dither > 0.0 else 1

    @property
    def variance(self) -> float:
        """Var e of an innovation."""
        return self.dither * (1.0 - self.dither)

    @property
    def aim(self) -> Target:
        """What the readout is to tell of the flips; of no use where there are none."""
        return target_of(self.target, self.target_order, self.dither) if self.dither > 0.0 else itself(0.0)

    @property
    def messages(self) -> int:
        """Values of the target that are read out of a state."""
        return 1 if self.aim.single else self.delays

    def choose(self, groups: GroupsLike | None = None, slope: float | None = None) -> CrawlerChoice:
        """Check what the options of a reset say of the episode's crawler.

        Parameters
        ----------
        groups : Groups, str, mapping, Actuator or None
            A mapping changes what it names; anything else but None settles all.
        slope : float or None

        Raises
        ------
        ValueError, TypeError
            If one is out of range, in whatever episode is drawn, or of the wrong type; the message names it.
        """
        if isinstance(groups, Mapping):
            known_names("groups", groups, RANGES)
            chosen = {name: number_within(name, value, RANGES[name]) for name, value in groups.items()}
        else:
            chosen = {} if groups is None else Groups.of(groups).to_dict()
        _worst(self.groups, {**self.randomize, **{name: Range(value, value) for name, value in chosen.items()}})
        return CrawlerChoice(chosen, None if slope is None else number_within(_SLOPE, slope, "(-inf, inf)"))

    def draw(self, generator: np.random.Generator, choice: CrawlerChoice = _NOTHING) -> tuple[Groups, Scene]:
        """Crawler and world of an episode; as many numbers are drawn whatever is chosen."""
        if not self.randomize and choice is _NOTHING:
            return self.groups, self.scene
        drawn = {name: each.at(generator.random()) for name, each in self.randomize.items()}
        settled = {} if choice.slope is None else {_SLOPE: choice.slope}
        groups, scene, _ = varied(self.groups, self.scene, self.hold, {**drawn, **choice.groups, **settled})
        return groups, scene


def refuse_unread(settings: Settings) -> None:
    """Refuse to tell of a hold within which nobody reads the body.

    Raises
    ------
    ValueError
        If there is no dither.
    """
    if settings.dither == 0.0:
        raise ValueError("readout_states needs dither in (0, 0.5], got 0.0: without flips no readout reads the body")


def numbers_of(crawlers: Sequence[tuple[Groups, Scene]]) -> NDArray[np.float64]:
    """Groups and slope of n crawlers, in the order of `randomize`; shape (8, n)."""
    rows = [(*groups.to_dict().values(), scene.slope) for groups, scene in crawlers]
    return np.array(rows, np.float64).reshape(len(rows), len(_NUMBERED)).T


def drawn_numbers(settings: Settings, numbers: NDArray[np.float64], shares: NDArray[np.float64]) -> NDArray[np.float64]:
    """What `Settings.draw` draws for each of n crawlers.

    Parameters
    ----------
    settings : Settings
    numbers : (8, n) array
        Of the crawlers' kinds, as from `numbers_of`.
    shares : (k, n) array
        Uniform random numbers of each crawler's own, one for each of `randomize`.

    Returns
    -------
    (8, n) array
    """
    drawn = numbers.copy()
    for (name, each), of_each in zip(settings.randomize.items(), shares, strict=True):
        # A power of an array may differ in the last bit from one of a number.
        span = each.high - each.low
        drawn[_NUMBERED.index(name)] = (
            [each.at(share) for share in of_each.tolist()] if each.log else each.low + of_each * span
        )
    return drawn


def columns_of_numbers(scene: Scene, numbers: NDArray[np.float64]) -> NDArray[np.float64]:
    """Coefficients, a crawler a column, of what `numbers_of` tells of each in the scene but for its slope."""
    *groups, slope = numbers
    together = SimpleNamespace(**dict(zip(RANGES, groups, strict=True)))
    return columns_of(together, SimpleNamespace(**scene.to_dict() | {_SLOPE: slope}), numbers.shape[1])


def known_options(options: dict[str, Any] | None, allowed: Sequence[str]) -> dict[str, Any]:
    """Options of a reset.

    Raises
    ------
    TypeError
        If they are neither a mapping nor None.
    ValueError
        If one is unknown.
    """
    if options is None:
        return {}
    if not isinstance(options, Mapping):
        raise TypeError(f"options must be a dict or None, got {options!r}")
    known_names("options", options, allowed)
    return dict(options)


def _ranges(randomize: Mapping[str, Sequence[float]] | None, groups: Groups) -> dict[str, Range]:
    """Ranges to draw from, after a look at both ends of each."""
    ranges = variations("randomize", randomize, (*RANGES, _SLOPE))
    _worst(groups, ranges)
    return ranges


def _worst(groups: Groups, ranges: Mapping[str, Range]) -> None:
    """Refuse the worst draw of the one range that depends on another group here, not in some later episode."""
    static, kinetic = ranges.get("static_friction"), ranges.get("kinetic_friction")
    replace(
        groups,
        static_friction=groups.static_friction if static is None else static.low,
        kinetic_friction=groups.kinetic_friction if kinetic is None else kinetic.high,
    )
