"""The body as a reservoir: driven by a series from rest, and read several times a sample."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...common.validation import known_names, number_within, whole_number
from ...crawler import ChainState, Groups, GroupsLike, Scene, simulate, State, Trajectory
from ...crawler.arguments import TOLERANCES
from ...crawler.model.holds import natural_hold
from ...crawler.model.tube import is_chain
from ...crawler.model.variations import varied
from ..encodings import encode, known_encoding, unit_series
from .reservoir import Step

__all__ = ["READINGS", "BodyReservoir", "body_states", "crawler_states"]

READINGS = ("deformation", "velocity", "pressure")
"""What is read of a body by default; of a chain the first two of every segment."""

_READABLE = (*READINGS, "foot_velocity")


@dataclass(frozen=True)
class BodyReservoir:
    """A body driven from rest by a series, and read several times a sample.

    Attributes
    ----------
    groups : Groups, str, mapping, Actuator or None
        As in `Groups.of`.
    scene : Scene, mapping or None
        As in `Scene.of`. Of a chain every segment is read.
    hold : float or str, in (0, inf)
        Length of a hold, as in `simulate`: natural units, or "20 ms" where groups is an `Actuator`. Natural as an
        attribute.
    encoding : {"pulse_width", "threshold", "sigma_delta"}
        How a sample becomes what the valve does; of bits, as they are, by the first two.
    holds_per_sample : int, at least 1
        Holds that each sample lasts.
    virtual_nodes : int, at least 1
        Readings a sample, equally spaced in time, the last at its end.
    readings : sequence of str
        Some of "deformation", "velocity", "pressure" and "foot_velocity".
    tolerance : float
        As in `simulate`.

    Raises
    ------
    TypeError, ValueError
        If an attribute is invalid.
    """

    groups: Any = None
    scene: Any = None
    hold: Any = 0.5
    encoding: str = "pulse_width"
    holds_per_sample: int = 1
    virtual_nodes: int = 4
    readings: Sequence[str] = READINGS
    tolerance: float = 1e-9

    def __post_init__(self) -> None:
        known_encoding(self.encoding)
        readings = (self.readings,) if isinstance(self.readings, str) else tuple(self.readings)
        known_names("readings", readings, _READABLE)
        if not readings or len(set(readings)) < len(readings):
            raise ValueError(f"readings must hold at least one reading and none twice, got {list(readings)}")
        for name, value in (
            ("groups", Groups.of(self.groups)),
            ("scene", Scene.of(self.scene)),
            ("hold", natural_hold(self.hold, self.groups)),
            ("holds_per_sample", whole_number("holds_per_sample", self.holds_per_sample, 1)),
            ("virtual_nodes", whole_number("virtual_nodes", self.virtual_nodes, 1)),
            ("readings", readings),
            ("tolerance", number_within("tolerance", self.tolerance, TOLERANCES)),
        ):
            object.__setattr__(self, name, value)

    @property
    def feature_names(self) -> list[str]:
        """Names of the states' columns: reading by reading, segment by segment, in order of time."""
        return [
            f"{reading}{segment}_{node}"
            for reading in self.readings
            for segment in self._segments(reading)
            for node in range(self.virtual_nodes)
        ]

    @property
    def features(self) -> int:
        """Number of the states' columns."""
        return len(self.feature_names)

    @property
    def samples_per_hold(self) -> int:
        """Of the motion: the fewest among which the readings are."""
        return int(self.virtual_nodes // np.gcd(self.virtual_nodes, self.holds_per_sample))

    def __call__(self, series: ArrayLike, seed: int = 0) -> NDArray[np.float64]:
        """Drive the body; nothing in it is random.

        Parameters
        ----------
        series : array_like of shape (samples,), in [0, 1]
        seed : int
            Of no matter here.

        Returns
        -------
        ndarray of shape (samples, features)
            Row k is read during sample k and has absorbed it.

        Raises
        ------
        ValueError
            If `series` has a wrong shape or a number out of range.
        """
        return self.read(self._driven(self.groups, series))

    def varied(self, numbers: Mapping[str, float]) -> "BodyReservoir":
        """The body with some numbers changed, as `stickslip.crawler.model.variations` names them.

        Parameters
        ----------
        numbers : mapping of str to float
            Such as ``{"duffing": 2.0, "slope": 0.1, "hold": 0.25}``.

        Returns
        -------
        BodyReservoir

        Raises
        ------
        ValueError
            If a name is unknown or a number out of range.
        """
        groups, scene, hold = varied(self.groups, self.scene, self.hold, numbers)
        return replace(self, groups=groups, scene=scene, hold=hold)

    def stepper(self, series: ArrayLike, seed: int = 0) -> Step:
        """Drive the body from rest by a series, and step it on from there.

        Parameters
        ----------
        series, seed
            As in a call.

        Returns
        -------
        callable
            A :data:`Step`: the rows that a longer series would have.
        """
        values = list(unit_series("series", series))
        state = self._driven(self.groups, series).final_state

        def step(value: float) -> NDArray[np.float64]:
            nonlocal state
            values.append(value)
            # What an encoding owes from earlier samples is in the whole schedule alone.
            valve = encode(values, self.encoding, self.holds_per_sample)[-self.holds_per_sample :]
            motion = self._moved(self.groups, valve, state)
            state = motion.final_state
            states: NDArray[np.float64] = self.read(motion)[-1]
            return states

        return step

    def on_grounds(self, series: ArrayLike, grounds: Sequence[tuple[float, float]]) -> NDArray[np.float64]:
        """Drive the body by the same series on grounds of other friction, each from rest.

        Parameters
        ----------
        series : array_like of shape (samples,), in [0, 1]
        grounds : sequence of (float, float)
            Static and kinetic friction groups.

        Returns
        -------
        ndarray of shape (grounds, samples, features)

        Raises
        ------
        ValueError
            If an argument is out of range.
        """
        crawlers = [replace(self.groups, static_friction=s, kinetic_friction=k) for s, k in grounds]
        return self.read(self._driven(crawlers, series))

    def _driven(self, groups: Groups | list[Groups], series: ArrayLike) -> Trajectory:
        return self._moved(groups, encode(series, self.encoding, self.holds_per_sample), None)

    def _moved(
        self, groups: Groups | list[Groups], valve: NDArray[Any], initial: State | ChainState | None
    ) -> Trajectory:
        return simulate(
            groups,
            valve,
            self.hold,
            scene=self.scene,
            tolerance=self.tolerance,
            samples_per_hold=self.samples_per_hold,
            initial=initial,
        )

    def read(self, motion: Trajectory) -> NDArray[np.float64]:
        """The states in a motion of such a body, or of several: (samples, features), or one more axis in front."""
        signals = [self._signal(motion, reading) for reading in self.readings]
        rows = motion.valve.shape[-1] // self.holds_per_sample
        return np.concatenate([_columns(signal, rows, self.virtual_nodes) for signal in signals], axis=-1)

    def _signal(self, motion: Trajectory, reading: str) -> NDArray[np.float64]:
        """A reading, shape (..., segments, samples)."""
        if self._segments(reading) != [""]:
            parts: NDArray[np.float64] = getattr(motion, f"segment_{reading}")
            return parts
        whole: NDArray[np.float64] = getattr(motion, reading)
        return whole[..., None, :]

    def _segments(self, reading: str) -> list[str]:
        """What tells a reading's segments apart in a name; the pressure and the foot are one."""
        if is_chain(self.scene) and reading in ("deformation", "velocity"):
            return [str(segment) for segment in range(self.scene.segments)]
        return [""]


def _columns(signal: NDArray[np.float64], rows: int, nodes: int) -> NDArray[np.float64]:
    """Lay (..., segments, samples) out as (..., rows, segments * nodes), keeping equally spaced samples."""
    of_row = signal.reshape(*signal.shape[:-1], rows, -1)
    stride = of_row.shape[-1] // nodes
    kept = np.swapaxes(of_row[..., stride - 1 :: stride], -3, -2)
    return kept.reshape(*kept.shape[:-2], -1)


def crawler_states(
    valve: ArrayLike,
    *,
    groups: GroupsLike | None = None,
    hold: float | str = 0.5,
    virtual_nodes: int = 4,
    scene: Scene | Mapping[str, Any] | None = None,
    tolerance: float = 1e-9,
) -> NDArray[np.float64]:
    """Drive the crawler from rest and read its body several times a hold.

    Parameters
    ----------
    valve : array_like of shape (holds,), in [0, 1]
        Valve states or duty cycles.
    groups, hold, virtual_nodes, scene, tolerance
        As in :class:`BodyReservoir`.

    Returns
    -------
    ndarray of shape (holds, features)
        Row k is read during hold k and has absorbed ``valve[k]``.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.
    """
    body = BodyReservoir(groups=groups, scene=scene, hold=hold, virtual_nodes=virtual_nodes, tolerance=tolerance)
    return body(unit_series("valve", valve))


def body_states(motion: Trajectory) -> NDArray[np.float64]:
    """Lay the body's motion out as a reservoir's states, one row a hold.

    Parameters
    ----------
    motion : Trajectory

    Returns
    -------
    ndarray of shape (holds, 3 * samples_per_hold), or (batch, holds, 3 * samples_per_hold)
        Deformations come first, then velocities, then pressures, each in order of time.
    """
    readings = [getattr(motion, reading) for reading in READINGS]
    return np.concatenate([each.reshape(*motion.valve.shape, -1) for each in readings], axis=-1)
