"""What is measured of work: bodies beside each other, and averages over ensembles."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...crawler import Groups, State
from .ensembles import boltzmann_starts, far_starts, random_valves, Works, works_of
from .jarzynski import Average, average
from .smooth import smooth_works
from .split import Split, split

__all__ = [
    "BETAS",
    "CASES",
    "COMPARED",
    "COUNTS",
    "FULL",
    "HOLD",
    "QUICK",
    "Case",
    "Size",
    "Spread",
    "Study",
    "compare",
    "measure",
    "spread_of",
    "thermal",
]

HOLD = 0.5
"""Of the valve, natural time."""


@dataclass(frozen=True)
class Case:
    """A body, and the scene it is in.

    Attributes
    ----------
    groups : Groups
    scene : mapping, optional
        As in `simulate`; without a meaning where friction is smooth.
    smooth : float, optional
        Velocity of the foot over which friction changes its sign, as in `smooth_works`; it jumps by default.
    """

    groups: Groups
    scene: Mapping[str, Any] | None = None
    smooth: float | None = None


_SLIDING = Groups(static_friction=Groups().kinetic_friction)
CASES: Mapping[str, Case] = {
    "as it is": Case(Groups()),
    "lag made fast": Case(Groups(deborah=0.01)),
    "lag made slow": Case(Groups(deborah=5.0)),
    "friction absent": Case(Groups(static_friction=0.0, kinetic_friction=0.0), {"ratchet": False}),
    "slides back": Case(Groups(), {"ratchet": False}),
    "slides back without stiction": Case(_SLIDING, {"ratchet": False}),
    "slides back on smooth friction": Case(_SLIDING, smooth=0.1),
    "anchored": Case(Groups(), {"anchored": True}),
    "nearly undamped and stiff": Case(Groups(damping_ratio=0.002, duffing=2000.0, deborah=0.05)),
    "anchored and chaotic": Case(Groups(damping_ratio=0.02, duffing=20.0, deborah=0.05), {"anchored": True}),
}
"""Bodies by name, each the default one but for what the name says.

Friction is taken apart in steps, since a static friction above the kinetic one cannot be made smooth (`smooth_works`):
the foot may slide back, then static friction is as kinetic, then the jump at rest is drawn out over 0.1 z_c / t_c.
"""
COMPARED: Mapping[str, str] = {
    "lag made fast": "as it is",
    "lag made slow": "as it is",
    "friction absent": "as it is",
    "slides back without stiction": "slides back",
    "slides back on smooth friction": "slides back without stiction",
}
"""Bodies whose spread is compared, each with the one from which it differs in what its name says."""
BETAS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
"""Of the averages, 1 / (P_max A_0 z_c)."""
COUNTS = (10, 30, 100, 300, 1000, 3000)
"""Of runs, at which the average's convergence is told, as far as there are so many."""
_PUSHES = (1, 0, 1, 1, 0, 0)
_DRAWS = 2000
_SETTLE = 40  # holds for which the valve stays shut at the end of a cycle


@dataclass(frozen=True)
class Size:
    """How much of everything.

    Attributes
    ----------
    inputs, starts, holds, washout : int
        Of the split of the variance.
    paired : int
        Inputs, from rest, under which the spread of one body is compared with that of another. Its interval gets
        narrower as their square root.
    cycles : int
        Random inputs from rest.
    thermal : int
        Starts at exp(-beta H), for each beta.
    """

    inputs: int
    starts: int
    holds: int
    washout: int
    paired: int
    cycles: int
    thermal: int


FULL, QUICK = Size(64, 6, 1000, 500, 1024, 3000, 1000), Size(24, 4, 600, 300, 192, 1000, 200)


@dataclass(frozen=True, eq=False)
class Spread:
    """Work of one body a hold, and what spreads it.

    Attributes
    ----------
    by_input : (paired,) array
        Work a hold under each of many inputs, from rest.
    parts : Split
        Of the variance over fewer inputs and many starts.
    viscous, friction : float
        Shares of the work that elastomer and ground take.
    residual : float
        Of the balance, as in `Works`.
    """

    by_input: NDArray[np.float64]
    parts: Split
    viscous: float
    friction: float
    residual: float

    @property
    def mean_work(self) -> tuple[float, float, float]:
        """Work a hold, and its 95% interval by bootstrap over inputs."""
        return _with_interval(lambda works: works.mean(axis=-1), self.by_input)

    @property
    def deviation(self) -> float:
        """Standard deviation of the work a hold over runs, each under an input of its own."""
        return float(self.by_input.std(ddof=1))

    @property
    def relative(self) -> tuple[float, float, float]:
        """Deviation over mean, and its 95% interval by bootstrap over inputs."""
        return _with_interval(_relative, self.by_input)


