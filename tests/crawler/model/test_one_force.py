"""The force is `equations.force` everywhere: what is written apart from it, for speed, equals what follows from it.

Exactly so, in rational arithmetic: a series is a number whose product is Cauchy's rule, a stiffness is a derivative.
"""

from fractions import Fraction
from numbers import Real

import numpy as np
import pytest

from stickslip.compiling.arithmetic import fma
from stickslip.compiling.arithmetic import Series as TracedSeries
from stickslip.crawler.closed_form import search
from stickslip.crawler.model.equations import (
    acceleration_at_no_force,
    elastic_energy,
    force,
    force_gradient,
    held_stiffness,
    mobility_of,
    stiffness_at,
)
from stickslip.crawler.model.groups import NONLINEAR
from stickslip.crawler.model.state import Body, Coefficients, FORWARD, STUCK
from stickslip.crawler.steps import chain_series
from stickslip.crawler.steps.propagator import Rates
from stickslip.crawler.steps.taylor_series import series_coefficients, step_inputs
from stickslip.crawler.steps.workspace import FORCE, P, V, WIDTH, Z

ORDER = 9
VALVE = 1


class Exact(Fraction):
    """A fraction that takes the float nearest to a simple fraction for that fraction."""

    @staticmethod
    def of(number):
        return Exact(Fraction(number).limit_denominator(1000) if isinstance(number, float) else Fraction(number))


def _exactly(name):
    operation = getattr(Fraction, name)

    def exactly(self, other):
        return Exact(operation(self, Exact.of(other))) if isinstance(other, Real) else NotImplemented

    return exactly


for _name in ("add", "sub", "mul", "truediv"):
    for _side in ("", "r"):
        setattr(Exact, f"__{_side}{_name}__", _exactly(f"__{_side}{_name}__"))
Exact.__neg__ = lambda self: Exact(Fraction.__neg__(self))
Exact.__abs__ = lambda self: Exact(Fraction.__abs__(self))


class Series(list):
    """A power series cut off after as many terms as it has, whose product is Cauchy's rule."""

    def _alike(self, other):
        return other if isinstance(other, Series) else [Exact.of(other)] + [Exact(0)] * (len(self) - 1)

    def __add__(self, other):
        return Series(x + y for x, y in zip(self, self._alike(other), strict=True))

    def __sub__(self, other):
        return Series(x - y for x, y in zip(self, self._alike(other), strict=True))

    def __mul__(self, other):
        other = self._alike(other)
        return Series(sum((self[i] * other[n - i] for i in range(n + 1)), Exact(0)) for n in range(len(self)))

    def __radd__(self, other):
        return self + other

    def __rsub__(self, other):
        return Series(y - x for x, y in zip(self, self._alike(other), strict=True))

    def __rmul__(self, other):
        return self * other


COEFFICIENTS = Coefficients(
    duffing=Exact(3, 7),
    damping=Exact(2, 9),
    lag_rate=Exact(5, 4),
    radial_coupling=Exact(3, 8),
    payload_fraction=Exact(7, 10),
    foot_fraction=Exact(3, 10),
    static_friction=Exact(2, 5),
    kinetic_friction=Exact(1, 4),
    slope=Exact(1, 20),
    anchored=False,
    ratchet=False,
)
START = Body(Exact(4, 5), Exact(-2, 3), Exact(1, 3), Exact(0), Exact(1, 6), FORWARD, 0)


def pressure_series():
    """Of p' = lambda (u - p), one order after the other."""
    p = [START.pressure]
    for n in range(1, ORDER + 1):
        p.append(COEFFICIENTS.lag_rate * ((VALVE if n == 1 else 0) - p[-1]) / n)
    return Series(p)


def test_the_stiffness_of_a_series():
    z, p = [Exact(4, 5), Exact(-2, 3), Exact(1, 7), Exact(3, 11)], pressure_series()[:4]
    assert stiffness_at(COEFFICIENTS, TracedSeries(z), TracedSeries(p)) == stiffness_at(
        COEFFICIENTS, Series(z), Series(p)
    )


@pytest.mark.parametrize("mode", [STUCK, FORWARD])
def test_the_recurrence_of_the_taylor_step(mode):
    mobility, constant = mobility_of(COEFFICIENTS, mode), acceleration_at_no_force(COEFFICIENTS, mode)
    motion = step_inputs(START._replace(mode=mode), COEFFICIENTS, VALVE, 0, 0)[:-5]
    series = series_coefficients(ORDER, *motion)
    z, v = [START.deformation], [START.velocity]
    p = pressure_series()
    for n in range(ORDER + 1):
        pull = force(COEFFICIENTS, Series(z), Series(v), Series(p[: n + 1]))
        z.append(v[n] / (n + 1))
        v.append((mobility * pull[n] + (constant if n == 0 else 0)) / (n + 1))
    assert series == (z, v, p, pull)
    assert pull[ORDER] != 0
    assert fma(Exact(1, 3), 1.0 / 3.0, 0.5) == Exact(11, 18), "floats are taken for simple fractions"


