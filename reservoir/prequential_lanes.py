"""Memory scores of many reservoirs at once, eight side by side.

Each lane does what `prequential.score` does, in the same order, and rounds as it does.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compiling.compilation import compiled
from ..compiling.vectors import aligned_zeros, broadcast, clipped, LANES, load, store
from .prequential import PrequentialMemory, RIDGE

__all__ = ["Readouts", "blank_readouts", "forget", "packed", "readouts_of", "score_lanes", "unpack"]

Array = NDArray[np.float64]


class Readouts(NamedTuple):
    """Readouts of many reservoirs, eight to a block: the last axis of every array but `seen` is the lane."""

    weights: Array  # (blocks, delays, features + 1, LANES)
    covariance: Array  # (blocks, half of the square matrix by rows, LANES)
    past: Array  # (blocks, delays, LANES): messages, newest first
    scaling: Array  # (blocks, 2, features, LANES): centre and scale of each feature
    seen: Array  # (blocks * LANES,): samples since the start
    variance: float  # of the message
    lead: float  # samples before the first message


def readouts_of(memories: Sequence[PrequentialMemory], kind: NDArray[np.int64]) -> Readouts:
    """Readouts of features that are scaled as those of others.

    Parameters
    ----------
    memories : sequence of PrequentialMemory
        Of the same numbers of delays and features, and the same target.
    kind : (reservoirs,) array of int
        Which of them is whose.

    Returns
    -------
    Readouts
        At their start.
    """
    first = memories[0]
    readouts = blank_readouts(len(kind), first.delays, len(first.centre) + 1, first.variance, first.target.lead)
    for i, which in enumerate(kind.tolist()):
        block, lane = divmod(i, LANES)
        readouts.scaling[block, 0, :, lane] = memories[which].centre
        readouts.scaling[block, 1, :, lane] = memories[which].scale
    forget(readouts, np.ones(len(kind), np.bool_))
    return readouts


def blank_readouts(count: int, delays: int, features: int, variance: float, lead: int = 0) -> Readouts:
    """Readouts that see nothing and learn nothing, of so many delays and features, the constant one among them."""
    blocks = -(-count // LANES)
    half = features * (features + 1) // 2
    return Readouts(
        aligned_zeros(blocks, delays, features, LANES),
        aligned_zeros(blocks, half, LANES),
        aligned_zeros(blocks, delays, LANES),
        aligned_zeros(blocks, 2, features - 1, LANES),
        aligned_zeros(blocks * LANES),
        variance,
        float(lead),
    )


def packed(readouts: Readouts, i: int) -> tuple[Array, ...]:
    """Copies of weights, covariance and messages as `PrequentialMemory.packed` returns them, of readout `i`."""
    block, lane = divmod(i, LANES)
    return tuple(each[block, ..., lane].copy() for each in (readouts.weights, readouts.covariance, readouts.past))


def unpack(readouts: Readouts, indices: Sequence[int], state: tuple[Array, ...], seen: int) -> None:
    """Let these readouts go on from what `packed` returned after `seen` samples."""
    block, lane = np.divmod(indices, LANES)
    for each, own in zip((readouts.weights, readouts.covariance, readouts.past), state, strict=True):
        each[block, ..., lane] = own
    readouts.seen[indices] = seen


@compiled
def forget(readouts: Readouts, mask: NDArray[np.bool_]) -> None:
    """Let the readouts in the mask, of shape (reservoirs,), start again."""
    for i in range(len(mask)):
        if not mask[i]:
            continue
        block, lane = i // LANES, i % LANES
        size = readouts.weights.shape[2]
        for d in range(readouts.weights.shape[1]):
            readouts.past[block, d, lane] = 0.0
            for f in range(size):
                readouts.weights[block, d, f, lane] = 0.0
        for row in range(size):
            for column in range(row + 1):
                k = row * (row + 1) // 2 + column
                readouts.covariance[block, k, lane] = 1.0 / RIDGE if row == column else 0.0
        readouts.seen[i] = 0.0


@compiled
def score_lanes(
    readouts: Readouts, block: int, states: Array, first: int, stride: int, messages: Array, scratch: Array
) -> None:
    """Score one sample of each reservoir of a block and learn it, in place.

    Parameters
    ----------
    readouts : Readouts
    block : int
    states : array of float64, C-contiguous
        Feature f of the block's lanes lies at ``first + f * stride`` and behind.
    first, stride : int
    messages : (blocks * LANES,) array
        Overwritten with what each sample earned: messages in, scores out.
    scratch : (2, features + 1, LANES) array
    """
    delays, size = readouts.weights.shape[1], readouts.weights.shape[2]
    half = size * (size + 1) // 2
    gains = size * LANES
    weights = block * delays * gains
    covariance = block * half * LANES
    past = block * delays * LANES
    centre = block * 2 * (size - 1) * LANES
    scale = centre + (size - 1) * LANES

    for f in range(size - 1):
        shifted = load(states, first + f * stride) - load(readouts.scaling, centre + f * LANES)
        store(scratch, f * LANES, shifted * load(readouts.scaling, scale + f * LANES))
    store(scratch, (size - 1) * LANES, broadcast(1.0))

    uncertainty = broadcast(1.0)
    for j in range(size):
        gain = broadcast(0.0)
        for i in range(size):
            k = i * (i + 1) // 2 + j if i >= j else j * (j + 1) // 2 + i
            gain = gain + load(scratch, i * LANES) * load(readouts.covariance, covariance + k * LANES)
        store(scratch, gains + j * LANES, gain)
        uncertainty = uncertainty + load(scratch, j * LANES) * gain
    shrink = broadcast(1.0) / uncertainty
    leverage = uncertainty - broadcast(1.0)
    certainty = clipped(broadcast(2.0) - leverage)

    for d in range(delays - 1, 0, -1):
        store(readouts.past, past + d * LANES, load(readouts.past, past + (d - 1) * LANES))
    store(readouts.past, past, load(messages, block * LANES))
    seen = load(readouts.seen, block * LANES) + broadcast(1.0)
    store(readouts.seen, block * LANES, seen)

    heard = seen - broadcast(readouts.lead)
    earned = broadcast(0.0)
    for d in range(delays):
        row = weights + d * gains
        prediction = broadcast(0.0)
        for f in range(size):
            prediction = prediction + load(readouts.weights, row + f * LANES) * load(scratch, f * LANES)
        target = load(readouts.past, past + d * LANES)
        known = clipped(heard - broadcast(float(d)))  # 1, or 0 for a message from before the first
        error = target - prediction
        share = clipped((heard - broadcast(float(d))) / seen)
        earned = earned + known * (target * target - error * error / (broadcast(1.0) + leverage * share))
        step = known * (error * shrink)
        for f in range(size):
            learned = load(readouts.weights, row + f * LANES) + step * load(scratch, gains + f * LANES)
            store(readouts.weights, row + f * LANES, learned)
    store(messages, block * LANES, certainty * earned / broadcast(readouts.variance))

    k = covariance
    for i in range(size):
        for j in range(i + 1):
            taken = load(scratch, gains + i * LANES) * load(scratch, gains + j * LANES) * shrink
            store(readouts.covariance, k, load(readouts.covariance, k) - taken)
            k += LANES
