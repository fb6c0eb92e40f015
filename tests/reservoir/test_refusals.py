"""Every guard of every measure refuses what it is there for, by the argument's own name."""

import re

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
    RidgeReadout,
    squared_correlation,
    state_rank,
)
from stickslip.reservoir.prequential import PrequentialMemory

RNG = np.random.default_rng(0)
STATES, BITS = RNG.normal(size=(120, 3)), RNG.integers(0, 2, 120).astype(float)


def memory(**options):
    arguments = {"states": STATES, "message": BITS, "delays": 3, "washout": 0} | options
    memory_capacity(**arguments)


def information(**options):
    arguments = {"states": STATES, "inputs": BITS, "delays": 3, "washout": 0} | options
    information_processing_capacity(**arguments)


def kernel(**options):
    kernel_quality(lambda u: delay_line(u, 3), **{"inputs": 9, "length": 20} | options)


def echo(**options):
    echo_state_property(**{"states": STATES.reshape(2, 60, 3)} | options)


def runs(**options):
    mean_over_runs(**{"values": [1.0, 2.0]} | options)


def over_runs(**options):
    memory_over_runs([memory_capacity(STATES, BITS, 2, washout=0)] * 2, **options)


def held_out(**options):
    predict_held_out(**{"states": STATES, "targets": BITS} | options)


def readout(**options):
    fit_readout(**{"states": STATES, "targets": BITS} | options)


def chosen(**options):
    RidgeReadout(**options).fit(STATES, BITS)


def network(**options):
    EchoStateNetwork(**{"nodes": 3} | options).states(BITS)


def recursive(**options):
    RecursiveLeastSquares(**{"features": 2, "outputs": 1} | options)


def running(**options):
    PrequentialMemory(**{"states": STATES, "delays": 2, "variance": 0.25} | options)


def rank(**options):
    state_rank(**{"states": STATES} | options)


def pair_of_ranks(**options):
    ranks(**{"different": STATES, "similar": STATES} | options)


def line(**options):
    delay_line(**{"signal": BITS, "taps": 2} | options)


def error(**options):
    nrmse(**{"prediction": BITS, "target": BITS} | options)


def correlation(**options):
    squared_correlation(**{"prediction": BITS, "target": BITS} | options)


WHOLE = {
    memory: {"washout": 0, "resamples": 0, "seed": 0, "delays": 1},
    information: {"max_degree": 1, "delays": 1, "washout": 0, "surrogates": 1, "patience": 1, "budget": 1, "seed": 0},
    kernel: {"inputs": 2, "length": 1, "endings": 1, "seed": 0},
    echo: {"washout": 0},
    network: {"nodes": 1, "seed": 0},
    recursive: {"features": 1, "outputs": 1},
    running: {"delays": 1},
    line: {"taps": 1},
}
REAL = {
    memory: {"holdout": "(0, 1)", "ridge": "[0, inf)", "significance": "(0, 0.5)", "confidence": "(0, 1)"},
    information: {"significance": "(0, 1)", "confidence": "(0, 1)"},
    kernel: {"threshold": "(0, 1)"},
    pair_of_ranks: {"threshold": "(0, 1)", "noise": "(-inf, inf)"},
    echo: {"tolerance": "(0, inf)"},
    runs: {"confidence": "(0, 1)"},
    over_runs: {"confidence": "(0, 1)"},
    held_out: {"holdout": "(0, 1)", "ridge": "[0, inf)"},
    readout: {"ridge": "[0, inf)"},
    chosen: {"penalty": "[0, inf)"},
    network: {
        "spectral_radius": "[0, inf)",
        "input_scaling": "(0, inf)",
        "leak": "(0, 1]",
        "density": "(0, 1]",
    },
    recursive: {"ridge": "(0, inf)", "forgetting": "(0, 1]", "scale": "(0, inf)"},
    running: {"variance": "(0, inf)"},
    rank: {"noise": "(-inf, inf)"},
}
ARRAYS = {
    memory: {"states": 2, "message": 1},
    information: {"states": 2, "inputs": 1},
    pair_of_ranks: {"different": 2},
    echo: {"states": 3},
    runs: {"values": 1},
    held_out: {"states": 2},
    readout: {"states": 2},
    running: {"states": 2},
    rank: {"states": 2},
    line: {"signal": 1},
    error: {"prediction": 1, "target": 1},
}


