"""What a map measures: one table, from names to functions of crawlers that were driven."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...crawler import lyapunov_spectrum, LyapunovSpectrum, simulate, State, Trajectory
from ...reservoir import information_processing_capacity, memory_capacity, target_series
from ...tasks import BodyReservoir

__all__ = ["DEGREES", "MEASURES", "Driven", "Measure", "Variable"]

Array = NDArray[np.float64]

DEGREES = (1, 2, 3)
"""Degrees of which "capacity" tells the capacities."""

# Far from rest, and within what every scene allows.
_OTHER_START = State(deformation=0.4, velocity=-0.3, pressure=0.5)
# Delays of products of one, two and three inputs, which are tried all: a thousand of the third degree.
_REACH = (40, 30, 20)


@dataclass(frozen=True, eq=False)
class Driven:
    """Crawlers that were driven, n of them, and how they are to be measured.

    Attributes
    ----------
    bodies : sequence of n BodyReservoir
        Who differ in groups, scene and hold alone.
    dithers : (n,) array
    valve : (n, holds) array of 0 and 1
    messages : (n, holds) array
        What of the valve was news; all zeros without dither.
    motion : Trajectory
        Of the batch.
    delays : int
        Of memory.
    washout : int
        Holds at the start that a measure leaves out that is not of the whole run.
    threads : int or None
        As in `simulate`.
    """

    bodies: Sequence[BodyReservoir]
    dithers: Array
    valve: NDArray[np.int64]
    messages: Array
    motion: Trajectory
    delays: int
    washout: int
    threads: int | None

    @property
    def holds(self) -> Array:
        """Length of a hold of each, (n,)."""
        return np.array([body.hold for body in self.bodies])

    @cached_property
    def states(self) -> Array:
        """What is read of the bodies, a row a hold: (n, holds, features)."""
        return self.bodies[0].read(self.motion)

    def told_by(self, by: Callable[..., Any], **asked: Any) -> Any:
        """What a function of the arguments of `simulate` says of the same crawlers and valves."""
        return by(
            [body.groups for body in self.bodies],
            self.valve,
            self.holds,
            scene=[body.scene for body in self.bodies],
            tolerance=self.bodies[0].tolerance,
            threads=self.threads,
            **asked,
        )


@dataclass(frozen=True)
class Variable:
    """What a measure tells, a number a run, or one for each point along a further dimension.

    Attributes
    ----------
    unit : str
        Natural units by their symbols; "1" for a number that has none.
    label : str
    along : str
        A further dimension, "delay" or "degree"; empty for none.
    least : float or None
        Below which no value and no interval can reach.
    """

    unit: str
    label: str
    along: str = ""
    least: float | None = 0.0


@dataclass(frozen=True)
class Measure:
    """One measure.

    Attributes
    ----------
    compute : callable
        Takes a :class:`Driven` of n crawlers and gives an array (n,), or (n, points), for each of the variables.
    variables : mapping of str to Variable
    of_message : bool
        Whether it needs flips to be told of.
    """

    compute: Callable[[Driven], Mapping[str, Array]]
    variables: Mapping[str, Variable] = field(hash=False)
    of_message: bool = False


def _memory(driven: Driven) -> dict[str, Array]:
    each = [
        memory_capacity(states, message, driven.delays, washout=driven.washout)
        for states, message in zip(driven.states, driven.messages, strict=True)
    ]
    profiles = np.array([one.profile for one in each])
    return {"memory": np.array([one.corrected for one in each]), "memory_profile": profiles}


def _parity(driven: Driven) -> dict[str, Array]:
    found = {}
    for order in (2, 3):
        found[f"parity_{order}"] = np.array(
            [
                memory_capacity(
                    states,
                    target_series(message, "parity", order, float(dither)),
                    driven.delays,
                    washout=driven.washout + order - 1,
                ).corrected
                for states, message, dither in zip(driven.states, driven.messages, driven.dithers, strict=True)
            ]
        )
    return found


def _capacity(driven: Driven) -> dict[str, Array]:
    rows = []
    for states, message in zip(driven.states, driven.messages, strict=True):
        found = information_processing_capacity(
            states, message, max_degree=DEGREES[-1], delays=_REACH, washout=driven.washout
        )
        rows.append([*(found.by_degree().get(degree, 0.0) for degree in DEGREES), float(found.rank)])
    table = np.array(rows)
    return {"capacity": table[:, :-1], "rank": table[:, -1]}


def _start(driven: Driven) -> dict[str, Array]:
    again = driven.told_by(simulate, initial=_OTHER_START)
    nodes = driven.motion.deformation.shape[-1] // driven.valve.shape[1]
    last = slice(-max(1, driven.valve.shape[1] // 10), None)
    difference, spread = [], []
    for name in ("deformation", "velocity"):
        first, second = getattr(driven.motion, name)[:, nodes - 1 :: nodes][:, last], getattr(again, name)[:, last]
        difference.append(np.mean((first - second) ** 2, axis=1))
        spread.append(np.var(first, axis=1))
    ratios = np.divide(difference, spread, out=np.zeros_like(spread), where=np.array(spread) > 0.0)
    return {"start_difference": np.sqrt(ratios.mean(axis=0))}


def _lyapunov(driven: Driven) -> dict[str, Array]:
    found: LyapunovSpectrum = driven.told_by(lyapunov_spectrum, washout=driven.washout)
    first, second = found.exponents.T
    return {"lyapunov": first, "lyapunov_2": second, "lyapunov_standard_error": found.standard_error[:, 0]}


def _speed(driven: Driven) -> dict[str, Array]:
    return {"speed": driven.motion.foot[:, -1] / (driven.valve.shape[1] * driven.holds)}


def _work(driven: Driven) -> dict[str, Array]:
    return {"work": np.asarray(driven.motion.work) / driven.valve.shape[1]}


def _slips(driven: Driven) -> dict[str, Array]:
    return {"slips": np.asarray(driven.motion.slips) / driven.valve.shape[1]}


MEASURES: Mapping[str, Measure] = MappingProxyType(
    {
        "memory": Measure(
            _memory,
            {
                "memory": Variable("1", "memory capacity"),
                "memory_profile": Variable("1", "memory capacity at a delay", "delay"),
            },
            of_message=True,
        ),
        "parity": Measure(
            _parity,
            {
                "parity_2": Variable("1", "capacity for products of 2 inputs in a row"),
                "parity_3": Variable("1", "capacity for products of 3 inputs in a row"),
            },
            of_message=True,
        ),
        "capacity": Measure(
            _capacity,
            {
                "capacity": Variable("1", "information processing capacity of a degree", "degree"),
                "rank": Variable("1", "rank of the states"),
            },
            of_message=True,
        ),
        "lyapunov": Measure(
            _lyapunov,
            {
                "lyapunov": Variable("1 / t_c", "largest Lyapunov exponent", least=None),
                "lyapunov_2": Variable("1 / t_c", "second Lyapunov exponent", least=None),
                "lyapunov_standard_error": Variable("1 / t_c", "standard error of the largest exponent in a run"),
            },
        ),
        "start": Measure(
            _start, {"start_difference": Variable("1", "difference of two starts at the end, over the spread")}
        ),
        "speed": Measure(_speed, {"speed": Variable("z_c / t_c", "mean speed of the foot", least=None)}),
        "work": Measure(_work, {"work": Variable("P_max A_0 z_c", "work of the pressure a hold", least=None)}),
        "slips": Measure(_slips, {"slips": Variable("1", "slips a hold")}),
    }
)
"""Measures by name. Speed, work and slips are means over the whole run, from rest."""
