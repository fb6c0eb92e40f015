"""A linear crawler in many digits, however stiff: sums of three exponentials in mpmath.

Payload and foot obey equations 7 to 9, as in `judge`; their distance is solved by eigenvalues, which at this many
digits are told apart by a nudge where they coincide. Events are searched for on a grid and refined by bisection.
"""

from decimal import Decimal

import mpmath as mp
import numpy as np
from judge import STICK, Verdict

from stickslip.crawler import REST, Scene

__all__ = ["LinearMotion", "modal_judge"]

_DIGITS = 60
_NUDGE = mp.mpf(10) ** -20
_LOOKS = [mp.mpf(float(x)) for x in np.concatenate([np.geomspace(1e-16, 1e-2, 24), np.linspace(0.01, 1.0, 60)[1:]])]


class LinearMotion:
    """z, its derivatives and the pressure's gap as functions of time, in one motion of the foot."""

    def __init__(self, groups, scene, motion, z, v, pressure, valve):
        self.damping = 2 * mp.mpf(groups.damping_ratio)
        r = mp.mpf(groups.foot_mass_fraction)
        self.valve, self.drag = mp.mpf(valve), motion * mp.mpf(groups.kinetic_friction)
        mass = 1 - r if motion == STICK else r * (1 - r)
        # Difference of what friction and weight do to the payload and to the foot, per mass.
        constant = self.drag / r if motion else -mp.mpf(scene.slope)
        self.lag = 1 / mp.mpf(groups.deborah)
        half = self.damping / (2 * mass)
        root = mp.sqrt(mp.mpc(half**2 - 1 / mass))
        rates = [half - root, half + root, mp.mpc(self.lag)]
        for i in range(3):
            while any(abs(rates[i] - other) <= abs(other) * _NUDGE / 2 for other in rates[:i]):
                rates[i] *= 1 + _NUDGE
        rest, gap = self.valve + constant * mass, mp.mpf(pressure) - self.valve
        y, v = mp.mpf(z) - rest, mp.mpf(v)
        share = gap / mass / ((rates[0] - rates[2]) * (rates[1] - rates[2]))
        y_free, v_free = y - share, v + rates[2] * share
        one = (v_free + rates[1] * y_free) / (rates[1] - rates[0])
        self.rest, self.gap = rest, gap
        self.modes = list(zip(rates, [one, y_free - one, share], strict=True))
        pulls = [(self.damping * rate - 1) * amplitude for rate, amplitude in self.modes]
        pulls[2] += gap
        self.pulls = list(zip(rates, pulls, strict=True))

    def derivative(self, t, order=0):
        """z at `t`, or a derivative of it."""
        total = sum((-rate) ** order * amplitude * mp.exp(-rate * t) for rate, amplitude in self.modes)
        return mp.re(total) + (self.rest if order == 0 else 0)

    def pressure(self, t):
        return self.valve + self.gap * mp.exp(-self.lag * t)

    def force(self, t):
        total = sum(pull * mp.exp(-rate * t) for rate, pull in self.pulls)
        return self.valve - self.rest + mp.re(total)


def modal_judge(groups, valve, hold, *, scene=None, samples_per_hold=1, initial=None) -> Verdict:
    """Solve one linear crawler; arguments as those of `simulate`."""
    scene, start = scene or Scene(), initial or REST
    with mp.workdps(_DIGITS):
        z, v, p, x, w = (mp.mpf(value) for value in start)
        motion, fresh = int(mp.sign(w)), w == 0
        rows, events, clearance = [], [], np.inf
        for k, command in enumerate(valve):
            for j in range(samples_per_hold):
                left, elapsed = mp.mpf(hold) / samples_per_hold, mp.mpf(0)
                while left > 0:
                    smooth = LinearMotion(groups, scene, motion, z, v, p, int(command))
                    r, slope = mp.mpf(groups.foot_mass_fraction), mp.mpf(scene.slope)
                    drag = smooth.drag + slope

                    def speed(t, smooth=smooth, w=w, v=v, r=r, drag=drag):
                        return w + (1 - r) * (v - smooth.derivative(t, 1)) - drag * t

                    step, following, near = _first(groups, scene, smooth, speed, motion, fresh, left)
                    clearance = min(clearance, near)
                    if motion != STICK:
                        x += (w + (1 - r) * v - drag * step / 2) * step - (1 - r) * (smooth.derivative(step) - z)
                        w = speed(step)
                    z, v, p = smooth.derivative(step), smooth.derivative(step, 1), smooth.pressure(step)
                    fresh = following is not None
                    left -= step
                    elapsed += step
                    if fresh:
                        motion, w = following, mp.mpf(0)
                        moment = k * mp.mpf(hold) + j * mp.mpf(hold) / samples_per_hold + elapsed
                        events.append((Decimal(mp.nstr(moment, 30)), motion))
                rows.append([float(value) for value in (z, v, p, x, w)])
    return Verdict(*np.array(rows).T, events, clearance, last_foot=float(x))


def _first(groups, scene, smooth, speed, motion, fresh, left):
    """Where the smooth motion ends, what follows (None for the same), and how near another course of events was."""
    if scene.anchored:
        return left, None, np.inf
    s, weight = mp.mpf(groups.static_friction), mp.mpf(groups.foot_mass_fraction) * mp.mpf(scene.slope)
    if motion != STICK:
        moment, near = _descent(lambda t: motion * speed(t), left, skip=fresh)
        if moment is None:
            return left, None, near
        push = motion * (smooth.force(moment) + weight)
        turns = not scene.ratchet and push > s
        near = min(near, np.inf if scene.ratchet else abs(float(push - s)))
        return moment, -motion if turns else STICK, near
    best, following, nearest = left, None, np.inf
    for direction in (1,) if scene.ratchet else (1, -1):
        moment, near = _descent(lambda t, d=direction: s + d * (smooth.force(t) + weight), left, skip=False)
        nearest = min(nearest, near)
        if moment is not None and (moment < best or following is None):
            best, following = moment, direction
    return best, following, nearest


def _descent(gap, left, *, skip):
    """First time in (0, left] at which `gap` falls below zero, or None; and its least distance from another course."""
    looks = [left * look for look in _LOOKS]
    values = [gap(t) for t in looks]
    near = abs(float(values[-1]))
    for i, value in enumerate(values):
        high = looks[i]
        if 0 < i < len(looks) - 1 and 0 < value <= min(values[i - 1], values[i + 1]):
            low, up = looks[i - 1], looks[i + 1]
            for _ in range(60):
                third = (up - low) / 3
                low, up = (low, up - third) if gap(low + third) < gap(up - third) else (low + third, up)
            high, value = low, gap(low)
            if not (skip and i < 2):
                near = min(near, abs(float(value)))
        if value < 0:
            low = looks[i - 1] if i else mp.mpf(0)
            for _ in range(110):
                middle = (low + high) / 2
                low, high = (middle, high) if gap(middle) > 0 else (low, middle)
            return high, near
    return None, near
