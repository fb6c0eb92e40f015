import subprocess
import sys

import numpy as np
import pytest

from stickslip.reservoir import fit_readout, predict_held_out
from stickslip.reservoir.ridge import samples_needed, training_samples


@pytest.fixture
def data():
    rng = np.random.default_rng(0)
    return rng.normal(size=(60, 5)) + 0.3, rng.normal(size=(60, 3))


@pytest.mark.parametrize("ridge", [1e-6, 0.1, 10.0])
def test_without_intercept_it_is_equation_11(data, ridge):
    states, targets = data
    R, Y = states.T, targets.T
    gram = R @ R.T
    expected = Y @ R.T @ np.linalg.inv(gram + ridge * gram.trace() / 5 * np.eye(5))
    readout = fit_readout(states, targets, ridge=ridge, fit_intercept=False)
    np.testing.assert_allclose(readout.coef_, expected, rtol=1e-10)
    assert not np.any(readout.intercept_)


def test_the_intercept_is_not_penalized(data):
    states, targets = data
    shifted = fit_readout(states, targets + 1e3, ridge=10.0)
    np.testing.assert_allclose(shifted.coef_, fit_readout(states, targets, ridge=10.0).coef_, atol=1e-10)


@pytest.mark.parametrize("fit_intercept", [True, False])
def test_more_samples_of_the_same_ask_for_no_other_ridge(data, fit_intercept):
    states, targets = data
    once, thrice = (
        fit_readout(np.tile(states, (n, 1)), np.tile(targets, (n, 1)), ridge=0.3, fit_intercept=fit_intercept)
        for n in (1, 3)
    )
    np.testing.assert_allclose(thrice.coef_, once.coef_, rtol=1e-9)


def test_collinear_states_keep_their_digits():
    """The normal equations would square the condition number of 1e7 and keep two digits of sixteen."""
    rng = np.random.default_rng(1)
    common, small = rng.normal(size=(2, 500))
    states = np.column_stack([common, common + 1e-7 * small])
    readout = fit_readout(states, small, ridge=0, fit_intercept=False)
    assert np.abs(readout.predict(states) - small).max() < 1e-7


def test_the_held_out_part_is_the_end_and_is_not_learned(data):
    states, targets = data
    prediction, target = predict_held_out(states, targets, holdout=0.25)
    np.testing.assert_array_equal(target, targets[45:])
    poisoned = targets.copy()
    poisoned[45:] = 1e6
    np.testing.assert_array_equal(predict_held_out(states, poisoned, holdout=0.25)[0], prediction)


def test_importing_the_package_leaves_scikit_learn_out():
    code = "import sys, stickslip.reservoir, stickslip.tasks; sys.exit('sklearn' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"states": np.zeros(60)}, r"states must be 2-dimensional and not empty, got shape \(60,\)"),
        ({"targets": np.zeros((59, 1))}, "targets must have as many samples as states, 60, got 59"),
        ({"targets": np.full(60, np.nan)}, r"targets must be finite, got nan at index \(0,\)"),
        ({"ridge": -1.0}, r"ridge must be in \[0, inf\), got -1.0"),
        ({"ridge": np.inf}, r"ridge must be in \[0, inf\), got inf"),
    ],
)
def test_bad_input(data, change, message):
    with pytest.raises(ValueError, match=message):
        fit_readout(**{"states": data[0], "targets": data[1], **change})


@pytest.mark.parametrize("states", [[[1.0], [2.0, 3.0]], "abc", [[1j]]])
def test_what_is_not_an_array_of_numbers(states):
    with pytest.raises(TypeError, match="states must be an array of real numbers, got "):
        fit_readout(states, [1.0])


def test_fewer_training_samples_than_features(data):
    states, targets = data
    predict_held_out(states[:10], targets[:10])
    with pytest.raises(ValueError, match=r"states must have at least 10 samples for 5 features and holdout=0.5, got 9"):
        predict_held_out(states[:9], targets[:9])


@pytest.mark.parametrize("holdout", [0.1, 0.2, 0.3, 0.5, 0.7, 0.9])
def test_the_samples_said_to_be_needed_are_enough_for_any_number_of_features(holdout):
    for features in range(1, 200):
        needed = samples_needed(features, holdout)
        training = training_samples(needed, holdout)
        assert training >= features
        assert needed - training >= 2
        if features in (1, 7, 60):
            x = np.eye(needed, features)
            prediction, _ = predict_held_out(x, np.arange(needed), holdout=holdout, ridge=1.0)
            assert len(prediction) == needed - training
            with pytest.raises(
                ValueError, match=f"^states must have at least {needed} samples for {features} features"
            ):
                predict_held_out(x[1:], np.arange(needed - 1), holdout=holdout, ridge=1.0)
