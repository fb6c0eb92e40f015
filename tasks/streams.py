"""Input streams: what the valve does, and what of it is news."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.validation import number_within, whole_number


def random_bits(length: int, seed: int | Sequence[int]) -> NDArray[np.int64]:
    """Draw independent fair bits, the standard input of memory benchmarks.

    Parameters
    ----------
    length : int, at least 1
    seed : int, at least 0, or sequence of such

    Returns
    -------
    ndarray of shape (length,)
        Of 0 and 1.

    Raises
    ------
    TypeError, ValueError
        If an argument is not such an integer.
    """
    return _generator(seed).integers(0, 2, whole_number("length", length, 1))


def random_uniform(length: int, seed: int | Sequence[int]) -> NDArray[np.float64]:
    """Draw independent uniform numbers, the standard real-valued input.

    Parameters
    ----------
    length : int, at least 1
    seed : int, at least 0, or sequence of such

    Returns
    -------
    ndarray of shape (length,)
        In [0, 1).

    Raises
    ------
    TypeError, ValueError
        If an argument is not such an integer.
    """
    return _generator(seed).random(whole_number("length", length, 1))


def _generator(seed: int | Sequence[int]) -> np.random.Generator:
    if isinstance(seed, Sequence):
        return np.random.default_rng([whole_number("seed", each, 0) for each in seed])
    return np.random.default_rng(whole_number("seed", seed, 0))


def dithered(command: ArrayLike, dither: float, seed: int) -> NDArray[np.int64]:
    """Flip each bit of a command with a probability.

    Parameters
    ----------
    command : array_like of shape (holds,)
        Of 0 and 1: the valve states a policy or a schedule asks for.
    dither : float, in [0, 1/2]
        Probability of a flip. At 1/2 the valve ignores the command.
    seed : int, at least 0

    Returns
    -------
    ndarray of shape (holds,)
        Of 0 and 1: the valve states that are applied.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.
    """
    a = bits("command", command)
    random = np.random.default_rng(whole_number("seed", seed, 0))
    return a ^ (random.random(len(a)) < number_within("dither", dither, "[0, 0.5]"))


def innovation(valve: ArrayLike, command: ArrayLike, dither: float) -> NDArray[np.float64]:
    """Subtract from the valve what the command told of it, which leaves the message to be remembered.

    ``e = u - E[u | a] = u - ((1 - dither) a + dither (1 - a))``: zero mean, variance dither (1 - dither), and
    uncorrelated with the command and from step to step. At ``dither=1/2`` it is ``u - 1/2``.

    Parameters
    ----------
    valve, command : array_like of shape (holds,)
        Of 0 and 1: the valve states applied, and asked for.
    dither : float, in (0, 1/2]
        Probability with which they differ. Without dither there is no message.

    Returns
    -------
    ndarray of shape (holds,)

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.
    """
    u, a = bits("valve", valve), bits("command", command)
    if len(u) != len(a):
        raise ValueError(f"valve must have as many holds as command, {len(a)}, got {len(u)}")
    dither = number_within("dither", dither, "(0, 0.5]")
    expected: NDArray[np.float64] = np.where(a == 1, 1 - dither, dither)
    return u - expected


def bits(name: str, value: ArrayLike) -> NDArray[np.int64]:
    """Convert to an integer array of 0 and 1.

    Parameters
    ----------
    name : str
        What the caller calls the argument.
    value : array_like of shape (length,)
        What the caller was given.

    Returns
    -------
    ndarray of shape (length,)

    Raises
    ------
    ValueError
        If `value` is not a non-empty vector of 0 and 1.
    """
    array = np.asarray(value)
    if array.ndim != 1 or array.size == 0:
        raise ValueError(f"{name} must be 1-dimensional and not empty, got shape {array.shape}")
    wrong = ~np.isin(array, (0, 1))
    if wrong.any():
        raise ValueError(f"{name} must be 0 or 1, got {array[wrong][0]} at index {np.argmax(wrong)}")
    return array.astype(np.int64)
