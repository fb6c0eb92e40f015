"""Lyapunov exponents of a driven crawler: how fast two motions under one input part, or forget how they began."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from itertools import product
from threading import Event
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.sharing import processors, share
from ..common.validation import number_within, whole_number
from .arguments import batch_of, schedule_of, start_of, TOLERANCES
from .batch.driving import grow_in_lanes
from .batch.lane_runs import blank_runs
from .batch_simulation import Batch, most_steps
from .model.columns import coefficients_of_each, coefficients_of_one, different, units_of
from .model.groups import Groups, GroupsLike
from .model.scene import Scene
from .model.state import Body, ChainState, REST, State, STUCK
from .motion.sampling import BODY_ROWS
from .refusals import solver_error, SolverError
from .runs import run_chain_growth, run_growth
from .solvers import AUTO, choose_for_each, NAMES, SOLVERS
from .steps.options import FINISHED

__all__ = ["LyapunovSpectrum", "lyapunov_spectrum"]

# Batch means: fewer tell too little of their own spread, more are too short to be independent (B. Schmeiser,
# Operations Research 30 (1982) 556).
_BLOCKS = 20
_ERRORS = 3.0
# In e-folds over a whole run: less is no growth at all, and more is not none.
_LEAST, _MOST = 0.1, 3.0
# Two ends are of one motion within so much, once a contraction would have brought them nearer still.
_APART, _TOGETHER = 1e-6, 1e-8
# Runs in lanes between which Python holds what came of them.
_AT_ONCE = 1024
_TAYLOR = NAMES.index("taylor")
_SHAPES = ("(holds,)", "(inputs, holds) or (rows, holds)", "(rows, inputs, holds)")


@dataclass(frozen=True, eq=False)
class LyapunovSpectrum:
    """Exponents of one crawler, or of each of several.

    Attributes
    ----------
    exponents : (2,) or (rows, 2) array
        Mean rates, per natural time and in falling order, at which the logarithms of small changes of deformation and
        velocity grow while the input stays the same. The second is the growth of areas less the first. Of a chain of
        segments they are the first two of the exponents of all their stretches and rates.
    standard_error : (2,) or (rows, 2) array
        Of the exponents, by batch means: from the spread of `blocks`.
    lag_exponent : float or (rows,) array
        -1 / Pi4, that of the pressure, on which the others do not act.
    foot_exponent : float or (rows,) array
        That of the foot's velocity, which is a state of its own while the foot slides: -inf where the foot stopped,
        since a stop leaves nothing of a change of it; 0 where the foot slid all the time, since the momentum then keeps
        every change; nan where it never moved, or is anchored, and there is no such state.
    stops : int or (rows,) array of int
        How often the foot stopped after the washout, in all inputs: so often a change of its velocity was projected
        out.
    divergence : float or (rows,) array
        Mean divergence of the smooth motion, -2 Pi2 / (1 - r) while the foot sticks and -2 Pi2 / (r (1 - r)) while it
        slides; of a chain that of all its stretches and rates. What the sum of the exponents is beyond, is of the
        events; of an anchored crawler the two are equal.
    attractors : int or (rows,) array of int
        Different motions that the starts have come to under one input, the most of all inputs; 1 from one start. Only
        ends that differ by more than 1e-6, though the first exponent would have brought them within 1e-8, count as two.
    blocks : (blocks, 2) or (rows, blocks, 2) array
        The exponents of each block, in no order: at least 20, equally long parts of the inputs.
    time : float or (rows,) array
        Natural time, of all inputs together, that was measured.
    groups : Groups or tuple of Groups
    """

    exponents: NDArray[np.float64]
    standard_error: NDArray[np.float64]
    lag_exponent: Any
    foot_exponent: Any
    stops: Any
    divergence: Any
    attractors: Any
    blocks: NDArray[np.float64]
    time: Any
    groups: Groups | tuple[Groups, ...]

    def __getitem__(self, row: int) -> LyapunovSpectrum:
        """Exponents of one crawler of several."""
        if isinstance(self.groups, Groups):
            raise TypeError("an index is of one crawler of several, got one alone")
        return LyapunovSpectrum(**{field.name: getattr(self, field.name)[row] for field in fields(self)})

    @property
    def verdict(self) -> Any:
        """What the exponents say, str or (rows,) array of str.

        "chaotic" if the first exponent is above 0 by more than 3 standard errors; "contracting" if it is below 0 by as
        much, and the foot's velocity is forgotten too; "multistable" if so, but several starts have come to different
        motions, each of which contracts; "neutral" if it is below 0 but the momentum keeps its changes,
        or if it is 0 within so little that changes cannot have grown or shrunk by more than 3 e-folds in all of `time`;
        and "undecided" otherwise: a longer run tells.
        """
        first, time = self.exponents[..., 0], np.asarray(self.time)
        margin = np.maximum(_ERRORS * self.standard_error[..., 0], _LEAST / time)
        kept = np.asarray(self.foot_exponent) == 0.0
        forgets, steady = first < -margin, np.abs(first) + margin <= _MOST / time
        cases = {
            "multistable": forgets & ~kept & (np.asarray(self.attractors) > 1),
            "contracting": forgets & ~kept,
            "chaotic": first > margin,
            "neutral": forgets | steady,
        }
        words = np.select(list(cases.values()), list(cases), "undecided")
        return str(words) if words.ndim == 0 else words


def lyapunov_spectrum(
    groups: GroupsLike | Sequence[GroupsLike],
    valve: ArrayLike,
    hold: float | str | Sequence[float | str] | NDArray[np.float64],
    *,
    scene: Scene | Mapping[str, Any] | Sequence[Scene | Mapping[str, Any] | None] | None = None,
    tolerance: float = 1e-9,
    solver: str = "auto",
    initial: State | ChainState | Sequence[State | ChainState] | None = None,
    washout: int = 200,
    max_steps: int | None = None,
    threads: int | None = None,
) -> LyapunovSpectrum:
    """Conditional Lyapunov exponents of crawlers under given inputs: the rates at which small changes grow or fade.

    Changes are carried along the motion that `simulate` would find, through slips, stops and reversals (G. Benettin et
    al., Meccanica 15 (1980) 9). Position is left out: it acts on nothing.

    Parameters
    ----------
    groups : Groups, str, mapping or Actuator, or sequence of them
        Each as in `Groups.of`: one crawler, or one a row.
    valve : (holds,), (inputs, holds), (rows, holds) or (rows, inputs, holds) array, in [0, 1]
        Duty cycles as for `simulate`. Where no other argument has rows, two dimensions are an ensemble of inputs to one
        crawler; where one has, they are a schedule for each row. Of three dimensions the first may be 1: the same
        ensemble for all rows.
    hold : float or str, or (rows,) array or sequence of them, in (0, inf)
    scene : Scene or mapping, or sequence of them, optional
        As for `simulate`.
    tolerance : float, in [1e-15, 1e-2]
    solver : {"auto", "closed_form", "taylor", "radau"}
    initial : State or ChainState, or list of them, optional
        At rest by default; the same for all. With a list each input is run from each start: exponents are means over
        them, and `LyapunovSpectrum.attractors` tells whether they come to one motion.
    washout : int, >= 0
        Holds of each input, at its start, that are not measured; 2 at least must be left. In them the body comes to its
        attractor, and changes turn to the direction in which they grow most: some multiples of 1 / |exponent|.
    max_steps : int, optional
        As for `simulate`, for each input.
    threads : int, optional
        Most that share the work; as many as there are processors to run on by default.

    Returns
    -------
    LyapunovSpectrum

    Raises
    ------
    ValueError, TypeError
        If an argument is out of its range or of the wrong type; the message names it.
    SolverError
        As `simulate`; the message names the row, and the input where there are several.

    Warns
    -----
    UserWarning
        If small changes fade within one step by more than floats can tell: an exponent is then nan.
    """
    batch, single, inputs = _rows(groups, valve, hold, scene)
    tolerance = number_within("tolerance", tolerance, TOLERANCES)
    if not isinstance(solver, str) or (solver != AUTO and solver not in SOLVERS):
        raise ValueError(f"solver must be one of {[AUTO, *SOLVERS]}, got {solver!r}")
    holds = inputs.shape[2]
    if holds < 2:
        raise ValueError(f"valve must have at least 2 holds, got {holds}")
    washout = whole_number("washout", washout, 0, holds - 2)
    begun: Any = [REST if initial is None else initial] if initial is None or isinstance(initial, tuple) else initial
    if not isinstance(begun, Sequence) or not begun:
        raise TypeError(f"initial must be a State, a ChainState or a list of them, got {initial!r}")
    for each in different(batch.scenes):
        starts = [start_of(one, each) for one in begun]
    budget = most_steps(holds, batch.scenes[0].segments)
    if max_steps is not None:
        budget = whole_number("max_steps", max_steps, 1)
    runs = _Runs(batch, inputs, starts, washout, tolerance, solver, budget)
    count = inputs.shape[1] * len(starts)
    each_way = runs.all(processors() if threads is None else whole_number("threads", threads, 1))
    found = [
        _spectrum(each_way[i * count : (i + 1) * count], len(starts), crawler)
        for i, crawler in enumerate(batch.crawlers)
    ]
    if single:
        return found[0]
    names = [field.name for field in fields(LyapunovSpectrum) if field.name != "groups"]
    together: dict[str, Any] = {name: np.array([getattr(one, name) for one in found]) for name in names}
    return LyapunovSpectrum(**together, groups=tuple(batch.crawlers))


def _rows(groups: Any, valve: ArrayLike, hold: Any, scene: Any) -> tuple[Batch, bool, NDArray[Any]]:
    """Who is driven, whether there is one crawler only, and the inputs of each, (rows, inputs, holds)."""
    given = schedule_of(valve, _SHAPES)
    first = given[(0,) * (given.ndim - 1)]
    batch, single, _ = batch_of(groups, first, hold, scene)
    if given.ndim == 2 and single:
        return batch, True, given[np.newaxis]
    if given.ndim == 2 or (given.ndim == 3 and len(given) > 1):
        each = given if given.ndim == 3 else given[:, np.newaxis]
        return batch_of(groups, each[:, 0], hold, scene)[0], False, each
    inputs = given.reshape(1, -1, given.shape[-1])
    return batch, single and given.ndim < 3, inputs.repeat(len(batch.crawlers), axis=0)


@dataclass(frozen=True)
class _Measured:
    """What was measured of one run."""

    lengths: NDArray[np.float64]  # (blocks,): natural time
    logarithms: NDArray[np.float64]  # (blocks, 2): growth of a vector and of an area
    divergence: float  # integral
    stops: int
    slid: bool  # whether the foot slides at the end
    end: tuple[float, float]  # z and v there
    whole: float  # natural time, the washout included


class _Runs:
    """All runs, each of a row and an input."""

    def __init__(
        self,
        batch: Batch,
        inputs: NDArray[Any],
        starts: Sequence[tuple[Body, NDArray[np.float64]]],
        washout: int,
        tolerance: float,
        solver: str,
        budget: int,
    ) -> None:
        self._batch, self._inputs, self._starts, self._washout = batch, inputs, starts, washout
        bodies, grounds, self._units = units_of(batch.crawlers, batch.scenes)
        self._columns = coefficients_of_each(bodies, grounds)
        self._solvers = choose_for_each(
            solver, batch.crawlers, batch.scenes, self._columns, batch.holds, self._units, tolerance
        )
        self._tolerance, self._budget = tolerance, budget
        measured = inputs.shape[2] - washout
        blocks = min(measured, -(-_BLOCKS // (inputs.shape[1] * len(starts))))
        self._ends = np.linspace(0, measured, blocks + 1).round().astype(np.int64)

    def all(self, threads: int) -> list[_Measured]:
        """Do all runs; return what changes did in each, those of a row side by side, and of these those of an input."""
        rows, inputs, _ = self._inputs.shape
        every = list(product(range(rows), range(inputs), range(len(self._starts))))
        in_lanes = (self._solvers == _TAYLOR) & ~self._batch.chains
        together = [run for run in every if in_lanes[run[0]]]
        apart = [run for run in every if not in_lanes[run[0]]]
        found: dict[tuple[int, int, int], _Measured] = {}
        for first in range(0, len(together), _AT_ONCE):
            some = together[first : first + _AT_ONCE]
            found |= zip(some, self._in_lanes(some, threads), strict=True)
        found |= zip(apart, share(self._alone, apart, threads), strict=True)
        return [found[run] for run in every]

    def _in_lanes(self, which: Sequence[tuple[int, int, int]], threads: int) -> list[_Measured]:
        """Do some runs by Taylor series."""
        i, j, start = np.array(which).T
        units = self._units[i]
        bodies, columns = np.empty((len(Body._fields), len(which))), np.empty((len(self._columns), len(which)))
        bodies.T[:] = np.array([body for body, _ in self._starts], np.float64)[start]
        bodies[[1, 4]] *= units
        none = np.empty((len(which), BODY_ROWS, 0))
        columns[:] = self._columns[:, i]
        runs = blank_runs(bodies, columns, self._batch.holds[i] / units, none, self._budget)
        options = SOLVERS["taylor"].options(self._tolerance)
        grown = grow_in_lanes(runs, self._inputs[i, j], self._washout, self._ends[1:], options, threads)
        ended = [Body(z, v, p, x, w, int(mode), int(slips)) for z, v, p, x, w, mode, slips in bodies.T.tolist()]
        for k in np.flatnonzero(runs.statuses > FINISHED)[:1].tolist():
            time = runs.finished[k] * self._batch.holds[i[k]] + runs.elapsed[k] * units[k]
            self._refuse(which[k], int(runs.statuses[k]), float(time), int(runs.steps[k]), ended[k])
        return [self._measured(*each) for each in zip(i.tolist(), grown, ended, strict=True)]

    def _alone(self, run: tuple[int, int, int], _over: Event) -> _Measured:
        """Do a run of another kind."""
        i, j, k = run
        batch, hold = self._batch, float(self._batch.holds[i])
        by = SOLVERS[NAMES[self._solvers[i]]]
        options = by.options(self._tolerance, tangents=True, max_steps=self._budget)
        duties, (body, stretches) = self._inputs[i, j].astype(np.float64), self._starts[k]
        if batch.chains[i]:
            groups, scene = batch.crawlers[i], batch.scenes[i]
            done = run_chain_growth(body, stretches, groups, scene, duties, self._washout, hold, options)
        else:
            coefficients, unit = coefficients_of_one(self._columns, i), float(self._units[i])
            done = run_growth(body, coefficients, unit, duties, self._washout, hold, options, by)
        outcome, finished, growth = done
        if outcome.status != FINISHED:
            self._refuse(run, outcome.status, finished * hold + outcome.elapsed, outcome.steps, outcome.body)
        return self._measured(i, growth[:, self._ends[1:] - 1], outcome.body)

    def _measured(self, i: int, grown: NDArray[np.float64], ended: Body) -> _Measured:
        """Of row i, from what `note_growth` noted at the ends of the blocks, and the body at the end."""
        hold = float(self._batch.holds[i])
        with np.errstate(invalid="ignore"):  # of what has faded altogether: see `_spectrum`
            logarithms = np.diff(np.hstack([np.zeros((2, 1)), grown[:2]])).T
        return _Measured(
            np.diff(self._ends) * hold,
            logarithms,
            float(grown[2, -1]),
            int(grown[3, -1]),
            ended.mode != STUCK,
            (ended.deformation, ended.velocity),
            self._inputs.shape[2] * hold,
        )

    def _refuse(self, run: tuple[int, int, int], status: int, time: float, steps: int, body: Body) -> None:
        """Say why a run has failed."""
        i, j, _ = run
        batch, by = self._batch, NAMES[self._solvers[i]]
        crawler = batch.crawlers[i], batch.scenes[i]
        error = solver_error(status, time, body.deformation, steps, *crawler, self._tolerance, by, body.slips)
        names = [f"crawler {i}"] * (len(batch.crawlers) > 1) + [f"input {j}"] * (self._inputs.shape[1] > 1)
        raise SolverError(": ".join([", ".join(names), str(error)] if names else [str(error)]))


def _spectrum(runs: Sequence[_Measured], starts: int, groups: Groups) -> LyapunovSpectrum:
    """Exponents of one crawler from its runs, those of one input from all starts together."""
    lengths, logarithms = (np.concatenate([getattr(run, name) for run in runs]) for name in ("lengths", "logarithms"))
    time = float(lengths.sum())
    with np.errstate(invalid="ignore"):
        vector, area = logarithms.sum(axis=0) / time
        exponents = np.array([vector, area - vector])
        rates = logarithms / lengths[:, np.newaxis]
        blocks = np.stack([rates[:, 0], rates[:, 1] - rates[:, 0]], axis=1)
        error = np.std(blocks, axis=0, ddof=1) / math.sqrt(len(blocks))
    if not np.isfinite(exponents).all():
        warnings.warn(
            "small changes fade within one step by more than floats can tell: an exponent that is nan is negative and "
            "too large to be found with these holds; shorter ones may do",
            stacklevel=3,
        )
    # Two that are equal may come in either order.
    order = np.argsort(-exponents, kind="stable")
    stops = sum(run.stops for run in runs)
    foot = -math.inf if stops else 0.0 if any(run.slid for run in runs) else math.nan
    return LyapunovSpectrum(
        exponents[order],
        error[order],
        -1.0 / groups.deborah,
        foot,
        stops,
        sum(run.divergence for run in runs) / time,
        _attractors(runs, starts, vector),
        blocks[:, order],
        time,
        groups,
    )


def _attractors(runs: Sequence[_Measured], starts: int, exponent: float) -> int:
    """Most ends of the runs of one input that are apart, though the exponent would have brought them together."""
    if math.exp(min(0.0, exponent * runs[0].whole)) > _TOGETHER:
        return 1
    most = 1
    for first in range(0, len(runs), starts):
        apart: list[tuple[float, float]] = []
        for run in runs[first : first + starts]:
            if all(math.dist(run.end, other) > _APART for other in apart):
                apart.append(run.end)
        most = max(most, len(apart))
    return most
