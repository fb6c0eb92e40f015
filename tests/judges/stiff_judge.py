"""The crawler by implicit collocation in 60-digit arithmetic, for bodies too stiff for an explicit series.

Like the other judges, from the four-variable equations (7 to 9): payload and foot each obey their own, with the
pressure's equation (2) solved exactly. A step is Radau IIA collocation on 24 nodes (E. Hairer and G. Wanner, Solving
Ordinary Differential Equations II, section IV.5), L-stable and of order 47. The unknowns are the internal force at
the nodes. Newton's corrections come from double precision, their residuals from Decimal, which runs ten times as fast
as mpmath without its C backend; mpmath makes the tables. A step is accepted where the Legendre series of the force,
with its value at the step's start as one node more, has died out, so that the polynomial is right everywhere in the
step and events can be sought on it; the step that ends on the event is then solved anew.

Run ``python tests/judges/stiff_judge.py --regenerate`` to compute the stored references of `extreme_rows.py` anew.
"""

import json
import os
import sys
from dataclasses import dataclass, field
from decimal import Decimal, localcontext
from functools import cache
from types import SimpleNamespace

import mpmath
import numpy as np
from judge import STICK, Verdict
from scipy.special import roots_jacobi

from stickslip.crawler import REST, Scene

__all__ = ["StiffRun", "reference", "stiff_judge", "stiff_run"]

_DIGITS = 60
_NODES = 24
# Largest of the last Legendre coefficients of the force in a step, relative to the force.
_RESOLVED = 1e-26
_NEGLIGIBLE = Decimal("1e-23")  # what a value at the start of a motion is called zero within
_GROWTH, _SHRINKAGE = 4.0, 0.1
_ITERATIONS = 40
_STORED_DIGITS = 25
_NUDGE = 1e-15  # change by which the condition is learnt
_LOOKS = np.concatenate([[0.0], np.geomspace(1e-12, 5e-3, 24), np.linspace(0.0, 1.0, 121)[1:]])


@dataclass
class StiffRun:
    """One crawler on its way, in Decimal."""

    payload: Decimal
    foot: Decimal
    payload_rate: Decimal
    foot_rate: Decimal
    pressure: Decimal
    motion: int
    fresh: bool  # whether this motion has only just begun
    bias: tuple[Decimal, ...]  # added to the internal force: a constant, and what to multiply z and its rate by
    nodes: int
    step: float = 0.0  # length to try next
    steps: int = 0
    peak: float = 0.0
    clearance: float = float("inf")
    events: list[tuple[Decimal, int]] = field(default_factory=list)
    samples: list[list[Decimal]] = field(default_factory=list)  # z, v, p, x, w


def stiff_judge(
    groups, valve, hold, *, scene=None, samples_per_hold=1, initial=None, number=Decimal, nodes=_NODES
) -> Verdict:
    """Integrate one crawler to more than 20 digits; arguments as those of `decimal_judge`, and the nodes of a step."""
    run = stiff_run(
        groups,
        valve,
        hold,
        scene=scene,
        samples_per_hold=samples_per_hold,
        initial=initial,
        number=number,
        nodes=nodes,
    )
    return Verdict(*np.array(run.samples, dtype=float).T, run.events, run.clearance, last_foot=run.samples[-1][3])


