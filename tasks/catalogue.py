"""The tasks known by name."""

from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..common.validation import whole_number
from .chaos import lorenz, mackey_glass
from .closed_loop import ClosedLoopTask
from .friction import FrictionTask
from .narma import BITS_HEIGHT, random_narma, UNIFORM_HEIGHT
from .parity import parity
from .streams import random_bits
from .task import ACCURACY, CAPACITY, NRMSE, Problem, SeriesTask, Task
from .waveforms import waveforms

__all__ = ["TASKS"]

# Mackey-Glass is sampled every 6 units of time and foretold by 84, as is usual; Lorenz's x every 0.05, and by 0.5.
_GLASS_STEP, _GLASS_AHEAD = 6.0, 14
_LORENZ_STEP, _LORENZ_AHEAD = 0.05, 10
# In a closed loop every 3 and every 0.02. Lyapunov exponents: J. D. Farmer, Physica D 4, 366, 1982, and J. C. Sprott,
# "Chaos and time-series analysis", 2003.
_GLASS_LOOP_STEP, _GLASS_EXPONENT = 3.0, 0.006
_LORENZ_LOOP_STEP, _LORENZ_EXPONENT = 0.02, 0.9056
# No solution leaves these, whatever the seed; Lorenz's, in practice.
_GLASS_TOP, _LORENZ_TOP = 1.5, 25.0


def _parity(order: int, length: int, seed: int) -> Problem:
    # The parity of bits a delay ago is the parity stream delayed, so its capacity is a memory capacity.
    bits = random_bits(length, seed)
    return Problem(bits.astype(np.float64), bits.astype(np.float64), parity(bits, order).astype(np.float64), order - 1)


def _narma(order: int, bits: bool, length: int, seed: int) -> Problem:
    inputs, targets = random_narma(length, order, seed, bits=bits)
    return Problem(inputs / (BITS_HEIGHT if bits else UNIFORM_HEIGHT), inputs, targets, order)


def _glass_series(step: float, length: int, seed: int) -> NDArray[np.float64]:
    start = np.random.default_rng(whole_number("seed", seed, 0)).uniform(0.8, 1.3)
    return mackey_glass(length, step=step, start=start)


def _mackey_glass(length: int, seed: int) -> Problem:
    series = _glass_series(_GLASS_STEP, whole_number("length", length, 1) + _GLASS_AHEAD, seed)
    inputs = series[:length]
    return Problem(inputs / _GLASS_TOP, inputs, series[_GLASS_AHEAD:], 0)


def _lorenz_series(step: float, length: int, seed: int) -> NDArray[np.float64]:
    start = np.random.default_rng(whole_number("seed", seed, 0)).uniform(-1.0, 1.0, 3)
    return lorenz(length, step=step, start=(start[0], start[1], 20.0 + start[2]))[:, 0]


def _lorenz(length: int, seed: int) -> Problem:
    series = _lorenz_series(_LORENZ_STEP, whole_number("length", length, 1) + _LORENZ_AHEAD, seed)
    inputs = series[:length]
    return Problem(0.5 + 0.5 * inputs / _LORENZ_TOP, inputs, series[_LORENZ_AHEAD:], 0)


def _glass_drive(length: int, seed: int) -> NDArray[np.float64]:
    return _glass_series(_GLASS_LOOP_STEP, length, seed) / _GLASS_TOP


def _lorenz_drive(length: int, seed: int) -> NDArray[np.float64]:
    return 0.5 + 0.5 * _lorenz_series(_LORENZ_LOOP_STEP, length, seed) / _LORENZ_TOP


def _waveforms(length: int, seed: int) -> Problem:
    inputs, kinds = waveforms(length, seed)
    return Problem(0.5 + 0.5 * inputs, inputs, kinds.astype(np.float64), 0)


TASKS: dict[str, Task] = {
    "memory capacity": SeriesTask(partial(_parity, 1), CAPACITY),
    "parity-2 capacity": SeriesTask(partial(_parity, 2), CAPACITY),
    "parity-3 capacity": SeriesTask(partial(_parity, 3), CAPACITY),
    **{f"NARMA-{order} NRMSE": SeriesTask(partial(_narma, order, True), NRMSE) for order in (2, 5, 10, 20)},
    **{f"NARMA-{order} uniform NRMSE": SeriesTask(partial(_narma, order, False), NRMSE) for order in (2, 5, 10, 20)},
    "Mackey-Glass NRMSE": SeriesTask(_mackey_glass, NRMSE),
    "Lorenz NRMSE": SeriesTask(_lorenz, NRMSE),
    "Mackey-Glass valid time": ClosedLoopTask(_glass_drive, _GLASS_EXPONENT * _GLASS_LOOP_STEP),
    "Lorenz valid time": ClosedLoopTask(_lorenz_drive, _LORENZ_EXPONENT * _LORENZ_LOOP_STEP),
    "waveform accuracy": SeriesTask(_waveforms, ACCURACY),
    "static friction NRMSE": FrictionTask("static"),
    "kinetic friction NRMSE": FrictionTask("kinetic"),
}
"""The tasks known by name, each named with its score. Add your own.

A capacity is the corrected total of `memory_capacity` over delays 0 to ``DELAYS - 1``, the message being the
parity of as many consecutive bits as the name says (memory: of one; parity-2 is exclusive or). More is better. These
targets are uncorrelated, so the capacities of a reservoir sum to its number of features at most. NARMA is driven by
bits of height 0.2, or uniformly from [0, 0.5]. Mackey-Glass is to be foretold by 84 units of time and Lorenz's x by
0.5; a valid time is for how many Lyapunov times they are foretold in a closed loop, 8 at most. Of an NRMSE less is
better, and 1 is what the mean scores; of an accuracy more, and 0.5 is chance. All are scored on the second half of
what the washout leaves, by a readout fitted on the first: with a penalty chosen there by leaving
samples out one by one, or for capacities, whose readouts are as many as the delays, with a fixed one of 1e-9 of the
states' variance.
"""
