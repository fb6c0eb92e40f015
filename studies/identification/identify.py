"""The groups, or the SI parameters, of a body from measurements: nonlinear least squares through slips and stops.

The residuals are those of whole runs, and their slopes the sensitivities that ride along through every slip and stop
(`stickslip.sensitivities`); of a chain of segments, differences of neighbours in one batch. Where a slip is won or lost
a run has a kink or a jump, which no slope tells: what is found is compared with bodies beside it along each parameter,
and its intervals reach as far as these fit as well.
A wrong guess gets the slips wrong, and then the sum of squares has many valleys. So the search starts from many bodies
about the guess on the first few holds, where few slips can be wrong, and lengthens the run as it closes in.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.stats import qmc, t

from ...common.validation import known_names, number_within, whole_number
from ...crawler import Actuator, Groups, GroupsLike, Scene, SolverError
from ...crawler.model.groups import RANGES
from ...crawler.model.tube import is_chain
from .design import best_word, Design
from .measurements import Measurements, several
from .prediction import Body, predicted, slopes_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Identification", "identify"]

# Typical sizes, for groups whose guess is 0 or nearly so.
_SIZES = {
    "duffing": 0.1,
    "damping_ratio": 0.02,
    "deborah": 0.05,
    "radial_coupling": 0.1,
    "foot_mass_fraction": 0.1,
    "static_friction": 0.05,
    "kinetic_friction": 0.05,
}
_SPREAD = 4.0  # starts lie within this factor of the guess, either way
_FARTHEST = 50.0  # and the search within this
_FRACTIONS = (1e-3, 0.999)  # of the mass that the foot may have
_FIRST = 12  # holds on which starts are compared
_LENGTHENED = 3.0  # the run grows by this factor
_KEPT = 8  # starts that are followed
_VALLEYS = np.geomspace(0.8, 1.25, 64)  # ratios of static frictions that are compared at the end
_DEEPEST = 4  # valleys among them that are descended
_STEP = 1e-5  # of differences, in units of the guess
# Where bodies beside a fit are compared with it, in standard errors.
_BESIDE = np.array([0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0, 2.25, 2.5, 3.0, 3.5, 4.0, 5.0, 7.0, 10.0, 15.0, 25.0])
_ROUNDS = 4  # descents that may follow one that was not the lowest
_STRUCTURED = 5.0  # standard errors of a correlation above which what is left is no noise
_AGAIN = (_FIRST, 2 * _FIRST)  # holds on which a fit that leaves more than noise is sought once more
_ALIKE = 0.95  # share of the static friction above which the kinetic one hides it
_HUGE = 1e6  # residual of a body that cannot be simulated
_UNKNOWN = 0.5  # a relative standard error above this is told
_NAMED = 0.2  # share of a direction above which a parameter is named with it


@dataclass(frozen=True, eq=False)
class Identification:
    """A body that fits measurements, and how well they tell it.

    Attributes
    ----------
    body : Groups or Actuator
        As the guess was.
    names : tuple of str
        Of the parameters that were free.
    covariance : (free, free) array
        Of the parameters, in their units, linearised about the fit, with the errors of each channel taken from what
        is left of it.
    noise : dict of str to float
        Root mean square of what is left of each channel.
    samples : int
        That were fitted.
    warnings : tuple of str
        What the data cannot tell.
    runs : tuple of Measurements
        That were fitted.
    scene : Scene
    profiles : dict of str to (values, rises)
        For each parameter, values of it beside the fit, the others following as the covariance has it, and by how much
        the sum of squares is larger there, in squares of the noise.
    """

    body: Body
    names: tuple[str, ...]
    covariance: NDArray[np.float64]
    noise: dict[str, float]
    samples: int
    warnings: tuple[str, ...]
    runs: tuple[Measurements, ...]
    scene: Scene
    profiles: dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]

    @property
    def groups(self) -> Groups:
        """The dimensionless groups of the body."""
        return self.body if isinstance(self.body, Groups) else self.body.groups

    def interval(self, level: float = 0.95) -> dict[str, tuple[float, float]]:
        """Intervals of the free parameters, one a name.

        They are those of the linearised fit by Student's t, and longer where `profiles` knows of bodies further away
        that fit as well: beyond a slip that is won or lost (D. M. Bates and D. G. Watts, Nonlinear Regression Analysis
        and Its Applications, Wiley 1988, section 6.1).

        Parameters
        ----------
        level : float
            Probability that an interval holds the true value, in (0, 1).
        """
        number_within("level", level, "(0, 1)")
        wide = float(t.ppf(0.5 + 0.5 * level, self.samples - len(self.names)))
        intervals = {}
        for name, error in zip(self.names, np.sqrt(np.diag(self.covariance)).tolist(), strict=True):
            values, rises = self.profiles[name]
            fitting = values[rises <= wide**2]
            around = [getattr(self.body, name) + sign * wide * error for sign in (-1.0, 1.0)]
            intervals[name] = min([around[0], *fitting.tolist()]), max([around[1], *fitting.tolist()])
        return intervals

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """What was found, ready for JSON.

        Parameters
        ----------
        level : float
            Of the intervals, in (0, 1).
        """
        errors = np.sqrt(np.diag(self.covariance)).tolist()
        return {
            "units": "natural" if isinstance(self.body, Groups) else "SI",
            "body": asdict(self.body),
            "groups": self.groups.to_dict(),
            "level": level,
            "free": {
                name: {"value": getattr(self.body, name), "standard_error": error, "interval": list(interval)}
                for (name, interval), error in zip(self.interval(level).items(), errors, strict=True)
            },
            "covariance": self.covariance.tolist(),
            "noise": self.noise,
            "samples": self.samples,
            "warnings": list(self.warnings),
            "scene": self.scene.to_dict(),
        }

    def next_word(self, length: int, aim: str | None = None) -> Design:
        """The word of the valve that would tell most about what is known least, or about another `aim`.

        Parameters
        ----------
        length : int
            Holds of the word, run from rest and measured as `runs[0]` was.
        aim : str, optional
            One of `names`, or "all" for all of them at once.

        Returns
        -------
        Design
        """
        run = self.runs[0]
        each = run.samples_per_hold or max(1, round(run.times.size / run.valve.size))
        return best_word(
            self.body,
            length,
            names=self.names,
            noise={name: self.noise[name] for name in run.measured},
            hold=run.hold,
            samples_per_hold=each,
            covariance=self.covariance,
            aim=aim,
            scene=self.scene,
        )

    def plot(self, run: int = 0) -> "Figure":
        """What was measured in one of the runs, the fit, and what is left of it, over time.

        Parameters
        ----------
        run : int
            Its place among `runs`.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from .figure import plot_fit

        return plot_fit(self, whole_number("run", run, 0, len(self.runs) - 1))


