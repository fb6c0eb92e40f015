"""A search for the reservoir that does best at a task: evolution by differences, on data that no test ever scores.

The first points are uniform in the space. Each one after that is one of the best so far, moved in some of its
dimensions by a share of the difference of two others of them, as in differential evolution [1]_, and by a little noise,
whose size is drawn anew over two decades. A dimension that has no order is redrawn now and then instead. Point k
depends on the seed, k, and the scores of the points before it alone, so that a search broken off and resumed is the
same search.

References
----------
.. [1] R. Storn and K. Price, "Differential evolution: a simple and efficient heuristic for global optimization over
   continuous spaces", J. Global Optimization 11, 341, 1997.
"""

import json
import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.files import write_text
from ...common.fingerprint import described, refuse_other
from ...common.threads import library_threads
from ...common.validation import number_within, whole_number
from ...crawler import SolverError
from ...reservoir import Estimate
from ...tasks.catalogue import TASKS
from ...tasks.reservoirs import BodyReservoir, Reservoir
from ...tasks.reservoirs.together import drive_together, Remembering
from ...tasks.task import mean_score, SeriesTask, Task
from .space import Choice, Space

__all__ = ["Evaluation", "Found", "held_out_scores", "search"]

_Point = NDArray[np.float64]

_ELITE = 10
_TRIES = 1000
_DIFFERENCE = 0.6
_MOVED, _REDRAWN = 0.4, 0.1  # probabilities that a dimension of either sort changes
_SAME = 1e-6  # to which a score is reproduced
_NOISE = 0.002, 0.2  # least and largest standard deviation, in shares of a range


@dataclass(frozen=True)
class Evaluation:
    """One point of a search.

    Attributes
    ----------
    point : list of float
        In the unit cube.
    scores : list of float or None
        One a validation seed; None where the reservoir could not be driven or scored.
    """

    point: list[float]
    scores: list[float] | None

    @property
    def score(self) -> float:
        """Mean over the validation seeds."""
        return float(np.mean(self.scores)) if self.scores else math.nan


@dataclass(frozen=True)
class Found:
    """What a search found.

    Attributes
    ----------
    reservoir : Reservoir
        The best of the finalists, by the mean over all seeds of validation.
    values : dict
        Its dimensions by name.
    validation : float
        That mean.
    evaluations : tuple of Evaluation
        All points, in order; the scores of finalists over all seeds of validation, of others over the first.
    """

    reservoir: Reservoir
    values: dict[str, Any]
    validation: float
    evaluations: tuple[Evaluation, ...]


