"""The delay line: the reservoir that remembers perfectly and computes nothing."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.validation import finite_array, whole_number


def delay_line(signal: ArrayLike, taps: int) -> NDArray[np.float64]:
    """Collect the states of a shift register driven by a signal.

    A linear readout of it has memory capacity 1 at each of the delays 0 to ``taps - 1`` and 0 beyond: the
    most any `taps` features can have, and none of it for a nonlinear task.

    Parameters
    ----------
    signal : array_like of shape (samples,)
    taps : int
        Length of the register, at least 1.

    Returns
    -------
    ndarray of shape (samples, taps)
        Column j is ``signal[k - j]``, zero before the start.

    Raises
    ------
    TypeError
        If `taps` is not an integer.
    ValueError
        If `signal` has a wrong shape or is not finite, or `taps` is below 1.
    """
    signal = finite_array("signal", signal, 1)
    taps = whole_number("taps", taps, 1)
    padded = np.concatenate([np.zeros(taps - 1), signal])
    return np.lib.stride_tricks.sliding_window_view(padded, taps)[:, ::-1].copy()
