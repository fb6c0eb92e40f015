"""A slow second implementation of the crawler, from the equations of the paper and not from the package's algebra.

The payload and the foot each obey their own equation of motion (7 to 9), X_p and X_f with their rates, in natural
units: masses 1 - r and r. SciPy's DOP853 integrates them, and the energies along with them.
"""

from dataclasses import dataclass, field
from decimal import Decimal

import numpy as np
from scipy.integrate import DOP853, solve_ivp
from scipy.optimize import brentq, minimize_scalar

from stickslip.crawler import Groups, REST, Scene

__all__ = ["BACKWARD", "FORWARD", "STICK", "Crawling", "Verdict", "follow", "judge"]

STICK, FORWARD, BACKWARD = 0, 1, -1
_ACCURACY = {"rtol": 1e-12, "atol": 1e-13}
# Where in a step to look for a change of sign; dense at its start, for slips that end soon after they begin.
_LOOKS = np.concatenate([np.geomspace(1e-9, 1e-2, 15), np.linspace(0.0, 1.0, 25)[1:-1], [1 - 1e-3, 1 - 1e-6, 1.0]])


@dataclass
class Verdict:
    """What a judge says of one run; arrays hold one entry a sample."""

    deformation: np.ndarray
    velocity: np.ndarray
    pressure: np.ndarray
    foot: np.ndarray
    foot_velocity: np.ndarray
    events: list[tuple[float | Decimal, int]]  # time and the motion that begins
    # How near the run came to another sequence of events, in force or speed. A comparison of slip counts is fair
    # only where this is far above rounding.
    clearance: float
    work: float = np.nan
    viscous_loss: float = np.nan
    friction_loss: float = np.nan
    last_foot: float | Decimal = np.nan
    last: tuple[Decimal, ...] = ()  # z, v, x, w at the end, where more than floats are known of them

    @property
    def slips(self) -> int:
        return sum(motion != STICK for _, motion in self.events)


@dataclass
class Crawling:
    """One crawler on its way."""

    groups: Groups
    scene: Scene
    state: np.ndarray  # X_p, X_f, their rates, work, viscous loss, friction loss
    time: float = 0.0
    motion: int = STICK
    fresh: bool = True  # whether this motion has only just begun
    peak: float = 0.0
    clearance: float = np.inf
    events: list[tuple[float, int]] = field(default_factory=list)

    foot_rate = 3  # where in `state`

    @property
    def foot_mass(self):
        return self.groups.foot_mass_fraction

    def force(self, pressure, state):
        """F_int of equations 1 and S18, on the payload; its opposite acts on the foot."""
        g = self.groups
        z, rate = state[0] - state[1], state[2] - state[3]
        area = 1.0 + g.radial_coupling * z
        return pressure * area - z - g.duffing * z**3 - 2.0 * g.damping_ratio * rate

    def rates(self, pressure, state):
        """Equations 7 (stick) or 8 and 9 (slip), and the powers that act."""
        g = self.groups
        z, rate = state[0] - state[1], state[2] - state[3]
        force = self.force(pressure, state)
        friction = -self.motion * g.kinetic_friction
        slope = self.scene.slope  # weight along the ground, per mass
        foot_acceleration = 0.0 if self.motion == STICK else (friction - force) / g.foot_mass_fraction - slope
        return np.array(
            [
                state[2],
                state[3],
                force / (1.0 - g.foot_mass_fraction) - slope,
                foot_acceleration,
                pressure * (1.0 + g.radial_coupling * z) * rate,
                2.0 * g.damping_ratio * rate**2,
                -friction * state[3],
            ]
        )

    def gaps(self):
        """The functions whose fall below zero ends this motion, each with the motion that follows it."""
        if self.scene.anchored:
            return []
        s, weight = self.groups.static_friction, self.foot_mass * self.scene.slope
        if self.motion != STICK:
            return [(lambda p, y: self.motion * y[self.foot_rate], None)]
        forward = (lambda p, y: s + weight + self.force(p, y), FORWARD)
        backward = (lambda p, y: s - weight - self.force(p, y), BACKWARD)
        return [forward] if self.scene.ratchet else [forward, backward]


def judge(groups, valve, hold, *, scene=None, samples_per_hold=1, initial=None) -> Verdict:
    """Integrate one crawler with SciPy; arguments as those of `simulate`."""
    scene = scene or Scene()
    start = initial or REST
    speeds = [start.velocity + start.foot_velocity, start.foot_velocity]
    positions = [start.deformation + start.foot, start.foot]
    run = Crawling(groups, scene, np.array([*positions, *speeds, 0.0, 0.0, 0.0]))
    run.motion = int(np.sign(start.foot_velocity))
    p, rows, clearance = follow(run, valve, hold, samples_per_hold, start.pressure)
    payload, foot, payload_rate, foot_rate = rows[:4]
    return Verdict(
        payload - foot, payload_rate - foot_rate, p, foot, foot_rate, run.events, clearance, *run.state[4:], foot[-1]
    )


