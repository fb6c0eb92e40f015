"""Every optional argument of every measure has its effect: all that is returned is that of plain loops."""

import inspect
import pickle
import warnings
from dataclasses import fields

import numpy as np
import plain_reservoir as plain
import pytest

from stickslip.reservoir import (
    echo_state_property,
    EchoStateNetwork,
    information_processing_capacity,
    kernel_quality,
    memory_capacity,
)


def everything(found):
    """All that a result says, by name."""
    names = [field.name for field in fields(found)]
    names += [name for name, each in vars(type(found)).items() if isinstance(each, property)]
    return {name: getattr(found, name) for name in names}


def assert_same(found, expected, rtol=1e-7, atol=1e-9):
    for name, value in expected.items():
        if name == "rare":  # of which a warning tells alone
            continue
        if isinstance(value, tuple | dict) and name != "total_interval" and name != "corrected_interval":
            assert getattr(found, name) == (pytest.approx(value) if isinstance(value, dict) else value), name
        elif value is None:
            assert getattr(found, name) is None, name
        else:
            np.testing.assert_allclose(getattr(found, name), value, rtol=rtol, atol=atol, err_msg=name)


def assert_other(found, other):
    assert pickle.dumps(everything(found)) != pickle.dumps(everything(other))


def options_of(function):
    return {name for name, each in inspect.signature(function).parameters.items() if each.kind is each.KEYWORD_ONLY}


def noisy(message, features, seed=1):
    """States that hold the last inputs and a product of two, with noise, a mean and units of their own."""
    rng = np.random.default_rng(seed)
    taps = np.column_stack([np.roll(message, d) for d in range(features - 1)] + [message * np.roll(message, 1)])
    return (taps + 0.4 * rng.normal(size=taps.shape)) @ rng.normal(size=(features, features)) + 3


@pytest.mark.parametrize(
    ("measure", "judge"),
    [
        (memory_capacity, plain.memory),
        (information_processing_capacity, plain.information),
        (kernel_quality, plain.kernel),
        (echo_state_property, plain.echo_state),
    ],
)
def test_the_defaults_are_those_of_the_judge(measure, judge):
    usual, judged = (
        {name: each.default for name, each in inspect.signature(function).parameters.items()}
        for function in (measure, judge)
    )
    # None is at least as many as the judge takes.
    assert usual.pop("surrogates", None) is None
    assert usual == {name: value for name, value in judged.items() if name != "surrogates"}


# The third of three values is rare: the squares of such a message are not constant.
MESSAGE = np.random.default_rng(0).choice([-1.0, 0.3, 2.0], 260, p=[0.5, 0.4, 0.1])
STATES = noisy(MESSAGE, 4)
MEMORY = {"states": STATES, "message": MESSAGE, "delays": 7, "washout": 40, "significance": 0.02, "seed": 3}
MEMORY_OPTIONS = {
    "washout": 61,
    "scoring": "leave one out",
    "holdout": 0.3,
    "ridge": 0.2,
    "fit_intercept": False,
    "significance": 0.2,
    "noise": 12.0,
    "resamples": 30,
}


def test_all_options_of_memory_are_tried():
    assert options_of(memory_capacity) == {*MEMORY_OPTIONS, "confidence", "seed"}


@pytest.mark.parametrize("scoring", ["held out", "leave one out"])
@pytest.mark.parametrize("option", MEMORY_OPTIONS)
def test_an_option_of_memory_has_its_effect(option, scoring):
    arguments = MEMORY | {"scoring": scoring}
    changed = arguments | {option: MEMORY_OPTIONS[option]}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        usual, found = memory_capacity(**arguments), memory_capacity(**changed)
    assert_same(usual, plain.memory(**arguments))
    assert_same(found, plain.memory(**changed))
    if (option, scoring) not in (("holdout", "leave one out"), ("scoring", "leave one out")):
        assert_other(found, usual)


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("scoring", ["held out", "leave one out"])
@pytest.mark.parametrize(("option", "value"), [("confidence", 0.6), ("seed", 4), ("delays", [9, 2]), ("noise", 3.0)])
def test_an_option_of_the_intervals_has_its_effect(option, value, scoring):
    arguments = MEMORY | {"scoring": scoring, "resamples": 30, "noise": 20.0}
    found = memory_capacity(**arguments | {option: value})
    assert_same(found, plain.memory(**arguments | {option: value}))
    assert_other(found, memory_capacity(**arguments))


def test_memory_by_default_is_that_of_plain_loops():
    rng = np.random.default_rng(5)
    bits = rng.integers(0, 2, 900).astype(float)
    states = noisy(bits, 3)
    assert_same(memory_capacity(states, bits, 5), plain.memory(states, bits, 5))


