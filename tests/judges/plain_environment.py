"""A slow second environment, from sections 2 and 4 of the design in plain Python and NumPy.

Nothing of the package is used. Payload and foot each obey their own equation of motion, which fourth-order Runge-Kutta
steps integrate; the readout is solved anew at every step by the normal equations of ridge regression.
"""

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["GROUPS", "Episode", "calibration_valves", "crawled", "episode", "memory_scores"]

GROUPS = {
    "duffing": 0.5,
    "damping_ratio": 0.05,
    "deborah": 0.5,
    "radial_coupling": 0.2,
    "foot_mass_fraction": 0.3,
    "static_friction": 0.3,
    "kinetic_friction": 0.2,
}
_RIDGE = 1e-3
_STEPS_A_HOLD = 48  # a multiple of the virtual nodes in use


class Episode(NamedTuple):
    """What each step of an episode should answer; every array has one row a step."""

    observations: NDArray[np.float64]  # z, v, p, w, and u of this hold and of those before
    rewards: NDArray[np.float64]
    speed: NDArray[np.float64]
    memory: NDArray[np.float64]
    distance: NDArray[np.float64]
    innovation: NDArray[np.float64]
    valve: NDArray[np.int64]


def episode(
    commands: NDArray[np.int64],
    flips: NDArray[np.bool_],
    move: Callable[[NDArray[np.int64]], NDArray[np.float64]],
    calibration: NDArray[np.float64] | None,
    *,
    hold: float,
    dither: float,
    memory_weight: float,
    delays: int,
    valve_history: int = 1,
    target: str = "memory",
    target_order: int = 2,
    moments: tuple[float, float] | None = None,
) -> Episode:
    """An episode from rest.

    Parameters
    ----------
    commands, flips : (steps,) arrays
    move : callable
        From the (steps,) valve states to the (steps, nodes, 5) states z, v, p, x, w of the body.
    calibration : (holds, nodes, 5) array or None
        What `move` says of the calibration's valves; None without dither.
    hold, dither, memory_weight, delays, valve_history, target, target_order
        Arguments of the environment.
    moments : tuple of two floats
        Of the NARMA series, where that is the target: mean and variance.
    """
    valve = np.where(flips, 1 - commands, commands)
    motion = move(valve)
    z, v, p, x, w = motion[:, -1].T
    speed = np.diff(x, prepend=0.0) / hold
    innovation = valve - ((1 - dither) * commands + dither * (1 - commands))
    memory = np.zeros(len(commands))
    if calibration is not None:
        message, variance, lead = message_of(innovation, target, target_order, dither, moments)
        targets = 1 if target == "narma" else delays
        memory = memory_scores(_features(motion), message, _features(calibration), targets, variance, lead)
    rewards = (1 - memory_weight) * speed + memory_weight * memory
    seen = [np.concatenate([np.zeros(age), valve])[: len(valve)] for age in range(valve_history)]
    return Episode(np.column_stack([z, v, p, w, *seen]), rewards, speed, memory, x, innovation, valve)


def message_of(
    innovations: NDArray[np.float64], target: str, order: int, dither: float, moments: tuple[float, float] | None
) -> tuple[NDArray[np.float64], float, int]:
    """What is to be told of the innovations, its variance, and how many steps pass before its first value.

    Mean and variance of a NARMA series have no closed form: those are given.
    """
    variance = dither * (1 - dither)
    if target == "memory":
        return innovations, variance, 0
    if target == "parity":
        past = [np.concatenate([np.zeros(age), innovations])[: len(innovations)] for age in range(order)]
        return np.prod(past, axis=0), variance**order, order - 1
    mean, spread = moments
    return narma(innovations, order, mean) - mean, spread, 0


def narma(innovations: NDArray[np.float64], order: int, start: float) -> NDArray[np.float64]:
    """The series of that order, as if it had been at `start` for ever and innovations 0."""
    s = [0.25] * (order - 1) + ((1 + innovations) / 4).tolist()
    y = [start] * order
    for k in range(len(innovations)):
        y.append(0.3 * y[-1] + 0.05 * y[-1] * sum(y[-order:]) + 1.5 * s[k] * s[k + order - 1] + 0.1)
    return np.array(y[order:])


def calibration_valves(hold: float) -> NDArray[np.int64]:
    """2000 random holds, fewer if they last longer than 20,000 units of time together, but never fewer than 100."""
    return np.random.default_rng(0).integers(0, 2, max(100, min(2000, int(20_000 / hold))))


def _features(motion: NDArray[np.float64]) -> NDArray[np.float64]:
    """Deformations at the nodes of each hold, then rates, then pressures."""
    return np.concatenate([motion[:, :, reading] for reading in range(3)], axis=1)


