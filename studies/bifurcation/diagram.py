"""Sections of the motion and Lyapunov exponents against one number of the crawler."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...common.validation import whole_number
from ...crawler import Groups, GroupsLike, lyapunov_spectrum, LyapunovSpectrum, Scene, simulate
from ...crawler.model.variations import varied
from ..maps.axes import axis_of, AxisLike
from ..maps.inputs import Inputs

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["BifurcationDiagram", "bifurcation_diagram"]

# Values whose rows are driven at once.
_TOGETHER = 8
# Sections that are kept of each value: more cannot be told apart in a figure.
_SECTIONS = 400


@dataclass(frozen=True, eq=False)
class BifurcationDiagram:
    """Sections and exponents of bodies that differ in one number.

    Attributes
    ----------
    name : str
        Of the number.
    values : (n,) array
        Ascending.
    sections : (n, sections) array
        Deformations at the ends of holds, or of words where the input is a word without dither: the last ones of every
        run.
    spectra : tuple of n LyapunovSpectrum
    inputs : Inputs
        Where the dither varies, that of the last value.
    """

    name: str
    values: NDArray[np.float64]
    sections: NDArray[np.float64]
    spectra: tuple[LyapunovSpectrum, ...]
    inputs: Inputs

    @property
    def exponents(self) -> NDArray[np.float64]:
        """Both exponents of each value, shape (n, 2)."""
        return np.array([each.exponents for each in self.spectra])

    @property
    def standard_error(self) -> NDArray[np.float64]:
        """Of the exponents, shape (n, 2)."""
        return np.array([each.standard_error for each in self.spectra])

    @property
    def verdicts(self) -> list[str]:
        """What each value's exponents say, as in `LyapunovSpectrum.verdict`."""
        return [each.verdict for each in self.spectra]

    def plot(self) -> Figure:
        """The sections above, the exponents with their 95% intervals below.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from .figure import plot_diagram  # matplotlib is optional, and slow to import

        return plot_diagram(self)


def bifurcation_diagram(
    over: AxisLike,
    *,
    groups: GroupsLike | None = None,
    scene: Scene | Mapping[str, Any] | None = None,
    hold: float = 0.5,
    inputs: Inputs | str = "bits",
    holds: int = 2200,
    washout: int = 200,
    seeds: int = 1,
    tolerance: float = 1e-9,
    threads: int | None = None,
    on_progress: Callable[[int, int], None] | None = None,
) -> BifurcationDiagram:
    """Drive bodies that differ in one number, and tell where they are at the ends of holds and how they forget.

    Parameters
    ----------
    over : str, or (str, array_like)
        What varies, as for `stickslip.parameter_map`: ``duffing=0:200:64``, ``hold=0.25,0.5,1``, a name and values.
    groups, scene, hold, tolerance, threads
        As for `stickslip.lyapunov_spectrum`: of the body that is varied.
    inputs : Inputs or str
        As for `stickslip.parameter_map`, "bits" or "word:0011" for two; every value gets the same ones.
    holds : int
        Of each run, from rest.
    washout : int
        Of these at the start, that nothing is told of.
    seeds : int, >= 1
        Runs of each value, each with its own input; 1 where the input is a word without dither.
    on_progress : callable, optional
        Told how many values are done, of how many: at first, and after each few.

    Returns
    -------
    BifurcationDiagram

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid; the message names it.
    SolverError
        As `stickslip.lyapunov_spectrum`.
    """
    name, values = axis_of("over", over)
    ensemble, body, ground = Inputs.of(inputs), Groups.of(groups), Scene.of(scene)
    seeds = whole_number("seeds", seeds, 1)
    if seeds > 1 and ensemble.dither == 0.0 and name != "dither":
        raise ValueError(f"seeds must be 1 for a word without dither, which is always the same, got {seeds}")
    bodies, valves = [], []
    for value in values:
        numbers = {} if name == "dither" else {name: value}
        bodies.append(varied(body, ground, hold, numbers))
        if name == "dither":
            ensemble = replace(ensemble, dither=value)
        valves.append(np.array([ensemble.drawn(holds, seed).valve for seed in range(seeds)]))
    every = 1 if ensemble.dither else len(ensemble.word)
    spectra: list[LyapunovSpectrum] = []
    sections = []
    for first in range(0, len(values), _TOGETHER):
        if on_progress is not None:
            on_progress(first, len(values))
        some = slice(first, first + _TOGETHER)
        each, scenes, lengths = (list(column) for column in zip(*bodies[some], strict=True))
        together = np.array(valves[some])
        found = lyapunov_spectrum(
            each, together, np.array(lengths), scene=scenes, tolerance=tolerance, washout=washout, threads=threads
        )
        spectra += [found[row] for row in range(len(each))]
        motion = simulate(
            np.repeat(np.array(each, object), seeds).tolist(),
            together.reshape(-1, holds),
            np.repeat(lengths, seeds),
            scene=np.repeat(np.array(scenes, object), seeds).tolist(),
            tolerance=tolerance,
            threads=threads,
        )
        last = motion.deformation[:, washout:][:, ::-1][:, ::every][:, : max(1, _SECTIONS // seeds)]
        sections.append(last.reshape(len(each), -1))
    if on_progress is not None:
        on_progress(len(values), len(values))
    return BifurcationDiagram(name, np.array(values), np.concatenate(sections), tuple(spectra), ensemble)
