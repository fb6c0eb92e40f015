"""Taylor coefficients, against mpmath, and the choice of order and step."""

import mpmath
import numpy as np
import pytest

from stickslip.compiling.roots import LARGEST_DEGREE
from stickslip.crawler import Groups, Scene
from stickslip.crawler.model.state import BACKWARD, Body, coefficients_of, FORWARD, STUCK
from stickslip.crawler.steps.options import TAYLOR
from stickslip.crawler.steps.taylor import expand, order_for, ORDERS
from stickslip.crawler.steps.taylor_series import series_coefficients
from stickslip.crawler.steps.workspace import (
    END_FORCE,
    END_V,
    END_Z,
    FORCE,
    HIGHEST,
    LENGTH,
    LOWEST,
    P,
    ROWS,
    STEP,
    V,
    WIDTH,
    Z,
)

ORDER = 12
CASES = [
    (Groups(), STUCK, 1.0),
    (Groups(), FORWARD, 0.0),
    (Groups(duffing=7.0, damping_ratio=0.4, deborah=0.2, radial_coupling=1.1), BACKWARD, 1.0),
    (Groups(duffing=0.0, damping_ratio=0.0, radial_coupling=0.0, foot_mass_fraction=0.9), FORWARD, 1.0),
]


def expanded(groups, motion, valve, order=ORDER, state=(0.4, -0.3, 0.7), tolerance=1e-9, remaining=np.inf):
    series = np.full((ROWS, WIDTH), np.nan)
    body = Body(*state, 0.0, 0.0, motion, 0)
    expand(body, coefficients_of(groups, Scene(ratchet=False)), valve, TAYLOR[order](), tolerance, remaining, series)
    return series


@pytest.mark.parametrize(("groups", "motion", "valve"), CASES)
def test_coefficients_are_those_of_mpmath(groups, motion, valve):
    series = expanded(groups, motion, valve)
    r = mpmath.mpf(groups.foot_mass_fraction)

    def force(z, v, p):
        area = 1 + groups.radial_coupling * z
        return p * area - z - groups.duffing * z**3 - 2 * mpmath.mpf(groups.damping_ratio) * v

    def rates(_, state):
        # Payload and foot by their own equations of motion, the pressure by its own.
        z, v, p = state[0] - state[1], state[2] - state[3], state[4]
        pull = force(z, v, p)
        foot = 0 if motion == STUCK else (-pull - motion * mpmath.mpf(groups.kinetic_friction)) / r
        return [state[2], state[3], pull / (1 - r), foot, (valve - p) / mpmath.mpf(groups.deborah)]

    with mpmath.workdps(60):
        foot_rate = mpmath.mpf(0)
        start = [mpmath.mpf(0.4), mpmath.mpf(0), mpmath.mpf(-0.3), foot_rate, mpmath.mpf(0.7)]
        solution = mpmath.odefun(rates, 0, start, tol=mpmath.mpf(10) ** -45)
        variables = {
            Z: lambda s: s[0] - s[1],
            V: lambda s: s[2] - s[3],
            P: lambda s: s[4],
            FORCE: lambda s: force(s[0] - s[1], s[2] - s[3], s[4]),
        }
        # Derivatives from values about a hundredth apart, by fitting a polynomial of thrice the order.
        nodes = [mpmath.mpf(j) / 200 for j in range(3 * ORDER + 3)]
        states = [solution(node) for node in nodes]
        for row, of in variables.items():
            expected = _interpolated(nodes, [of(state) for state in states])[: ORDER + 1]
            for n, coefficient in enumerate(expected):
                assert series[row, n] == pytest.approx(float(coefficient), rel=1e-11, abs=1e-11)


def _interpolated(nodes, values):
    """Ascending coefficients of the polynomial through the values (Newton's divided differences)."""
    differences = list(values)
    for level in range(1, len(nodes)):
        for i in range(len(nodes) - 1, level - 1, -1):
            differences[i] = (differences[i] - differences[i - 1]) / (nodes[i] - nodes[i - level])
    coefficients = [differences[-1]]
    for node, difference in zip(reversed(nodes[:-1]), reversed(differences[:-1]), strict=True):
        shifted = [mpmath.mpf(0), *coefficients]
        for n, c in enumerate(coefficients):
            shifted[n] -= node * c
        shifted[0] += difference
        coefficients = shifted
    return coefficients


