"""The crawler in 50-digit arithmetic, for what double precision cannot decide.

Like `judge`, from the four-variable equations (7 to 9): payload and foot each obey their own, and the pressure its own
(2). Every variable is a Taylor series by recurrence; events are searched for on a grid and refined by bisection.
"""

from dataclasses import dataclass, field
from decimal import Decimal, localcontext
from operator import mul
from types import SimpleNamespace

import numpy as np
from judge import STICK, Verdict

from stickslip.crawler import REST, Scene

__all__ = ["as_written", "decimal_judge"]

_DIGITS = 50
_VARIABLES = ("payload", "foot", "payload_rate", "foot_rate", "pressure")
_ORDER = 46
_NEGLIGIBLE = Decimal("1e-38")  # largest last term of a series
_LONGEST_STEP = Decimal("1.0")
_LOOKS = np.concatenate([np.geomspace(1e-8, 5e-3, 12), np.linspace(0.0, 1.0, 101)[1:-1], [1 - 1e-4, 1.0]])


@dataclass
class _Run:
    """State and events of one crawler, in Decimal."""

    payload: Decimal
    foot: Decimal
    payload_rate: Decimal
    foot_rate: Decimal
    pressure: Decimal
    motion: int
    fresh: bool  # whether this motion has only just begun
    clearance: float = float("inf")
    events: list[tuple[Decimal, int]] = field(default_factory=list)


def decimal_judge(groups, valve, hold, *, scene=None, samples_per_hold=1, initial=None, number=Decimal) -> Verdict:
    """Integrate one crawler to more than 30 digits; arguments as those of `simulate`.

    `number` reads a float: `Decimal` takes its binary value, `as_written` the decimal fraction it stands for.
    """
    scene, start = scene or Scene(), initial or REST
    with localcontext() as context:
        context.prec = _DIGITS
        groups = SimpleNamespace(
            **{name: number(value) for name, value in groups.to_dict().items()}, slope=number(scene.slope)
        )
        z, v, p, x, w = (number(value) for value in start)
        motion = int(w.compare(0))
        run = _Run(x + z, x, v + w, w, p, motion, motion == STICK)
        hold = number(hold)
        rows = []
        for k, command in enumerate(valve):
            for j in range(samples_per_hold):
                opened = k * hold + hold * j / samples_per_hold
                _advance(run, groups, scene, int(command), opened, hold / samples_per_hold)
                z, v = run.payload - run.foot, run.payload_rate - run.foot_rate
                rows.append([float(value) for value in (z, v, run.pressure, run.foot, run.foot_rate)])
        _last_clearance(run, groups, scene)
        last = (run.payload - run.foot, run.payload_rate - run.foot_rate, run.foot, run.foot_rate)
    return Verdict(*np.array(rows).T, run.events, run.clearance, last_foot=run.foot, last=last)


def as_written(value: float) -> Decimal:
    """The decimal fraction that a float is written as, 0.3 and not the binary fraction nearest to it."""
    return Decimal(repr(float(value)))


def _advance(run, groups, scene, command, opened, length):
    elapsed = Decimal(0)
    while elapsed < length:
        series = _expand(run, groups, command)
        last = max(abs(row[n]) for row in series.values() for n in (_ORDER - 1, _ORDER))
        step = min(_LONGEST_STEP, length - elapsed)
        if last:
            step = min(step, (_NEGLIGIBLE / last) ** (Decimal(1) / _ORDER))
        step, following = _first_event(run, groups, scene, series, step)
        for name in _VARIABLES:
            setattr(run, name, _value(series[name], step))
        elapsed += step
        run.fresh = False
        if following is not None:
            run.motion, run.fresh, run.foot_rate = following, True, Decimal(0)
            # The payload's rate is its own; only the foot's rounding is put right.
            run.events.append((opened + elapsed, following))


def _expand(run, groups, command):
    """Coefficients of each variable and of the force on the payload."""
    duffing, damping, coupling = groups.duffing, 2 * groups.damping_ratio, groups.radial_coupling
    foot_mass, drag = groups.foot_mass_fraction, run.motion * groups.kinetic_friction
    payload_mass = 1 - foot_mass
    series = {name: [getattr(run, name)] for name in _VARIABLES}
    series["force"] = []
    z, square = [], []
    for n in range(_ORDER + 1):
        z.append(series["payload"][n] - series["foot"][n])
        square.append(_convolve(z, z, n))
        cube = _convolve(square, z, n) if duffing else 0
        area = _convolve(series["pressure"], z, n) if coupling else 0
        rate = series["payload_rate"][n] - series["foot_rate"][n]
        force = series["pressure"][n] + coupling * area - z[n] - duffing * cube - damping * rate
        series["force"].append(force)
        constant = 1 if n == 0 else 0
        slope = groups.slope * constant
        foot_rate = Decimal(0) if run.motion == STICK else (-force - drag * constant) / foot_mass - slope
        series["payload"].append(series["payload_rate"][n] / (n + 1))
        series["foot"].append(series["foot_rate"][n] / (n + 1))
        series["payload_rate"].append((force / payload_mass - slope) / (n + 1))
        series["foot_rate"].append(foot_rate / (n + 1))
        series["pressure"].append((command * constant - series["pressure"][n]) / groups.deborah / (n + 1))
    return series


