"""The tasks known by name: their series written out again in plain Python, and what they score."""

import math
from itertools import pairwise

import numpy as np
import pytest

from stickslip.tasks import (
    BodyReservoir,
    ClosedLoopTask,
    DelayLine,
    FrictionTask,
    lorenz,
    mackey_glass,
    TASKS,
    waveforms,
)
from stickslip.tasks.task import DELAYS

RUN = {"length": 900, "seed": 4, "washout": 60}

NAMES = [
    "memory capacity",
    "parity-2 capacity",
    "parity-3 capacity",
    *(f"NARMA-{order} NRMSE" for order in (2, 5, 10, 20)),
    *(f"NARMA-{order} uniform NRMSE" for order in (2, 5, 10, 20)),
    "Mackey-Glass NRMSE",
    "Lorenz NRMSE",
    "Mackey-Glass valid time",
    "Lorenz valid time",
    "waveform accuracy",
    "static friction NRMSE",
    "kinetic friction NRMSE",
]


def test_the_names_in_the_order_that_tables_show():
    assert [name for name in TASKS if name in NAMES] == NAMES
    for name, task in TASKS.items():
        assert name.endswith(task.metric.name)


def naive_narma(u, order):
    y, past = dict.fromkeys(range(-20, 1), 0.0), dict.fromkeys(range(-20, 0), 0.0) | dict(enumerate(u))
    for t in range(len(u)):
        total = sum(y[t - i] for i in range(order))
        product = 1.5 * past[t - order + 1] * past[t]
        y[t + 1] = {
            2: 0.4 * y[t] + 0.4 * y[t] * y[t - 1] + 0.6 * past[t] ** 3 + 0.1,
            20: math.tanh(0.3 * y[t] + 0.05 * y[t] * total + product + 0.01) + 0.2,
        }.get(order, 0.3 * y[t] + 0.05 * y[t] * total + product + 0.1)
    return [y[t + 1] for t in range(len(u))]


def naive_series(name, length, seed):
    """Drive, inputs, targets and warm-up of a task, from NumPy's generator and the equations alone."""
    random = np.random.default_rng(seed)
    kind, _, rest = name.partition(" ")
    if kind in ("memory", "parity-2", "parity-3"):
        order = 1 if kind == "memory" else int(kind[-1])
        bits = random.integers(0, 2, length)
        signs = [math.prod(1 - 2 * int(bit) for bit in bits[max(0, t - order + 1) : t + 1]) for t in range(length)]
        return bits, bits, [(1 - sign) // 2 for sign in signs], order - 1
    if kind.startswith("NARMA"):
        order, uniform = int(kind[6:]), rest.startswith("uniform")
        drive = random.random(length) if uniform else random.integers(0, 2, length)
        inputs = (0.5 if uniform else 0.2) * drive
        return drive, inputs, naive_narma(inputs, order), order
    if kind == "Mackey-Glass":
        series = mackey_glass(length + 14, delay=17.0, step=6.0, start=random.uniform(0.8, 1.3), transient=1000.0)
        return series[:length] / 1.5, series[:length], series[14:], 0
    if kind == "Lorenz":
        start = np.array([0.0, 0.0, 20.0]) + random.uniform(-1.0, 1.0, 3)
        series = lorenz(length + 10, step=0.05, start=start, transient=50.0)[:, 0]
        return 0.5 + 0.02 * series[:length], series[:length], series[10:], 0
    inputs, kinds = waveforms(length, seed, points=8)
    return 0.5 + 0.5 * inputs, inputs, kinds, 0


SERIES = [name for name in NAMES if "valid" not in name and "friction" not in name]


@pytest.mark.parametrize("name", SERIES)
def test_a_draw_is_its_definition(name):
    problem = TASKS[name].draw(200, 7)
    drive, inputs, targets, warm_up = naive_series(name, 200, 7)
    for found, expected in ((problem.drive, drive), (problem.inputs, inputs), (problem.targets, targets)):
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-14)
        assert found.dtype == np.float64
    assert problem.warm_up == warm_up


def naive_nrmse(states, targets, start):
    """Least squares by NumPy on the first half of what is scored, judged on the second."""
    half = start + (len(states) - start) // 2
    design = np.column_stack([states, np.ones(len(states))])
    weights = np.linalg.lstsq(design[start:half], targets[start:half])[0]
    residual = design[half:] @ weights - targets[half:]
    return math.sqrt(np.mean(residual**2)) / targets[half:].std()


@pytest.mark.parametrize("name", [name for name in SERIES if "NRMSE" in name])
def test_an_error_is_that_of_least_squares(name):
    """The penalty that is chosen among four features and hundreds of samples hardly matters."""
    solution = TASKS[name].attempt(DelayLine(4), **RUN)
    drive, _, targets, _ = naive_series(name, RUN["length"], RUN["seed"])
    states = np.column_stack([np.concatenate([np.zeros(lag), drive[: len(drive) - lag]]) for lag in range(4)])
    assert solution.score == pytest.approx(naive_nrmse(states, np.array(targets), RUN["washout"]), rel=5e-3)
    assert len(solution.prediction) == len(solution.target) == 420