def search(
    task: Task,
    space: Space,
    *,
    evaluations: int = 300,
    exploration: int = 60,
    seed: int = 0,
    validation_seeds: Sequence[int] = (1000, 1001, 1002, 1003),
    finalists: int = 5,
    length: int = 3000,
    washout: int = 200,
    seconds: float = math.inf,
    file: Path | None = None,
    on_progress: Callable[[int, int], None] | None = None,
) -> Found:
    """Look for the reservoir of a space that does best at a task.

    Every point is scored on the first seed of validation. The best few, the finalists, are scored on the others
    too, and the best of them in the mean is what was found. How good it is, only seeds can tell that were used for
    neither: see `held_out_scores`.

    Parameters
    ----------
    task : Task
    space : Space
    evaluations : int, at least 1
        Points to score; finalists cost more of them besides.
    exploration : int, at least 4
        Points that are drawn uniformly, before the best are varied.
    seed : int, at least 0
        Of the points.
    validation_seeds : sequence of int
        One at least, none twice.
    finalists : int, at least 1
    length, washout : int
        As in `Task.attempt`.
    seconds : float, in (0, inf]
        Wall time after which no further point is tried, the finalists excepted. What is found then depends on the
        machine, unless the search is resumed to its end.
    file : Path, optional
        Where every evaluation is kept once it is made. A search whose file is there goes on from it, if the file was
        made by the same search and its first score is reproduced; only `evaluations`, `finalists` and `seconds` may
        differ.
    on_progress : callable, optional
        Called with the points scored and those wanted.

    Returns
    -------
    Found

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid, `file` belongs to another search, the space is empty, or no point could be scored.
    """
    evaluations = whole_number("evaluations", evaluations, 1)
    exploration = whole_number("exploration", exploration, 4)
    finalists = whole_number("finalists", finalists, 1)
    if seconds != math.inf:
        seconds = number_within("seconds", seconds, "(0, inf)")
    seeds = _distinct("validation_seeds", validation_seeds)
    settings = {
        "task": _name(task),
        "space": {name: described(dimension) for name, dimension in space.dimensions.items()},
        "build": described(space.build),
        "seed": whole_number("seed", seed, 0),
        "exploration": exploration,
        "validation_seeds": seeds,
        "length": whole_number("length", length, 1),
        "washout": whole_number("washout", washout, 0),
    }
    kept = _kept(file, settings)

    def scores(evaluation: Evaluation, of: Sequence[int]) -> list[float] | None:
        reservoir = space.build(space.at(np.array(evaluation.point)))
        assert reservoir is not None  # proposals are those that can be built
        return _scores(task, reservoir, of, length, washout)

    with library_threads(1):
        _reproduce(file, kept, lambda evaluation: scores(evaluation, seeds[:1]))
        scored, beyond = kept[:evaluations], kept[evaluations:]
        until = time.monotonic() + seconds
        while len(scored) < evaluations and (not scored or time.monotonic() < until):
            point = Evaluation(_proposal(space, scored, exploration, seed, task.metric.more_is_better), None)
            scored.append(Evaluation(point.point, scores(point, seeds[:1])))
            _keep(file, settings, scored)
            if on_progress is not None:
                on_progress(len(scored), evaluations)

        for index in _ranking(scored, task.metric.more_is_better)[:finalists]:
            first = scored[index]
            if first.scores is not None and len(first.scores) < len(seeds):
                others = scores(first, seeds[1:])
                # The first seed's score stays as it is: by it a longer search goes on.
                scored[index] = Evaluation(first.point, [*first.scores, *(others or [])])
                _keep(file, settings, [*scored, *beyond])
    final = [e for e in scored if e.scores is not None and len(e.scores) == len(seeds)]
    if not final:
        raise ValueError(f"space must hold a reservoir that can do the task, got none in {len(scored)} evaluations")
    best = (max if task.metric.more_is_better else min)(final, key=lambda e: e.score)
    values = space.at(np.array(best.point))
    reservoir = space.build(values)
    assert reservoir is not None
    return Found(reservoir, values, best.score, tuple(scored))


def held_out_scores(
    task: Task,
    reservoir: Reservoir,
    seeds: Iterable[int],
    *,
    validation_seeds: Iterable[int] = (),
    length: int = 4000,
    washout: int = 200,
) -> tuple[list[float], Estimate]:
    """Score a reservoir on seeds that it was not chosen by.

    Parameters
    ----------
    task : Task
    reservoir : Reservoir
    seeds : iterable of int
        Two at least.
    validation_seeds : iterable of int
        Those that it was chosen by.
    length, washout : int
        As in `Task.attempt`.

    Returns
    -------
    scores : list of float
    estimate : Estimate
        Their mean, and where the true mean lies.

    Raises
    ------
    ValueError
        If a seed is among those of validation, or an argument is invalid.
    """
    chosen = _distinct("seeds", seeds)
    leaked = sorted(set(chosen) & set(validation_seeds))
    if leaked:
        raise ValueError(f"seeds must hold none of the validation seeds, got {leaked}")
    with library_threads(1):
        scores = _attempted(task, reservoir, chosen, length, washout)
    return scores, mean_score(task, scores, getattr(reservoir, "features", None))


def _scores(task: Task, reservoir: Reservoir, seeds: Sequence[int], length: int, washout: int) -> list[float] | None:
    try:
        scores = _attempted(task, reservoir, seeds, length, washout)
    except (SolverError, FloatingPointError, np.linalg.LinAlgError):
        return None
    return scores if all(map(math.isfinite, scores)) else None


