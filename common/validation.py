"""Arguments checked, and refused in one sentence: the name, what is allowed, and what was given."""

from collections.abc import Iterable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray


def finite_array(name: str, value: ArrayLike, ndim: int | tuple[int, ...]) -> NDArray[np.float64]:
    """Convert to a float array of the given number of dimensions, without a NaN or an infinity.

    Parameters
    ----------
    name : str
        What the caller calls the argument.
    value : array_like
        What the caller was given.
    ndim : int or tuple of int
        The numbers of dimensions allowed.

    Returns
    -------
    ndarray of float64

    Raises
    ------
    TypeError
        If `value` is not an array of real numbers.
    ValueError
        If `value` has another number of dimensions, is empty, has masked entries, or is not finite everywhere.
    """
    if np.ma.is_masked(value):
        index = tuple(int(i) for i in np.argwhere(np.ma.getmaskarray(np.ma.asarray(value)))[0])
        raise ValueError(f"{name} must have no masked entries, got one at index {index}")
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be an array of real numbers, got {value!r}") from None
    except OverflowError:  # a whole number beyond all floats
        raise ValueError(f"{name} must be finite, got a whole number beyond the floats") from None
    allowed = (ndim,) if isinstance(ndim, int) else ndim
    if array.ndim not in allowed or array.size == 0:
        wanted = " or ".join(f"{n}-dimensional" for n in allowed)
        raise ValueError(f"{name} must be {wanted} and not empty, got shape {array.shape}")
    if not np.isfinite(array).all():
        index = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise ValueError(f"{name} must be finite, got {array[index]} at index {index}")
    return array


def known_names(name: str, given: Iterable[Any], allowed: Iterable[str]) -> None:
    """Refuse a name that is not among those allowed.

    Parameters
    ----------
    name : str
        What the caller calls the argument.
    given : iterable
        The names the caller was given.
    allowed : iterable of str

    Raises
    ------
    ValueError
        If one of `given` is unknown.
    """
    known = list(allowed)
    for each in given:
        if each not in known:
            raise ValueError(f"{name} has no {each!r}; allowed are {known}")


def different_names(name: str, given: Iterable[Any], allowed: Iterable[str]) -> None:
    """Refuse a name that is not among those allowed or is there twice, and no name at all.

    Parameters
    ----------
    name : str
        What the caller calls the argument.
    given : iterable
        The names the caller was given.
    allowed : iterable of str

    Raises
    ------
    ValueError
        If one of `given` is unknown or given twice, or there is none.
    """
    known, names = list(allowed), list(given)
    known_names(name, names, known)
    if not names or len(set(names)) < len(names):
        raise ValueError(f"{name} must be one or several of {known}, each once, got {names}")


def truth_value(name: str, value: Any) -> bool:
    """Convert a truth value, Python's or NumPy's, to Python's.

    Parameters
    ----------
    name : str
        What the caller calls the argument.
    value : bool or numpy.bool_
        What the caller was given.

    Returns
    -------
    bool

    Raises
    ------
    TypeError
        If `value` is anything else.
    """
    if not isinstance(value, bool | np.bool_):
        raise TypeError(f"{name} must be True or False, got {value!r}")
    return bool(value)


def whole_number(name: str, value: Any, minimum: int, maximum: int | None = None) -> int:
    """Convert to an int that is at least `minimum`, and at most `maximum` if there is one.

    Parameters
    ----------
    name : str
        What the caller calls the argument.
    value : int or numpy integer
        What the caller was given; a bool or a float is refused even where it is whole.
    minimum : int
        The least value allowed.
    maximum : int, optional
        The largest value allowed.

    Returns
    -------
    int

    Raises
    ------
    TypeError
        If `value` is not an integer.
    ValueError
        If `value` is below `minimum` or above `maximum`.
    """
    allowed = f">= {minimum}" if maximum is None else f"in [{minimum}, {maximum}]"
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        raise TypeError(f"{name} must be a whole number {allowed}, got {value!r}")
    if value < minimum or (maximum is not None and value > maximum):
        raise ValueError(f"{name} must be a whole number {allowed}, got {value!r}")
    return int(value)


def number_within(name: str, value: Any, interval: str) -> float:
    """Convert to a float inside an interval.

    Parameters
    ----------
    name : str
        What the caller calls the argument.
    value : float
        What the caller was given.
    interval : str
        The values allowed in the usual notation, such as ``"(0, 1]"`` or ``"[0, inf)"``.

    Returns
    -------
    float

    Raises
    ------
    TypeError
        If `value` is not a real number.
    ValueError
        If `value` lies outside `interval` (a NaN lies outside all).
    """
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer | np.floating):
        raise TypeError(f"{name} must be a number in {interval}, got {value!r}")
    # A whole number may be too large for a float.
    if isinstance(value, int) and abs(value) > 10**308:
        raise ValueError(f"{name} must be in {interval}, got a number of {len(str(abs(value)))} digits")
    low, high = _ends_of(interval)
    allowed_end = (value == low and interval[0] == "[") or (value == high and interval[-1] == "]")
    if not (low < value < high or allowed_end):
        raise ValueError(f"{name} must be in {interval}, got {value!r}")
    return float(value)


@cache
def _ends_of(interval: str) -> tuple[float, float]:
    low, high = interval[1:-1].split(",")
    return float(low), float(high)
