"""Memory of linear bodies against their modes, exactly and measured."""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm, solve_discrete_lyapunov

from ...crawler import Groups, simulate
from ...reservoir import memory_capacity
from ...tasks import body_states, dithered
from .study import Study
from .wording import Told

__all__ = ["exact_profile", "modes"]


def exact_profile(groups: Groups, hold: float, delays: int) -> NDArray[np.float64]:
    """Memory of a linear anchored body, raw states and fair bits, exactly: b' A'^d C^-1 A^d b with C = A C A' + b b'.

    H. Jaeger, "Short term memory in echo state networks", GMD Report 152, 2001; O. L. White, D. D. Lee and
    H. Sompolinsky, Physical Review Letters 92, 148102, 2004.
    """
    payload, lag = 1.0 - groups.foot_mass_fraction, groups.deborah
    rates = np.array(
        [
            [0.0, 1.0, 0.0],
            [-1.0 / payload, -2.0 * groups.damping_ratio / payload, 1.0 / payload],
            [0.0, 0.0, -1.0 / lag],
        ]
    )
    flow = expm(rates * hold)
    impulse = np.linalg.solve(rates, flow - np.eye(3)) @ np.array([0.0, 0.0, 1.0 / lag])
    covariance = solve_discrete_lyapunov(flow, np.outer(impulse, impulse))
    profile, response = [], impulse
    for _ in range(delays):
        profile.append(float(response @ np.linalg.solve(covariance, response)))
        response = flow @ response
    return np.array(profile)


def modes(study: Study) -> Told:
    """Linear anchored bodies: memory by delay, exactly and measured, beside the rates of the body's modes."""
    rows = [
        [
            "Π₂",
            "Π₄",
            "λ",
            "−1/Π₄",
            "memory in all, exactly",
            "to delay 20, exactly",
            "measured",
            "mean delay",
            "half-life of the profile's tail",
            "ln 2 / (2 abs(rate) hold)",
        ]
    ]
    told, delays, holds = {}, 3000, 4 * study.size.holds
    valve = dithered(np.zeros(holds, np.int64), 0.5, 0)
    for damping in (0.02, 0.05, 0.2):
        for deborah in (0.05, 0.5, 5.0):
            groups = Groups(duffing=0.0, radial_coupling=0.0, damping_ratio=damping, deborah=deborah)
            exact = exact_profile(groups, 0.5, delays)
            states = body_states(simulate(groups, valve, 0.5, scene={"anchored": True}))
            measured = memory_capacity(states, valve - 0.5, 20)
            rate = -damping / (1.0 - groups.foot_mass_fraction)
            slowest = max(rate, -1.0 / deborah)
            tail = np.cumsum(exact[::-1])[::-1]
            first = int(np.flatnonzero(tail > 1e-9)[-1])
            middle = first // 2
            half_life = np.log(2.0) * (first - middle) / np.log(tail[middle] / tail[first])
            rows.append(
                [
                    f"{damping:g}",
                    f"{deborah:g}",
                    f"{rate:.4f}",
                    f"{-1.0 / deborah:.2f}",
                    f"{exact.sum():.3f}",
                    f"{exact[:20].sum():.3f}",
                    f"{measured.total:.3f}",
                    f"{np.arange(delays) @ exact / exact.sum():.1f}",
                    f"{half_life:.1f}",
                    f"{np.log(2.0) / (2.0 * -slowest * 0.5):.1f}",
                ]
            )
            told[f"Π₂ {damping:g}, Π₄ {deborah:g}"] = {
                "exact": exact.sum(),
                "to 20": exact[:20].sum(),
                "measured": measured.total,
            }
    return rows, told
