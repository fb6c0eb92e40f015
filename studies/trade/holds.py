"""One hold of the valve from any state of the body: the transition that dynamic programming plans with."""

import numpy as np
from numpy.typing import NDArray

from ...common.sharing import processors
from ...crawler.model.state import Body, FORWARD, STUCK
from ...envs.batch_engine import BatchEngine
from ...envs.settings import Settings
from .conditions import conditions

__all__ = ["Holds"]

Array = NDArray[np.float64]

_DEFORMATION, _VELOCITY, _PRESSURE, _FOOT, _FOOT_VELOCITY, _MODE, _SLIPS = range(len(Body._fields))
# Crawlers that one call steps: a generator is made for each, though none is drawn from.
_MOST = 16_384
_FOR_EVER = int(np.iinfo(np.int64).max)


class Holds:
    """Steps bodies through single holds, by the kernel of the batched environment, without flips.

    Parameters
    ----------
    settings : Settings
        See `conditions`.
    threads : int, optional
        All processors by default.
    """

    def __init__(self, settings: Settings, threads: int | None = None) -> None:
        self._still = conditions(
            groups=settings.groups, scene=settings.scene, hold=settings.hold, tolerance=settings.tolerance, dither=0.0
        )
        self._threads = processors() if threads is None else threads
        self._engines: dict[int, BatchEngine] = {}

    def __call__(self, states: Array, valves: NDArray[np.int64]) -> tuple[Array, Array]:
        """Hold the valve of each body.

        Parameters
        ----------
        states : (4, n) array
            Deformation, velocity, pressure and foot velocity, natural units.
        valves : (n,) array
            Each 0 or 1.

        Returns
        -------
        states : (4, n) array
            At the end of the hold.
        distances : (n,) array
            That the foot has travelled in it.

        Raises
        ------
        SolverError
            If a motion diverges.
        """
        after, distances = np.empty_like(states), np.empty(states.shape[1])
        for begin in range(0, states.shape[1], _MOST):
            part = slice(begin, begin + _MOST)
            after[:, part], distances[part] = self._step(states[:, part], valves[part])
        return after, distances

    def _step(self, states: Array, valves: NDArray[np.int64]) -> tuple[Array, Array]:
        count = states.shape[1]
        engine = self._engines.get(count)
        if engine is None:
            engine = self._engines[count] = BatchEngine([self._still], np.zeros(count, int), _FOR_EVER, self._threads)
            engine.begin(np.ones(count, np.bool_), [0] * count)
        bodies = engine.batch.bodies[:, :count]
        observed = [_DEFORMATION, _VELOCITY, _PRESSURE, _FOOT_VELOCITY]
        bodies[observed] = states
        bodies[_FOOT] = bodies[_SLIPS] = 0.0
        bodies[_MODE] = np.where(states[3] > 0.0, FORWARD, STUCK)
        engine.step(np.ascontiguousarray(valves, np.int64), np.zeros(count, np.bool_))
        return bodies[observed], bodies[_FOOT].copy()