def naive_capacity(states, message, start):
    """Squared correlation of the best linear readout with each older message, by NumPy, on held-out samples."""
    found = []
    for delay in range(DELAYS):
        older = np.concatenate([np.zeros(delay), message[: len(message) - delay]])
        found.append(1 - min(1.0, naive_nrmse(states[start + DELAYS :], older[start + DELAYS :], 0) ** 2))
    return np.array(found)


@pytest.mark.parametrize(("name", "taps"), [("memory capacity", 4), ("parity-2 capacity", 0), ("parity-3 capacity", 0)])
def test_a_capacity_is_the_share_of_the_message_that_is_explained(name, taps):
    solution = TASKS[name].attempt(DelayLine(4), **RUN)
    assert solution.score == pytest.approx(taps, abs=1e-6)
    assert len(solution.memory.profile) == DELAYS == 40
    bits, _, message, _ = naive_series(name, RUN["length"], RUN["seed"])
    states = np.column_stack([np.concatenate([np.zeros(lag), bits[: len(bits) - lag]]) for lag in range(4)])
    expected = naive_capacity(states, np.array(message, dtype=float), RUN["washout"])
    np.testing.assert_allclose(solution.memory.profile > 0.5, expected > 0.5)


@pytest.mark.parametrize(
    ("name", "step", "exponent", "series"),
    [
        ("Mackey-Glass valid time", 3.0, 0.006, lambda x: x / 1.5),
        ("Lorenz valid time", 0.02, 0.9056, lambda x: 0.5 + 0.02 * x),
    ],
)
def test_a_closed_loop_is_of_its_own_step_and_exponent(name, step, exponent, series):
    task = TASKS[name]
    random = np.random.default_rng(3)
    if name.startswith("Mackey"):
        expected = mackey_glass(50, step=step, start=random.uniform(0.8, 1.3))
    else:
        expected = lorenz(50, step=step, start=np.array([0.0, 0.0, 20.0]) + random.uniform(-1.0, 1.0, 3))[:, 0]
    np.testing.assert_allclose(task.draw(50, 3), series(expected), rtol=1e-12)
    assert task.exponent == pytest.approx(exponent * step, rel=1e-12)
    assert task == ClosedLoopTask(
        task.draw, task.exponent, forecasts=10, horizon=8.0, tolerance=0.4, noise=1e-4, metric=task.metric
    )


def test_each_friction_task_is_named_after_its_friction():
    assert TASKS["static friction NRMSE"] == FrictionTask("static", word="11100", repeats=6)
    assert TASKS["kinetic friction NRMSE"] == FrictionTask("kinetic", word="11100", repeats=6)
    assert FrictionTask() == FrictionTask("kinetic")


# To a thousandth, as far as another computer repeats it: it adds up in another order, and chaos multiplies that.
GOLDEN = {
    "memory capacity": 3.3163,
    "parity-2 capacity": 0.4094,
    "parity-3 capacity": 0,
    "NARMA-2 NRMSE": 0.125828,
    "NARMA-5 NRMSE": 0.781401,
    "NARMA-10 NRMSE": 0.809303,
    "NARMA-20 NRMSE": 0.810602,
    "NARMA-2 uniform NRMSE": 0.333807,
    "NARMA-5 uniform NRMSE": 0.673886,
    "NARMA-10 uniform NRMSE": 0.85291,
    "NARMA-20 uniform NRMSE": 0.747257,
    "Mackey-Glass NRMSE": 0.621001,
    "Lorenz NRMSE": 1.01789,
    "Mackey-Glass valid time": 0.0396,
    "Lorenz valid time": 0.123162,
    "waveform accuracy": 0.678571,
    "static friction NRMSE": 0.586477,
    "kinetic friction NRMSE": 0.00643851,
}


@pytest.mark.parametrize("name", NAMES)
def test_the_scores_of_a_small_crawler_do_not_move(name):
    assert TASKS[name].attempt(BodyReservoir(virtual_nodes=2), **RUN).score == pytest.approx(GOLDEN[name], rel=1e-3)


def test_the_ladder_of_narma_grows_harder():
    scores = [TASKS[f"NARMA-{order} uniform NRMSE"].attempt(DelayLine(4), **RUN).score for order in (2, 5, 10)]
    assert all(easier < harder for easier, harder in pairwise(scores))


@pytest.mark.parametrize("name", TASKS)
@pytest.mark.parametrize("length", [0, -3, 2.5])
def test_no_task_has_a_draw_of_nothing(name, length):
    with pytest.raises((TypeError, ValueError), match=f"^length must be a whole number >= 1, got {length}"):
        TASKS[name].draw(length, 0)
