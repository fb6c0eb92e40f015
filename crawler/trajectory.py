"""What a simulation returns."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .model.actuator import Actuator
from .model.groups import Groups
from .model.scene import Scene
from .model.state import ChainState, State

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["EVENT", "Trajectory"]

EVENT = np.dtype([("time", np.float64), ("mode", np.int8), ("crawler", np.int64)])
"""One change of the foot's motion: its time, the motion that begins (0 sticks, 1 slides forward, -1 backward), and
the crawler's place in the batch (0 for one)."""

# Relative; the groups that are made of SI numbers take a dozen roundings.
_ROUNDING = 1e-12


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Sampled motion of one crawler, or of a batch.

    Sample j of hold k is taken at (k + (j + 1) / samples_per_hold) * hold: the last sample of a hold is its end, and
    the initial state is not among the samples. Natural units (z_c, t_c, P_max A_0), or SI after :meth:`in_si`.

    Attributes
    ----------
    time : (samples,) array, or (batch, samples) where the holds differ
        Else shared by the batch.
    deformation, velocity : (..., samples) arrays
        z = X_p - X_f - L_0 and its rate.
    pressure : (..., samples) array
        In [0, 1], or pascal.
    foot, foot_velocity : (..., samples) arrays
        Position of the foot, 0 at the start unless `initial` says otherwise, and its rate.
    segment_deformation, segment_velocity : (..., segments, samples) arrays
        Stretch of each segment and its rate, the one behind first; they sum to `deformation` and `velocity`.
    valve : (..., holds) array of int8, or of float64 where floats were given
        The input that was applied: 0, 1, or the share of the hold for which the valve was open.
    slips : int or (...) array of int
        How often the foot broke loose.
    events : (events,) structured array of dtype :data:`EVENT`
        Every change of motion, crawler by crawler in order of time.
    work : float or (...) array
        Done by the pressure, int P dV (equation S28).
    stored : float or (...) array
        Growth of kinetic and elastic energy, and on a slope of potential energy.
    viscous_loss, friction_loss : float or (...) array
        Dissipated in the elastomer and under the foot.
    energy_scale : float or (...) array
        Sum of all energies without their signs, to which `energy_residual` is to be compared: what the pressure, the
        slope and the losses gave or took in each step, and what was stored at the start and at the end.
    hold : float, or (batch,) array
    model : str
        What was integrated, and by which solver.
    groups : Groups or tuple of Groups
        That were simulated, one a crawler of a batch.
    scene : Scene or tuple of Scene
        That they were simulated in, likewise.
    initial : State or ChainState
        Where the motion began, in the units of the arrays.
    condition : float or (...) array or None
        Where `simulate` was asked for it, the factor by which a small change of the start grows until the end: the
        greatest ratio of the change of deformation, velocity, foot and foot velocity at the end to that of deformation
        and velocity, and of foot velocity if the foot slides, at the start, both in natural units and as the root of
        the sum of their squares. The answer is known to no more digits than this leaves of the tolerance.
    actuator : Actuator or None
        Whose SI units the arrays are in; None for natural units.
    """

    time: NDArray[np.float64]
    deformation: NDArray[np.float64]
    velocity: NDArray[np.float64]
    pressure: NDArray[np.float64]
    foot: NDArray[np.float64]
    foot_velocity: NDArray[np.float64]
    segment_deformation: NDArray[np.float64]
    segment_velocity: NDArray[np.float64]
    valve: NDArray[Any]
    slips: Any
    events: NDArray[np.void]
    work: Any
    stored: Any
    viscous_loss: Any
    friction_loss: Any
    energy_scale: Any
    hold: Any
    model: str
    groups: Groups | tuple[Groups, ...]
    scene: Scene | tuple[Scene, ...]
    initial: State | ChainState
    condition: Any = None
    actuator: Actuator | None = None

    def __repr__(self) -> str:
        holds, samples = self.valve.shape[-1], self.time.shape[-1]
        length, time, energy = ("z_c", "t_c", "P_max A_0 z_c") if self.actuator is None else ("m", "s", "J")
        members = [self.groups] if isinstance(self.groups, Groups) else self.groups
        kinds = list(dict.fromkeys(members))
        crawlers = "one crawler" if isinstance(self.groups, Groups) else f"{len(members)} crawlers"
        units = "natural units" if self.actuator is None else "SI"
        lines = (
            f"Trajectory of {crawlers} in {units}: {holds} holds of {_spread(self.hold)} {time}, "
            f"{samples // holds} samples a hold",
            f"  groups  {kinds[0]}" + (f" and {len(kinds) - 1} more" if len(kinds) > 1 else ""),
            f"  model   {self.model}",
            f"  foot    at {_spread(self.foot[..., -1])} {length} after {_spread(self.slips)} slips",
            f"  energy  work {_spread(self.work)}, stored {_spread(self.stored)}, viscous loss "
            f"{_spread(self.viscous_loss)}, friction loss {_spread(self.friction_loss)}, residual "
            f"{_spread(self.energy_residual)} of {_spread(self.energy_scale)} {energy}",
        )
        return "\n".join(lines)

    @property
    def payload(self) -> NDArray[np.float64]:
        """Displacement of the payload X_p from its start at rest, shape (..., samples)."""
        return self.foot + self.deformation

    @property
    def dissipation(self) -> Any:
        """Energy lost in the elastomer and under the foot, float or shape (...)."""
        return self.viscous_loss + self.friction_loss

    @property
    def energy_residual(self) -> Any:
        """Work less stored less dissipated energy: zero but for the solver's error, float or shape (...)."""
        return self.work - self.stored - self.dissipation

    @property
    def final_state(self) -> State | ChainState:
        """The last sample of one crawler, from which `simulate` can go on as its `initial`; segment by segment if many.

        Raises
        ------
        ValueError
            If the trajectory is a batch or in SI.
        """
        if self.deformation.ndim != 1 or self.actuator is not None:
            raise ValueError("final_state is of one crawler in natural units, got a batch or a trajectory in SI")
        last = {name: float(getattr(self, name)[-1]) for name in State._fields}
        if len(self.segment_deformation) == 1:
            return State(**last)
        segments = (self.segment_deformation[:, -1].copy(), self.segment_velocity[:, -1].copy())
        return ChainState(*segments, *(last[name] for name in ChainState._fields[2:]))

    def in_si(self, actuator: Actuator) -> Trajectory:
        """The same motion in metres, seconds, pascals and joules.

        Parameters
        ----------
        actuator : Actuator
            Whose scales to use; its groups are those that were simulated, but for roundings.

        Returns
        -------
        Trajectory

        Raises
        ------
        TypeError
            If `actuator` is none.
        ValueError
            If the trajectory is in SI already, or of other groups than the actuator's; the message names one.
        """
        if not isinstance(actuator, Actuator):
            raise TypeError(f"actuator must be an Actuator, got {actuator!r}")
        if self.actuator is not None:
            raise ValueError("trajectory is in SI already; in_si takes one in natural units")
        self._refuse_other(actuator.groups)
        scales = actuator.scales
        factor = {
            "time": scales.time,
            "hold": scales.time,
            "deformation": scales.length,
            "foot": scales.length,
            "velocity": scales.length / scales.time,
            "segment_deformation": scales.length,
            "segment_velocity": scales.length / scales.time,
            "foot_velocity": scales.length / scales.time,
            "pressure": scales.pressure,
            **dict.fromkeys(("work", "stored", "viscous_loss", "friction_loss", "energy_scale"), scales.energy),
        }
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        for name, scale in factor.items():
            values[name] = values[name] * scale
        values["events"] = self.events.copy()
        values["events"]["time"] *= scales.time
        start = self.initial._asdict()
        values["initial"] = type(self.initial)(
            **{name: np.multiply(start[name], factor[name]).tolist() for name in start}
        )
        values["actuator"] = actuator
        return Trajectory(**values)

    def _refuse_other(self, groups: Groups) -> None:
        members = (self.groups,) if isinstance(self.groups, Groups) else self.groups
        for index, simulated in enumerate(members):
            for name, value in groups.to_dict().items():
                own = getattr(simulated, name)
                if not math.isclose(value, own, rel_tol=_ROUNDING):
                    where = "" if len(members) == 1 else f" of crawler {index}"
                    raise ValueError(
                        f"actuator must have the groups that were simulated, {name} = {own!r}{where}, got {value!r}"
                    )

    def plot(self) -> Figure:
        """Foot, payload, valve and pressure against time, as in the paper's Figure 1.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        ValueError
            If the trajectory is a batch.
        """
        from .trajectory_figure import plot_trajectory  # matplotlib is optional, and slow to import

        return plot_trajectory(self)

    def animate(
        self, file: Path | str, *, slow_motion: float = 1.0, start: float = 0.0, stop: float | None = None
    ) -> Path:
        """Write a film of the motion: the crawler, or the anchored body, segment by segment, and what it has just done.

        Each picture is one of the samples, so nothing in it is made up between them; the first is where the motion
        began. The film has 30 pictures a second, in which at most 2 t_c pass. Its words are in mm, s and kPa where the
        trajectory is in SI (:meth:`in_si`), and then a slope is as steep as it is, else as its number; at most 7
        degrees are drawn.

        Parameters
        ----------
        file : Path or str
            What is written, whole or not at all: a film if it ends in ``.mp4``, a small animation in ``.gif``, a page
            with a player in ``.html``, which needs nothing else.
        slow_motion : float, in [0.01, 1000]
            2 makes the film twice as slow, which needs twice as many samples.
        start, stop : float
            Part of the motion that is shown, in the units of `time`; all of it by default.

        Returns
        -------
        Path
            Of the file.

        Raises
        ------
        TypeError, ValueError
            If an argument is wrong, if the trajectory is a batch, or if it has too few samples a hold for a film that
            is smooth; the message tells how many it needs.
        FileNotFoundError
            If the file's folder is missing.
        stickslip.common.extras.MissingExtra
            Without the extra ``render``.
        """
        from .drawing.animation import animate  # what draws and writes films is optional, and slow to import

        return animate(self, file, slow_motion=slow_motion, start=start, stop=stop)


def _spread(values: Any) -> str:
    """One number, or the least and the greatest of several."""
    low, high = np.min(values), np.max(values)
    return f"{low:.6g}" if np.ndim(values) == 0 or low == high else f"{low:.6g} to {high:.6g}"
