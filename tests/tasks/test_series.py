"""Chaotic series and waveforms against mpmath, SciPy and what is known of them."""

import math

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stickslip.tasks import chaos, lorenz, mackey_glass, waveforms


@pytest.mark.parametrize("start", [0.3, 1.2])
def test_mackey_glass_over_its_first_delay_is_an_exponential(start):
    """The delayed x is constant there: x = g / 0.1 + (start - g / 0.1) e^(-0.1 t)."""
    rest = 2.0 * start / (1.0 + start**10)
    times = 0.5 * np.arange(34)
    expected = rest + (start - rest) * np.exp(-0.1 * times)
    np.testing.assert_allclose(mackey_glass(34, step=0.5, start=start, transient=0.0), expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize("delay", [17.0, 30.0])
def test_mackey_glass_against_scipy_delay_by_delay(delay):
    start, spans = 0.9, 6
    piece = [lambda t: np.full_like(np.asarray(t), start)]
    opening = start
    for n in range(spans):

        def rate(t, x, n=n):
            late = piece[n](t - delay)
            return 0.2 * late / (1.0 + late**10) - 0.1 * x

        span = (n * delay, (n + 1) * delay)
        solution = solve_ivp(rate, span, [opening], method="DOP853", rtol=1e-12, atol=1e-13, dense_output=True)
        piece.append(lambda t, sol=solution.sol: sol(t)[0])
        opening = solution.y[0, -1]
    times = np.arange(int(delay * spans))
    expected = [float(piece[int(t // delay) + 1](float(t))) for t in times]
    # SciPy's interpolant is of order 7, so that its own error is some 1e-9.
    series = mackey_glass(len(times), delay=delay, start=start, transient=0.0)
    np.testing.assert_allclose(series, expected, rtol=0, atol=1e-8)


def delayed_runge_kutta(delay, start, spans, steps):
    """The classical Runge-Kutta method at `steps` a delay, the delayed x between two of them by Hermite's cubic."""
    h = delay / steps
    x, slope = np.full(steps * spans + 1, start), np.zeros(steps * spans + 1)

    def production(late):
        return 0.2 * late / (1.0 + late**10)

    def late(i):
        return (start, 0.0) if i < steps else (x[i - steps], slope[i - steps])

    for i in range(steps * spans):
        (a, da), (b, db) = late(i), late(i + 1)
        if i < steps:
            b, db = start, 0.0
        early, middle, end = map(production, (a, 0.5 * (a + b) + h / 8 * (da - db), b))
        one = early - 0.1 * x[i]
        two = middle - 0.1 * (x[i] + h / 2 * one)
        three = middle - 0.1 * (x[i] + h / 2 * two)
        four = end - 0.1 * (x[i] + h * three)
        x[i + 1] = x[i] + h / 6 * (one + 2 * two + 2 * three + four)
        slope[i], slope[i + 1] = one, end - 0.1 * x[i + 1]
    return x


@pytest.mark.parametrize(("delay", "error"), [(17.0, 3e-12), (30.0, 2e-11), (60.0, 2e-10), (100.0, 2e-9)])
def test_mackey_glass_against_runge_kutta_at_every_delay(delay, error):
    """The judge errs by some fourth power of its step: less than the bound here, and a sixteenth at half the step."""
    series = mackey_glass(160, delay=delay, step=delay / 20, start=0.9, transient=0.0)
    coarse, fine = (delayed_runge_kutta(delay, 0.9, 8, steps)[: -1 : steps // 20] for steps in (400, 800))
    assert np.abs(fine - series).max() < error
    assert np.abs(fine - series).max() < np.abs(coarse - series).max() / 8


def test_mackey_glass_begins_where_the_transient_ends():
    later = mackey_glass(5, delay=20.0, step=2.0, start=0.7, transient=30.0)
    np.testing.assert_allclose(later, mackey_glass(20, delay=20.0, step=2.0, start=0.7, transient=0.0)[15:], atol=1e-14)
    np.testing.assert_array_equal(mackey_glass(5), mackey_glass(5, delay=17.0, step=1.0, start=1.2, transient=1000.0))
    assert len(mackey_glass(1, delay=100.0, start=1.5)) == 1


def test_mackey_glass_does_not_depend_on_its_nodes(monkeypatch):
    series = mackey_glass(300, transient=0.0)
    monkeypatch.setattr(chaos, "_NODES", 100)
    np.testing.assert_allclose(series, mackey_glass(300, transient=0.0), rtol=0, atol=2e-13)


def test_mackey_glass_samples_one_motion_whatever_the_step():
    fine = mackey_glass(600, step=0.25, transient=100.0)
    np.testing.assert_allclose(mackey_glass(100, step=1.5, transient=100.0), fine[::6], rtol=0, atol=1e-13)
    settled = mackey_glass(5000, step=2.0)
    assert 0.2 < settled.min() < settled.max() < 1.4


def test_lorenz_against_mpmath():
    with mp.workdps(30):

        def rates(_, state):
            x, y, z = state
            return [10 * (y - x), x * (28 - z) - y, x * y - mp.mpf(8) / 3 * z]

        flow = mp.odefun(rates, 0, [1, 2, 20], tol=mp.mpf(10) ** -20)
        expected = np.array([[float(v) for v in flow(0.25 * k)] for k in range(5)])
    series = lorenz(5, step=0.25, start=(1, 2, 20), transient=0.0)
    np.testing.assert_allclose(series, expected, rtol=0, atol=1e-12)
    np.testing.assert_allclose(lorenz(1, start=(1, 2, 20), transient=1.0), expected[-1:], rtol=0, atol=1e-12)


def test_lorenz_by_default_and_with_each_argument():
    usual = {"step": 0.05, "start": (1.0, 1.0, 1.0), "transient": 50.0}
    np.testing.assert_array_equal(lorenz(4), lorenz(4, **usual))
    for change in ({"step": 0.1}, {"start": (1.0, 1.0, 2.0)}, {"transient": 49.0}):
        assert (lorenz(4) != lorenz(4, **{**usual, **change})).any(axis=1)[1:].all()
    start = np.array([1.0, 2.0, 20.0])
    lorenz(3, start=start)
    np.testing.assert_array_equal(start, [1.0, 2.0, 20.0])


def test_lorenz_steps_the_same_in_one_call_or_in_many(monkeypatch):
    whole = lorenz(3, step=0.31, transient=2.0)
    monkeypatch.setattr(chaos, "_STEPS_OF_A_CALL", 7)
    np.testing.assert_array_equal(lorenz(3, step=0.31, transient=2.0), whole)


def test_lorenz_contracts_volumes_at_its_known_rate():
    """The divergence of the flow is -(10 + 1 + 8/3) everywhere."""
    start, size, time = np.array([1.0, 2.0, 20.0]), 1e-5, 0.5
    columns = [
        (lorenz(1, start=start + d, transient=time)[0] - lorenz(1, start=start - d, transient=time)[0]) / (2 * size)
        for d in size * np.eye(3)
    ]
    assert math.log(np.linalg.det(columns)) == pytest.approx(-(11 + 8 / 3) * time, abs=1e-6)


def test_lorenz_stays_on_its_attractor():
    x, y, z = lorenz(4000).T
    assert np.abs(x).max() < 20
    assert np.abs(y).max() < 28
    assert 0 < z.min() < z.max() < 49
    assert z.mean() == pytest.approx(23.55, abs=0.5)


def test_waveforms_by_hand():
    inputs, kinds = waveforms(8 * 400, 0)
    assert set(kinds.tolist()) == {0, 1}
    half = math.sqrt(0.5)
    for period, kind in zip(inputs.reshape(-1, 8), kinds.reshape(-1, 8), strict=True):
        assert len(set(kind.tolist())) == 1
        shape = [1.0] * 4 + [-1.0] * 4 if kind[0] else [0.0, half, 1.0, half, 0.0, -half, -1.0, -half]
        np.testing.assert_allclose(period, shape, atol=1e-15)
    assert abs(kinds.mean() - 0.5) < 4 * 0.5 / math.sqrt(400)
    changes = kinds[8::8] != kinds[:-8:8]
    assert abs(changes.mean() - 0.5) < 4 * 0.5 / math.sqrt(399)


def test_waveforms_without_memory_are_told_in_seven_of_eight_samples_at_most():
    """The best guess from a value alone: a square wherever the square's values are seen."""
    inputs, kinds = waveforms(80_000, 1)
    guess = np.isclose(np.abs(inputs), 1.0)
    assert (guess == kinds).mean() == pytest.approx(7 / 8, abs=0.01)


def test_waveforms_are_drawn_by_period():
    inputs, kinds = waveforms(20, 3)
    np.testing.assert_array_equal(kinds, np.repeat(np.random.default_rng(3).integers(0, 2, 3), 8)[:20])
    np.testing.assert_array_equal(inputs, waveforms(20, 3, points=8)[0])
    np.testing.assert_array_equal(
        waveforms(4, 0, points=4)[0] ** 2, [0, 1, 0, 1] if not waveforms(4, 0, points=4)[1][0] else [1] * 4
    )
    assert (kinds.dtype, inputs.dtype) == (np.int64, np.float64)


def test_waveforms_may_end_within_a_period():
    inputs, kinds = waveforms(13, 2, points=12)
    np.testing.assert_array_equal(inputs[:12], waveforms(12, 2, points=12)[0])
    assert len(inputs) == len(kinds) == 13


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: mackey_glass(0), "length must be a whole number >= 1, got 0"),
        (lambda: mackey_glass(5, delay=0), r"delay must be in \(0, 100\], got 0"),
        (lambda: mackey_glass(5, step=-1.0), r"step must be in \(0, inf\), got -1.0"),
        (lambda: mackey_glass(5, start=2.0), r"start must be in \(0, 1.5\], got 2.0"),
        (lambda: lorenz(5, start=(1, 2)), "start must have 3 numbers, got 2"),
        (lambda: lorenz(5, start=(1, 2, np.inf)), r"start must be finite, got inf at index \(2,\)"),
        (lambda: lorenz(5, transient=-1), r"transient must be in \[0, inf\), got -1"),
        (lambda: waveforms(5, 0, points=6), "points must be a multiple of 4, got 6"),
        (lambda: waveforms(5, -1), "seed must be a whole number >= 0, got -1"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(ValueError, match=message):
        call()
