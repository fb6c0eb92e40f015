"""The memory readout with which every episode starts."""

import numpy as np

from ..crawler.control import FINISHED, MAX_STEPS
from ..crawler.simulation import solver_error
from ..reservoir.prequential import PrequentialMemory
from .settings import Settings
from .stepping import rest, stepper_for

__all__ = ["calibrated_memory"]

# Random commands, enough for the scale of each feature to a few percent; fewer where holds are long, but never fewer
# than the least.
_COMMANDS = 2000
_TIME = 20_000.0
_LEAST = 100
_SEED = 0


def calibrated_memory(settings: Settings) -> PrequentialMemory:
    """Memory readout that has seen this body under random commands, dithered as in the episodes.

    Raises
    ------
    SolverError
        If the motion diverges.
    """
    affordable = int(min(_TIME / settings.hold, _COMMANDS))
    holds = settings.delays + max(affordable, _LEAST)
    generator = np.random.default_rng(_SEED)
    commands = generator.integers(0, 2, holds)
    valves = commands ^ (generator.random(holds) < settings.dither)
    samples = np.empty((5, settings.virtual_nodes))
    states = np.empty((holds, settings.features))
    groups, scene, hold, tolerance = settings.groups, settings.scene, settings.hold, settings.tolerance
    hold_valve, fixed, workspace, solver = stepper_for(groups, scene, hold, tolerance, settings.virtual_nodes)
    body, observation = rest(), np.empty(5, np.float32)
    for k, valve in enumerate(valves.tolist()):
        status, elapsed = hold_valve(body, fixed, valve, samples, workspace, observation)
        if status != FINISHED:
            reached = k * hold + elapsed
            raise solver_error(status, reached, float(body[0]), MAX_STEPS, groups, scene, tolerance, solver)
        states[k] = samples[:3].reshape(-1)
    return PrequentialMemory(
        states,
        valves - np.abs(commands - settings.dither),
        settings.delays,
        variance=settings.dither * (1.0 - settings.dither),
    )
