"""Nothing keeps or changes what it is given, and nothing that is given out is kept."""

import numpy as np
import pytest

from stickslip.reservoir import (
    delay_line,
    echo_state_property,
    EchoStateNetwork,
    fit_readout,
    information_processing_capacity,
    kernel_quality,
    mean_over_runs,
    memory_capacity,
    memory_over_runs,
    nrmse,
    predict_held_out,
    ranks,
    RecursiveLeastSquares,
    RecursiveLeastSquaresReadout,
    RidgeReadout,
    squared_correlation,
    state_rank,
)
from stickslip.reservoir.prequential import PrequentialMemory

RNG = np.random.default_rng(0)
STATES = RNG.normal(size=(80, 3)) + 1
TARGETS = STATES @ RNG.normal(size=(3, 2)) + RNG.normal(size=(80, 2))
MESSAGE = RNG.integers(0, 2, 80).astype(float)

CALLS = {
    "memory": lambda x, y, e: memory_capacity(x, e, 3, washout=5, resamples=4),
    "memory, left out": lambda x, y, e: memory_capacity(x, e, 3, washout=5, scoring="leave one out", noise=20.0),
    "memory of the far": lambda x, y, e: memory_capacity(x * 2.0**-600, e, np.array([0, 2]), washout=5),
    "information": lambda x, y, e: information_processing_capacity(x, e, delays=4, washout=5, noise=20.0),
    "ranks": lambda x, y, e: ranks(x, x[:20]),
    "rank": lambda x, y, e: state_rank(x),
    "echo": lambda x, y, e: echo_state_property(x.reshape(2, 40, 3)),
    "runs": lambda x, y, e: mean_over_runs(x[:, 0]),
    "line": lambda x, y, e: delay_line(e, 3),
    "network": lambda x, y, e: EchoStateNetwork(4).states(e),
    "nrmse": lambda x, y, e: nrmse(x[:, 0], y[:, 0]),
    "correlation": lambda x, y, e: squared_correlation(x[:, :2], y),
    "fitted": lambda x, y, e: fit_readout(x, y).predict(x),
    "chosen": lambda x, y, e: RidgeReadout(np.abs(y[:5, 0])).fit(x, y).predict(x),
    "recursive": lambda x, y, e: RecursiveLeastSquaresReadout(1.0).fit(x, y).predict(x),
    "held out": lambda x, y, e: predict_held_out(x, y),
}


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_arguments_may_be_read_only_and_are_left_alone(call):
    given = [each.copy() for each in (STATES, TARGETS, MESSAGE)]
    for each in given:
        each.flags.writeable = False
    call(*given)
    for each, was in zip(given, (STATES, TARGETS, MESSAGE), strict=True):
        np.testing.assert_array_equal(each, was)


@pytest.mark.parametrize(
    "readout",
    [RidgeReadout(), RidgeReadout(0.1), RidgeReadout(0.1, fit_intercept=False), RecursiveLeastSquaresReadout()],
    ids=str,
)
@pytest.mark.parametrize("outputs", [1, 2])
def test_a_fitted_readout_keeps_none_of_its_samples(readout, outputs):
    x, y = STATES.copy(), TARGETS[:, :outputs].copy() if outputs > 1 else TARGETS[:, 0].copy()
    readout.fit(x, y)
    before, weights = readout.predict(STATES), readout.coef_.copy()
    x[:], y[:] = np.nan, np.nan
    np.testing.assert_array_equal(readout.predict(STATES), before)
    np.testing.assert_array_equal(readout.coef_, weights)
    assert not np.shares_memory(readout.predict(STATES), readout.predict(STATES))


def test_the_candidates_of_one_readout_are_its_own():
    penalties = np.array([0.1, 1.0])
    chosen, usual = (RidgeReadout(each).fit(STATES, TARGETS) for each in (penalties, None))
    np.testing.assert_allclose(usual.candidates_, 10.0 ** np.arange(-30, 3), rtol=1e-12)
    chosen.candidates_[:] = usual.candidates_[:] = 7.0
    np.testing.assert_array_equal(penalties, [0.1, 1.0])
    np.testing.assert_allclose(RidgeReadout().fit(STATES, TARGETS).candidates_, 10.0 ** np.arange(-30, 3), rtol=1e-12)