@dataclass(frozen=True, eq=False)
class Study:
    """All that is measured.

    Attributes
    ----------
    spreads : dict of str to Spread
        By the name of the case.
    cycles : (runs,) array
        Work of the default crawler from rest through random bits, until it lies still again.
    least_loss : float
        Least that elastomer and ground took in one of these cycles.
    residual : float
        Of the balance of these cycles.
    crawler : dict of float to Average
        Of the cycles, by beta.
    by_count : dict of (float, int) to Average
        The same, of so many runs.
    conserving, damped : dict of float to Average
        Of an anchored body from starts at exp(-beta H) under one input, without damping and with that of the default.
    """

    spreads: dict[str, Spread]
    cycles: NDArray[np.float64]
    least_loss: float
    residual: float
    crawler: dict[float, Average]
    by_count: dict[tuple[float, int], Average]
    conserving: dict[float, Average]
    damped: dict[float, Average]


def measure(size: Size) -> Study:
    """Measure everything."""
    spreads = {name: spread_of(case, size) for name, case in CASES.items()}
    cycles = works_of(Groups(), random_valves(size.cycles, 20, _SETTLE), [State()], hold=HOLD)
    works = cycles.work[:, 0]
    return Study(
        spreads=spreads,
        cycles=works,
        least_loss=float((cycles.viscous + cycles.friction).min()),
        residual=cycles.residual,
        crawler={beta: average(works, beta) for beta in BETAS},
        by_count={
            (beta, count): average(works[:count], beta) for beta in BETAS for count in COUNTS if count <= len(works)
        },
        conserving=thermal(Groups(damping_ratio=0.0), size.thermal),
        damped=thermal(Groups(), size.thermal),
    )


def spread_of(case: Case, size: Size, hold: float = HOLD) -> Spread:
    """What spreads the work of a body after a washout: by input, and inputs against starts far from each other."""
    paired, few = (
        _works_of(case, random_valves(inputs, size.washout + size.holds), starts, hold, size.washout)
        for inputs, starts in ((size.paired, [State()]), (size.inputs, far_starts(size.starts)))
    )
    whole = float(few.work.sum())
    return Spread(
        by_input=paired.work[:, 0] / size.holds,
        parts=split(few.work / size.holds),
        viscous=float(few.viscous.sum()) / whole,
        friction=float(few.friction.sum()) / whole,
        residual=max(paired.residual, few.residual),
    )


def _works_of(case: Case, valves: NDArray[np.int64], starts: Sequence[State], hold: float, washout: int) -> Works:
    if case.smooth is not None:
        return smooth_works(case.groups, valves, starts, hold=hold, width=case.smooth, washout=washout)
    return works_of(case.groups, valves, starts, hold=hold, scene=case.scene, washout=washout, tolerance=1e-6)


def compare(one: Spread, other: Spread) -> tuple[float, float, float]:
    """How many times as much the work of one body varies over inputs as that of another, each relative to its mean.

    Parameters
    ----------
    one, other : Spread
        Under the same inputs.

    Returns
    -------
    ratio, low, high : float
        Of the standard deviations over the means, with its 95% interval by bootstrap over inputs, paired.
    """
    return _with_interval(lambda a, b: _relative(a) / _relative(b), one.by_input, other.by_input)


def _with_interval(told: Callable[..., Any], *works: NDArray[np.float64]) -> tuple[float, float, float]:
    """Whatever is told of works by input, and its 95% interval by bootstrap over the inputs, the same of all."""
    draws = np.random.default_rng(0).integers(works[0].size, size=(_DRAWS, works[0].size))
    low, high = np.quantile(told(*(each[draws] for each in works)), [0.025, 0.975])
    return float(told(*works)), float(low), float(high)


def _relative(works: NDArray[np.float64]) -> Any:
    return works.std(axis=-1, ddof=1) / works.mean(axis=-1)


def thermal(groups: Groups, count: int) -> dict[float, Average]:
    """Averages over starts of an anchored body at exp(-beta H), under one input, by beta."""
    found = {}
    for seed, beta in enumerate(BETAS):
        starts = boltzmann_starts(groups, beta, count, seed)
        works = works_of(groups, np.array([_PUSHES]), starts, hold=HOLD, scene={"anchored": True})
        found[beta] = average(works.work[0], beta)
    return found
