"""Warnings of the solver and the measures as sentences, for a page has no terminal."""

import warnings
from collections.abc import Callable
from threading import Lock
from typing import TypeVar

__all__ = ["heard"]

Result = TypeVar("Result")

# Python keeps what becomes of warnings for all threads together, and a page moves while another thread measures.
_ONE_AT_A_TIME = Lock()


def heard(function: Callable[[], Result]) -> tuple[Result, str]:
    """Call a function; return what it returns, and its first warning.

    Parameters
    ----------
    function : callable
        Takes nothing.

    Returns
    -------
    result
    sentence : str
        Empty where nothing was warned of.
    """
    with _ONE_AT_A_TIME, warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        result = function()
    return result, " ".join(str(said[0].message).split()) if said else ""
