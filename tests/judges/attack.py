"""Random crawlers from all over the ranges, for attacks on the solvers.

Every solver that can take a case runs it, and once more in two parts. Where the answers differ by more than their
tolerance explains, the finest answer is asked how far it moves if its start moves by the tolerance: a motion that
tells nothing at its tolerance is sensitive, and no solver's fault. What is left is judged.
"""

import warnings
from collections import Counter
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np
from decimal_judge import decimal_judge
from judge import Verdict
from modal_judge import modal_judge

from stickslip.crawler import ChainState, EnergyWarning, Groups, Scene, simulate, SolverError, State, Trajectory
from stickslip.crawler.model.tube import is_chain

__all__ = ["Case", "attack", "random_case"]


@dataclass(frozen=True)
class Case:
    """What `simulate` is called with, but for the solver."""

    groups: Groups
    valve: list[float]
    hold: float
    scene: Scene
    tolerance: float
    initial: State | ChainState

    @property
    def arguments(self) -> dict[str, Any]:
        return vars(self).copy()

    @property
    def is_chain(self) -> bool:
        return is_chain(self.scene)

    @property
    def is_linear(self) -> bool:
        return self.groups.duffing == 0.0 and self.groups.radial_coupling == 0.0

    @property
    def solvers(self) -> list[str]:
        if self.is_chain:
            return ["taylor"]
        return ["closed_form", "taylor", "radau"] if self.is_linear else ["taylor", "radau"]


def random_case(rng: np.random.Generator) -> Case:
    """One crawler, its ground, its start, its schedule and a tolerance."""
    scene = _scene(rng)
    extreme = rng.random() < 0.4
    return Case(
        _groups(rng, extreme),
        _valve(rng),
        _between(rng, 0.02, 200.0 if extreme else 5.0),
        scene,
        10.0 ** rng.uniform(-15.0, -3.0),
        _start(rng, scene),
    )