def stiff_run(
    groups,
    valve,
    hold,
    *,
    scene=None,
    samples_per_hold=1,
    initial=None,
    number=Decimal,
    nodes=_NODES,
    bias=(0.0, 0.0, 0.0),
    nudge=(0.0, 0.0),
) -> StiffRun:
    """The whole run, with samples in full; `bias` is added to the force, `nudge` to the initial z and v."""
    scene, start = scene or Scene(), initial or REST
    if scene != Scene(anchored=scene.anchored, ratchet=scene.ratchet):
        raise ValueError(f"the stiff judge knows level ground and one massless segment only, got {scene}")
    with localcontext() as context:
        context.prec = _DIGITS
        groups = SimpleNamespace(**{name: number(value) for name, value in groups.to_dict().items()})
        z, v, p, x, w = (number(value) for value in start)
        z, v = z + Decimal(nudge[0]), v + Decimal(nudge[1])
        motion = int(w.compare(0))
        run = StiffRun(x + z, x, v + w, w, p, motion, motion == STICK, tuple(Decimal(b) for b in bias), nodes)
        hold = number(hold)
        for k, command in enumerate(valve):
            run.step = _first_step(run, groups, hold)
            for j in range(samples_per_hold):
                opened = k * hold + hold * j / samples_per_hold
                _advance(run, groups, scene, int(command), opened, hold / samples_per_hold)
                z, v = run.payload - run.foot, run.payload_rate - run.foot_rate
                run.samples.append([z, v, run.pressure, run.foot, run.foot_rate])
        if not scene.anchored:
            run.clearance = min([run.clearance, *(abs(float(gap)) for gap, _ in _gaps_now(run, groups, scene))])
    return run


def _first_step(run, groups, longest):
    """A step short enough for the fastest rate of the body and of the fluid."""
    g = {name: float(value) for name, value in vars(groups).items()}
    z = float(run.payload - run.foot)
    mass = (1.0 - g["foot_mass_fraction"]) * (1.0 if run.motion == STICK else g["foot_mass_fraction"])
    stiffness = 1.0 + 3.0 * g["duffing"] * z * z + g["radial_coupling"]
    rate = 1.0 / g["deborah"] + np.sqrt(stiffness / mass) + 2.0 * g["damping_ratio"] / mass
    return min(float(longest), 1.0 / rate)


@cache
def _tables(nodes):
    """Nodes c in (0, 1], Radau IIA matrix, its double, and what takes values at 0 and c to Legendre coefficients."""
    with mpmath.workdps(_DIGITS + 20), localcontext() as context:
        context.prec = _DIGITS
        guesses = (1.0 + roots_jacobi(nodes - 1, 1.0, 0.0)[0]) / 2.0

        def radau(t):
            return mpmath.legendre(nodes, 2 * t - 1) - mpmath.legendre(nodes - 1, 2 * t - 1)

        c = [*(mpmath.findroot(radau, mpmath.mpf(float(guess))) for guess in guesses), mpmath.mpf(1)]
        values = mpmath.matrix([_legendre(t, nodes) for t in c])
        integrals = mpmath.matrix([_integrals(t, nodes) for t in c])
        radau_matrix = integrals * values**-1
        transform = mpmath.matrix([_legendre(t, nodes + 1) for t in [mpmath.mpf(0), *c]]) ** -1
        exact = _decimals(radau_matrix)
        looks = np.polynomial.legendre.legvander(2.0 * _LOOKS - 1.0, nodes)
        return SimpleNamespace(
            c=[_decimal(t) for t in c],
            exact=exact,
            once=exact.astype(float),
            twice=exact.astype(float) @ exact.astype(float),
            transform=_decimals(transform),
            looks=looks,
            recurrence=[
                [Decimal(2 * n + 1) / (n + 1) for n in range(nodes + 1)],
                [Decimal(n + 1) / (n + 2) for n in range(nodes + 1)],
            ],
        )


def _legendre(t, count):
    """P_0 to P_{count-1} at 2 t - 1."""
    x = 2 * t - 1
    row = [mpmath.mpf(1), x]
    for n in range(1, count - 1):
        row.append(((2 * n + 1) * x * row[n] - n * row[n - 1]) / (n + 1))
    return row[:count]


def _integrals(t, count):
    """Integrals from 0 to t of P_0 to P_{count-1} at 2 t - 1."""
    row = _legendre(t, count + 1)
    return [t, *((row[n + 1] - row[n - 1]) / (2 * (2 * n + 1)) for n in range(1, count))]


def _decimal(value):
    return Decimal(mpmath.nstr(value, _DIGITS + 10))