def _attempted(task: Task, reservoir: Reservoir, seeds: Sequence[int], length: int, washout: int) -> list[float]:
    if isinstance(task, SeriesTask) and isinstance(reservoir, BodyReservoir):
        body = Remembering(reservoir)
        drive_together((body, task.drive(length, seed), seed) for seed in seeds)
        reservoir = body
    return [task.attempt(reservoir, length=length, seed=seed, washout=washout).score for seed in seeds]


def _ranking(scored: Sequence[Evaluation], more_is_better: bool) -> list[int]:
    """Which evaluations could be scored, the best on the first seed first."""
    usable = [index for index, evaluation in enumerate(scored) if evaluation.scores]
    sign = -1.0 if more_is_better else 1.0
    return sorted(usable, key=lambda index: sign * (scored[index].scores or [math.nan])[0])


def _proposal(
    space: Space, scored: Sequence[Evaluation], exploration: int, seed: int, more_is_better: bool
) -> list[float]:
    """The next point that can be built."""
    random = np.random.default_rng([seed, len(scored)])
    elite = [np.array(scored[index].point) for index in _ranking(scored, more_is_better)[:_ELITE]]
    exploring = len(scored) < exploration or len(elite) < 3
    for _ in range(_TRIES):
        point = random.random(len(space.dimensions)) if exploring else _varied(space, elite, random)
        if space.build(space.at(point)) is not None:
            return [float(share) for share in point]
    raise ValueError(f"space must hold reservoirs that can be built, got none in {_TRIES} draws")


def _varied(space: Space, elite: Sequence[_Point], random: np.random.Generator) -> _Point:
    one, two, three = (elite[index] for index in random.permutation(len(elite))[:3])
    low, high = np.log(_NOISE)
    noise = math.exp(random.uniform(low, high)) * random.standard_normal(len(one))
    moved = one + _DIFFERENCE * (two - three) + noise
    ordered = np.array([not isinstance(dimension, Choice) for dimension in space.dimensions.values()])
    changed = random.random(len(one)) < np.where(ordered, _MOVED, _REDRAWN)
    # Back from the wall by as much as it went past it.
    reflected = 1 - np.abs(1 - np.abs(moved) % 2)
    return np.where(changed, np.where(ordered, reflected, random.random(len(one))), one)


def _distinct(name: str, seeds: Iterable[int]) -> list[int]:
    numbers = [whole_number(name, seed, 0) for seed in seeds]
    if not numbers or len(set(numbers)) < len(numbers):
        raise ValueError(f"{name} must hold one seed at least and none twice, got {numbers}")
    return numbers


def _kept(file: Path | None, settings: dict[str, Any]) -> list[Evaluation]:
    if file is None or not file.exists():
        return []
    try:
        kept = json.loads(file.read_text(encoding="utf-8"))
        evaluations = [Evaluation(**each) for each in kept["evaluations"]]
        made_for = dict(kept["settings"])
    except (ValueError, TypeError, KeyError) as error:
        raise ValueError(f"file must be one that a search has written, got {file}: {error!r}") from None
    refuse_other(f"to go on with the search in {file}", made_for, settings)
    return evaluations


def _reproduce(
    file: Path | None, kept: Sequence[Evaluation], score: Callable[[Evaluation], list[float] | None]
) -> None:
    """Refuse evaluations whose first score is another today: the task, a measure or a reservoir has changed since."""
    first = next((evaluation for evaluation in kept if evaluation.scores), None)
    if first is None or first.scores is None:
        return
    today = score(first)
    if today is None or not math.isclose(today[0], first.scores[0], rel_tol=_SAME, abs_tol=_SAME):
        raise ValueError(
            f"the first score must be {first.scores[0]!r} to go on with the search in {file}, "
            f"got {today[0] if today else None!r}: the task, its measure or the reservoirs have changed since"
        )


def _name(task: Task) -> str:
    """The name of a registered task, the description of any other."""
    return next((name for name, each in TASKS.items() if each is task), str(described(task)))


def _keep(file: Path | None, settings: dict[str, Any], scored: Sequence[Evaluation]) -> None:
    if file is None:
        return
    text = json.dumps({"settings": settings, "evaluations": [asdict(each) for each in scored]}) + "\n"
    write_text(file, text)
