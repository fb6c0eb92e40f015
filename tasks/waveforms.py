"""Waveforms to be told apart: periods of a sine and of a square, in random order."""

import numpy as np
from numpy.typing import NDArray

from ..common.validation import whole_number

__all__ = ["waveforms"]


def waveforms(length: int, seed: int, *, points: int = 8) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Draw a series of periods, each a sine or a square with equal odds, and name the kind of every sample.

    The standard first task of physical reservoirs [1]_, [2]_. Every value of the square is one of the sine's too, so
    that none is known for a square by itself: by chance 1 of 2 are named rightly, and without memory 7 of 8 at most.

    Parameters
    ----------
    length : int, at least 1
        Samples; the last period may be cut short.
    seed : int, at least 0
    points : int, at least 4
        Samples a period, a multiple of 4.

    Returns
    -------
    inputs : ndarray of shape (length,)
        ``sin(2 pi j / points)`` at point j of a sine; 1 in the first half of a square, and -1 in the second.
    kinds : ndarray of int64, shape (length,)
        0 for a sine, 1 for a square.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.

    References
    ----------
    .. [1] Y. Paquot, F. Duport, A. Smerieri, J. Dambre, B. Schrauwen, M. Haelterman and S. Massar, "Optoelectronic
       reservoir computing", Scientific Reports 2, 287, 2012.
    .. [2] J. Torrejon et al., "Neuromorphic computing with nanoscale spintronic oscillators", Nature 547, 428, 2017.
    """
    length, points = whole_number("length", length, 1), whole_number("points", points, 4)
    if points % 4:
        raise ValueError(f"points must be a multiple of 4, got {points}")
    random = np.random.default_rng(whole_number("seed", seed, 0))
    kinds = np.repeat(random.integers(0, 2, -(-length // points)), points)[:length]
    point = np.arange(length) % points
    sine = np.sin(2 * np.pi * point / points)
    return np.where(kinds == 1, np.where(point < points // 2, 1.0, -1.0), sine), kinds