def _decimals(matrix):
    return np.array([[_decimal(matrix[i, j]) for j in range(matrix.cols)] for i in range(matrix.rows)], dtype=object)


def _advance(run, groups, scene, command, opened, length):
    elapsed = Decimal(0)
    while elapsed < length:
        remaining = length - elapsed
        trial = remaining if run.step >= float(remaining) else Decimal(run.step)
        path, size = _step(run, groups, command, trial)
        run.steps += 1
        # The last coefficients fall as a power of the step's length.
        factor = 0.9 * (_RESOLVED / size) ** (1.0 / run.nodes) if size > 0.0 else _GROWTH
        if size > _RESOLVED:
            run.step = float(trial) * max(min(factor, 0.8), _SHRINKAGE)
            assert run.step > 1e-40, "the judge's step has shrunk to nothing"
            continue
        if trial < remaining or factor < 1.0:
            run.step = float(trial) * min(factor, _GROWTH)
        path, following = _first_event(run, groups, scene, command, path)
        run.payload, run.foot = path.payload[-1], path.foot[-1]
        run.payload_rate, run.foot_rate = path.payload_rate[-1], path.foot_rate[-1]
        run.pressure = path.pressure[-1]
        elapsed += path.length
        run.fresh = False
        if following is not None:
            run.motion, run.fresh, run.foot_rate, run.peak = following, True, Decimal(0), 0.0
            run.step = min(run.step, _first_step(run, groups, length))
            run.events.append((opened + elapsed, following))


def _force(run, groups, pressure, z, rate):
    """F_int of equations 1 and S18, on the payload; its opposite acts on the foot."""
    area = 1 + groups.radial_coupling * z
    force = pressure * area - z - groups.duffing * z**3 - 2 * groups.damping_ratio * rate
    constant, by_z, by_rate = run.bias
    return force + (constant + by_z * z + by_rate * rate) if any(run.bias) else force


def _step(run, groups, command, length):
    """Collocation over `length`: the path, and the relative size of its unresolved part."""
    tables = _tables(run.nodes)
    r, drag = groups.foot_mass_fraction, run.motion * groups.kinetic_friction
    pressure = _pressures(run.pressure, command, groups, [length * c for c in tables.c])
    start = _force(run, groups, run.pressure, run.payload - run.foot, run.payload_rate - run.foot_rate)
    stages = _newton_in_doubles(run, groups, pressure, float(length), float(start))
    if stages is None:
        return None, np.inf
    force = np.array([Decimal(value) for value in stages], dtype=object)
    reduced = float(1 / (1 - r) if run.motion == STICK else 1 / (1 - r) + 1 / r)
    previous = np.inf
    for _ in range(_ITERATIONS):
        payload_rate = run.payload_rate + length * (tables.exact @ (force / (1 - r)))
        payload = run.payload + length * (tables.exact @ payload_rate)
        if run.motion == STICK:
            foot_rate, foot = np.full(run.nodes, run.foot_rate), np.full(run.nodes, run.foot)
        else:
            foot_rate = run.foot_rate + length * (tables.exact @ ((-force - drag) / r))
            foot = run.foot + length * (tables.exact @ foot_rate)
        z = payload - foot
        residual = _force(run, groups, pressure, z, payload_rate - foot_rate) - force
        jacobian = _jacobian(run, groups, pressure.astype(float), z.astype(float), float(length), reduced)
        # In doubles only the correction's leading digits are needed, of whatever size it is.
        largest = max(abs(value) for value in residual)
        scale = max(1.0, float(max(abs(value) for value in force)))
        if largest == 0:
            break
        correction = np.linalg.solve(jacobian, (residual / largest).astype(float))
        size = float(largest) * abs(correction).max() / scale
        force = force + np.array([Decimal(value) for value in correction], dtype=object) * largest
        if size < 1e-45 or (size < 1e-36 and size > 0.1 * previous):
            break
        previous = size
    else:
        return None, np.inf
    path = SimpleNamespace(
        length=length,
        pressure=np.concatenate([[run.pressure], pressure]),
        force=np.concatenate([[start], force]),
        payload=np.concatenate([[run.payload], payload]),
        foot=np.concatenate([[run.foot], foot]),
        payload_rate=np.concatenate([[run.payload_rate], payload_rate]),
        foot_rate=np.concatenate([[run.foot_rate], foot_rate]),
    )
    tail = max(abs(float(c)) for c in tables.transform[-3:] @ path.force)
    return path, tail / scale