def _convolve(left, right, n):
    """Coefficient n of the product of two series."""
    return sum(map(mul, left[: n + 1], right[n::-1]))


def _value(coefficients, t):
    total = Decimal(0)
    for coefficient in reversed(coefficients):
        total = total * t + coefficient
    return total


def _first_event(run, groups, scene, series, step):
    """Where the step ends and the motion that follows, None for the same."""
    if scene.anchored:
        return step, None
    s = groups.static_friction
    best, following = step, None
    if run.motion != STICK:
        speed = [run.motion * c for c in series["foot_rate"]]
        # A slip that begins at rest: divide out that root.
        moment = _descent(run, speed[1:] if run.fresh else speed, step)
        if moment is not None and moment <= best:
            push = run.motion * (_value(series["force"], moment) + groups.foot_mass_fraction * groups.slope)
            if not scene.ratchet:
                run.clearance = min(run.clearance, abs(float(push - s)))
            best, following = moment, STICK if scene.ratchet or push <= s else -run.motion
        return best, following
    for motion in (1,) if scene.ratchet else (1, -1):
        gap = [motion * c for c in series["force"]]
        gap[0] += s + motion * groups.foot_mass_fraction * groups.slope
        moment = _descent(run, gap, step)
        if moment is not None and (moment < best or following is None):
            best, following = moment, motion
    return best, following


def _descent(run, polynomial, step):
    """First time at which the polynomial falls through zero, or None."""
    if abs(polynomial[0]) < _NEGLIGIBLE:
        polynomial = [Decimal(0), *polynomial[1:]]
        leading = next((c for c in polynomial if abs(c) > _NEGLIGIBLE), Decimal(0))
        if leading < 0:
            return Decimal(0)
    elif polynomial[0] < 0:
        return Decimal(0)
    scaled = np.array([float(c * step**n) for n, c in enumerate(polynomial)])
    doubt = 1e-9 * abs(scaled).max()
    if scaled[0] + np.minimum(scaled[1:], 0.0).sum() > doubt:
        return None  # the negative terms together cannot reach zero
    values = np.polynomial.polynomial.polyval(_LOOKS, scaled)
    for i in range(len(_LOOKS)):
        if abs(values[i]) < doubt:
            values[i] = float(_value(polynomial, step * Decimal(_LOOKS[i])))
        moment = step * Decimal(_LOOKS[i])
        if 0 < i < len(_LOOKS) - 1 and 0 <= values[i] <= min(values[i - 1], values[i + 1]):
            bounds = step * Decimal(_LOOKS[i - 1]), step * Decimal(_LOOKS[i + 1])
            moment, lowest = _minimum(polynomial, *bounds)
            values[i] = float(lowest)
            run.clearance = min(run.clearance, abs(values[i]))
        if values[i] < 0:
            low = step * Decimal(_LOOKS[i - 1]) if i else Decimal(0)
            return _root(run, polynomial, low, moment)
    return None


def _minimum(polynomial, low, high):
    """Least value between two times, by ternary search."""
    for _ in range(120):
        third = (high - low) / 3
        if _value(polynomial, low + third) < _value(polynomial, high - third):
            high -= third
        else:
            low += third
    return low, _value(polynomial, low)


def _last_clearance(run, groups, scene):
    """Whether an event was about to happen as time ran out."""
    if scene.anchored:
        return
    z, v = run.payload - run.foot, run.payload_rate - run.foot_rate
    force = run.pressure * (1 + groups.radial_coupling * z) - z - groups.duffing * z**3 - 2 * groups.damping_ratio * v
    force += groups.foot_mass_fraction * groups.slope
    gaps = [run.foot_rate] if run.motion else [groups.static_friction + force]
    if not run.motion and not scene.ratchet:
        gaps.append(groups.static_friction - force)
    run.clearance = min(run.clearance, *(abs(float(gap)) for gap in gaps), float("inf"))


def _root(run, polynomial, low, high):
    """Root between a time where the polynomial is positive and one where it is negative."""
    slopes = [n * c for n, c in enumerate(polynomial)][1:]
    for _ in range(24):
        middle = (low + high) / 2
        low, high = (middle, high) if _value(polynomial, middle) > 0 else (low, middle)
    t = (low + high) / 2
    for _ in range(8):
        slope = _value(slopes, t)
        if slope == 0:
            break
        t = min(max(t - _value(polynomial, t) / slope, low), high)
    # Less steep by d, the polynomial would have turned round some d^2 above this root.
    run.clearance = min(run.clearance, float(slope) ** 2)
    return t
