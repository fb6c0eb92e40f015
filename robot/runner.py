"""A policy at a fixed rate: read, decide, turn the valve, at instants that do not drift."""

from array import array
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..common.validation import number_within, whole_number
from ..crawler.model.actuator import Actuator
from ..crawler.model.holds import natural_hold
from .acting import acting, trained_in
from .clock import Clock, RealClock
from .log import Log, refuse_unwritable
from .observer import Observer
from .report import Report
from .sensors import Limits, readings_of, Sensors
from .valve import shut_at_the_end, turning

__all__ = ["Runner"]

_TIMES = ("woke", "reading", "deciding", "writing", "latency")


class Runner:
    """A policy, the sensors and the valve of a robot.

    Decision k falls on the instant ``start + k * hold`` of a monotonic clock, however long those before took: the
    sensors are read, the policy decides, the valve is turned. Between two decisions the sensors are read at equal
    distances, for velocities that are not measured, and for the log. Whatever ends a run, the valve is shut before
    anything else is done.

    Parameters
    ----------
    policy : Policy, model of Stable-Baselines3, or callable from observation to 0 or 1
        `stickslip.pretrained` and `stickslip.train.policies.read_policy` make the first.
    read : callable
        Returns a mapping of names with units to numbers, such as ``{"deformation_mm": 4.1, "foot_mm": 12.0,
        "pressure_kPa": 11.3}``; `SENSORS` has all of them. Positions count from where the body rested, pressures from
        that of the air. Two of deformation, foot and payload must be there; velocities that are not are slopes of
        these, and a pressure that is not follows the valve with the actuator's lag.
    write : callable
        Takes 1 to open the valve and 0 to shut it, or the volts that are given for these.
    actuator : Actuator
        The body in SI units, which makes readings dimensionless.
    hold : float or str, optional
        Between two decisions: t_c, or seconds as in "20 ms". By default that of the policy's training.
    readings : int, in [2, 1000]
        In each hold.
    window : int, in [2, 1000], optional
        Readings of a slope; as many as there are in a hold, and 4 at most, by default.
    dither : float, in [0, 0.5], optional
        Probability with which a command is flipped, which is the message to the body; that of the policy's training by
        default.
    seed : int
        Of the flips: those of an environment that is reset with it.
    volts : (float, float), optional
        Of the shut and of the open valve, for `write`.
    limits : mapping, optional
        Least and greatest that sensors may tell, such as ``{"pressure_kPa": (-2, 30)}``; beyond them the run ends.
    allowed : float, in (0, 1]
        Share of a hold after which a deadline counts as missed.
    clock : Clock, optional
        `RealClock` by default.

    Raises
    ------
    TypeError, ValueError
        If an argument is out of range or of the wrong type; the message names it.
    """

    def __init__(
        self,
        policy: Any,
        read: Callable[[], Mapping[str, float]],
        write: Callable[[Any], Any],
        *,
        actuator: Actuator,
        hold: float | str | None = None,
        readings: int = 8,
        window: int | None = None,
        dither: float | None = None,
        seed: int = 0,
        volts: tuple[float, float] | None = None,
        limits: Limits | None = None,
        allowed: float = 0.1,
        clock: Clock | None = None,
    ) -> None:
        trained = trained_in(policy)
        if not isinstance(actuator, Actuator):
            raise TypeError(f"actuator must be an Actuator, got {actuator!r}")
        if not callable(read):
            raise TypeError(f"read must be callable, got {read!r}")
        if hold is None and "hold" not in trained:
            raise ValueError("hold must be given, such as '20 ms', for a policy that does not say how it was trained")
        self._act, self._read, self._turn = acting(policy), read, turning(write, volts)
        self._natural = natural_hold(trained["hold"] if hold is None else hold, actuator)
        self._trained = natural_hold(trained["hold"], actuator) if "hold" in trained else None
        self.hold = self._natural * actuator.scales.time
        """Seconds between two decisions."""
        self._readings = whole_number("readings", readings, 2, 1000)
        self._window = whole_number("window", min(4, readings) if window is None else window, 2, 1000)
        self._dither = number_within("dither", trained.get("dither", 0.0) if dither is None else dither, "[0, 0.5]")
        self._seed = whole_number("seed", seed, 0)
        self._allowed = number_within("allowed", allowed, "(0, 1]") * self.hold
        self._limits, self._actuator = limits, actuator
        Sensors(limits)  # which refuses them before the first run
        self._history = whole_number("valve_history", trained.get("valve_history", 1), 1)
        self._ratchet = bool((trained.get("scene") or {}).get("ratchet", True))
        self._clock: Clock = RealClock() if clock is None else clock
        self._begin()

    def _begin(self) -> None:
        self.log = Log()
        """What the last run has read."""
        self._times = {name: array("d") for name in _TIMES}
        self._skipped = 0

    @property
    def report(self) -> Report:
        """How well the last run has kept its time so far, after an exception as well."""
        times: dict[str, NDArray[np.float64]] = {name: np.array(self._times[name]) for name in _TIMES}
        count = len(times["latency"])
        whole = {name: values[:count] for name, values in times.items()}
        return Report(count, self._skipped, self.hold, self._natural, self._trained, self._allowed, **whole)

    def run(self, holds: int | None = None, *, log: str | Path | None = None) -> Report:
        """Let the policy act, from a body at rest.

        Parameters
        ----------
        holds : int, optional
            How many; until something ends it by default.
        log : str or Path, optional
            File of comma-separated columns to write when the run is over, however it ended: ``time_s``, ``valve``,
            ``command`` and what was measured. The valve is what it is from this row on; it is empty where a reading
            came so late that the valve should have been turned before.

        Returns
        -------
        Report

        Raises
        ------
        SensorError
            If a sensor is missing, tells no number, or one outside its limits.
        RuntimeError
            If the valve cannot be shut at the end.
        OSError
            If the log cannot be written: before the run begins, if that can be known.
        BaseException
            What `read`, `write` or the policy raised, and interrupts; the valve is shut then.
        """
        count = None if holds is None else whole_number("holds", holds, 1)
        if log is not None:
            refuse_unwritable(Path(log))
        self._begin()
        try:
            with shut_at_the_end(self._turn):
                self._turn(0)
                self._drive(count)
        finally:
            if log is not None:
                self.log.write(Path(log))
        return self.report

    def _drive(self, holds: int | None) -> None:
        clock, hold, sensors = self._clock, self.hold, Sensors(self._limits)
        observer = Observer(self._actuator, self._history, ratchet=self._ratchet, window=self._window)
        flips = np.random.default_rng(self._seed)
        valve, k, start = 0, 0, clock.now()

        def look() -> tuple[float, dict[str, float]]:
            seen = clock.now() - start
            measured = sensors.measured(self._read())
            observer.see(seen, readings_of(measured), valve)
            return seen, measured

        while holds is None or k < holds:
            instant = k * hold
            clock.sleep_until(start + instant)
            seen, measured = look()
            read = clock.now() - start
            command = self._act(observer.observation)
            valve = 1 - command if flips.random() < self._dither else command
            decided = clock.now() - start
            self._turn(valve)
            turned = clock.now() - start
            self.log.add(seen, valve, command, measured)
            spent = seen - instant, read - seen, decided - read, turned - decided, turned - instant
            for name, value in zip(_TIMES, spent, strict=True):
                self._times[name].append(value)
            for j in range(1, self._readings):
                if turned - instant >= (j + 1) * hold / self._readings:
                    continue  # its time is over
                clock.sleep_until(start + instant + j * hold / self._readings)
                seen, measured = look()
                # Of a hold that is over nobody may take the valve for that of the next.
                self.log.add(seen, valve if seen < instant + hold else None, None, measured)
            late = int((clock.now() - start - instant) / hold)
            skipped = max(0, late - 1)
            if holds is not None:
                skipped = min(skipped, holds - 1 - k)
            observer.turned(valve, 1 + skipped)
            self._skipped += skipped
            k += 1 + skipped
        clock.sleep_until(start + k * hold)
        seen, measured = look()
        self.log.add(seen, 0, None, measured)