BITS = (np.random.default_rng(0).random(420) < 0.4).astype(float)
UNIFORM = np.random.default_rng(0).uniform(-1, 1, 420)
INFORMATION = {"delays": 5, "max_degree": 2, "washout": 20, "significance": 0.01, "seed": 2, "patience": 3}
INFORMATION_OPTIONS = {
    "max_degree": 3,
    "delays": [6, 3],
    "washout": 31,
    "significance": 0.2,
    "patience": 1,
    "budget": 9,
    "noise": 3.0,
    "confidence": 0.5,
}


def test_all_options_of_information_are_tried():
    elsewhere = {"basis", "threshold", "surrogates", "support", "seed"}
    assert options_of(information_processing_capacity) == {*INFORMATION_OPTIONS, *elsewhere}


@pytest.mark.filterwarnings("ignore:the budget")
@pytest.mark.parametrize("basis", ["walsh", "legendre"])
@pytest.mark.parametrize("option", INFORMATION_OPTIONS)
def test_an_option_of_information_has_its_effect(option, basis):
    inputs = BITS if basis == "walsh" else UNIFORM
    states, arguments = noisy(inputs, 4), INFORMATION | {"basis": basis}
    changed = arguments | {option: INFORMATION_OPTIONS[option]}
    found = information_processing_capacity(states, inputs, **changed)
    assert_same(found, plain.information(states, inputs, **changed))
    assert len(found.terms) > 2
    assert_other(found, information_processing_capacity(states, inputs, **arguments))


@pytest.mark.filterwarnings("ignore:[0-9]+ functions explain more than chance")
@pytest.mark.parametrize(
    ("option", "value"), [("threshold", "chi-squared"), ("surrogates", 300), ("seed", 3), ("significance", 0.05)]
)
def test_an_option_of_the_surrogates_has_its_effect(option, value):
    """Rare bits and states with outliers: what is shuffled explains more than the law for constant squares says."""
    rare = (np.random.default_rng(0).random(420) < 0.2).astype(float)
    states = noisy(rare, 4) + 0.1 * np.random.default_rng(1).standard_t(1.5, size=(420, 4))
    arguments = INFORMATION | {"threshold": "surrogates", "surrogates": 210, "delays": [5, 4]}
    found = information_processing_capacity(states, rare, **arguments | {option: value})
    assert_same(found, plain.information(states, rare, **arguments | {option: value}))
    assert found.terms
    assert_other(found, information_processing_capacity(states, rare, **arguments))


def test_the_support_of_legendre_polynomials_has_its_effect():
    states = noisy(UNIFORM, 4)
    arguments = INFORMATION | {"basis": "legendre"}
    found = information_processing_capacity(states, UNIFORM, support=(-1.5, 2.0), **arguments)
    assert_same(found, plain.information(states, UNIFORM, support=(-1.5, 2.0), **arguments))
    assert_other(found, information_processing_capacity(states, UNIFORM, **arguments))


def test_information_by_default_is_that_of_plain_loops():
    bits = (np.random.default_rng(3).random(700) < 0.5).astype(float)
    states = noisy(bits, 3)
    found = information_processing_capacity(states, bits)
    assert_same(found, plain.information(states, bits))
    assert found.reach == {1: 11, 2: 11, 3: 11}


KERNEL_OPTIONS = {"inputs": 30, "length": 15, "shared": 4, "endings": 3, "threshold": 0.05, "noise": 12.0, "seed": 1}


@pytest.mark.parametrize("option", [None, *KERNEL_OPTIONS])
def test_an_option_of_kernel_quality_has_its_effect(option):
    assert options_of(kernel_quality) == set(KERNEL_OPTIONS)
    reservoir = EchoStateNetwork(8, input_scaling=0.8).states
    arguments = {"inputs": 25}
    found = kernel_quality(reservoir, **arguments)
    if option is not None:
        usual, arguments = found, arguments | {option: KERNEL_OPTIONS[option]}
        found = kernel_quality(reservoir, **arguments)
        assert_other(found, usual)
    assert_same(found, plain.kernel(reservoir, **arguments))


@pytest.mark.parametrize("options", [{}, {"washout": 30}, {"tolerance": 0.6}])
def test_an_option_of_the_echo_state_property_has_its_effect(options):
    """Four trajectories in two wells, of which two pairs meet, and a third pair nearly."""
    rng = np.random.default_rng(0)
    now = np.array([[-1.0, -1.2, 0.8, 1.1, 1.3]]).T + 0.1 * rng.normal(size=(5, 2))
    states = np.empty((5, 120, 2))
    for k, u in enumerate(rng.normal(size=120)):
        now = np.tanh(now @ [[1.6, 0.3], [-0.2, 1.4]] + 0.1 * u)
        states[:, k] = now
    states[4] += 0.2
    assert options_of(echo_state_property) == {"washout", "tolerance"}
    found = echo_state_property(states, **options)
    # Distances of 1e-11 have five digits.
    assert_same(found, plain.echo_state(states, **options), rtol=1e-5)
    if options:
        assert_other(found, echo_state_property(states))
