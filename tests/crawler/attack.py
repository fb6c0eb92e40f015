"""Random crawlers from all over the ranges, for attacks on the solvers."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from stickslip.crawler import ChainState, Groups, Scene, State

__all__ = ["Case", "random_case"]


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
        return self.scene.segments > 1 and self.scene.tube_mass > 0.0

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
        _between(rng, 0.02, 50.0 if extreme else 5.0),
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
    heavy = _between(rng, 1e-4, 0.5) if extreme else rng.uniform(0.05, 0.5)
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
