"""Closed loops: reservoirs stepped on, valid times known by hand, and the exponents of the series."""

import math

import numpy as np
import pytest

from stickslip.reservoir import RidgeReadout
from stickslip.tasks import BodyReservoir, ClosedLoopTask, DelayLine, EchoState, lorenz, mackey_glass, stepper, TASKS
from stickslip.tasks.closed_loop import _valid_samples

SERIES = np.random.default_rng(0).random(60)
LOGISTIC = math.log(2)


def logistic(length, seed):
    series = np.empty(length)
    series[0] = np.random.default_rng(seed).uniform(0.1, 0.9)
    for k in range(1, length):
        series[k] = 4 * series[k - 1] * (1 - series[k - 1])
    return series


@pytest.mark.parametrize(
    "reservoir",
    [
        DelayLine(4),
        EchoState(6, 0.8, 0.5, leak=0.6, centred=True),
        EchoState(6, topology="cycle"),
        BodyReservoir(virtual_nodes=2),
        BodyReservoir(scene={"segments": 3, "tube_mass": 1.0, "anchored": True}, virtual_nodes=1),
        BodyReservoir(encoding="sigma_delta", holds_per_sample=3, virtual_nodes=3),
        lambda series, seed: np.cumsum(series)[:, None],
    ],
)
def test_a_reservoir_stepped_on_gives_the_rows_of_the_whole_series(reservoir):
    whole = reservoir(SERIES, 3)
    step = stepper(reservoir, SERIES[:40], 3)
    np.testing.assert_allclose([step(float(value)) for value in SERIES[40:]], whole[40:], rtol=0, atol=1e-8)


def test_who_knows_the_map_is_valid_to_the_horizon_and_who_knows_nothing_is_not():
    task = ClosedLoopTask(logistic, LOGISTIC, horizon=8.0, noise=0.0)
    known = task.attempt(lambda u, seed: np.stack([u, u * u], axis=1), length=600, seed=1, washout=10)
    assert known.score == pytest.approx(LOGISTIC * math.ceil(8 / LOGISTIC))
    assert len(known.details["valid times"]) == task.forecasts
    noise = np.random.default_rng(0).standard_normal((600, 1))
    assert task.attempt(lambda u, seed: noise[: len(u)], length=600, seed=1, washout=10).score < 1.5


def test_a_valid_time_is_the_logarithm_of_the_error_it_starts_with():
    """What is heard wrongly by delta grows by e in each Lyapunov time, to 0.4 standard deviations."""
    delta = 1e-6
    task = ClosedLoopTask(logistic, LOGISTIC, horizon=25.0, forecasts=60, noise=0.0)
    score = task.attempt(
        lambda u, seed: np.stack([u, u * u, delta * np.sin(1e4 * u)], axis=1) @ np.array([[1, 0], [0, 1], [1, 0]]),
        length=4000,
        seed=0,
        washout=10,
    ).score
    assert score == pytest.approx(math.log(0.4 * math.sqrt(1 / 8) / (4 * delta)), abs=1.5)