@pytest.mark.parametrize("y", [TARGETS, TARGETS[:, 0]], ids=["two outputs", "one output"])
def test_weights_once_read_are_not_learned_on(y):
    readout = RecursiveLeastSquaresReadout().partial_fit(STATES[:10], y[:10])
    read = [np.asarray(readout.coef_), np.asarray(readout.intercept_)]
    kept = [each.copy() for each in read]
    readout.partial_fit(STATES[10:], y[10:])
    for each, was in zip(read, kept, strict=True):
        np.testing.assert_array_equal(each, was)
    assert not np.array_equal(readout.coef_, kept[0])
    before = readout.predict(STATES)
    readout.coef_[:] = 0
    np.testing.assert_array_equal(readout.predict(STATES), before)


def test_a_fit_forgets_what_was_learned_and_a_partial_one_does_not():
    x, y = STATES[:40], TARGETS[:40, 0]
    readout = RecursiveLeastSquaresReadout().partial_fit(100 * x, -y)
    np.testing.assert_array_equal(readout.fit(x, y).coef_, RecursiveLeastSquaresReadout().fit(x, y).coef_)
    first, second = RecursiveLeastSquaresReadout(0.3, forgetting=0.9), RecursiveLeastSquaresReadout(0.3, forgetting=0.9)
    first.fit(x, y).partial_fit(STATES[40:], TARGETS[40:, 0])
    second.partial_fit(x, y)
    for row, target in zip(STATES[40:], TARGETS[40:, 0], strict=True):
        second.partial_fit(row[None], target[None])
    np.testing.assert_allclose(first.coef_, second.coef_, rtol=1e-12)


def test_the_estimator_forgets_as_the_readout_of_a_reward_does():
    """With a constant of the root mean square of all that was fitted."""
    scale = np.sqrt(np.mean(STATES**2))
    judge = RecursiveLeastSquares(4, 2, ridge=0.3, forgetting=0.9, scale=scale)
    for row, target in zip(STATES, TARGETS, strict=True):
        judge.learn([*row, scale], target)
    readout = RecursiveLeastSquaresReadout(0.3, forgetting=0.9).fit(STATES, TARGETS)
    np.testing.assert_array_equal(readout.coef_, judge.weights[:, :3])
    np.testing.assert_array_equal(readout.intercept_, scale * judge.weights[:, 3])
    np.testing.assert_allclose(readout.predict(STATES[:1])[0], judge.predict([*STATES[0], scale]), rtol=1e-13)


def test_what_a_recursive_readout_is_told_and_tells_is_its_own():
    readout = RecursiveLeastSquares(3, 2)
    x, y = STATES[0].copy(), TARGETS[0].copy()
    first = readout.learn(x, y)
    weights, told = readout.weights.copy(), readout.predict(STATES[1])
    x[:] = y[:] = first[:] = np.nan
    told[:] = np.nan
    np.testing.assert_array_equal(readout.weights, weights)
    assert np.isfinite(readout.learn(STATES[1], TARGETS[1])).all()


def test_a_memory_score_keeps_none_of_its_calibration():
    calibration = STATES.copy()
    memory = PrequentialMemory(calibration, 3, variance=0.25)
    calibration[:] = np.nan
    other = PrequentialMemory(STATES, 3, variance=0.25)
    assert memory.score(STATES[0], 0.5) == other.score(STATES[0], 0.5)
    packed = memory.packed()
    for each in packed:
        each[:] = np.nan
    assert memory.score(STATES[1], 0.5) == other.score(STATES[1], 0.5)


def test_what_is_held_out_is_a_copy():
    targets = TARGETS.copy()
    _, held_out = predict_held_out(STATES, targets)
    held_out[:] = 0
    np.testing.assert_array_equal(targets, TARGETS)


def test_a_reservoir_may_write_its_states_into_one_array():
    states = np.empty((20, 6))

    def reservoir(stream):
        states[:] = EchoStateNetwork(6).states(stream)
        stream[:] = np.nan
        return states

    one, other = (kernel_quality(each, inputs=15, length=20) for each in (reservoir, EchoStateNetwork(6).states))
    np.testing.assert_array_equal(one.kernel_singular_values, other.kernel_singular_values)


def test_a_network_steps_on_whatever_becomes_of_its_states():
    network = EchoStateNetwork(5, leak=0.6, seed=2)
    step = network.stepper(MESSAGE[:30])
    expected = network.states(MESSAGE)
    for k in range(30, 60):
        state = step(MESSAGE[k])
        np.testing.assert_allclose(state, expected[k], rtol=0, atol=1e-14)
        state[:] = np.nan


def test_runs_are_left_alone_by_what_they_are_combined_to():
    runs = [memory_capacity(STATES + i, MESSAGE, 2, washout=5) for i in range(2)]
    memory_over_runs(runs).delays[:] = 9
    assert runs[0].delays.tolist() == [0, 1]