def _newton_in_doubles(run, groups, pressure, length, start):
    """The force at the nodes to double precision, or None where Newton does not converge."""
    tables = _tables(run.nodes)
    g = SimpleNamespace(**{name: float(value) for name, value in vars(groups).items()})
    r, drag = g.foot_mass_fraction, run.motion * g.kinetic_friction
    z0, v0 = float(run.payload - run.foot), float(run.payload_rate - run.foot_rate)
    sliding = run.motion != STICK
    reduced = 1.0 / (1.0 - r) + (1.0 / r if sliding else 0.0)
    push = drag / r if sliding else 0.0
    p = pressure.astype(float)
    force = np.full(run.nodes, start)
    times = np.array(tables.c, dtype=float) * length
    here = SimpleNamespace(bias=[float(b) for b in run.bias])
    with np.errstate(all="ignore"):
        for _ in range(_ITERATIONS):
            v = v0 + push * times + length * reduced * (tables.once @ force)
            z = z0 + v0 * times + 0.5 * push * times**2 + length**2 * reduced * (tables.twice @ force)
            residual = _force(here, g, p, z, v) - force
            if not np.isfinite(residual).all():
                return None
            correction = np.linalg.solve(_jacobian(run, g, p, z, length, reduced), residual)
            force = force + correction
            if abs(correction).max() <= 1e-8 * (1.0 + abs(force).max()):
                return force
    return None


def _jacobian(run, groups, pressure, z, length, reduced):
    """Of the residual's opposite, in doubles: the force acts on z and v through the masses."""
    tables = _tables(run.nodes)
    slope = float(groups.radial_coupling) * pressure - 1.0 - 3.0 * float(groups.duffing) * z * z
    damping = 2.0 * float(groups.damping_ratio)
    by_z, by_v = length**2 * reduced * tables.twice, length * reduced * tables.once
    return np.eye(run.nodes) - slope[:, None] * by_z + damping * by_v


def _pressures(opening, command, groups, times):
    """Equation 2 solved: the gap to the valve's pressure falls exponentially."""
    gap = opening - command
    if gap == 0:
        return np.full(len(times), opening)
    return np.array([command + gap * (-t / groups.deborah).exp() for t in times], dtype=object)


def _gaps(run, groups, scene, path):
    """Values along a path of the functions whose fall below zero ends this motion, and the motion that follows."""
    if run.motion != STICK:
        return [(run.motion * path.foot_rate, None)]
    s = groups.static_friction
    backward = [] if scene.ratchet else [(s - path.force, -1)]
    return [(s + path.force, 1), *backward]


def _gaps_now(run, groups, scene):
    force = _force(run, groups, run.pressure, run.payload - run.foot, run.payload_rate - run.foot_rate)
    return _gaps(run, groups, scene, SimpleNamespace(foot_rate=run.foot_rate, force=force))


