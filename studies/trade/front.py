"""What a trade came to: its points, what of the plane they dominate, and where the knee is."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...reservoir.bootstrap import Estimate, mean_over_runs
from ...train.schedules import pareto_front
from .hypervolume import hypervolume
from .plan import Cell, CONDITIONED, JUDGED, LIMIT, OPEN_LOOP, Trade, TRAINED

__all__ = ["Front", "Point", "area", "as_json", "estimated", "fronts", "gain"]

_ROUNDING = 1e-9
_HELD = {"held open": "1", "held shut": "0"}


class Evaluated(NamedTuple):
    """What a policy came to in the evaluations of its training."""

    reward: float = 0.0
    """What it was trained for: the weighted reward per step, or the utility of a floor."""
    speed: float = 0.0
    memory: float = 0.0


_NOT_EVALUATED = Evaluated()


@dataclass(frozen=True, eq=False)
class Point:
    """One schedule or policy, judged on m seeds.

    Attributes
    ----------
    kind : str
        "open loop", "held open", "held shut", "policy" or "conditioned policy".
    name : str
        The schedule's word, or the cell.
    weight, seed : float or None, int or None
        Of memory in the reward, and of the training.
    speeds, memories : (m,) arrays
        Over long runs: of the foot, z_c / t_c; held-out memory capacity, its corrected total.
    episode_speeds, episode_memories : (m,) arrays or None
        Means over one episode of what the environment pays, each before its weight.
    body_memories : (m,) array or None
        Memory of a policy whose feedback is cut: its commands on flips that it knows nothing of.
    evaluated : Evaluated
        What it came to in the evaluations of its training, whose seeds judge nothing.
    floor : float or None
        On speed, of a training for one instead of a weight.
    """

    kind: str
    name: str
    weight: float | None
    seed: int | None
    speeds: NDArray[np.float64]
    memories: NDArray[np.float64]
    episode_speeds: NDArray[np.float64] | None = None
    episode_memories: NDArray[np.float64] | None = None
    body_memories: NDArray[np.float64] | None = None
    evaluated: Evaluated = _NOT_EVALUATED
    floor: float | None = None

    @property
    def mean(self) -> tuple[float, float]:
        """Mean speed and memory."""
        return float(self.speeds.mean()), float(self.memories.mean())

    def rewards(self, weight: float) -> NDArray[np.float64]:
        """Reward per step at a weight, over long runs, shape (m,)."""
        return (1 - weight) * self.speeds + weight * self.memories


@dataclass(frozen=True, eq=False)
class Front:
    """All that a trade came to at one dither; the target is what its memory is of, as in the environment."""

    dither: float
    open_loop: Sequence[Point]
    held: Sequence[Point]
    policies: Sequence[Point]
    conditioned: Sequence[Point]
    limit: Mapping[str, Any]
    target: str = "memory"

    @property
    def points(self) -> list[Point]:
        """All of them."""
        return [*self.open_loop, *self.held, *self.policies, *self.conditioned]

    @property
    def speed_limit(self) -> Estimate:
        """Speed of the fastest policy that is known."""
        return estimated(np.array(self.limit["speeds"]))

    @property
    def chosen(self) -> list[Point]:
        """Of the trainings at each weight or floor the best, and those that none surpasses in both objectives.

        Both in their own evaluations: the seeds that judge have no part in the choice, since the best of several on
        them would be lucky. By rising weight.
        """
        best: dict[Any, Point] = {}
        of_weights_first = sorted(
            self.policies, key=lambda each: (each.floor or 0.0, each.weight or 0.0, -each.evaluated.reward)
        )
        for point in of_weights_first:
            best.setdefault((point.weight, point.floor), point)
        unsurpassed = pareto_front(np.array([point.evaluated[1:] for point in of_weights_first]).reshape(-1, 2))
        chosen = {id(point) for point in best.values()} | {id(of_weights_first[i]) for i in unsurpassed}
        return [point for point in of_weights_first if id(point) in chosen]

    @property
    def shown(self) -> list[Point]:
        """Those of `points` that a page tells of."""
        return [*self.open_loop, *self.held, *self.chosen, *self.conditioned]

    def areas_by_seed(self) -> list[float]:
        """Hypervolume of the trainings of each seed by themselves."""
        seeds = sorted({point.seed for point in self.policies if point.seed is not None})
        return [area([point for point in self.policies if point.seed == seed]).mean for seed in seeds]

    @property
    def fastest(self) -> Point | None:
        """The policy of most speed among those chosen."""
        return max(self.chosen, key=lambda point: point.mean[0], default=None)

    @property
    def knee(self) -> Point | None:
        """The policy chosen that is farthest above the chord between the fastest of them and that of most memory.

        None where none is above it.
        """
        candidates = self.chosen
        if not candidates:
            return None
        means = np.array([point.mean for point in candidates])
        front = means[pareto_front(means)]
        (fast, least), (slow, most) = front[0], front[-1]
        if fast == slow:
            return None
        above = (means[:, 0] - slow) / (fast - slow) + (means[:, 1] - least) / (most - least) - 1
        best = int(np.argmax(above))
        return candidates[best] if above[best] > _ROUNDING else None

    def losses(self) -> list[Point]:
        """Policies that earn less than a schedule at their own weight: held open, held shut or the best word.

        Less means so on these seeds beyond doubt: the 95% interval of the difference from the schedule ends below 0.
        Where all seeds agree there is no doubt.
        """
        weighed = [point for point in [*self.policies, *self.conditioned] if point.weight is not None]
        return [point for point in weighed if _below_zero(self.lead(point))]

    def lead(self, point: Point) -> Estimate:
        """What a policy earns at its weight above the best schedule."""
        assert point.weight is not None
        schedules = [*self.open_loop, *self.held]
        best = max((schedule.rewards(point.weight) for schedule in schedules), key=np.mean)
        return estimated(point.rewards(point.weight) - best)

    def summary(self) -> dict[str, Any]:
        """Hypervolumes, what closing the loop gains, the knee and the limit, ready for JSON."""
        told: dict[str, Any] = {
            "speed limit": as_json(self.speed_limit),
            "losses": [point.name for point in self.losses()],
        }
        if self.fastest is not None:
            told["fastest"] = described(self.fastest)
        if self.knee is not None:
            told["knee"] = described(self.knee)
        return told | (self._areas() if self.dither else {})

    def _areas(self) -> dict[str, Any]:
        told: dict[str, Any] = {"open loop": {"hypervolume": as_json(area(self.open_loop))}}
        for name, points in (("policies", self.chosen), ("conditioned policy", self.conditioned)):
            if points:
                told[name] = {"hypervolume": as_json(area(points)), "gain": as_json(gain(points, self.open_loop))}
        each = self.areas_by_seed()
        if len(each) > 1:
            told["policies"]["hypervolume of one training a weight"] = as_json(mean_over_runs(each))
        return told


def described(point: Point) -> dict[str, Any]:
    """A point in numbers, ready for JSON."""
    return {
        "kind": point.kind,
        "name": point.name,
        "weight": point.weight,
        "floor": point.floor,
        "seed": point.seed,
        "speed": as_json(estimated(point.speeds)),
        "memory": as_json(estimated(point.memories)),
    }


def fronts(trade: Trade, results: Mapping[Cell, Any]) -> list[Front]:
    """What the finished cells of a trade came to.

    Parameters
    ----------
    trade : Trade
    results : mapping of Cell to dict
        By `TradeFolder.results`; all of them.

    Returns
    -------
    list of Front
        One a dither.
    """
    return [_front(dither, results, trade.world(dither).target) for dither in trade.dithers]


def _front(dither: float, results: Mapping[Cell, Any], target: str) -> Front:
    of = {cell: result for cell, result in results.items() if cell.dither == dither}
    open_loop = of[Cell(OPEN_LOOP, dither)]
    return Front(
        dither,
        list(_schedules(OPEN_LOOP, open_loop["front"])),
        [next(iter(_schedules(kind, open_loop["held"], only=word))) for kind, word in _HELD.items()],
        [_policy(TRAINED, cell, result) for cell, result in of.items() if cell.kind == JUDGED[TRAINED]],
        [_policy(CONDITIONED, cell, result) for cell, result in of.items() if cell.kind == JUDGED[CONDITIONED]],
        of[Cell(LIMIT, dither)],
        target,
    )


def _schedules(kind: str, numbers: Mapping[str, Any], only: str | None = None) -> Iterator[Point]:
    for name, speeds, memories in zip(numbers["names"], numbers["speeds"], numbers["memories"], strict=True):
        if only in (None, name):
            yield Point(kind, name, None, None, np.array(speeds), np.array(memories))


def _policy(kind: str, cell: Cell, result: Mapping[str, Any]) -> Point:
    paid = result["episodes"]
    return Point(
        kind,
        cell.name.removeprefix("judged-"),
        cell.weight,
        cell.seed,
        np.array(result["speeds"]),
        np.array(result["memories"]),
        np.array(paid["speeds"]),
        np.array(paid["memories"]),
        np.array(result["body memories"]) if "body memories" in result else None,
        Evaluated(**result.get("evaluated", {})),
        cell.floor,
    )


def area(points: Sequence[Point]) -> Estimate:
    """Hypervolume of the mean points from (0, 0), and its interval over the seeds that judge."""
    return _jackknifed(lambda those: _area(points, those), len(points[0].speeds))


def gain(points: Sequence[Point], others: Sequence[Point]) -> Estimate:
    """By what share the hypervolume of some points exceeds that of others, judged on as many seeds."""
    return _jackknifed(lambda those: _area(points, those) / _area(others, those) - 1, len(points[0].speeds))


def _area(points: Sequence[Point], those: NDArray[np.int64]) -> float:
    return hypervolume([(point.speeds[those].mean(), point.memories[those].mean()) for point in points])


def _jackknifed(statistic: Callable[[NDArray[np.int64]], float], runs: int) -> Estimate:
    """A statistic of means over seeds, with Student's interval over the jackknife's pseudovalues, as in `Judgement`."""
    everything = np.arange(runs)
    whole = statistic(everything)
    pseudovalues = [runs * whole - (runs - 1) * statistic(np.delete(everything, k)) for k in everything]
    spread = estimated(np.array(pseudovalues))
    return Estimate(whole, whole + spread.low - spread.mean, whole + spread.high - spread.mean, runs)


def _below_zero(estimate: Estimate) -> bool:
    return (estimate.mean if np.isnan(estimate.high) else estimate.high) < -_ROUNDING


def estimated(values: NDArray[np.float64]) -> Estimate:
    """Mean over seeds, with its 95% interval; without one where all are the same."""
    return mean_over_runs(values, bounds=(-np.inf, np.inf))


def as_json(estimate: Estimate) -> dict[str, float | None]:
    """An estimate ready for JSON."""
    return {
        name: None if np.isnan(value) else value
        for name, value in (("mean", estimate.mean), ("low", estimate.low), ("high", estimate.high))
    }
