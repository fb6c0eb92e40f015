"""A crawler in the middle of an episode: what planners save, copy and go back to."""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from ..crawler import Groups, Scene
from .infos import TOLD
from .observation import seen_at_rest
from .settings import Settings

__all__ = ["CrawlerState", "refuse_foreign"]

# Counted up whenever a state of before would no longer be gone on from to the bit.
VERSION = 3


@dataclass(frozen=True, eq=False)
class CrawlerState:
    """All that the rest of an episode depends on, of one crawler.

    `get_state` of `StickSlipCrawlerEnv` or `StickSlipCrawlerVectorEnv` makes it, and `set_state` of either goes on from
    it, to the last bit. It can be pickled; what it holds is its own and nobody's to change.

    Attributes
    ----------
    settings : Settings
        Of the environment.
    groups, scene : Groups, Scene
        Of the episode.
    body : (7,) array
        Deformation, velocity, pressure, foot, foot velocity, kind of motion and slips so far.
    steps : int
        Of the episode so far.
    observation : array of float32
        What the last step has shown.
    told : array
        What the last step has told: `stickslip.envs.infos.TOLD`.
    read : (3 * nodes,) array
        What the readout has seen of the last hold; of one node without dither.
    readout : tuple of arrays
        Of the memory: weights, the lower half of the covariance by rows, and past messages, newest first; then what
        messages other than innovations are made of. Empty where there is no message.
    over : bool
        Whether the episode has come to its end and a batch is to begin the next.
    generator : numpy.random.Generator or None
        None where it was not asked for: whoever is set to this state goes on with its own.
    seed : int or None
        Of the generator.
    version : int
        Of this form.
    """

    settings: Settings
    groups: Groups
    scene: Scene
    body: NDArray[np.float64]
    steps: int
    observation: NDArray[np.float32]
    told: NDArray[np.float64]
    read: NDArray[np.float64]
    readout: tuple[NDArray[np.float64], ...]
    over: bool
    generator: np.random.Generator | None
    seed: int | None
    version: int = VERSION


def refuse_foreign(state: object, settings: Settings) -> None:
    """Refuse a state that an environment of these settings cannot go on from.

    Raises
    ------
    TypeError
        If it is none.
    ValueError
        If it is of another version, or of other settings; the message names the first that differs.
    """
    if not isinstance(state, CrawlerState):
        raise TypeError(f"state must be a CrawlerState, as get_state returns it, got {state!r}")
    version = getattr(state, "version", None)
    if version != VERSION:
        raise ValueError(f"state must be of version {VERSION}, got one of version {version}")
    for field in fields(Settings):
        own, other = (getattr(each, field.name, None) for each in (settings, state.settings))
        if own != other:
            raise ValueError(f"state must come from an environment of {field.name} = {own!r}, got one of {other!r}")
    size = len(seen_at_rest(settings.valve_history))
    if len(state.told) != len(TOLD) or len(state.observation) != size:
        raise ValueError(
            f"state must hold an observation of {size} and {TOLD}, "
            f"got an observation of {len(state.observation)} and {len(state.told)} numbers told"
        )
