"""An orthonormal basis of the states, fast where that is safe: what every measure here is computed in.

The Gram matrix squares the condition number, and states sampled within one hold of the valve are close to collinear.
Its Cholesky factor is still good enough to make the columns nearly orthonormal, and what is left to do is then well
conditioned: two passes lose no more digits than Householder's QR does, and are products of matrices [1]_. How well
the first pass did is looked at, not assumed: where nine digits are certain already it is left at that, and where it
failed Householder's QR takes over.

References
----------
.. [1] Y. Yamamoto, Y. Nakatsukasa, Y. Yanagisawa and T. Fukaya, "Roundoff error analysis of the CholeskyQR2
   algorithm", Electronic Transactions on Numerical Analysis 44, 306, 2015.
"""

import math
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from ..common.validation import finite_array
from .sensor_noise import noise_over_signal

Array = NDArray[np.float64]

# A direction counts if it is longer than this many roundings of the states. A state that is an affine function of
# another one follows it to a few.
_ROUNDINGS = 100 * np.finfo(np.float64).eps
# Departure from orthonormality after the first pass up to which the second one repairs it: [1] needs below 1.
_NEARLY_ORTHONORMAL = 0.5
_NINE_DIGITS = 1e-9
# Largest state below which, and above whose inverse, squares of states lose digits or overflow.
_LEAST_SIZE = 2.0**-300


def of_usual_size(states: Array) -> Array:
    """The states, or where their squares would leave the floating-point numbers a power of two times them.

    Parameters
    ----------
    states : ndarray

    Returns
    -------
    ndarray
        The same array where it is not multiplied.
    """
    largest = max(abs(float(states.max())), abs(float(states.min())))
    if largest == 0 or _LEAST_SIZE < largest < 1 / _LEAST_SIZE:
        return states
    return np.ldexp(states, -math.frexp(largest)[1])


class Whitening(NamedTuple):
    """A map of features to columns that are orthonormal, or nearly.

    Attributes
    ----------
    map : ndarray of shape (features, features)
        Upper triangular.
    departure : float
        At most how far the product of the columns with themselves is from the identity, by rounding.
    """

    map: Array
    departure: float

    @property
    def nine_digits(self) -> bool:
        """Whether the columns are orthonormal enough: scores of finite series are uncertain in their third digit."""
        return self.departure < _NINE_DIGITS


def whitening(gram: Array) -> Whitening | None:
    """Map features to nearly orthonormal columns, or say that they are too close to collinear for it.

    Parameters
    ----------
    gram : ndarray of shape (features, features)
        Products of the features, summed over the samples.

    Returns
    -------
    Whitening or None
        None where the condition number, columns scaled to one length, is above some 1e8.
    """
    scale = np.sqrt(np.maximum(gram.diagonal(), 0))
    if not scale.all():
        return None
    factor, failed = scipy.linalg.lapack.dpotrf(gram / np.outer(scale, scale))
    if failed:
        return None
    inverse = scipy.linalg.lapack.dtrtri(factor)[0]
    # Rounding of the Gram matrix, stretched by the map from both sides.
    departure = np.finfo(np.float64).eps * len(gram) * float(np.linalg.norm(inverse)) ** 2
    return Whitening(inverse / scale[:, None], departure)


def repaired(x: Array, white: Whitening | None) -> tuple[Array, Array] | None:
    """Finish an orthonormal basis by a second pass.

    Parameters
    ----------
    x : ndarray of shape (samples, features)
    white : Whitening or None
        Of `x`.

    Returns
    -------
    columns : ndarray of shape (samples, features)
        ``x @ white.map``.
    triangle : ndarray of shape (features, features)
        Upper triangular; ``columns @ triangle^-1`` is orthonormal to rounding. None in place of both where the first
        pass did not leave the columns nearly orthonormal.
    """
    if white is None:
        return None
    columns = x @ white.map
    triangle = repair(columns.T @ columns)
    return None if triangle is None else (columns, triangle)


def repair(gram: Array) -> Array | None:
    """Triangle that makes nearly orthonormal columns orthonormal.

    Parameters
    ----------
    gram : ndarray of shape (features, features)
        Products of the columns with themselves.

    Returns
    -------
    ndarray of shape (features, features), or None
        Upper triangular; None where the columns are not nearly orthonormal.
    """
    # Not "above", which would let a NaN pass.
    if not np.linalg.norm(gram - np.eye(len(gram))) < _NEARLY_ORTHONORMAL:
        return None
    triangle: Array = scipy.linalg.lapack.dpotrf(gram)[0]
    return triangle