@pytest.mark.parametrize(
    ("change", "washout", "length"),
    [
        ({}, 10, 300),
        ({"forecasts": 3}, 10, 300),
        ({"horizon": 2.0}, 10, 300),
        ({"tolerance": 0.05}, 10, 300),
        ({"noise": 0.05}, 10, 300),
        ({"noise": 0.0}, 10, 300),
        ({"exponent": 0.1}, 10, 300),
        ({"exponent": 0.1}, 200, 240),  # too short for a horizon: half of the samples that are foretold in
        ({}, 57, 300),
    ],
)
def test_every_argument_of_a_closed_loop_is_heard(change, washout, length):
    """The whole task once more, on a delay line of two taps and their squares, in loops."""
    of = {"exponent": LOGISTIC, "forecasts": 10, "horizon": 8.0, "tolerance": 0.4, "noise": 1e-4, **change}

    def states(heard):
        early = np.concatenate([[0.0], heard[:-1]])
        return np.stack([heard, heard**2, early], axis=1)

    series = logistic(length, 2)
    training = washout + (length - washout) // 2
    noise = np.random.default_rng([2, length]).standard_normal(training - 1)
    noisy = np.clip(series[: training - 1] + of["noise"] * series.std() * noise, 0, 1)
    readout = RidgeReadout().fit(states(noisy)[washout:], series[washout + 1 : training])
    samples = min(math.ceil(of["horizon"] / of["exponent"]), (length - training) // 2)
    times = []
    for begin in np.linspace(training, length - samples, of["forecasts"]).round().astype(int):
        heard = series[:begin].tolist()
        for ahead in range(samples):
            heard.append(float(np.clip(readout.predict(states(np.array(heard[-2:]))[-1:])[0], 0, 1)))
            if abs(heard[-1] - series[begin + ahead]) > of["tolerance"] * series.std():
                break
        else:
            ahead = samples
        times.append(of["exponent"] * ahead)
    found = ClosedLoopTask(logistic, **of).attempt(lambda u, seed: states(u), length=length, seed=2, washout=washout)
    assert found.details["valid times"] == pytest.approx(times)
    assert found.score == pytest.approx(np.mean(times))
    assert change or len(set(times)) > 1


def test_a_forecast_is_valid_up_to_the_tolerance_itself():
    truth = np.array([0.5, 0.5, 0.75, 0.25, 0.0])
    assert _valid_samples(lambda value: value, lambda states: 0.5, truth, 0.25) == 3
    assert _valid_samples(lambda value: value, lambda states: 0.5, truth, 0.24) == 1
    assert _valid_samples(lambda value: value, lambda states: 0.5, truth, 1.0) == 4


def test_what_the_loop_hears_is_kept_within_the_range():
    heard = []
    for reading, expected in ((7.0, 1.0), (-7.0, 0.0)):
        _valid_samples(heard.append, lambda states, reading=reading: reading, np.full(3, 0.5), 9.0)
        assert heard == [0.5, expected]
        heard.clear()


def test_a_candidate_foretells_the_second_half_of_the_training_from_the_first():
    asked = []

    class Listening:
        def __call__(self, series, seed):
            asked.append(("fitted", len(series), seed))
            return np.stack([series, series**2], axis=1)

        def stepper(self, series, seed):
            asked.append(("stepped", len(series), seed))
            return lambda value: np.array([value, value**2])

    class Tuned:
        candidates = (Listening(),)

    ClosedLoopTask(logistic, LOGISTIC, forecasts=2, horizon=1.0).attempt(Tuned(), length=440, seed=6, washout=40)
    # The readout is fitted on samples 40 to 240 of 440; of a candidate on 40 to 140. A horizon is 2 samples.
    assert asked == [
        ("fitted", 139, 6), ("stepped", 139, 6), ("stepped", 237, 6),
        ("fitted", 239, 6), ("stepped", 239, 6), ("stepped", 437, 6),
    ]  # fmt: skip


def test_a_network_is_tuned_before_the_forecasts_begin():
    """What is foretold may not be seen: another second half leaves the choice, and so the readout, as it is."""
    heard = []

    class Tuned:
        candidates = (EchoState(5), EchoState(5, 0.5, 1.0))

    def draw(length, seed):
        return logistic(length, seed)

    class Recorded:
        def __init__(self, network):
            self.network = network

        def __call__(self, series, seed):
            heard.append(len(series))
            return self.network(series, seed)

        def stepper(self, series, seed):
            heard.append(len(series))
            return self.network.stepper(series, seed)

    Tuned.candidates = tuple(map(Recorded, Tuned.candidates))
    task = ClosedLoopTask(draw, LOGISTIC, forecasts=2)
    task.attempt(Tuned(), length=400, seed=0, washout=20)
    # Both candidates, each fitted once and stepped on twice, hear nothing after the 210 samples of the training.
    assert len(heard) == 3 * 3
    assert max(heard[:6]) < 210 <= max(heard[6:])


def test_a_network_of_hundreds_of_nodes_foretells_lorenz_for_lyapunov_times():
    network = EchoState(300, 0.6, 3.0, centred=True)
    score = TASKS["Lorenz valid time"].attempt(network, length=4000, seed=0, washout=200).score
    assert 2.5 < score < 8
    assert TASKS["Lorenz valid time"].attempt(DelayLine(12), length=4000, seed=0, washout=200).score < 1
    glass = TASKS["Mackey-Glass valid time"].attempt(
        EchoState(200, 0.5, 1.0, centred=True), length=4000, seed=0, washout=200
    )
    assert glass.score > 2.5


def test_the_exponent_of_lorenz():
    """Sprott: 0.9056. The growth of a small distance, set back after each half unit of time."""
    step, count, distance = 0.5, 3000, 1e-7
    here = lorenz(1, transient=50.0)[0]
    there = here + np.array([distance, 0, 0])
    growth = 0.0
    for _ in range(count):
        here, there = (lorenz(2, step=step, start=start, transient=0.0)[1] for start in (here, there))
        apart = there - here
        growth += math.log(np.linalg.norm(apart) / distance)
        there = here + apart * (distance / np.linalg.norm(apart))
    assert TASKS["Lorenz valid time"].exponent == pytest.approx(0.02 * growth / (step * count), rel=0.04)


def test_the_exponent_of_mackey_glass():
    """About 0.006 at a delay of 17: the growth of a small distance until it is no longer small."""
    rates = []
    for start in (0.6, 0.8, 0.9, 1.1, 1.2, 1.3):
        one, other = (mackey_glass(1500, step=2.0, start=each, transient=500.0) for each in (start, start + 1e-9))
        # The largest in a hundred units of time, which are beyond the swings of one period.
        apart = np.log(np.abs(one - other)).reshape(-1, 50).max(axis=1)
        small = apart < math.log(1e-2)
        rates.append(np.polyfit(100.0 * np.flatnonzero(small), apart[small], 1)[0])
    assert TASKS["Mackey-Glass valid time"].exponent / 3.0 == pytest.approx(np.mean(rates), rel=0.35)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"exponent": 0.0}, r"exponent must be in \(0, inf\), got 0"),
        ({"forecasts": 0}, "forecasts must be a whole number >= 1, got 0"),
        ({"horizon": -1.0}, r"horizon must be in \(0, inf\), got -1"),
        ({"tolerance": 0.0}, r"tolerance must be in \(0, inf\), got 0"),
        ({"noise": -1.0}, r"noise must be in \[0, inf\), got -1"),
    ],
)
def test_bad_input(change, message):
    with pytest.raises(ValueError, match=message):
        ClosedLoopTask(**{"draw": logistic, "exponent": LOGISTIC, **change})


def test_a_series_too_short():
    with pytest.raises(ValueError, match="length must be a whole number >= 108, got 100"):
        TASKS["Lorenz valid time"].attempt(DelayLine(2), length=100, seed=0, washout=100)
