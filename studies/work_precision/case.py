"""The run on which solvers are compared, and what is compared of it."""

import time
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...common.validation import number_within, whole_number
from ...crawler import Groups, REST, Scene, simulate, SolverError, State, Trajectory
from ...crawler.model.variations import HOLDS
from ...tasks import random_bits

__all__ = [
    "DEFORMATION",
    "FOOT",
    "MEAN_SPEED",
    "RMS_DEFORMATION",
    "SLIP_RATE",
    "Case",
    "afford",
    "differences",
    "quantities",
    "statistics",
]

FOOT, DEFORMATION = "foot position", "deformation"
MEAN_SPEED, SLIP_RATE, RMS_DEFORMATION = "mean speed", "slips per time", "RMS deformation"

_PROBE_HOLDS = 4
_LONGEST_RUN = 10.0  # seconds


@dataclass(frozen=True)
class Case:
    """A crawler driven from rest by random valve states.

    Parameters
    ----------
    groups : Groups, str, mapping or Actuator
    scene : Scene or mapping
    hold : float, in (0, inf)
        Natural units.
    holds : int, >= 1
    seed : int, >= 0
        Of the valve states, ``random_bits(holds, seed)``.

    Raises
    ------
    ValueError, TypeError
        If an argument is out of its range or of the wrong type; the message names it.
    """

    groups: Groups = field(default_factory=Groups)
    scene: Scene = field(default_factory=Scene)
    hold: float = 0.5
    holds: int = 400
    seed: int = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "groups", Groups.of(self.groups))
        object.__setattr__(self, "scene", Scene.of(self.scene))
        object.__setattr__(self, "hold", number_within("hold", self.hold, HOLDS))
        whole_number("holds", self.holds, 1)
        whole_number("seed", self.seed, 0)

    @cached_property
    def valve(self) -> NDArray[np.int64]:
        """The valve states, shape (holds,)."""
        return random_bits(self.holds, self.seed)

    @property
    def duration(self) -> float:
        """Length of the run, natural units."""
        return self.holds * self.hold

    def run(self, solver: str, tolerance: float, *, initial: State = REST, holds: int | None = None) -> Trajectory:
        """Simulate the case, or its first holds, sampled at the end of each hold."""
        return simulate(
            self.groups,
            self.valve[:holds],
            self.hold,
            scene=self.scene,
            tolerance=tolerance,
            solver=solver,
            initial=initial,
        )


def afford(case: Case, solver: str, tolerance: float) -> None:
    """Refuse a run that would take longer than anyone waits for, judged by its first holds.

    Raises
    ------
    SolverError
        If the run would take more than ten seconds, or the solver fails already.
    """
    case.run(solver, tolerance, holds=1)  # compiles
    probe = min(_PROBE_HOLDS, case.holds)
    start = time.perf_counter()
    case.run(solver, tolerance, holds=probe)
    seconds = (time.perf_counter() - start) * case.holds / probe
    if seconds > _LONGEST_RUN:
        raise SolverError(f"the run would take about {seconds:.0f} s, more than the {_LONGEST_RUN:.0f} s allowed")


def quantities(case: Case, run: Trajectory) -> dict[str, NDArray[np.float64]]:
    """The samples of deformation and, unless the scene is anchored, of foot position."""
    return {DEFORMATION: run.deformation} if case.scene.anchored else {FOOT: run.foot, DEFORMATION: run.deformation}


def differences(case: Case, one: Trajectory, other: Trajectory) -> dict[str, float]:
    """Largest difference over the samples, by quantity."""
    theirs = quantities(case, other)
    return {name: float(np.abs(mine - theirs[name]).max()) for name, mine in quantities(case, one).items()}


def statistics(case: Case, run: Trajectory) -> dict[str, float]:
    """Root mean square of the sampled deformation and, unless the scene is anchored, mean speed and slips per time."""
    found = {RMS_DEFORMATION: float(np.sqrt(np.mean(run.deformation**2)))}
    if not case.scene.anchored:
        found = {
            MEAN_SPEED: float(run.foot[-1]) / case.duration,
            SLIP_RATE: run.slips / case.duration,
            **found,
        }
    return found