def _first_event(run, groups, scene, command, path):
    """The path up to its first event and the motion that follows it, or the whole path and None."""
    if scene.anchored:
        return path, None
    found = []
    for index, (values, following) in enumerate(_gaps(run, groups, scene, path)):
        if run.motion != STICK and run.fresh:
            # A slip begins at rest: that root is divided out, which leaves the acceleration at the start.
            drag = run.motion * groups.kinetic_friction
            begun = run.motion * (-path.force[0] - drag) / groups.foot_mass_fraction
            times = np.array(_tables(run.nodes).c, dtype=object) * path.length
            moment = _descent(run, np.concatenate([[begun], values[1:] / times]))
        else:
            moment = _descent(run, values)
        if moment is not None:
            found.append((moment, index, following))
    following = None
    if found:
        moment, index, following = min(found, key=lambda event: event[0])
        path = _path_to_event(run, groups, scene, command, path, moment, index)
    run.peak = max(run.peak, float(max(abs(path.foot_rate))))
    if not found:
        return path, None
    if following is None:
        run.clearance = min(run.clearance, run.peak)
        push = run.motion * path.force[-1]
        if not scene.ratchet:
            run.clearance = min(run.clearance, abs(float(push - groups.static_friction)))
        following = -run.motion if not scene.ratchet and push > groups.static_friction else STICK
    return path, following


def _path_to_event(run, groups, scene, command, path, moment, index):
    """The path solved anew so that it ends on the event."""
    if moment == 0:
        held = {name: values[:1] for name, values in vars(path).items() if name != "length"}
        return SimpleNamespace(length=Decimal(0), **held)
    length = moment * path.length
    for _ in range(6):
        ended, _ = _step(run, groups, command, length)
        value = _gaps(run, groups, scene, ended)[index][0][-1]
        slope = _slope(run, groups, command, ended, index)
        if slope == 0:
            break
        change = -value / slope
        if abs(change) <= Decimal("1e-40") * path.length or slope > 0:
            break
        length += change
    # Less steep by d, the gap would have turned round some d^2 above this root.
    run.clearance = min(run.clearance, float(slope) ** 2)
    return ended


def _slope(run, groups, command, path, index):
    """Rate of the event function at a path's end."""
    p, force = path.pressure[-1], path.force[-1]
    r, drag = groups.foot_mass_fraction, run.motion * groups.kinetic_friction
    if run.motion != STICK:
        return run.motion * (-force - drag) / r
    z, v = path.payload[-1] - path.foot[-1], path.payload_rate[-1]
    area = 1 + groups.radial_coupling * z
    slope = (command - p) / groups.deborah * area - 2 * groups.damping_ratio * force / (1 - r)
    slope += (groups.radial_coupling * p - 1 - 3 * groups.duffing * z * z) * v
    return slope if index == 0 else -slope


def _descent(run, values):
    """First fraction of the step at which a function, given at 0 and the nodes, falls through zero; or None."""
    tables = _tables(run.nodes)
    scale = float(max(abs(value) for value in values))
    if scale == 0.0:
        return None
    coefficients = tables.transform @ values
    series = coefficients.astype(float)
    seen = tables.looks @ series
    doubt = 1e-12 * scale

    def exactly(i):
        return _clenshaw(coefficients, Decimal(float(_LOOKS[i])))

    begun = False
    for i in range(len(_LOOKS)):
        value = exactly(i) if abs(seen[i]) < doubt else Decimal(seen[i])
        if i == 0:
            value = values[0]
        # What starts at zero, but for rounding, has not fallen yet.
        if not begun and abs(value) < _NEGLIGIBLE:
            continue
        if not begun and value < 0:
            return Decimal(0)
        low = Decimal(float(_LOOKS[i - 1])) if begun else Decimal(float(_LOOKS[i]))
        begun = True
        here = Decimal(float(_LOOKS[i]))
        slack = doubt if abs(seen[i]) < doubt else 0.0
        if 0 < i < len(_LOOKS) - 1 and value >= 0 and seen[i] - slack < min(seen[i - 1], seen[i + 1]):
            # How far a parabola through three looks may dip below the lowest.
            if seen[i] > 2.0 * max(seen[i - 1] - seen[i], seen[i + 1] - seen[i]) + doubt:
                run.clearance = min(run.clearance, seen[i])
                continue
            turning, least = _minimum(coefficients, low, Decimal(float(_LOOKS[i + 1])))
            if low < turning < Decimal(float(_LOOKS[i + 1])):
                run.clearance = min(run.clearance, abs(float(least)))
                if least < 0:
                    here, value = turning, least
        if value < 0:
            return _root(coefficients, low, here)
    return None