class Centred(NamedTuple):
    """States without their mean.

    Attributes
    ----------
    states : ndarray of shape (samples, features)
    mean : ndarray of shape (features,)
        Of what the first sample leaves of them.
    """

    states: Array
    mean: Array


def centre(states: Array) -> Centred:
    """Subtract the mean of each column, to rounding even where it is far larger than what varies.

    Parameters
    ----------
    states : ndarray of shape (samples, features)

    Returns
    -------
    Centred
    """
    # A difference from a neighbour is exact or nearly so, and a column that never moves becomes exactly zero.
    moved = states - states[0]
    # As a product, which is a third of the cost of `mean` along the rows.
    mean = np.full(len(moved), 1 / len(moved)) @ moved
    moved -= mean
    return Centred(moved, mean)


def orthonormal_basis(states: Array) -> Array:
    """Find an orthonormal basis of what the centred states span.

    Parameters
    ----------
    states : ndarray of shape (samples, features)

    Returns
    -------
    ndarray of shape (samples, rank)
        Its columns have zero mean. Directions no longer than the rounding of the states are left out.
    """
    x = centre(states).states
    norms = column_norms(states)
    white = whitening(x.T @ x)
    found = repaired(x, white)
    if white is not None and found is not None and surely_full_rank(white, norms):
        columns, triangle = found
        return _without_mean(columns @ scipy.linalg.lapack.dtrtri(triangle)[0])
    q, triangle = scipy.linalg.qr(x / norms, mode="economic", check_finite=False)
    left, singular, _ = np.linalg.svd(triangle, full_matrices=False)
    return _without_mean(q @ left[:, singular > _tolerance(singular)])


def state_rank(states: ArrayLike, *, noise: float | None = None) -> int:
    """Count the directions in which states vary by more than their rounding, or than the noise of their sensors.

    It bounds every sum of capacities. Each column is divided by its norm, offset included, and then centred, so that
    its rounding is that of the number 1; a singular value counts if it is above a hundred such roundings. Neither the
    unit of a column nor its offset matters, as long as the offset leaves digits for what varies.

    With noise in each feature in proportion to its standard deviation, a direction counts if the features, each in
    units of it, vary in that direction by more than the noise.

    Parameters
    ----------
    states : array_like of shape (samples, features)
    noise : float, optional
        Signal-to-noise ratio of the sensors in decibels.

    Returns
    -------
    int

    Raises
    ------
    ValueError
        If `states` has a wrong shape or is not finite.
    """
    x = of_usual_size(finite_array("states", states, 2))
    if noise is None:
        return rank_of(x)
    moved = centre(x).states
    spread = column_norms(moved)
    return int((np.linalg.svd(moved / spread, compute_uv=False) > noise_over_signal(noise)).sum())


def rank_of(states: Array) -> int:
    """`state_rank` without the checks."""
    scaled = centre(states).states / column_norms(states)
    # LAPACK itself, for `qr` would copy the whole of the states twice.
    triangle = np.triu(scipy.linalg.lapack.dgeqrf(np.asfortranarray(scaled), overwrite_a=True)[0][: scaled.shape[1]])
    singular = np.linalg.svd(triangle, compute_uv=False)
    return int((singular > _tolerance(singular)).sum())


def surely_full_rank(white: Whitening, norms: Array) -> bool:
    """Whether the whitening of centred states alone shows that their rank is the number of features.

    Parameters
    ----------
    white : Whitening
        Of some of the samples: others can only add to the rank.
    norms : ndarray of shape (features,)
        Of the columns of the states, offset included.

    Returns
    -------
    bool
    """
    # With columns scaled to `norms`, the least singular value is at least this norm's inverse, nearly.
    inverse = np.linalg.norm(white.map * norms[:, None])
    return bool(inverse * 2 * _ROUNDINGS * np.sqrt(len(norms)) < 1)


def column_norms(x: Array) -> Array:
    """Euclidean norm of each column, or 1 for a column of zeros."""
    norms: Array = np.sqrt(np.einsum("ij,ij->j", x, x))
    return np.where(norms > 0, norms, 1.0)


def _without_mean(basis: Array) -> Array:
    # A direction that is small in the states has the rounding of their mean magnified.
    return basis - basis.mean(axis=0)


def _tolerance(singular: Array) -> float:
    return float(_ROUNDINGS * max(1.0, singular[0]))