def follow(run, valve, hold, samples_per_hold, opening):
    """Take `run` through the schedule from the pressure `opening`: pressures, states (one a column), clearance."""
    groups, rows = run.groups, []
    for k, command in enumerate(valve):
        begin = k * hold

        def pressure(t, begin=begin, opening=opening, command=command):
            return command + (opening - command) * np.exp(-(t - begin) / groups.deborah)

        for j in range(samples_per_hold):
            _advance(run, pressure, begin + hold * (j + 1) / samples_per_hold)
            rows.append([pressure(run.time), *run.state])
        opening = pressure(begin + hold)
    p, *states = np.array(rows).T
    return p, states, min([run.clearance, *(abs(gap(opening, run.state)) for gap, _ in run.gaps())])


def _advance(run, pressure, until):
    """Integrate to `until`, from event to event."""
    while run.time < until:
        if run.motion == STICK and run.fresh and _starts(run, pressure):
            continue
        solver = DOP853(lambda t, y: run.rates(pressure(t), y), run.time, run.state, until, **_ACCURACY)
        while solver.status == "running":
            before, origin = solver.t, solver.y.copy()
            solver.step()
            assert solver.status != "failed", "DOP853 failed"
            moment, motion = _first_event(run, pressure, solver, before)
            run.fresh = False
            if moment is None:
                run.time, run.state = solver.t, solver.y
                continue
            run.state = _travel(run, pressure, before, moment, origin)
            run.time = moment
            _begin(run, pressure, motion)
            break


def _starts(run, pressure):
    """Break loose where a resting foot is pulled too hard already, or is about to be."""
    now, soon = run.time, run.time + 1e-7
    later = _travel(run, pressure, now, soon, run.state)
    for gap, motion in run.gaps():
        here = gap(pressure(now), run.state)
        if here < -1e-14 or (here < 1e-14 and gap(pressure(soon), later) < here):
            _begin(run, pressure, motion)
            return True
    return False


def _first_event(run, pressure, solver, before):
    """Time of the first event of the last step and the motion that follows, or (None, None)."""
    dense = solver.dense_output()
    looks = before + _LOOKS * (solver.t - before)
    best, following = None, None
    for gap, motion in run.gaps():

        def value(t, gap=gap):
            return gap(pressure(t), dense(t))

        times = looks.copy()
        values = value(times)
        for i in range(1, len(times) - 1):
            # A dip between two looks, if it might reach zero, is looked at closely.
            if values[i] <= values[i - 1] and values[i] <= values[i + 1]:
                swing = abs(values[i + 1] - 2 * values[i] + values[i - 1])
                if 0.0 < values[i] < 4.0 * swing + 1e-6:
                    closest = minimize_scalar(
                        value, bounds=times[[i - 1, i + 1]], method="bounded", options={"xatol": 1e-12}
                    )
                    if closest.fun < values[i]:
                        times[i], values[i] = closest.x, closest.fun
                run.clearance = min(run.clearance, abs(values[i]))
        if run.motion != STICK:
            run.peak = max(run.peak, values.max())
        below = np.flatnonzero(values < 0.0)
        if not len(below):
            continue
        i = below[0]
        if i == 0:
            moment = before if run.fresh or value(before) <= 0.0 else brentq(value, before, times[0], xtol=1e-15)
        else:
            moment = brentq(value, times[i - 1], times[i], xtol=1e-15, rtol=1e-15)
        # The interpolant is less accurate than the step: correct by what an integration to the root finds.
        for _ in range(2):
            reached = _travel(run, pressure, before, moment, solver.y_old)
            near = 1e-3 * (solver.t - before)
            slope = (value(moment + near) - value(moment - near)) / (2.0 * near)
            # Less steep by d, the gap would have turned round some d^2 above this root.
            run.clearance = min(run.clearance, slope**2)
            if slope >= 0.0:
                break
            moment = min(max(moment - gap(pressure(moment), reached) / slope, before), solver.t)
        if best is None or moment < best:
            best, following = moment, motion
    return best, following


def _travel(run, pressure, start, end, state):
    """State at `end` from `state` at `start` in the present motion."""
    if end == start:
        return state.copy()
    return solve_ivp(lambda t, y: run.rates(pressure(t), y), (start, end), state, method="DOP853", **_ACCURACY).y[:, -1]


def _begin(run, pressure, motion):
    """Change the motion; None means that the foot has come to rest and friction decides what follows."""
    if motion is None:
        run.clearance = min(run.clearance, run.peak)
        # A foot that comes to rest under too great a push turns round at once.
        weight = run.foot_mass * run.scene.slope
        push = run.motion * (run.force(pressure(run.time), run.state) + weight)
        turns = not run.scene.ratchet and push > run.groups.static_friction
        if not run.scene.ratchet:
            run.clearance = min(run.clearance, abs(push - run.groups.static_friction))
        motion = -run.motion if turns else STICK
    run.state = run.state.copy()
    run.state[run.foot_rate] = 0.0
    run.motion, run.fresh, run.peak = motion, True, 0.0
    run.events.append((run.time, motion))