@pytest.mark.parametrize("mode", [STUCK, FORWARD])
def test_the_recurrence_of_the_chain(monkeypatch, mode):
    mass = [Exact(2, 5), Exact(1, 7), Exact(3, 4)]
    segments = 2
    stretches = np.array([[Exact(1, 2), Exact(-1, 3)], [Exact(2, 7), Exact(1, 4)]], object)
    mobility = np.array([1 / each for each in mass], object)
    workspace = chain_series.ChainWorkspace(
        mobility,
        stretches,
        np.zeros((7, WIDTH, segments), object),
        np.zeros((16, WIDTH), object),
        np.zeros(WIDTH, object),
        None,
        None,
        np.zeros(segments + 1, object),
        None,
        None,
        None,
    )
    monkeypatch.setattr(chain_series, "accelerate_nodes", chain_series.accelerate_nodes.py_func)
    body = START._replace(mode=mode, foot_velocity=Exact(mode, 6))
    chain_series.expand_chain.py_func(body, COEFFICIENTS, VALVE, ORDER, workspace)

    p = pressure_series()
    z, v = ([[each] for each in row] for row in stretches)
    rates = [[] for _ in mass]
    for n in range(ORDER + 1):
        pulls = [force(COEFFICIENTS, Series(z[j]), Series(v[j]), Series(p[: n + 1]))[n] for j in range(segments)]
        drag = mode * COEFFICIENTS.kinetic_friction + COEFFICIENTS.slope * mass[0]
        loads = [-pulls[0] - (drag if n == 0 else 0), pulls[0] - pulls[1], pulls[1]]
        for j in (1, 2):
            loads[j] -= COEFFICIENTS.slope * mass[j] if n == 0 else 0
        if mode == STUCK:
            loads[0] = Exact(0)
        for rate, load, each in zip(rates, loads, mass, strict=True):
            rate.append(load / each)
        for j in range(segments):
            z[j].append(v[j][n] / (n + 1))
            v[j].append(segments * (rates[j + 1][n] - rates[j][n]) / (n + 1))
        assert list(workspace.segments[FORCE, n]) == pulls
    for j in range(segments):
        assert list(workspace.segments[Z, : ORDER + 2, j]) == z[j]
        assert list(workspace.segments[V, : ORDER + 2, j]) == v[j]
    assert list(workspace.rear[P, : ORDER + 1]) == p


def slopes(z, p):
    """Of the force with respect to z, v and p: the terms of first order about them."""
    for place in range(3):
        z_, v_, p_ = (Series([x, Exact(place == i)]) for i, x in enumerate((z, START.velocity, p)))
        yield force(COEFFICIENTS, z_, v_, p_)[1]


@pytest.mark.parametrize("z", [Exact(0), Exact(4, 5), Exact(-7, 3)])
@pytest.mark.parametrize("p", [Exact(0), Exact(2, 3), Exact(-1)])
def test_the_stiffness_is_the_slope_of_the_force(z, p):
    by_z, by_v, by_p = slopes(z, p)
    assert stiffness_at(COEFFICIENTS, z, p) == -by_z
    assert force_gradient(COEFFICIENTS, z, p) == (by_z, by_v, by_p)
    assert held_stiffness(COEFFICIENTS, z) == stiffness_at(COEFFICIENTS, z, Exact(0))
    energy = elastic_energy(COEFFICIENTS, Series([z, Exact(1), Exact(0)]))
    assert energy[1] == -force(COEFFICIENTS, z, Exact(0), Exact(0))
    assert 2 * energy[2] == stiffness_at(COEFFICIENTS, z, Exact(0))


@pytest.mark.parametrize("mode", [STUCK, FORWARD])
def test_the_force_of_the_closed_form(monkeypatch, mode):
    monkeypatch.setattr(search, "_faded", search._faded.py_func)
    linear = COEFFICIENTS._replace(**dict.fromkeys(NONLINEAR, Exact(0)))
    mobility, constant = mobility_of(linear, mode), acceleration_at_no_force(linear, mode)
    rates = Rates(mobility, linear.damping, linear.lag_rate, *[None] * 5)
    start = search.deviation.py_func(START._replace(mode=mode), linear, VALVE, rates)
    assert start.acceleration == mobility * force(linear, *START[:3]) + constant
    # At rest under the valve's pressure nothing accelerates.
    assert mobility * force(linear, start.rest, 0, Exact(VALVE)) + constant == 0
