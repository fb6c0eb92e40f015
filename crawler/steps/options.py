"""What the solvers are told, and what they answer."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..model.state import Body, Coefficients, Ledger

__all__ = [
    "AFRESH",
    "DIVERGED",
    "FINISHED",
    "LOG_FULL",
    "MAX_STEPS",
    "METHODS",
    "OUT_OF_STEPS",
    "PAUSED",
    "SAMPLES_A_STEP",
    "STEPS_A_HOLD",
    "TAYLOR",
    "ClosedForm",
    "Hold",
    "Leg",
    "Method",
    "Options",
    "Outcome",
    "Pace",
    "Radau",
    "Recording",
    "Situation",
    "Taylor",
    "Taylor8",
    "Taylor12",
    "Taylor16",
    "Taylor20",
    "TaylorChain",
    "TaylorSensitive",
    "is_taylor",
    "method_of",
]

FINISHED, DIVERGED, OUT_OF_STEPS, LOG_FULL, PAUSED = 0, 1, 2, 3, 4

# Half a second of work, ten thousand times what the default crawler needs for a hold of 20.
MAX_STEPS = 1_000_000
# Steps that a run may take besides for each of its holds.
STEPS_A_HOLD = 1000
# Samples that take as long as a step.
SAMPLES_A_STEP = 10


class Taylor8(NamedTuple):
    """The method of Taylor series of order 8: the last coefficient of the force."""

    @staticmethod
    def order() -> int:
        """Degree of the force's polynomial in a step."""
        return 8


class Taylor12(NamedTuple):
    """Of order 12."""

    @staticmethod
    def order() -> int:
        """Degree of the force's polynomial in a step."""
        return 12


class Taylor16(NamedTuple):
    """Of order 16."""

    @staticmethod
    def order() -> int:
        """Degree of the force's polynomial in a step."""
        return 16


class Taylor20(NamedTuple):
    """Of order 20."""

    @staticmethod
    def order() -> int:
        """Degree of the force's polynomial in a step."""
        return 20


class Radau(NamedTuple):
    """The method of Radau collocation."""

    @staticmethod
    def order() -> int:
        """Degree to which its polynomials are padded with zeros."""
        return 12


class ClosedForm(NamedTuple):
    """No method at all: the motion is linear."""


class TaylorChain(NamedTuple):
    """The method of Taylor series for a chain of segments, of any order: it is expanded in loops."""


class TaylorSensitive(NamedTuple):
    """The method of Taylor series with sensitivities along, of the order of the method in the workspace."""


Taylor = Taylor8 | Taylor12 | Taylor16 | Taylor20
Method = Taylor | Radau | ClosedForm | TaylorChain | TaylorSensitive
TAYLOR: dict[int, type[Taylor]] = {method.order(): method for method in (Taylor8, Taylor12, Taylor16, Taylor20)}
# Of a crawler of one body.
METHODS: tuple[type[Method], ...] = (*TAYLOR.values(), Radau, ClosedForm)


class Options(NamedTuple):
    """How accurately, and for how long at most, to integrate."""

    tolerance: float
    order: int  # degree of the force's polynomial in a step
    max_steps: int
    energy: bool  # whether to keep the ledger
    log: bool  # whether to write down the events
    tangents: bool  # whether to carry the tangents
    method: Method  # its type alone matters: kernels are compiled for the one that is used


class Hold(NamedTuple):
    """A stretch of time in which the valve stays as it is: a hold, or a part of one; times in natural units."""

    valve: float  # 0 or 1
    length: float  # of the whole hold
    begin: float  # of the stretch, time into the hold
    end: float  # at most `length`
    start: float  # of the hold in the run; only the events' times depend on it


class Recording(NamedTuple):
    """What is written down of a hold; views of arrays."""

    # (5, S): z, v, p, x, w at the times length (j + 1) / S; of a chain see `chain_parts`; with tangents, if there are
    # rows for it, their growth too, at the stretch's end: see `note_growth`
    samples: NDArray[np.float64]
    events: NDArray[np.float64]  # (capacity, 2): time and new mode of each event, if `Options.log`


class Pace(NamedTuple):
    """What one step tells the next of the same motion."""

    length: float  # to be tried next; 0 where nothing is known
    span: float  # of the step whose polynomials lie in the workspace; 0 without one
    begin: float  # of the next step, in those polynomials' time: `span`, or 0 to do the same step again
    error: float  # of that step, in tolerances; 0 for a Taylor series
    doubt: float  # force by which a grip may be beyond its threshold on that step without the foot breaking loose


class Outcome(NamedTuple):
    """What a hold, or a run, came to."""

    status: int  # FINISHED, DIVERGED, OUT_OF_STEPS, LOG_FULL or PAUSED
    elapsed: float  # time into the hold that was reached
    steps: int  # taken
    logged: int  # events written
    body: Body
    ledger: Ledger
    pace: Pace


class Leg(NamedTuple):
    """Where a stretch of the valve that was paused goes on, and when it is to pause again."""

    opening: Body  # at the stretch's begin
    elapsed: float  # time into the hold that is behind
    pace: Pace
    steps: int  # to take at most until the next pause


class Situation(NamedTuple):
    """Where the motion stands at the start of a step."""

    opening: Body  # at the begin of the valve's stretch
    body: Body
    coefficients: Coefficients
    hold: Hold
    elapsed: float  # time into the hold
    options: Options
    workspace: Any  # of the solver


def method_of(options: Any) -> type[Method]:
    """Class of a method of the options, from the type that numba gives the control."""
    return options[-1].instance_class


def is_taylor(options: Any) -> bool:
    """Whether a method of the options is one of Taylor series, from the type that numba gives the control."""
    return method_of(options) in TAYLOR.values()


AFRESH = Pace(0.0, 0.0, 0.0, 0.0, 0.0)
