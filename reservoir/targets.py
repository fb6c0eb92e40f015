r"""What a running readout is to tell of the innovations: themselves, products of them, or a nonlinear series of them.

A target is a series made of the innovations :math:`e_k` alone, of mean 0 and a known variance, whoever commands:

- ``"memory"``: :math:`e_k`, of variance :math:`V = \epsilon (1 - \epsilon)`.
- ``"parity"``: :math:`e_k e_{k-1} \cdots e_{k-n+1}`, of variance :math:`V^n`. Innovations are uncorrelated whatever
  past ones a command depends on, and so are these products, with each other and with every weighted sum of
  innovations. At :math:`\epsilon = 1/2` and one command for ever they are the parity of as many bits.
- ``"narma"``: :math:`y_{k+1}` less its mean, where [1]_

  .. math:: y_{k+1} = 0.3 y_k + 0.05 y_k \sum_{i=0}^{n-1} y_{k-i} + 1.5 s_{k-n+1} s_k + 0.1, \quad s_k = (1 + e_k) / 4.

  Inputs lie in [0, 1/2] as in the papers. Up to n = 5 no input there drives y beyond the smaller fixed point of the
  largest one; from order 6 on some do. Mean and variance are those of a long series under random commands. One command
  for ever, through the third moment of an innovation, changes the variance by up to 1.5%.

References
----------
.. [1] K. Nakajima, H. Hauser, T. Li and R. Pfeifer, "Information processing via physical soft body", Scientific
   Reports 5, 10487, 2015.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.validation import finite_array, number_within, whole_number
from ..compiling.compilation import compiled, formula

__all__ = ["LONGEST", "ORDERS", "TARGETS", "Target", "aimed", "itself", "target_of", "target_series"]

TARGETS = ("memory", "parity", "narma")
_MEMORY, _PARITY, _NARMA = range(len(TARGETS))

LONGEST = 5
"""Highest order: see above."""

ORDERS = 2, LONGEST
"""Lowest order and highest."""

_SAMPLES, _WASHOUT, _SEED = 1_000_000, 1000, 0


class Target(NamedTuple):
    """A target, in numbers that compiled code takes."""

    kind: int  # its place in TARGETS
    order: int  # innovations in a product, or n
    mean: float  # that is taken off
    variance: float
    lead: int  # samples before the first value that is known
    single: bool  # whether the newest value alone is read out, and not those of the delays too


def target_of(name: str, order: int, dither: float) -> Target:
    """The target of a name.

    Parameters
    ----------
    name : {"memory", "parity", "narma"}
    order : int, 2 to 5
        Of the others than memory.
    dither : float, in (0, 1/2]
        Probability of a flip.

    Returns
    -------
    Target

    Raises
    ------
    ValueError, TypeError
        If an argument is out of range or of the wrong type; the message names it.
    """
    if name not in TARGETS:
        raise ValueError(f"target must be one of {list(TARGETS)}, got {name!r}")
    kind, order = TARGETS.index(name), whole_number("target_order", order, *ORDERS)
    variance = number_within("dither", dither, "(0, 0.5]") * (1.0 - dither)
    if kind == _MEMORY:
        return itself(variance)
    if kind == _PARITY:
        return Target(kind, order, 0.0, variance**order, order - 1, False)
    return Target(kind, order, *_narma_moments(order, dither), 0, True)


def itself(variance: float) -> Target:
    """The innovations themselves, of this variance."""
    return Target(_MEMORY, 1, 0.0, variance, 0, False)


def target_series(innovations: ArrayLike, name: str, order: int, dither: float) -> NDArray[np.float64]:
    """A target of a run: what `stickslip.memory_capacity` takes in place of the innovations.

    Parameters
    ----------
    innovations : (samples,) array_like
    name, order, dither
        As for `target_of`.

    Returns
    -------
    (samples,) array of float64
        In the first ``order - 1`` samples innovations from before the first count as 0.

    Raises
    ------
    ValueError, TypeError
        If an argument has the wrong shape, is out of range or of the wrong type; the message names it.
    """
    given = finite_array("innovations", innovations, 1)
    target = target_of(name, order, dither)
    values = np.empty(len(given))
    _fill(target.kind, target.order, target.mean, np.zeros((2, LONGEST)), given, values)
    return values


@formula
def aimed(kind: int, order: int, mean: float, recent: NDArray[np.float64], innovation: float) -> float:
    """Value of the target at the newest sample.

    Parameters
    ----------
    kind, order, mean
        Of a `Target`.
    recent : (2, LONGEST) array
        Innovations, newest first, and values; zeros at the start; updated. Of memory it is not touched.
    innovation : float

    Returns
    -------
    float
    """
    if kind == _MEMORY:
        return innovation
    for i in range(order - 1, 0, -1):
        recent[0, i] = recent[0, i - 1]
    recent[0, 0] = innovation
    if kind == _PARITY:
        product = 1.0
        for i in range(order):
            product *= recent[0, i]
        return product
    last, total = recent[1, 0] + mean, 0.0
    for i in range(order):
        total += recent[1, i] + mean
    driven = (1.0 + recent[0, order - 1]) * (1.0 + innovation) / 16.0
    value = 0.3 * last + 0.05 * last * total + 1.5 * driven + 0.1 - mean
    for i in range(order - 1, 0, -1):
        recent[1, i] = recent[1, i - 1]
    recent[1, 0] = value
    return value


@compiled
def _fill(
    kind: int,
    order: int,
    mean: float,
    recent: NDArray[np.float64],
    innovations: NDArray[np.float64],
    values: NDArray[np.float64],
) -> None:
    for k in range(len(innovations)):
        values[k] = aimed(kind, order, mean, recent, innovations[k])


@lru_cache
def _narma_moments(order: int, dither: float) -> tuple[float, float]:
    """Mean and variance of y under random commands."""
    random = np.random.default_rng(_SEED)
    flips, commands = random.random(_SAMPLES) < dither, random.integers(0, 2, _SAMPLES)
    values = np.empty(_SAMPLES)
    _fill(_NARMA, order, 0.0, np.zeros((2, LONGEST)), (1 - 2 * commands) * (flips - dither), values)
    return float(values[_WASHOUT:].mean()), float(values[_WASHOUT:].var())
