"""Every kernel compiled before it is needed, as images and clusters want it."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, cast

import gymnasium as gym
import numpy as np

from .compiling.compilation import Kernel
from .crawler import Groups, lyapunov_spectrum, Scene, sensitivities, simulate
from .crawler.solvers import SOLVERS
from .envs import StickSlipCrawlerEnv
from .envs.batch_kernel import STEP_BATCH
from .reservoir import EchoStateNetwork, RecursiveLeastSquares, target_series
from .reservoir.prequential import PrequentialMemory
from .tasks import lorenz

__all__ = ["uses", "where_kept"]

_LINEAR = {"duffing": 0.0, "radial_coupling": 0.0}
_STIFF = {"damping_ratio": 200.0}
_CHAIN = Scene(segments=2, tube_mass=0.2)


def where_kept() -> str:
    """Folder of the environment's kernels.

    Raises
    ------
    OSError
        If they would be kept nowhere.
    """
    kernel = cast(Kernel, next(iter(STEP_BATCH.values())))
    if kernel.unkept:
        raise OSError(f"kernels are compiled {kernel.unkept}")
    return str(kernel.stats.cache_path)


def uses() -> Iterator[tuple[str, Callable[[], object]]]:
    """What people use kernels for, the least of each kind, by name."""
    # One tolerance for every order of the Taylor series.
    tolerances = sorted({SOLVERS["taylor"].order_for(10.0**-digits): 10.0**-digits for digits in range(2, 16)}.items())
    for order, tolerance in tolerances:
        yield f"simulate, Taylor series of order {order}", partial(_simulate, "taylor", tolerance, {})
        yield f"simulate, a batch by Taylor series of order {order}", partial(_simulate_batch, tolerance)
    yield "simulate, closed form", partial(_simulate, "closed_form", 1e-9, _LINEAR)
    yield "simulate, Radau collocation", partial(_simulate, "radau", 1e-9, {})
    yield "simulate, chain of segments", _chain
    yield "exponents, chain of segments", _chain_exponents
    yield "sensitivities", partial(sensitivities, Groups(), [1, 0], 0.5)
    bodies: list[tuple[str, float, dict[str, float]]] = [
        (f"Taylor series of order {order}", tolerance, {}) for order, tolerance in tolerances
    ]
    bodies += [("closed form", 1e-6, _LINEAR), ("Radau collocation", 1e-6, _STIFF)]
    for name, tolerance, groups in bodies:
        remembering = {"groups": groups, "tolerance": tolerance}
        yield f"environment, {name}", partial(_environment, remembering)
        yield f"batch, {name}", partial(_batch, remembering)
        yield f"batch without memory, {name}", partial(_batch, {**remembering, "dither": 0.0, "memory_weight": 0.0})
    yield "episodes drawn", partial(_batch, {"groups": _LINEAR, "randomize": {"deborah": (0.3, 0.7)}})
    yield "recursive least squares", _readout
    yield "memory reward", _memory_reward
    yield "reward's target", partial(target_series, [0.0], "parity", 2, 0.1)
    yield "echo-state network", partial(EchoStateNetwork(1).states, [0.0])
    yield "Lorenz's flow", partial(lorenz, 1)


def _simulate(solver: str, tolerance: float, groups: dict[str, float]) -> object:
    return simulate(Groups(**groups), [1, 0], 0.5, solver=solver, tolerance=tolerance)


def _simulate_batch(tolerance: float) -> object:
    return simulate(Groups(), [[1, 0], [0, 1]], 0.5, solver="taylor", tolerance=tolerance)


def _chain() -> object:
    return simulate(Groups(), [1, 0], 0.5, scene=_CHAIN)


def _chain_exponents() -> object:
    return lyapunov_spectrum(Groups(), [1, 0], 0.5, scene=_CHAIN, washout=0)


def _environment(settings: dict[str, Any]) -> None:
    environment = StickSlipCrawlerEnv(**settings)
    environment.reset(seed=0)
    environment.step(1)


def _batch(settings: dict[str, Any]) -> None:
    environment = gym.make_vec("StickSlipCrawler-v0", 2, **settings)
    environment.reset(seed=0)
    environment.step(np.array([1, 0]))
    environment.close()


def _memory_reward() -> object:
    return PrequentialMemory([[0.0], [1.0]], 1, variance=0.25).score(np.array([1.0]), 0.5)


def _readout() -> object:
    return RecursiveLeastSquares(1, 1).learn([1.0], [1.0])