def memory_scores(
    states: NDArray[np.float64],
    innovations: NDArray[np.float64],
    calibration: NDArray[np.float64],
    delays: int,
    variance: float,
    lead: int = 0,
) -> NDArray[np.float64]:
    """What each step earns: sum over d of (e^2 - (e - ehat)^2 / (1 + h_d)) / Var e, by the normal equations."""
    spread = calibration.std(axis=0)
    x = (states - calibration.mean(axis=0)) / np.where(spread > 0, spread, 1.0)
    x = np.column_stack([x, np.ones(len(x))])
    messages = np.zeros((len(x), delays))  # of step k and delay d: e_{k-d}, zero from before the first
    innovations = np.where(np.arange(len(x)) < lead, 0.0, innovations)
    for d in range(min(delays, len(x))):
        messages[d:, d] = innovations[: len(x) - d]
    scores = np.zeros(len(x))
    for k in range(len(x)):
        past, now = x[:k], x[k]
        normal = _RIDGE * np.eye(x.shape[1]) + past.T @ past
        leverage = now @ np.linalg.solve(normal, now)
        d = np.arange(max(min(k + 1 - lead, delays), 0))
        message = messages[k, d]
        error = message - now @ np.linalg.solve(normal, past.T @ messages[:k, d])
        earned = message**2 - error**2 / (1 + leverage * (k + 1 - lead - d) / (k + 1))
        scores[k] = min(max(2 - leverage, 0.0), 1.0) * earned.sum() / variance
    return scores


def crawled(
    valves: NDArray[np.int64], hold: float, nodes: int, changes: Mapping[str, float] | None = None
) -> NDArray[np.float64]:
    """States z, v, p, x, w at the nodes of each hold, from rest, on flat ground with a ratchet: (holds, nodes, 5)."""
    g = {**GROUPS, **(changes or {})}
    stiff, damping, lag, coupling = g["duffing"], 2 * g["damping_ratio"], g["deborah"], g["radial_coupling"]
    foot_mass, static, kinetic = g["foot_mass_fraction"], g["static_friction"], g["kinetic_friction"]
    payload_mass = 1 - foot_mass
    assert _STEPS_A_HOLD % nodes == 0
    step, every = hold / _STEPS_A_HOLD, _STEPS_A_HOLD // nodes

    def force(pressure, state):
        payload, foot, payload_rate, foot_rate = state
        z = payload - foot
        return pressure * (1 + coupling * z) - z - stiff * z**3 - damping * (payload_rate - foot_rate)

    def rates(pressure, state, sliding):
        f = force(pressure, state)
        return state[2], state[3], f / payload_mass, (-f - kinetic) / foot_mass if sliding else 0.0

    def moved(state, time, length, sliding):
        def after(slopes, share):
            return tuple(y + share * length * dy for y, dy in zip(state, slopes, strict=True))

        middle, end = pressure_at(time + length / 2), pressure_at(time + length)
        one = rates(pressure_at(time), state, sliding)
        two = rates(middle, after(one, 0.5), sliding)
        three = rates(middle, after(two, 0.5), sliding)
        four = rates(end, after(three, 1.0), sliding)
        return after([(a + 2 * b + 2 * c + d) / 6 for a, b, c, d in zip(one, two, three, four, strict=True)], 1.0)

    def over(state, time, sliding):
        return state[3] < 0 if sliding else force(pressure_at(time), state) < -static

    state, sliding, opening = (0.0, 0.0, 0.0, 0.0), False, 0.0
    rows = []
    for valve in valves.tolist():

        def pressure_at(time, valve=valve, opening=opening):
            return valve + (opening - valve) * math.exp(-time / lag)

        for k in range(_STEPS_A_HOLD):
            time, end = k * step, (k + 1) * step
            after = moved(state, time, end - time, sliding)
            while over(after, end, sliding):
                low, high = time, end  # of the time of the event
                for _ in range(40):
                    middle = (low + high) / 2
                    reached = moved(state, time, middle - time, sliding)
                    low, high = (low, middle) if over(reached, middle, sliding) else (middle, high)
                state, time, sliding = moved(state, time, high - time, sliding), high, not sliding
                state = (*state[:3], 0.0)
                after = moved(state, time, end - time, sliding)
            state = after
            if (k + 1) % every == 0:
                payload, foot, payload_rate, foot_rate = state
                rows.append([payload - foot, payload_rate - foot_rate, pressure_at(end), foot, foot_rate])
        opening = pressure_at(hold)
    return np.array(rows).reshape(len(valves), nodes, 5)
