"""How fast a policy can be that sees the whole state of the body: dynamic programming for the average speed.

The state at the end of a hold is deformation, velocity, pressure and foot velocity. With W(s) what a state is worth
beyond the average speed g, in distance, Bellman's equation of the average reward [1]_ is

    W(s) + g hold = max over a of  (1 - dither) Q_a(s) + dither Q_(1-a)(s),    Q_u(s) = distance_u(s) + W(state_u(s)),

where u is the valve after the flip, and distance and state are those that the crawler's own solver finds. W is kept on
a grid, and found by relative value iteration. What the grid says of its average speed is off by what it interpolates:
the limit is what the policy comes to when it is simulated. That policy looks a few exact holds ahead and takes W for
the rest.

References
----------
.. [1] M. L. Puterman, "Markov Decision Processes", Wiley, 1994, chapter 8.
"""

import json
from collections.abc import Callable
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...common.files import atomically
from ...common.fingerprint import described
from ...common.validation import whole_number
from ...envs.settings import Settings
from ...reservoir.bootstrap import Estimate, mean_over_runs
from .conditions import conditions
from .grid import Grid, reachable_pressures
from .holds import Holds
from .judgement import held_out_seeds
from .rollouts import roll_out_many, WASHOUT

__all__ = ["Planner", "SpeedLimit", "speed_limit"]

Array = NDArray[np.float64]
Bits = NDArray[np.int64]

# A step of value iteration goes this share of the way, so that it settles where the best gait is periodic.
_SHARE = 0.7
_MOST_SWEEPS = 2000
_SETTLED = 1e-3  # of the average speed, at which it ends
_COARSE, _FINE = 14, 40  # resolutions: that looks for the ends of the axes, and from which on there are more pressures
_MOST_EXTENSIONS = 6
_SLACK = 1.15  # by which an axis reaches beyond what was seen
_TRIAL = 64, 300  # crawlers and holds that look for the ends of the axes


class Planner:
    """A policy that looks exact holds ahead and takes the grid's values for the rest.

    Parameters
    ----------
    settings : Settings
        See `conditions`.
    grid : Grid
    values : (n,) array
        At the grid's points.
    lookahead : int, >= 1
        Holds that are simulated, along all sequences of valve states.
    threads : int, optional
        All processors by default.
    """

    def __init__(
        self, settings: Settings, grid: Grid, values: Array, lookahead: int = 3, threads: int | None = None
    ) -> None:
        self.settings, self.grid, self.values = settings, grid, values
        self.lookahead = whole_number("lookahead", lookahead, 1, 10)
        self._hold = Holds(settings, threads)

    def predict(self, observation: ArrayLike) -> Bits:
        """Best command for what is observed.

        Parameters
        ----------
        observation : (n, k) or (k,) array_like
            Of the environment, of which the first four numbers count.

        Returns
        -------
        (n,) array, or array of no dimension, of 0 and 1
        """
        observed = np.asarray(observation, np.float64)
        gains = self.gains(np.atleast_2d(observed)[:, :4].T)
        return np.asarray(gains[1] > gains[0], np.int64).reshape(observed.shape[:-1])

    def gains(self, states: Array) -> Array:
        """What a hold with the valve shut, and one with it open, is worth.

        Parameters
        ----------
        states : (4, n) array

        Returns
        -------
        (2, n) array
            In distance, beyond the average speed.
        """
        distances = []
        for _ in range(self.lookahead):
            valves = np.repeat([0, 1], states.shape[1])
            states, distance = self._hold(np.tile(states, 2), valves)
            distances.append(distance)
        worth = self.grid.interpolation(states) @ self.values
        while True:
            gains = (distances.pop() + worth).reshape(2, -1)
            if not distances:
                return gains
            worth = expected(gains, self.settings.dither)


def expected(gains: Array, dither: float) -> Array:
    """Worth of the better command, of what shut and open are worth, shape (2, n): it is flipped now and then."""
    best: Array = (1.0 - dither) * gains.max(axis=0) + dither * gains.min(axis=0)
    return best


