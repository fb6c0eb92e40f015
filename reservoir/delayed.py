"""Sums of products of states with delayed copies of a message, gathered block by block.

The copies as one matrix would be larger than the states, and larger than the cache: most of the time would go into
moving them. A block of samples and its copies stay in the cache while all is done with them that there is to do.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Delays = NDArray[np.int64]

# Numbers in the larger of the two matrices of a block: a quarter of a megabyte.
_BLOCK = 2**15
_LEAST = 32


def delayed_rows(message: Array, delays: Delays, start: int, stop: int) -> Array:
    """Copies of a message: row i is ``message[k - delays[i]]`` for k from `start` to `stop`.

    Parameters
    ----------
    message : ndarray of shape (samples,)
    delays : ndarray of shape (delays,)
        At most `start`.
    start, stop : int

    Returns
    -------
    ndarray of shape (delays, stop - start)
    """
    longest = delays.max()
    windows = np.lib.stride_tricks.sliding_window_view(message[start - longest : stop], stop - start)
    rows: Array = windows[longest - delays]
    return rows


def delayed_products(
    states: Array,
    message: Array,
    delays: Delays,
    start: int,
    stop: int,
    *,
    to_white: Array | None = None,
    centred: bool = True,
) -> tuple[Array, Array]:
    """Sum the products of states with states, and of states with a delayed message, from `start` to `stop`.

    The first of these samples is subtracted from all, and what is left of the mean afterwards, in the sums. No mean
    of n samples is further from one of them than sqrt(n) standard deviations, so that costs the digits of n at most.

    Parameters
    ----------
    states : ndarray of shape (samples, features)
    message : ndarray of shape (samples,)
    delays : ndarray of shape (delays,)
        At most `start`.
    start, stop : int
    to_white : ndarray of shape (features, features), optional
        Multiplies the states from the right.
    centred : bool
        Whether the mean of the states is subtracted.

    Returns
    -------
    gram : ndarray of shape (features, features)
    cross : ndarray of shape (features, delays)
    """
    features = states.shape[1]
    offset = states[start] if centred else np.zeros(features)
    gram, cross = np.zeros((features, features)), np.zeros((features, len(delays)))
    total, level = np.zeros(features), np.zeros(len(delays))
    for moved, rows in _blocks(states, message, delays, start, stop, offset):
        columns = moved if to_white is None else moved @ to_white
        gram += columns.T @ columns
        cross += columns.T @ rows.T
        # As products, which cost a third of sums.
        ones = np.ones(len(moved))
        total += ones @ columns
        level += rows @ ones
    if not centred:
        return gram, cross
    mean = total / (stop - start)
    return gram - np.outer(total, mean), cross - np.outer(mean, level)


def delayed_squared_correlations(
    states: Array,
    weights: Array,
    offset: Array,
    message: Array,
    delays: Delays,
    start: int,
    stop: int,
) -> tuple[Array, Array]:
    """Squared correlation of each delayed message with its prediction, as in `squared_correlation`, and its scatter.

    Parameters
    ----------
    states : ndarray of shape (samples, features)
    weights : ndarray of shape (features, delays)
    offset : ndarray of shape (features,)
        Subtracted from the states before they are weighted. It changes no correlation, but saves digits.
    message : ndarray of shape (samples,)
        Of a mean that is small beside its spread.
    delays : ndarray of shape (delays,)
    start, stop : int
        First sample that is scored, and the one after the last.

    Returns
    -------
    squared : ndarray of shape (delays,)
    scatter : ndarray of shape (delays,)
        ``sum (p t)^2 / (sum p^2 sum t^2)`` of prediction p and message t, each without its mean: in White's form the
        variance of the correlation where there is none. 1 / samples where p^2 and t^2 are unrelated, and where either
        is constant.
    """
    p, t, pp, tt, pt, ptt, pptt = np.zeros((7, len(delays)))
    for moved, rows in _blocks(states, message, delays, start, stop, offset):
        prediction = weights.T @ moved.T
        ones = np.ones(len(moved))
        p += prediction @ ones
        t += rows @ ones
        pp += np.vecdot(prediction, prediction)
        tt += np.vecdot(rows, rows)
        pt += np.vecdot(prediction, rows)
        prediction *= rows
        ptt += np.vecdot(prediction, rows)
        pptt += np.vecdot(prediction, prediction)
    samples = stop - start
    covariance = np.maximum(pt - p * t / samples, 0)
    scale = np.maximum(pp - p**2 / samples, 0) * (tt - t**2 / samples)
    # Rounding can carry a perfect correlation past 1 in the last digit.
    squared = np.minimum(np.divide(covariance**2, scale, out=np.zeros_like(scale), where=scale > 0), 1)
    # The message's own mean is left in: it is of the order of its standard error.
    level = p / samples
    fourth = np.maximum(pptt - 2 * level * ptt + level**2 * tt, 0)
    scatter = np.divide(fourth, scale, out=np.full_like(scale, 1 / samples), where=scale > 0)
    return squared, scatter


def _blocks(
    states: Array, message: Array, delays: Delays, start: int, stop: int, offset: Array
) -> Iterator[tuple[Array, Array]]:
    features = states.shape[1]
    block = max(_LEAST, _BLOCK // max(features, len(delays)))
    moved = np.empty((block, features))
    for first in range(start, stop, block):
        last = min(first + block, stop)
        rows = delayed_rows(message, delays, first, last)
        yield np.subtract(states[first:last], offset, out=moved[: last - first]), rows
