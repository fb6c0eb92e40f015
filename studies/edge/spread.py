"""The spread of work over inputs, and over starts that hardly differ."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...crawler import Groups, lyapunov_spectrum, simulate, State
from ...tasks import dithered
from .study import PLACES, Study
from .wording import Told

__all__ = ["spread_of_work"]


def spread_of_work(study: Study) -> Told:
    """How much work differs over inputs, and over starts that differ by a thousandth under one input."""
    inputs, holds, washout = 20, study.size.holds, study.size.holds // 3
    starts = [State(deformation=0.001 * k) for k in range(6)]
    rows = [["scene", "Π₁", "Π₄", "λ", "work a hold", "spread over inputs", "spread over starts", "share of starts"]]
    told = {}
    valves = np.array([dithered(np.zeros(holds, np.int64), 0.5, seed) for seed in range(inputs)])
    for place, scene in PLACES.items():
        for duffing in (0.5, 20.0, 200.0):
            for deborah in (0.05, 0.5, 5.0):
                groups = Groups(damping_ratio=0.02, duffing=duffing, deborah=deborah)
                works = np.array([work_between(groups, valves, scene, start, washout) for start in starts])
                over_inputs = float(works[0].std(ddof=1))
                over_starts = float(np.sqrt(works.var(axis=0, ddof=1).mean()))
                found = lyapunov_spectrum(groups, valves[:4], 0.5, scene=scene, washout=washout, tolerance=1e-6)
                exponent, error = found.exponents[0], found.standard_error[0]
                share = over_starts / over_inputs
                rows.append(
                    [
                        place,
                        f"{duffing:g}",
                        f"{deborah:g}",
                        f"{exponent:.3f} ± {error:.3f}",
                        f"{works.mean():.2g}",
                        f"{over_inputs:.2g}",
                        f"{over_starts:.1g}",
                        f"{share:.1g}",
                    ]
                )
                told[f"{place}, Π₁ {duffing:g}, Π₄ {deborah:g}"] = {
                    "exponent": exponent,
                    "share": share,
                    "over inputs": over_inputs,
                }
    return rows, told


def work_between(
    groups: Groups, valves: NDArray[np.int64], scene: Mapping[str, Any], start: State, washout: int
) -> NDArray[np.float64]:
    """Work a hold after the washout, for each input."""
    whole, before = (
        simulate(groups, given, 0.5, scene=scene, initial=start, tolerance=1e-6).work
        for given in (valves, valves[:, :washout])
    )
    return np.asarray(whole - before) / (valves.shape[1] - washout)