@dataclass(frozen=True, eq=False)
class SpeedLimit:
    """How fast the best policy is, as far as the grid resolves it.

    Attributes
    ----------
    policy : Planner
    speeds : (m,) array
        Mean speed of the policy on each held-out seed, z_c / t_c.
    seeds : tuple of int
    holds : int
        Of each run, after a washout of 200.
    grid_speed : float
        What the grid says of itself: off by what it interpolates.
    outside : float
        Share of the holds that ended beyond the grid's outermost points.
    """

    policy: Planner
    speeds: Array
    seeds: tuple[int, ...]
    holds: int
    grid_speed: float
    outside: float

    @property
    def speed(self) -> Estimate:
        """Mean over the held-out seeds, and its interval of 95%."""
        return mean_over_runs(self.speeds)


def speed_limit(
    dither: float = 0.1,
    *,
    resolution: int = 28,
    lookahead: int = 3,
    seeds: int = 10,
    holds: int = 10_000,
    folder: Path | None = None,
    threads: int | None = None,
    **env_kwargs: Any,
) -> SpeedLimit:
    """Find the fastest policy by dynamic programming, and measure it.

    Parameters
    ----------
    dither : float, in [0, 1/2]
    resolution : int, in [6, 100]
        Points of the grid over deformation and over velocity; over foot velocity there are half as many, over pressure
        8, or 16 from 40 on.
    lookahead : int, in [1, 10]
        Holds that the policy simulates ahead of each decision.
    seeds : int, >= 1
        Held-out seeds.
    holds : int, >= 1
        Of the run on each.
    folder : Path, optional
        Where the result is kept, or found.
    threads : int, optional
        All processors by default.
    **env_kwargs
        Others as for `conditions`. The foot must be ratcheted, as it is by default.

    Returns
    -------
    SpeedLimit

    Raises
    ------
    ValueError, TypeError
        If an argument is out of range or of the wrong type, or `folder` holds a result of other arguments; the message
        names it.
    """
    settings = conditions(dither=dither, **env_kwargs)
    if settings.scene.anchored or not settings.scene.ratchet:
        raise ValueError(f"scene must have a foot that slides forward alone, got {settings.scene}")
    whole_number("resolution", resolution, 6, 100)
    whole_number("lookahead", lookahead, 1, 10)
    whole_number("holds", holds, 1)
    held_out = held_out_seeds(seeds)
    asked = {"settings": settings, "resolution": resolution, "lookahead": lookahead, "seeds": seeds, "holds": holds}
    made_for = json.dumps(described(asked))
    kept = None if folder is None else folder / f"speed-limit-{sha256(made_for.encode()).hexdigest()[:16]}.npz"
    if kept is None or not kept.exists():
        found = _found(settings, resolution, lookahead, held_out, holds, threads)
        if kept is None:
            return found
        kept.parent.mkdir(parents=True, exist_ok=True)
        atomically(kept, lambda unfinished: _write(unfinished, found, made_for))
    return _read(kept, settings, lookahead, held_out, holds, threads)


def _found(
    settings: Settings, resolution: int, lookahead: int, held_out: tuple[int, ...], holds: int, threads: int | None
) -> SpeedLimit:
    hold = Holds(settings, threads)
    ends = _ends(_random_states(settings, hold))
    for _ in range(_MOST_EXTENSIONS):
        grid = _grid(settings, ends, _COARSE)
        values, _ = _relative_values(settings, grid, hold)
        visited = _visited(Planner(settings, grid, values, 1, threads), hold)
        if not grid.outside(visited).any():
            break
        seen = _ends(visited)
        ends = np.minimum(ends[0], seen[0]), np.maximum(ends[1], seen[1])
    grid = _grid(settings, ends, resolution)
    values, grid_speed = _relative_values(settings, grid, hold)
    policy = Planner(settings, grid, values, lookahead, threads)
    beyond = 0

    def act(_: int, observations: NDArray[np.float32]) -> Bits:
        nonlocal beyond
        beyond += int(grid.outside(observations[:, :4].T.astype(np.float64)).sum())
        return policy.predict(observations)

    scores = roll_out_many(lambda _: act, len(held_out), holds, settings, seed=held_out[0], threads=threads)
    share = beyond / (len(held_out) * (holds + WASHOUT))
    return SpeedLimit(policy, scores.speeds, held_out, holds, grid_speed, share)