def identify(
    measurements: Measurements | Sequence[Measurements],
    *,
    free: Sequence[str] | None = None,
    guess: GroupsLike | None = None,
    scene: Scene | dict[str, Any] | None = None,
    starts: int = 512,
    tolerance: float = 1e-9,
    seed: int = 0,
) -> Identification:
    """Find the body that measurements are of.

    Parameters
    ----------
    measurements : Measurements or sequence of them
        One run or several of one body, all of whose valves are known.
    free : sequence of str, optional
        What to find: fields of the guess. All groups by default; of an `Actuator` they must be named, since no motion
        tells, for example, all of its masses, stiffnesses and pressures.
    guess : Groups, preset, mapping or Actuator, optional
        Where to look, right within a factor of about three; the default groups by default. With an `Actuator`, the
        measurements are in SI, and what is not free is as it says.
    scene : Scene or mapping, optional
    starts : int
        Bodies about the guess that are compared, >= 1; one is the guess itself.
    tolerance : float
        Of `simulate`.
    seed : int
        Of the starts.

    Returns
    -------
    Identification

    Raises
    ------
    ValueError, TypeError
        If a name is not a field of the guess, or there are no more samples than free parameters.
    RuntimeError
        If no start can be simulated.
    """
    runs = several(measurements)
    body: Body = guess if isinstance(guess, Actuator) else Groups.of(guess)
    if free is None and isinstance(body, Actuator):
        raise ValueError("free must name what to find of an Actuator, got None")
    names = tuple(RANGES if free is None else free)
    known_names("free", names, [name for name in body.__dataclass_fields__ if name != "segments"])
    whole_number("starts", starts, 1)
    problem = _Problem(runs, body, names, Scene.of(scene), tolerance)
    if problem.samples <= len(names):
        raise ValueError(f"measurements must have more samples than the {len(names)} free, got {problem.samples}")

    longest = max(run.valve.size for run in runs)
    points = problem.about_the_guess(starts, whole_number("seed", seed, 0))
    kept, holds = _KEPT, _FIRST
    while True:
        holds = min(holds, longest)
        costs = problem.costs(points, holds)
        best = np.argsort(costs)[:kept]
        if not np.isfinite(costs[best[0]]):
            raise RuntimeError("no body about the guess can be simulated; guess another")
        points = np.array([problem.descend(points[i], holds) for i in best if np.isfinite(costs[i])])
        if holds == longest:
            break
        kept, holds = max(1, kept // 2), round(_LENGTHENED * holds)
    point = points[np.argmin(problem.costs(points, longest))]
    point = problem.polished(point, longest)
    if problem.structure(point) > _STRUCTURED:  # a wrong count of slips leaves more than noise
        ends = [point]
        for begin in _AGAIN:
            valleys = problem.about_the_static_friction(point, begin)
            holds = begin
            while holds < longest:
                valleys = np.array([problem.descend(each, holds) for each in valleys])
                holds = round(_LENGTHENED * holds)
            ends += [problem.descend(each, longest) for each in valleys]
        point = problem.polished(ends[np.argmin(problem.costs(np.array(ends), longest))], longest)
    return problem.told(point)


class _Problem:
    """Least squares in units of the guess; where both frictions are free, the kinetic one is a share of the static."""

    def __init__(
        self, runs: Sequence[Measurements], guess: Body, names: tuple[str, ...], scene: Scene, tolerance: float
    ) -> None:
        self.runs, self.guess, self.names, self.scene, self.tolerance = runs, guess, names, scene, tolerance
        self.units = np.array([max(abs(getattr(guess, name)), _SIZES.get(name, 0.0)) for name in names])
        self.kinetic = names.index("kinetic_friction") if {"static_friction", "kinetic_friction"} <= {*names} else None
        if self.kinetic is not None:
            self.units[self.kinetic] = 1.0
        if np.any(self.units == 0.0):
            name = names[int(np.argmin(self.units))]
            raise ValueError(f"guess must have a {name} other than 0, which tells its size, got 0")
        self.errors = {name: self._spread(name) for name in self._measured}
        self.samples = sum(int(np.isfinite(getattr(run, name)).sum()) for run in runs for name in run.measured)

    @property
    def _measured(self) -> list[str]:
        return list(dict.fromkeys(name for run in self.runs for name in run.measured))

    def _spread(self, name: str) -> float:
        """Standard deviation of a channel, to weigh it by until its errors are known."""
        values = [getattr(run, name) for run in self.runs if name in run.measured]
        spread = float(np.sqrt(np.mean([np.nanvar(each) for each in values])))
        return spread or 1.0

    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Least and greatest points."""
        low = np.array([1.0 / _FARTHEST if name == "deborah" else 0.0 for name in self.names])
        high = np.full(len(self.names), _FARTHEST)
        if "foot_mass_fraction" in self.names:
            i = self.names.index("foot_mass_fraction")
            low[i], high[i] = (share / self.units[i] for share in _FRACTIONS)
        if isinstance(self.guess, Actuator):
            low[:] = 1.0 / _FARTHEST
        if self.kinetic is not None:
            low[self.kinetic], high[self.kinetic] = 0.0, 1.0
        elif "kinetic_friction" in self.names:
            i = self.names.index("kinetic_friction")
            high[i] = self.guess.static_friction / self.units[i]
        elif "static_friction" in self.names:
            i = self.names.index("static_friction")
            low[i] = self.guess.kinetic_friction / self.units[i]
        return low, high

    def body(self, point: NDArray[np.float64]) -> Body:
        """The body at a point."""
        values = dict(zip(self.names, (point * self.units).tolist(), strict=True))
        if self.kinetic is not None:
            values["kinetic_friction"] *= values["static_friction"]
        return replace(self.guess, **values)

    def turned(self, point: NDArray[np.float64]) -> NDArray[np.float64]:
        """Slopes of the body's parameters in the point's coordinates, (free, free)."""
        slopes = np.diag(self.units)
        if self.kinetic is not None:
            static = self.names.index("static_friction")
            slopes[self.kinetic, self.kinetic] = point[static] * self.units[static]
            slopes[self.kinetic, static] = point[self.kinetic] * self.units[static]
        return slopes

    def about_the_guess(self, starts: int, seed: int) -> NDArray[np.float64]:
        """Points spread evenly on a logarithmic scale, the guess among them."""
        low, high = self.bounds()
        spread = qmc.Sobol(len(self.names), rng=np.random.default_rng(seed)).random(starts)
        points = _SPREAD ** (2.0 * spread - 1.0)
        points[0] = [getattr(self.guess, name) for name in self.names] / self.units
        if self.kinetic is not None:
            points[:, self.kinetic] = spread[:, self.kinetic]
            points[0, self.kinetic] = self.guess.kinetic_friction / max(self.guess.static_friction, 1e-300)
        return np.clip(points, low, high)

    def about_the_static_friction(self, point: NDArray[np.float64], holds: int) -> NDArray[np.float64]:
        """A point, and the deepest valleys along its static friction, whose sum of squares has a kink a slip."""
        if "static_friction" not in self.names:
            return point[np.newaxis]
        points = np.tile(point, (_VALLEYS.size, 1))
        points[:, self.names.index("static_friction")] *= _VALLEYS
        if self.kinetic is not None:  # the kinetic one stays
            points[:, self.kinetic] = np.minimum(points[:, self.kinetic] / _VALLEYS, 1.0)
        low, high = self.bounds()
        points = np.clip(points, low, high)
        costs = self.costs(points, holds)
        walls = np.concatenate([[np.inf], costs, [np.inf]])
        valleys = np.flatnonzero((costs < walls[:-2]) & (costs <= walls[2:]))
        deepest = valleys[np.argsort(costs[valleys])[:_DEEPEST]]
        return np.concatenate([point[np.newaxis], points[deepest]])

    def residuals(self, points: NDArray[np.float64], holds: int) -> NDArray[np.float64]:
        """What is left of the first holds of every run, in units of the errors: (points, samples)."""
        bodies = [self.body(point) for point in points]
        parts = []
        for whole in self.runs:
            run = whole.until(holds)
            for name, values in predicted(bodies, run, self.scene, self.tolerance).items():
                told = np.isfinite(getattr(run, name))
                left = (values[:, told] - getattr(run, name)[told]) / self.errors[name]
                parts.append(np.nan_to_num(left, nan=_HUGE, posinf=_HUGE, neginf=-_HUGE))
        return np.concatenate(parts, axis=1)

    def costs(self, points: NDArray[np.float64], holds: int) -> NDArray[np.float64]:
        """Mean square of what is left; inf where the body cannot be simulated."""
        costs = np.mean(self.residuals(points, holds) ** 2, axis=1)
        return np.where(costs < 1e-3 * _HUGE**2, costs, np.inf)

    def slopes(self, point: NDArray[np.float64], holds: int) -> NDArray[np.float64]:
        """Slopes of the residuals in the parameters, (samples, free)."""
        if is_chain(self.scene):
            return self._differences(point, holds)
        parts, body = [], self.body(point)
        try:
            for whole in self.runs:
                run = whole.until(holds)
                for name, slopes in slopes_of(body, run, self.scene, self.tolerance, self.names).items():
                    parts.append(slopes[np.isfinite(getattr(run, name))] / self.errors[name])
        except SolverError:  # where the residuals are those of no body, which has no slopes
            return self._differences(point, holds)
        return np.concatenate(parts) @ self.turned(point)

    def _differences(self, point: NDArray[np.float64], holds: int) -> NDArray[np.float64]:
        """The same by central differences of bodies in one batch."""
        low, high = self.bounds()
        ahead = np.minimum(point + _STEP, high)
        behind = np.maximum(point - _STEP, low)
        n = len(point)
        points = np.tile(point, (2 * n, 1))
        points[np.arange(n), np.arange(n)] = ahead
        points[n + np.arange(n), np.arange(n)] = behind
        left = self.residuals(points, holds)
        return ((left[:n] - left[n:]) / (ahead - behind)[:, np.newaxis]).T

    def descend(self, point: NDArray[np.float64], holds: int) -> NDArray[np.float64]:
        """The least sum of squares that is found from a point."""
        low, high = self.bounds()
        inside = np.clip(point, low + 1e-9, high - 1e-9)
        found = least_squares(
            lambda x: self.residuals(x[np.newaxis], holds)[0],
            inside,
            jac=lambda x: self.slopes(x, holds),
            bounds=(low, high),
            xtol=1e-10,
            ftol=1e-10,
            gtol=1e-12,
            max_nfev=30,
        )
        return np.asarray(found.x)

    def beside(self, point: NDArray[np.float64], holds: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Points beside one, (free, beside, free), and by how much more they leave, in squares of the noise.

        A row is a parameter of the body, moved by so many standard errors. The others follow as the covariance has it,
        or, where that leaves less, by a Gauss-Newton step from there.
        """
        covariance, scale, _, _ = self._linearised(point, holds)
        turned = self.turned(point)
        back = np.linalg.pinv(turned)
        slopes = self.slopes(point, holds) @ back
        errors = np.sqrt(np.diag(turned @ covariance @ turned.T))
        ways = turned @ covariance / np.where(errors > 0.0, errors, 1.0)[:, np.newaxis]
        offsets = np.concatenate([-_BESIDE, _BESIDE])
        low, high = self.bounds()
        found, costs = [], []
        for i, way in enumerate(ways):
            points = np.clip(point + np.outer(offsets, way), low, high)
            left = self.residuals(points, holds)
            step = -np.linalg.pinv(np.delete(slopes, i, axis=1)) @ left.T
            moved = np.clip(points + np.insert(step, i, 0.0, axis=0).T @ back.T, low, high)
            both = np.stack([np.mean(each**2, axis=1) for each in (left, self.residuals(moved, holds))])
            found.append(np.where((both[1] < both[0])[:, np.newaxis], moved, points))
            costs.append(both.min(axis=0))
        least = self.costs(point[np.newaxis], holds)[0]
        return np.array(found), (np.array(costs) - least) * self.samples / scale

    def _linearised(
        self, point: NDArray[np.float64], holds: int
    ) -> tuple[NDArray[np.float64], float, NDArray[np.float64], NDArray[np.float64]]:
        """Covariance of the point, the mean square that is left, and the slopes' singular values and directions."""
        slopes = self.slopes(point, holds)
        left = self.residuals(point[np.newaxis], holds)[0]
        scale = float(left @ left) / (self.samples - len(self.names))
        _, singular, directions = np.linalg.svd(slopes, full_matrices=False)
        known = np.maximum(singular, 1e-12 * max(singular[0], 1.0))
        return (directions.T / known**2) @ directions * scale, scale, known, directions

    def polished(self, point: NDArray[np.float64], holds: int) -> NDArray[np.float64]:
        """The lowest of what is found beside a point, weighed by what it leaves."""
        for _ in range(2):  # weights by what is left, then the fit by these weights
            self.weigh(point)
            starts = self.about_the_static_friction(point, holds)
            ends = np.array([self.descend(start, holds) for start in starts])
            point = ends[np.argmin(self.costs(ends, holds))]
        for _ in range(_ROUNDS):
            beside, rises = self.beside(point, holds)
            lowest = np.unravel_index(np.argmin(rises), rises.shape)
            if rises[lowest] >= 0.0:
                break
            lower = self.descend(beside[lowest], holds)
            costs = self.costs(np.array([point, lower]), holds)
            if not costs[1] < costs[0]:
                break
            point = lower
            self.weigh(point)
        return point

    def structure(self, point: NDArray[np.float64]) -> float:
        """Correlation of what is left from one sample to the next, the largest of all channels, in standard errors."""
        found = [0.0]
        for run in self.runs:
            for name, values in predicted([self.body(point)], run, self.scene, self.tolerance).items():
                left = values[0] - getattr(run, name)
                products = left[1:] * left[:-1]
                told = np.isfinite(products)
                if told.any():
                    found.append(float(products[told].mean() / np.nanmean(left**2) * np.sqrt(told.sum())))
        return max(found)

    def weigh(self, point: NDArray[np.float64]) -> None:
        """Take the errors of the channels from what a body leaves of them."""
        self.errors = {name: left or 1.0 for name, left in self._left(point).items()}

    def _left(self, point: NDArray[np.float64]) -> dict[str, float]:
        """Root mean square of what a body leaves of each channel."""
        squares: dict[str, list[NDArray[np.float64]]] = {name: [] for name in self._measured}
        for run in self.runs:
            for name, values in predicted([self.body(point)], run, self.scene, self.tolerance).items():
                squares[name].append((values[0] - getattr(run, name)) ** 2)
        return {name: float(np.sqrt(np.nanmean(np.concatenate(each)))) for name, each in squares.items()}

    def told(self, point: NDArray[np.float64]) -> Identification:
        """The identification at a fit."""
        longest = max(run.valve.size for run in self.runs)
        covariance, scale, known, directions = self._linearised(point, longest)
        turned = self.turned(point)
        beside, rises = self.beside(point, longest)
        values = np.array(
            [[getattr(self.body(each), name) for each in row] for name, row in zip(self.names, beside, strict=True)]
        )
        found = Identification(
            body=self.body(point),
            names=self.names,
            covariance=turned @ covariance @ turned.T,
            noise=self._left(point),
            samples=self.samples,
            warnings=_what_is_not_told(self.names, known, directions, scale),
            runs=tuple(self.runs),
            scene=self.scene,
            profiles=dict(zip(self.names, zip(values, rises, strict=True), strict=True)),
        )
        more = _hidden_friction(found)
        if self.structure(point) > _STRUCTURED:
            more += (
                "what is left is more than noise, since it goes on from sample to sample: the body differs from the "
                "model, or a better fit was missed",
            )
        return replace(found, warnings=found.warnings + more)


def _hidden_friction(found: Identification) -> tuple[str, ...]:
    """A sentence where the static friction may be next to the kinetic one."""
    intervals = found.interval()
    if "static_friction" not in intervals:
        return ()
    low, high = intervals["static_friction"]
    if found.body.kinetic_friction < _ALIKE * low:
        return ()
    return (
        f"static_friction may be within 5% of kinetic_friction: a foot that breaks loose then hardly jumps, and the "
        f"data tell it no better than {low:.3g} to {high:.3g}",
    )


def _what_is_not_told(
    names: tuple[str, ...], singular: NDArray[np.float64], directions: NDArray[np.float64], scale: float
) -> tuple[str, ...]:
    """A sentence for each direction in which the fit may move by more than half of the guess."""
    told = []
    for size, direction in zip(singular, directions, strict=True):
        error = float(np.sqrt(scale)) / float(size)
        if error > _UNKNOWN:
            order = np.argsort(-np.abs(direction))
            sign = np.sign(direction[order[0]])
            parts = [
                f"{'up' if direction[i] * sign > 0 else 'down'} in {names[i]} by {abs(direction[i]):.2g} of the guess"
                for i in order
                if abs(direction[i]) > _NAMED
            ]
            told.append(
                f"the data hardly tell a body from one {' and '.join(parts)}: the standard error along this is "
                f"{min(error, 1e9):.2g} of the guess"
            )
    return tuple(told)