def _clenshaw(coefficients, t):
    """Legendre series at 2 t - 1."""
    x = 2 * t - 1
    rises, falls = _tables(len(coefficients) - 1).recurrence
    last = before = Decimal(0)
    for n in range(len(coefficients) - 1, 0, -1):
        last, before = coefficients[n] + rises[n] * x * last - falls[n] * before, last
    return coefficients[0] + x * last - before / 2


def _minimum(coefficients, low, high):
    """Least value between two times, by ternary search."""
    for _ in range(90):
        third = (high - low) / 3
        if _clenshaw(coefficients, low + third) < _clenshaw(coefficients, high - third):
            high -= third
        else:
            low += third
    return low, _clenshaw(coefficients, low)


def _root(coefficients, low, high):
    """Root between a time where the series is positive and one where it is negative: bisection, then the secant."""
    for _ in range(24):
        middle = (low + high) / 2
        low, high = (middle, high) if _clenshaw(coefficients, middle) > 0 else (low, middle)
    above, below = _clenshaw(coefficients, low), _clenshaw(coefficients, high)
    return low if above == below else low + (high - low) * above / (above - below)


SAMPLED = ("deformation", "velocity", "pressure", "foot", "foot_velocity")


def reference(row) -> dict:
    """What `extremes.json` stores for a row of `extreme_rows`: its inputs and the judge's verdict in 25 digits."""
    arguments = (row.groups, row.schedule, row.hold)
    run = stiff_run(*arguments, **row.options)
    return {
        **row.inputs(),
        "samples": {
            name: [_written(value) for value in values]
            for name, values in zip(SAMPLED, zip(*run.samples, strict=True), strict=True)
        },
        "events": [[_written(time), motion] for time, motion in run.events],
        "slips": sum(motion != STICK for _, motion in run.events),
        "clearance": float(f"{run.clearance:.3g}"),
        "condition": float(f"{_condition(run, arguments, row.options):.3g}"),
    }


def _written(value):
    return f"{value:.{_STORED_DIGITS - 1}e}"


def _condition(run, arguments, options):
    """Largest change of a sample per change of the initial z or v, or of the force: a constant, in phase with z, or v.

    The force in phase is what a resonance adds up; it is no larger than the constant one.
    """
    farthest, fastest = (max(1.0, *(abs(float(row[i])) for row in run.samples)) for i in (0, 1))
    changes = [
        {"nudge": (_NUDGE, 0.0)},
        {"nudge": (0.0, _NUDGE)},
        {"bias": (_NUDGE, 0.0, 0.0)},
        {"bias": (0.0, _NUDGE / farthest, 0.0)},
        {"bias": (0.0, 0.0, _NUDGE / fastest)},
    ]
    worst = 0.0
    for change in changes:
        other = stiff_run(*arguments, **options, **change)
        moved = np.abs(np.array(other.samples, dtype=object) - np.array(run.samples, dtype=object))
        worst = max(worst, float(moved.max()) / _NUDGE)
    return worst


def _regenerate(names):
    """Compute references anew, all or those of the named rows, and replace the file."""
    from extreme_rows import REFERENCES, ROWS, stored

    references = stored() if REFERENCES.exists() else {}
    for name in names or ROWS:
        references[name] = reference(ROWS[name])
        slips, clearance, condition = (references[name][key] for key in ("slips", "clearance", "condition"))
        print(f"{name}: {slips} slips, clearance {clearance}, condition {condition}", flush=True)
        unfinished = REFERENCES.with_suffix(".tmp")
        kept = {name: references[name] for name in ROWS if name in references}
        unfinished.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
        os.replace(unfinished, REFERENCES)


if __name__ == "__main__":
    if sys.argv[1:2] != ["--regenerate"]:
        sys.exit(f"usage: python {sys.argv[0]} --regenerate [ROW ...]")
    _regenerate(sys.argv[2:])