def _between(rng, low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _or_zero(rng, chance, value):
    return 0.0 if rng.random() < chance else value


def _groups(rng, extreme):
    linear = rng.random() < 0.3
    static = float(rng.choice([0.0, rng.uniform(0.0, 1.0), _between(rng, 1e-12 if extreme else 1e-3, 1.0)]))
    heavy = _between(rng, 1e-6, 0.5) if extreme else rng.uniform(0.05, 0.5)
    return Groups(
        duffing=0.0 if linear else _or_zero(rng, 0.1, _between(rng, 1e-2, 1e4 if extreme else 10.0)),
        damping_ratio=_or_zero(rng, 0.15, _between(rng, 1e-3, 100.0 if extreme else 3.0)),
        deborah=_between(rng, 1e-3 if extreme else 0.05, 10.0),
        radial_coupling=0.0 if linear else _or_zero(rng, 0.1, rng.uniform(0.0, 0.95)),
        foot_mass_fraction=heavy if rng.random() < 0.5 else 1.0 - heavy,
        static_friction=static,
        kinetic_friction=static * float(rng.choice([0.0, 1.0, rng.uniform()])),
    )


def _scene(rng):
    anchored = bool(rng.random() < 0.15)
    ratchet = bool(rng.random() < 0.6)
    slope = _or_zero(rng, 0.7, float(rng.uniform(-0.3, 0.3)))
    if rng.random() < 0.15:
        return Scene(anchored, ratchet, slope, int(rng.integers(1, 6)), _between(rng, 1e-2, 1.0))
    return Scene(anchored, ratchet, slope)


def _valve(rng):
    holds = int(rng.integers(1, 13))
    if rng.random() < 0.6:
        return [float(bit) for bit in rng.integers(0, 2, holds)]
    return [float(duty) for duty in rng.uniform(0.0, 1.0, holds).round(int(rng.integers(1, 17)))]


def _start(rng, scene):
    if rng.random() < 0.4:
        return State()
    z, v = rng.uniform(-1.5, 1.5), _or_zero(rng, 0.5, rng.normal())
    pressure = float(rng.choice([0.0, 1.0, rng.uniform()]))
    speed = 0.0 if scene.anchored else _or_zero(rng, 0.6, rng.normal())
    speed = abs(speed) if scene.ratchet else speed
    foot = _or_zero(rng, 0.8, rng.normal() * 100.0)
    if scene.segments == 1 or scene.tube_mass == 0.0 or rng.random() < 0.5:
        return State(z, v, pressure, foot, speed)
    parts = rng.normal(size=(2, scene.segments)) / scene.segments
    return ChainState(parts[0].tolist(), parts[1].tolist(), pressure, foot, speed)


# What runs are compared by.
_VARIABLES = ("deformation", "velocity", "pressure", "foot", "foot_velocity")
# A run may be off by so many tolerances a unit of time, or by so much more than its start, moved by some, moves it.
_ERRORS, _NUDGE, _AMPLIFIED = 100.0, 10.0, 100.0
_FINEST = 1e-14
# Slips are counted alike where static friction is above so many tolerances.
_COUNTABLE = 10.0
_BUDGET, _FINE_BUDGET = 20_000, 200_000


def attack(case: Case) -> Counter[str]:
    """Run a case by every solver that can take it, and say what became of it.

    Returns
    -------
    Counter
        "runs", and of them "refused" and "energy" (the balance does not close); then one of "alone" (fewer than two
        answers), "agree", "sensitive", "unjudged", "wrong: solver" and "slips" (the same motion with other counts).
    """
    found: Counter[str] = Counter()
    runs = {solver: _run(case, found, solver=solver) for solver in case.solvers}
    counts = {run.slips for run in runs.values() if run is not None}
    if len(case.valve) > 1:
        runs["in two parts"] = _in_two_parts(case, found)
    done = {name: run for name, run in runs.items() if run is not None}
    if len(done) < 2:
        found["alone"] += 1
        return found
    allowed = _ERRORS * max(case.tolerance, 1e-13) * (1.0 + case.hold * len(case.valve)) * _size(done.values())
    same = max(_distance(one, other) for one, other in combinations(done.values(), 2)) <= allowed
    if same and (len(counts) < 2 or not _has_a_count(case)):
        found["agree"] += 1
    elif same:
        found[_blame_for_slips(case, found)] += 1
    else:
        found[_blame(case, done, allowed, found)] += 1
    return found


def _has_a_count(case: Case) -> bool:
    """Whether the number of slips is defined at the case's tolerance.

    Under equal frictions a foot stops where it would next break loose, and an undamped body brings it back there, to
    graze that threshold at every swing.
    """
    groups = case.groups
    grazes = groups.damping_ratio == 0.0 and groups.static_friction == groups.kinetic_friction
    return groups.static_friction > _COUNTABLE * case.tolerance and not grazes


def _blame(case: Case, done: dict[str, Trajectory], allowed: float, found: Counter[str]) -> str:
    """What is wrong with runs that differ."""
    nudged = _nudged(case, found)
    if None in nudged:
        return "unjudged"
    moved = max(_distance(nudged[0], run) for run in nudged[1:])
    apart = max(_distance(one, other) for one, other in combinations(done.values(), 2))
    if apart <= _AMPLIFIED * moved:
        return "sensitive"
    truth = _truth(case, allowed, found)
    if truth is None:
        return "unjudged"
    return "wrong: " + ", ".join(name for name, run in done.items() if _distance(run, truth) > 0.5 * allowed)


def _blame_for_slips(case: Case, found: Counter[str]) -> str:
    """What is wrong with runs that move alike and count other slips."""
    if len({run and run.slips for run in _nudged(case, found)}) > 1:
        return "sensitive"
    verdict = _verdict(case)
    if verdict is None:
        return "unjudged"
    return "sensitive" if verdict.clearance < max(_NUDGE * case.tolerance, 1e-12) else "slips"


def _verdict(case: Case) -> Verdict | None:
    """What a judge in many digits says, who knows no duty cycles and no masses of a tube."""
    if case.scene.tube_mass > 0.0 or set(case.valve) - {0.0, 1.0}:
        return None
    given = {"groups": case.groups, "valve": case.valve, "hold": case.hold, "scene": case.scene}
    return (modal_judge if case.is_linear else decimal_judge)(**given, initial=case.initial, samples_per_hold=2)


def _truth(case: Case, allowed: float, found: Counter[str]) -> Any:
    """The finest answer where solvers agree on it, or else what a judge says; None where there is none."""
    if len(case.solvers) > 1:
        fine = {"tolerance": _FINEST, "max_steps": _FINE_BUDGET}
        finest = [_run(case, found, solver=solver, **fine) for solver in case.solvers]
        if None not in finest and all(_distance(finest[0], run) <= 0.1 * allowed for run in finest[1:]):
            return finest[0]
    return _verdict(case)


def _run(case: Case, found: Counter[str], **changes: Any) -> Trajectory | None:
    found["runs"] += 1
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            run = simulate(**{**case.arguments, "samples_per_hold": 2, "max_steps": _BUDGET, **changes})
        except SolverError:
            found["refused"] += 1
            return None
    found["energy"] += sum(issubclass(warning.category, EnergyWarning) for warning in caught)
    return run


def _in_two_parts(case: Case, found: Counter[str]) -> Trajectory | None:
    """The same run, begun anew in its middle."""
    middle = len(case.valve) // 2
    first = _run(case, found, valve=case.valve[:middle])
    second = first and _run(case, found, valve=case.valve[middle:], initial=first.final_state)
    if second is None:
        return None
    joined = {name: np.concatenate([getattr(first, name), getattr(second, name)]) for name in _VARIABLES}
    return replace(second, **joined)


def _nudged(case: Case, found: Counter[str]) -> list[Trajectory | None]:
    """The finest answer, and those for a start moved by some tolerances."""
    nudge = _NUDGE * max(case.tolerance, _FINEST)
    runs = []
    for z, v in ((0.0, 0.0), (nudge, 0.0), (-nudge, 0.0), (0.0, nudge), (0.0, -nudge)):
        start: Any = case.initial
        if isinstance(start, ChainState):
            parts = np.add(start.segment_deformation, z), np.add(start.segment_velocity, v)
            start = start._replace(segment_deformation=parts[0], segment_velocity=parts[1])
        else:
            start = start._replace(deformation=start.deformation + z, velocity=start.velocity + v)
        solver = "closed_form" if "closed_form" in case.solvers else "auto"
        fine = {"tolerance": _FINEST, "max_steps": _FINE_BUDGET, "solver": solver}
        runs.append(_run(case, found, initial=start, **fine))
    return runs


def _distance(one: Any, other: Any) -> float:
    return max(float(np.abs(getattr(one, name) - getattr(other, name)).max()) for name in _VARIABLES)


def _size(runs: Any) -> float:
    return 1.0 + max(float(np.abs(getattr(run, name)).max()) for run in runs for name in _VARIABLES)
