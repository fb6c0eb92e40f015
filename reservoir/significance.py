"""What chance alone explains of a function of the input: the law to which a capacity is compared.

The share of a function y that least squares on states with an orthonormal basis Q explain is ``||b||^2 / ||y||^2`` with
``b = Q^T y``. If y is uncorrelated with the states, b is nearly normal with the covariance ``Q^T diag(y^2) Q``. That is
the identity times Var y only if y^2 says nothing of the states: true for fair bits, false for a product of rare flips
and states that jump at the same flips. So the covariance is estimated as White does [1]_, with y itself in place of
residuals: under the hypothesis that is tested they are the same, and the level holds in short series too. A weighted
sum of chi-squared variables follows; its first three cumulants give a gamma law [2]_.

References
----------
.. [1] H. White, "A heteroskedasticity-consistent covariance matrix estimator and a direct test for heteroskedasticity",
   Econometrica 48, 817, 1980.
.. [2] D. R. Jensen and H. Solomon, "A Gaussian approximation to the distribution of a definite quadratic form", Journal
   of the American Statistical Association 67, 898, 1972.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Standard deviation of y^2 over its mean up to which it counts as constant: fair bits less their mean leave some.
_CONSTANT = 0.1
VALUES_FOR_A_TAIL = 1000
"""From fewer no tail is fitted: its largest tenth would be below a hundred."""
# Number of rare factors, beside those of a function itself, by which a state may be mistaken for the function.
_FURTHER = 2
# Values beyond a quantile from which it is taken from them.
_ENOUGH = 10
# Shape below which a generalised Pareto law is exponential, to rounding.
_EXPONENTIAL = 1e-6


class Chance(NamedTuple):
    """What chance explains of functions.

    Attributes
    ----------
    mean : ndarray of shape (functions,)
        Share of the variance that chance explains in the mean.
    cutoff : ndarray of shape (functions,)
        Share that it explains more than with the probability asked for. Where the explained shares were given it is
        exact only as far as they need to be told from it.
    """

    mean: Array
    cutoff: Array


def chance(basis: Array, rows: Array, significance: float, explained: Array | None = None) -> Chance:
    """Law of the explained share of functions that are uncorrelated with the states.

    Parameters
    ----------
    basis : ndarray of shape (samples, rank)
        Orthonormal, of zero mean.
    rows : ndarray of shape (functions, samples)
    significance : float, in (0, 1)
    explained : ndarray of shape (functions,), optional
        The shares that will be compared. Those that are beyond doubt are not looked at closely, which costs samples x
        rank^2 operations each.

    Returns
    -------
    Chance
    """
    # Imported where it is used: it takes a fifth of a second, and whoever only steps an environment needs none of it.
    from scipy.special import betaincinv, gammainccinv

    samples, rank = basis.shape
    leverage = np.vecdot(basis, basis)
    centred = rows - rows.mean(axis=1, keepdims=True)
    squares = centred**2
    total = squares.sum(axis=1)
    moving = total > 0
    share = np.divide(squares @ leverage, total, out=np.full(len(rows), rank / samples), where=moving)
    # Exact for normal functions, and for any that do not depend on the states where there are many samples.
    exact = float(betaincinv(rank / 2, max(samples - 1 - rank, 1) / 2, 1 - significance))
    cutoff = np.minimum(1, np.maximum(1, share * samples / rank) * exact)
    # Upper bound: the cutoff if a single direction of the states held all of the variance.
    most = np.minimum(1, 2 * share * gammainccinv(0.5, significance))
    uneven = squares.std(axis=1) > _CONSTANT * squares.mean(axis=1)
    close = moving & uneven
    if explained is not None:
        close &= (explained > cutoff) & (explained <= most)
        cutoff = np.where(moving & uneven & (explained > most), most, cutoff)
    for i in np.flatnonzero(close):
        covariance = (basis * squares[i][:, None]).T @ basis / total[i]
        weights = np.linalg.eigvalsh(covariance)
        second, third = float(weights @ weights), float(np.sum(weights**3))
        # Diagonal of the quadratic form. Random signs leave it as it is, so that the variance without it is exact for
        # fair signs.
        alone = leverage * squares[i] / total[i]
        variance = 2 * max(second - float(alone @ alone), 0)
        shape = second**3 / (2 * third**2)
        spread = (float(gammainccinv(shape, significance)) - shape) / np.sqrt(shape)
        cutoff[i] = min(most[i], max(cutoff[i], share[i] + np.sqrt(variance) * spread))
    return Chance(share, cutoff)


def effective_events(basis: Array, rows: Array) -> Array:
    """Number of samples that carry what the states tell of functions: ``(sum s^2)^2 / sum s^4``.

    s is the product of the function with its leave-one-out prediction. A capacity that rests on seven coincidences of
    rare flips has some seven.

    Parameters
    ----------
    basis : ndarray of shape (samples, rank)
    rows : ndarray of shape (functions, samples)

    Returns
    -------
    ndarray of shape (functions,)
    """
    centred = rows - rows.mean(axis=1, keepdims=True)
    products = ((centred @ basis) @ basis.T - np.vecdot(basis, basis) * centred) * centred
    squares = products**2
    fourth = np.vecdot(squares, squares)
    return squares.sum(axis=1) ** 2 / np.where(fourth > 0, fourth, np.inf)


def events_needed(functions: Array, significance: float) -> float:
    """Effective samples needed before a product of inputs can be told from one with further factors.

    In a sample where a rare flip never falls on the others, a product with it is a multiple of the product without it:
    no statistic of the sample can tell them apart. If the flip has probability p, that happens over n independent
    occasions with probability ``(1 - p)^n``, which is below the significance from ``n = -ln(significance) / p`` on. Two
    further flips ask for twice as many, since most of what is seen then rests on occasions with one of them. The fourth
    moment of a function of one input stands for 1 / p; it is 1 for fair bits.

    Parameters
    ----------
    functions : ndarray of shape (degrees, samples)
        Of one input, as in `stickslip.reservoir.product_basis`.
    significance : float, in (0, 1)

    Returns
    -------
    float
    """
    squares = functions**2
    kurtosis = (squares**2).mean(axis=1) / squares.mean(axis=1) ** 2
    return float(-_FURTHER * np.log(significance) * kurtosis.max())


def tail_quantile(values: Array, significance: float) -> float:
    """Quantile of a law of which a sample is given, beyond the sample where need be.

    Where fewer than ten values are beyond it, a generalised Pareto law is fitted to the largest tenth of them by
    probability-weighted moments [1]_.

    Parameters
    ----------
    values : ndarray
        `VALUES_FOR_A_TAIL` at least, and a hundredth of the inverse of the significance.
    significance : float, in (0, 1)
        Probability beyond the quantile.

    Returns
    -------
    float

    References
    ----------
    .. [1] J. R. M. Hosking and J. R. Wallis, "Parameter and quantile estimation for the generalized Pareto
       distribution", Technometrics 29, 339, 1987.
    """
    ordered = np.sort(values)
    if len(ordered) * significance >= _ENOUGH:
        return float(np.quantile(ordered, 1 - significance))
    beyond = len(ordered) // 10
    start = ordered[-beyond - 1]
    excess = ordered[-beyond:] - start
    mean = float(excess.mean())
    if mean == 0:
        return float(start)
    weighted = float(np.mean((1 - (np.arange(1, beyond + 1) - 0.35) / beyond) * excess))
    # In the convention of a tail (1 + shape x / scale)^(-1 / shape).
    shape = 2 - mean / (mean - 2 * weighted)
    scale = 2 * mean * weighted / (mean - 2 * weighted)
    # The law of an explained share has nearly an exponential tail; a fit to a hundred values may be shorter by chance.
    shape = max(shape, 0.0)
    times = beyond / len(ordered) / significance
    reach = math.log(times) if shape < _EXPONENTIAL else (times**shape - 1) / shape
    return float(start + scale * reach)
