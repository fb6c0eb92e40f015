"""The simulator in the place of a robot."""

from collections.abc import Mapping, Sequence
from typing import Any, TYPE_CHECKING

from ..common.validation import known_names, number_within
from ..crawler.model.actuator import Actuator
from ..crawler.model.scene import Scene
from .clock import Clock
from .sensors import SENSORS

if TYPE_CHECKING:
    from ..crawler.model.state import State

__all__ = ["SimulatedPlant"]


class SimulatedPlant:
    """A simulated body behind `read` and `write`, which moves as a clock goes.

    From one write to the next it is moved in one piece, as the environment moves it in a hold. It needs the simulator,
    and with it numba.

    Parameters
    ----------
    actuator : Actuator
    clock : Clock
        The runner's own.
    scene : Scene or mapping, optional
        Of one massless segment, on the ground with a ratcheted foot by default.
    tolerance : float
        Of the solver; that of the environment by default.
    sensors : sequence of str
        Those of :data:`SENSORS` that it has, all by default; of a robot without sensors of velocity
        ``("deformation", "pressure", "foot")``.

    Raises
    ------
    TypeError, ValueError
        If an argument is out of range or of the wrong type.
    """

    def __init__(
        self,
        actuator: Actuator,
        clock: Clock,
        *,
        scene: Scene | Mapping[str, Any] | None = None,
        tolerance: float = 1e-6,
        sensors: Sequence[str] = tuple(SENSORS),
    ) -> None:
        from ..crawler.simulation import simulate  # takes numba, which a robot does without

        known_names("sensors", sensors, SENSORS)
        self._simulate = simulate
        self._scales, self._groups, self._clock = actuator.scales, actuator.groups, clock
        self._scene, self._sensors = Scene.of(scene), tuple(sensors)
        self._tolerance = number_within("tolerance", tolerance, "[1e-15, 1e-2]")
        self._valve = 0
        self._turned = self._seen = clock.now()
        self._at_turn: State | None = None  # at rest
        self._now: State | None = None
        # Kernels are compiled now, not between two deadlines.
        simulate(self._groups, [1], 0.5, scene=self._scene, tolerance=self._tolerance)

    def read(self) -> dict[str, float]:
        """What its sensors tell now, in SI units: such as ``{"deformation_m": 0.004, "pressure_Pa": 11e3}``."""
        state = self._moved()
        units = self._scales.length, self._scales.length / self._scales.time
        z, v, p, x, w = (0.0,) * 5 if state is None else state
        told = {
            "deformation": ("deformation_m", z * units[0]),
            "velocity": ("velocity_m_s", v * units[1]),
            "pressure": ("pressure_Pa", p * self._scales.pressure),
            "foot": ("foot_m", x * units[0]),
            "foot_velocity": ("foot_velocity_m_s", w * units[1]),
            "payload": ("payload_m", (x + z) * units[0]),
        }
        return dict(told[name] for name in self._sensors)

    def write(self, valve: int) -> None:
        """Open the valve by 1, shut it by 0.

        Raises
        ------
        ValueError
            If it is neither.
        """
        if valve not in (0, 1):
            raise ValueError(f"valve must be 0 or 1, got {valve!r}")
        self._at_turn = self._moved()
        self._turned = self._seen
        self._valve = int(valve)

    def _moved(self) -> "State | None":
        """Where the body is now."""
        now = self._clock.now()
        if now > self._seen:
            self._seen = now
            moved = self._simulate(
                self._groups,
                [self._valve],
                (now - self._turned) / self._scales.time,
                scene=self._scene,
                tolerance=self._tolerance,
                initial=self._at_turn,
            )
            self._now = moved.final_state  # type: ignore[assignment]
        return self._now
