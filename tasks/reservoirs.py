"""What drives what: reservoirs as functions from a series in [0, 1] to states, one row a sample.

Each call starts at rest: nothing of one series is left in the next.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.validation import finite_array, known_names, number_within, whole_number
from ..crawler import ChainState, Groups, GroupsLike, Scene, simulate, State, Trajectory
from ..crawler.model.tube import is_chain
from ..crawler.model.variations import HOLDS, varied
from ..crawler.simulation import TOLERANCES
from ..reservoir import delay_line, EchoStateNetwork
from .encodings import encode, known_encoding, unit_series

__all__ = [
    "READINGS",
    "RESERVOIRS",
    "BodyReservoir",
    "DelayLine",
    "EchoState",
    "Reservoir",
    "Step",
    "body_states",
    "crawler_states",
    "known_reservoirs",
]

Reservoir = Callable[[NDArray[Any], int], NDArray[np.float64]]
"""Takes a series (length,) in [0, 1] and a seed for what in it is random; gives states (length, features).

One that has `candidates`, a sequence of reservoirs, is tuned by the benchmark, on training data alone. One that has
`on_grounds`, as :class:`BodyReservoir` has, can tell the ground it crawls on. One that has `stepper`, a function of a
series and a seed that gives a :data:`Step`, is stepped on from the end of that series and not driven anew.
"""

Step = Callable[[float], NDArray[np.float64]]
"""Takes the next sample of a series, in [0, 1], and gives the states (features,) that have absorbed it."""

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
    hold : float, in (0, inf)
        Length of a hold, natural units.
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
    hold: float = 0.5
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
            ("hold", number_within("hold", self.hold, HOLDS)),
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
        return self._read(self._driven(self.groups, series))

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
            states: NDArray[np.float64] = self._read(motion)[-1]
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
        return self._read(self._driven(crawlers, series))

    def _driven(self, groups: Groups | list[Groups], series: ArrayLike) -> Trajectory:
        return self._moved(groups, encode(series, self.encoding, self.holds_per_sample), None)

    def _moved(
        self, groups: Groups | list[Groups], valve: NDArray[Any], initial: State | ChainState | None
    ) -> Trajectory:
        often = self.virtual_nodes // np.gcd(self.virtual_nodes, self.holds_per_sample)
        return simulate(
            groups,
            valve,
            self.hold,
            scene=self.scene,
            tolerance=self.tolerance,
            samples_per_hold=int(often),
            initial=initial,
        )

    def _read(self, motion: Trajectory) -> NDArray[np.float64]:
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


@dataclass(frozen=True)
class DelayLine:
    """The shift register with so many taps: perfect memory, and no computation.

    Attributes
    ----------
    features : int, at least 1
    """

    features: int

    def __post_init__(self) -> None:
        whole_number("features", self.features, 1)

    def __call__(self, series: ArrayLike, seed: int = 0) -> NDArray[np.float64]:
        """States (samples, features) under `series` (samples,); nothing in it is random."""
        return delay_line(series, self.features)

    def stepper(self, series: ArrayLike, seed: int = 0) -> Step:
        """Go on from the end of a series."""
        taps = self(series, seed)[-1]

        def step(value: float) -> NDArray[np.float64]:
            nonlocal taps
            taps = np.concatenate([[value], taps[:-1]])
            return taps

        return step


_RADII = (0.5, 0.7, 0.9, 0.99)
_SCALINGS = (0.01, 0.05, 0.2, 1.0)


@dataclass(frozen=True)
class EchoState:
    """An echo-state network of so many nodes.

    Left at a default it is no fair baseline: what is best differs from task to task and from size to size. With `tune`
    it has `candidates`, of which the benchmark takes, for every task and seed, the one that does best within the
    training data.

    Attributes
    ----------
    features : int, at least 1
    spectral_radius, input_scaling : float
        As in `stickslip.reservoir.EchoStateNetwork`.
    tune : bool
        Whether the two are to be chosen.
    leak : float, in (0, 1]
        As in `stickslip.reservoir.EchoStateNetwork`.
    topology : {"random", "cycle", "orthogonal"}
        As in `stickslip.reservoir.EchoStateNetwork`: "cycle" is the simple cycle reservoir.
    centred : bool
        Whether the series u drives the network as 2 u - 1, so that tanh is odd about its middle.
    """

    features: int
    spectral_radius: float = 0.9
    input_scaling: float = 0.1
    tune: bool = False
    leak: float = 1.0
    topology: str = "random"
    centred: bool = False

    def __post_init__(self) -> None:
        self._network(0)

    @property
    def candidates(self) -> tuple["EchoState", ...]:
        """Networks of as many nodes over a grid of radii, input scalings and centred or not; none without `tune`."""
        if not self.tune:
            return ()
        return tuple(
            replace(self, spectral_radius=radius, input_scaling=scaling, centred=centred, tune=False)
            for radius, scaling, centred in product(_RADII, _SCALINGS, (False, True))
        )

    def __call__(self, series: ArrayLike, seed: int) -> NDArray[np.float64]:
        """States (samples, features) under `series` (samples,); the seed fixes the weights."""
        return self._network(seed).states(self._heard(finite_array("series", series, 1)))

    def stepper(self, series: ArrayLike, seed: int) -> Step:
        """Go on from the end of a series."""
        step = self._network(seed).stepper(self._heard(finite_array("series", series, 1)))
        return lambda value: step(self._heard(value))

    def _heard(self, series: Any) -> Any:
        return 2 * series - 1 if self.centred else series

    def _network(self, seed: int) -> EchoStateNetwork:
        return EchoStateNetwork(
            self.features,
            spectral_radius=self.spectral_radius,
            input_scaling=self.input_scaling,
            leak=self.leak,
            seed=seed,
            topology=self.topology,
        )


def known_reservoirs(features: int = 12, *, segments: int = 3, **body: Any) -> dict[str, Reservoir]:
    """Bodies, and the baselines beside them, of as many features.

    Pressure only, linear, anchored and crawler are one ladder: each adds one part of the body to the one before, in
    this order the valve's lag, the elastomer, what is nonlinear in it, and the stick-slip friction.

    Parameters
    ----------
    features : int
        At least 3 and a multiple of it, for three readings of the crawler at every virtual node. A chain has the
        largest multiple of its readings that is no more, and at least one of each.
    segments : int, at least 2
        Of the chain, whose tube weighs 0.3 of payload and foot.
    **body
        Arguments of :class:`BodyReservoir` for all bodies; `scene` for the crawler and, anchored or in pieces, for
        the others. Not `virtual_nodes` or `readings`.

    Returns
    -------
    dict of str to Reservoir
        "crawler", "anchored", "linear", "pressure only", "chain of N", "delay line", "echo-state network", "cycle
        reservoir" and "orthogonal network", of which the last three are tuned.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.
    """
    features = whole_number("features", features, len(READINGS))
    if features % len(READINGS):
        raise ValueError(f"features must be a multiple of {len(READINGS)}, got {features}")
    segments = whole_number("segments", segments, 2)
    crawler = BodyReservoir(virtual_nodes=features // len(READINGS), **body)
    anchored = replace(crawler, scene=replace(crawler.scene, anchored=True))
    tube_mass = crawler.scene.tube_mass or _TUBE_MASS
    chain = replace(crawler, scene=replace(crawler.scene, segments=segments, tube_mass=tube_mass), virtual_nodes=1)
    return {
        "crawler": crawler,
        "anchored": anchored,
        "linear": replace(anchored, groups=replace(crawler.groups, duffing=0.0, radial_coupling=0.0)),
        "pressure only": replace(anchored, readings=("pressure",), virtual_nodes=features),
        f"chain of {segments}": replace(chain, virtual_nodes=max(1, features // chain.features)),
        "delay line": DelayLine(features),
        "echo-state network": EchoState(features, tune=True),
        "cycle reservoir": EchoState(features, tune=True, topology="cycle"),
        "orthogonal network": EchoState(features, tune=True, topology="orthogonal"),
    }


_TUBE_MASS = 0.3

RESERVOIRS = known_reservoirs()
"""The reservoirs known by name, at 12 features. Add your own."""


def crawler_states(
    valve: ArrayLike,
    *,
    groups: GroupsLike | None = None,
    hold: float = 0.5,
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
        Of one crawler.

    Returns
    -------
    ndarray of shape (holds, 3 * samples_per_hold)
        Deformations come first, then velocities, then pressures, each in order of time.
    """
    return np.hstack([getattr(motion, reading).reshape(len(motion.valve), -1) for reading in READINGS])
