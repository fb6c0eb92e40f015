"""Delayed parity: the target that no linear readout of the input's past can approach."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.validation import whole_number
from ..reservoir.delay_line import delay_line
from .streams import bits as as_bits


def parity(bits: ArrayLike, order: int, delay: int = 0) -> NDArray[np.int64]:
    """Compute whether the number of ones among some past bits is odd.

    ``(sum_{i=0..order-1} u(t - delay - i)) mod 2``. For fair bits it is again a stream of independent fair
    bits, and from order 2 on it is uncorrelated with every weighted sum of the input.

    Parameters
    ----------
    bits : array_like of shape (samples,)
        Of 0 and 1.
    order : int, at least 1
        Number of consecutive bits. 1 is plain memory; 2 is exclusive or.
    delay : int, at least 0
        Age of the latest of them.

    Returns
    -------
    ndarray of shape (samples,)
        Of 0 and 1. Entries from index ``delay + order - 1`` on are defined by `bits` alone; those before it
        take the bits before the start to be 0.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.
    """
    stream = as_bits("bits", bits)
    order, delay = whole_number("order", order, 1), whole_number("delay", delay, 0)
    return delay_line(stream, delay + order)[:, delay:].sum(axis=1).astype(np.int64) % 2
