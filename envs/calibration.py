"""The memory readout with which every episode starts: one that has seen the body under random commands."""

import numpy as np
from numpy.typing import NDArray

from ..reservoir.prequential import PrequentialMemory
from .settings import Settings

__all__ = ["calibrated_memory", "calibration_commands"]

# Random commands, enough for the scale of each feature to a few percent; fewer where holds are long, but never fewer
# than the least.
_COMMANDS = 2000
_TIME = 20_000.0
_LEAST = 100
_SEED = 0


def calibration_commands(settings: Settings) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Random commands, and the valve as dithered as in the episodes.

    Returns
    -------
    commands, valves : (holds,) arrays of 0 and 1
    """
    affordable = int(min(_TIME / settings.hold, _COMMANDS))
    holds = settings.delays + max(affordable, _LEAST)
    generator = np.random.default_rng(_SEED)
    commands = generator.integers(0, 2, holds)
    return commands, commands ^ (generator.random(holds) < settings.dither)


def calibrated_memory(settings: Settings, states: NDArray[np.float64]) -> PrequentialMemory:
    """Memory readout of a body that went through the calibration's commands from rest.

    Parameters
    ----------
    settings : Settings
    states : (holds, features) array
        Deformations at the virtual nodes of each hold, then rates, then pressures.

    Returns
    -------
    PrequentialMemory
    """
    commands, valves = calibration_commands(settings)
    return PrequentialMemory(
        states,
        valves - np.abs(commands - settings.dither),
        settings.delays,
        variance=settings.dither * (1.0 - settings.dither),
    )