@pytest.mark.parametrize(("groups", "motion", "valve"), CASES)
def test_coefficients_do_not_depend_on_the_order(groups, motion, valve):
    low, high = expanded(groups, motion, valve, ORDERS[0]), expanded(groups, motion, valve, ORDERS[-1])
    for row in (Z, V, P, FORCE):
        np.testing.assert_array_equal(low[row, :9], high[row, :9])
    np.testing.assert_array_equal(low[[Z, V], 9], high[[Z, V], 9])


def test_an_exponential_pressure():
    groups = Groups(deborah=0.25)
    series = expanded(groups, STUCK, 1.0)
    expected = [1.0 - 0.3] + [-0.3 * (-4.0) ** n / float(mpmath.factorial(n)) for n in range(1, ORDER + 1)]
    np.testing.assert_allclose(series[P, : ORDER + 1], expected, rtol=1e-14)


@pytest.mark.parametrize("tolerance", 10.0 ** np.arange(-15, -1))
def test_the_step_leaves_out_no_more_than_the_tolerance(tolerance):
    order = order_for(tolerance)
    series = expanded(Groups(duffing=3.0), STUCK, 1.0, order, tolerance=tolerance)
    length = series[STEP, LENGTH]
    assert length > 0.0
    last = [(n + 1) * abs(series[V, n + 1]) * length**n for n in (order - 1, order)]
    # The length is found with logarithms to a twentieth, which is a part in hundreds of it.
    assert max(last) == pytest.approx(tolerance, rel=0.15)


def test_the_order_grows_with_the_digits_asked_for():
    orders = [order_for(10.0**-digits) for digits in range(2, 16)]
    assert orders == sorted(orders)
    assert orders[-1] == ORDERS[-1] <= LARGEST_DEGREE
    assert orders[0] == ORDERS[0]
    assert set(orders) <= set(ORDERS)


def test_a_body_at_rest_takes_a_long_step_but_a_finite_one():
    series = expanded(Groups(), STUCK, 0.0, state=(0.0, 0.0, 0.0))
    assert 1.0 <= series[STEP, LENGTH] < 2.0 * np.pi


def test_no_step_is_longer_than_asked_for():
    assert expanded(Groups(), STUCK, 1.0, remaining=1e-3)[STEP, LENGTH] == 1e-3


@pytest.mark.parametrize("order", ORDERS)
def test_machine_code_computes_what_the_recurrence_says(order):
    groups, state = Groups(duffing=3.0), (0.4, -0.3, 0.7)
    series = expanded(groups, STUCK, 1.0, order, state)
    coefficient = coefficients_of(groups, Scene())
    with mpmath.workdps(40):
        numbers = [*state, 1.0, coefficient.lag_rate, coefficient.radial_coupling, coefficient.duffing]
        numbers += [coefficient.damping, 1.0 / coefficient.payload_fraction, 0.0]
        rows = series_coefficients(order, *(mpmath.mpf(number) for number in numbers))
    for written, row in zip(series, rows, strict=False):
        np.testing.assert_allclose(written[: len(row)], [float(number) for number in row], rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize(("groups", "motion", "valve"), CASES)
@pytest.mark.parametrize("order", ORDERS)
def test_a_step_knows_its_end_and_the_reach_of_its_event_function(groups, motion, valve, order):
    series = expanded(groups, motion, valve, order)
    step = series[STEP]
    rows = {END_Z: series[Z, : order + 2], END_V: series[V, : order + 2], END_FORCE: series[FORCE, : order + 1]}
    for column, row in rows.items():
        assert step[column] == pytest.approx(np.polynomial.polynomial.polyval(step[LENGTH], row), rel=1e-13, abs=1e-15)
    terms = series[FORCE, 1 : order + 1].copy()
    if motion != STUCK:
        terms = -motion * (1.0 - groups.foot_mass_fraction) * series[V, 1 : order + 1]
        terms[0] -= groups.kinetic_friction
    terms *= step[LENGTH] ** np.arange(1, order + 1)
    assert step[LOWEST] == pytest.approx(np.minimum(terms, 0.0).sum(), rel=1e-12)
    assert step[HIGHEST] == pytest.approx(np.maximum(terms, 0.0).sum(), rel=1e-12)
