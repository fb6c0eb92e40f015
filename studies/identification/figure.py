"""The figure of a fit. Importing this imports matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...common.extras import optional_import
from ...common.figures import house_style, OKABE_ITO
from ...crawler import Actuator
from .prediction import predicted

with optional_import():
    from matplotlib import pyplot as plt
    from matplotlib.figure import Figure

if TYPE_CHECKING:
    from .identification import Identification

__all__ = ["plot_fit"]

_TOLERANCE = 1e-9
_RATES, _PRESSURES = ("velocity", "foot_velocity"), ("pressure",)
# Powers of ten by which SI is brought to the numbers of a small robot.
_SI = {"m": (1e3, "mm"), "m/s": (1e3, "mm/s"), "Pa": (1e-3, "kPa")}


def plot_fit(found: Identification, run: int) -> Figure:
    """Each channel of a run as it was measured and as the fit has it, and below it what is left.

    Parameters
    ----------
    found : Identification
    run : int
        Its place among `found.runs`.

    Returns
    -------
    matplotlib.figure.Figure
    """
    measured = found.runs[run]
    names = measured.measured
    fitted = predicted([found.body], measured, found.scene, _TOLERANCE)
    si = isinstance(found.body, Actuator)
    with house_style():
        figure, panels = plt.subplots(
            2 * len(names),
            1,
            sharex=True,
            squeeze=False,
            figsize=(7.0, 0.6 + 2.4 * len(names)),
            layout="constrained",
            height_ratios=[3.0, 1.0] * len(names),
        )
        for k, name in enumerate(names):
            above, below = panels[2 * k, 0], panels[2 * k + 1, 0]
            factor, unit = _unit(name, si)
            values, curve = getattr(measured, name) * factor, fitted[name][0] * factor
            color = OKABE_ITO[k % len(OKABE_ITO)]
            _shade(above, measured.valve, measured.hold)
            above.plot(measured.times, values, ".", ms=3, color="0.45", label="measured")
            above.plot(measured.times, curve, color=color, label="fit")
            above.set_ylabel(f"{name.replace('_', ' ')} ({unit})")
            below.axhline(0.0, color="0.6", lw=0.6, zorder=0)
            below.plot(measured.times, values - curve, ".", ms=3, color=color)
            left = found.noise[name] * factor
            below.set(ylabel=f"residual\n({unit})", ylim=(-4.0 * left, 4.0 * left) if left > 0.0 else None)
            if k == 0:
                above.legend(loc="lower right", ncols=2, bbox_to_anchor=(1.0, 1.0))
        panels[-1, 0].set(xlabel=f"time ({'s' if si else '$t_c$'})", xlim=(0.0, measured.valve.size * measured.hold))
        figure.align_ylabels()
    return figure


def _unit(name: str, si: bool) -> tuple[float, str]:
    """By what a channel is multiplied, and the unit that it is then in."""
    rate, pressure = name in _RATES, name in _PRESSURES
    if si:
        return _SI["m/s" if rate else "Pa" if pressure else "m"]
    return 1.0, "$z_c/t_c$" if rate else "$P_{max}$" if pressure else "$z_c$"


def _shade(axes: plt.Axes, valve: np.ndarray, hold: float) -> None:
    """Shade the time in which the valve is open."""
    for k, duty in enumerate(valve.tolist()):
        if duty > 0.0:
            axes.axvspan(k * hold, (k + duty) * hold, color="0.92", lw=0, zorder=0)