def _grid(settings: Settings, ends: tuple[Array, Array], resolution: int) -> Grid:
    low, high = ends
    pressures = reachable_pressures(settings.hold, settings.groups.deborah, 8 if resolution < _FINE else 16)
    return Grid(
        np.linspace(low[0], high[0], resolution),
        np.linspace(low[1], high[1], resolution),
        pressures,
        np.linspace(0.0, high[3], resolution // 2 + 1)[1:],
    )


def _relative_values(settings: Settings, grid: Grid, hold: Holds) -> tuple[Array, float]:
    """What the grid's points are worth, and the average speed that they speak of."""
    points = grid.points
    transitions = []
    for valve in (0, 1):
        states, distances = hold(points, np.full(points.shape[1], valve))
        transitions.append((distances, grid.interpolation(states)))
    values = np.zeros(points.shape[1])
    low = high = 0.0
    for _ in range(_MOST_SWEEPS):
        gains = np.stack([distances + matrix @ values for distances, matrix in transitions])
        change = expected(gains, settings.dither) - values
        # The average reward of the grid lies between the least and the largest change.
        low, high = float(change.min()), float(change.max())
        values += _SHARE * (change - change[0])
        if high - low < _SETTLED * settings.hold:
            break
    return values, (low + high) / 2 / settings.hold


def _random_states(settings: Settings, hold: Holds) -> Array:
    """States of bodies from rest whose valves are random, shape (4, n)."""
    bodies, holds = _TRIAL
    random = np.random.default_rng(0)
    return _driven(hold, bodies, holds, lambda _: random.integers(0, 2, bodies))


def _visited(policy: Planner, hold: Holds) -> Array:
    """States that bodies under a policy come to, shape (4, n)."""
    bodies, holds = _TRIAL
    random = np.random.default_rng(1)

    def valves(states: Array) -> Bits:
        return policy.predict(states.T) ^ (random.random(bodies) < policy.settings.dither)

    return _driven(hold, bodies, holds, valves)


def _driven(hold: Holds, bodies: int, holds: int, valves: Callable[[Array], Bits]) -> Array:
    states = np.zeros((4, bodies))
    seen = []
    for _ in range(holds):
        states, _ = hold(states, valves(states))
        seen.append(states)
    return np.concatenate(seen, axis=1)


def _ends(states: Array) -> tuple[Array, Array]:
    """Ends of axes that hold these states and a little more."""
    low, high = states.min(axis=1), states.max(axis=1)
    reach = (_SLACK - 1.0) * (high - low)
    return low - reach, high + reach


def _write(file: Path, found: SpeedLimit, made_for: str) -> None:
    grid = found.policy.grid
    with file.open("wb") as stream:
        np.savez_compressed(
            stream,
            made_for=made_for,
            deformations=grid.axes[0],
            velocities=grid.axes[1],
            pressures=grid.axes[2],
            foot_velocities=grid.axes[3][1:],
            values=found.policy.values,
            speeds=found.speeds,
            grid_speed=found.grid_speed,
            outside=found.outside,
        )


def _read(
    file: Path, settings: Settings, lookahead: int, held_out: tuple[int, ...], holds: int, threads: int | None
) -> SpeedLimit:
    with np.load(file, allow_pickle=False) as kept:
        grid = Grid(*(kept[name] for name in ("deformations", "velocities", "pressures", "foot_velocities")))
        policy = Planner(settings, grid, kept["values"], lookahead, threads)
        return SpeedLimit(policy, kept["speeds"], held_out, holds, float(kept["grid_speed"]), float(kept["outside"]))