def cases(table):
    return [
        pytest.param(call, name, allowed, id=f"{call.__name__}-{name}")
        for call, arguments in table.items()
        for name, allowed in arguments.items()
    ]


def refuses(error, text):
    return pytest.raises(error, match=f"^{re.escape(text)}$")


@pytest.mark.parametrize(("call", "name", "least"), cases(WHOLE))
def test_a_whole_number_has_a_least_value(call, name, least):
    call()
    with refuses(ValueError, f"{name} must be a whole number >= {least}, got {least - 1}"):
        call(**{name: least - 1})
    with refuses(TypeError, f"{name} must be a whole number >= {least}, got 2.0"):
        call(**{name: 2.0})


@pytest.mark.parametrize(("call", "name", "interval"), cases(REAL))
def test_a_number_has_its_interval(call, name, interval):
    call()
    low, high = (float(end) for end in interval[1:-1].split(","))
    beyond = [float("nan"), low if interval[0] == "(" else -1e-300, high if interval[-1] == ")" else high + 1e-15]
    for value in beyond:
        with refuses(ValueError, f"{name} must be in {interval}, got {value}"):
            call(**{name: value})
    with refuses(TypeError, f"{name} must be a number in {interval}, got True"):
        call(**{name: True})


@pytest.mark.parametrize(("call", "name", "dimensions"), cases(ARRAYS))
def test_an_array_has_its_dimensions_and_is_finite(call, name, dimensions):
    call()
    shape = (2,) * (dimensions + 1)
    with refuses(ValueError, f"{name} must be {dimensions}-dimensional and not empty, got shape {shape}"):
        call(**{name: np.zeros(shape)})
    index = ", ".join(["0"] * dimensions) + ("," if dimensions == 1 else "")
    with refuses(ValueError, f"{name} must be finite, got nan at index ({index})"):
        call(**{name: np.full((2,) * dimensions, np.nan)})


@pytest.mark.parametrize(
    ("call", "options", "text"),
    [
        (memory, {"scoring": "x"}, "scoring has no 'x'; allowed are ['held out', 'leave one out']"),
        (information, {"basis": "x"}, "basis has no 'x'; allowed are ['walsh', 'legendre']"),
        (information, {"threshold": "x"}, "threshold has no 'x'; allowed are ['chi-squared', 'surrogates']"),
        (network, {"topology": "x"}, "topology has no 'x'; allowed are ['random', 'cycle', 'orthogonal']"),
        (correlation, {"prediction": BITS[:, None]}, "prediction must have the shape of target, (120,), got (120, 1)"),
        (readout, {"targets": BITS[1:]}, "targets must have as many samples as states, 120, got 119"),
        (memory, {"message": BITS[1:]}, "message must have as many samples as states, 120, got 119"),
        (information, {"inputs": BITS[1:]}, "inputs must have as many samples as states, 120, got 119"),
        (memory, {"message": 0 * BITS}, "message must vary, or there is nothing to remember, got 0.0 throughout"),
        (
            information,
            {"inputs": 0 * BITS},
            "inputs must vary, or there is nothing to compute with, got 0.0 throughout",
        ),
        (
            echo,
            {"states": STATES.reshape(2, 60, 3), "washout": 59},
            "states must have at least 61 samples for washout=59, got 60",
        ),
        (
            information,
            {"washout": 116},
            "states must have at least 121 samples for 3 features, washout=116 and 3 delays, got 120",
        ),
        (
            memory,
            {"washout": 115},
            "states must have at least 121 samples for 3 features, washout=115, delays up to 2 and holdout=0.5, "
            "got 120",
        ),
        (information, {"delays": [3, 3]}, "delays must be one number or one for each of 3 degrees, got 2"),
    ],
)
def test_other_refusals_word_for_word(call, options, text):
    with refuses(ValueError, text):
        call(**options)


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_what_is_just_enough_is_taken():
    memory(washout=114)
    information(washout=115, max_degree=1)
    echo(washout=58)
    memory(scoring="leave one out", washout=114)
    with refuses(
        ValueError,
        "states must have at least 121 samples for 3 features, washout=115, delays up to 2 and "
        "scoring='leave one out', got 120",
    ):
        memory(scoring="leave one out", washout=115)
