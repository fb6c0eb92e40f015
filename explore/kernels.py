"""The kernels that a setup needs."""

from .measures import exponents_of, long_run
from .motion import shown
from .setup import Setup

__all__ = ["compile_kernels"]

_SHUT = (0,)


def compile_kernels(setup: Setup) -> None:
    """Have all kernels compiled and kept that a page needs for a setup, where they are not.

    Parameters
    ----------
    setup : Setup

    Raises
    ------
    SolverError
        As `simulate`.
    """
    shown(setup, _SHUT)
    if setup.drive != "live":
        exponents_of(setup, long_run(setup).valve)
