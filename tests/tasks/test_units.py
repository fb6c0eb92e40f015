"""Every score is that of the same states in other units: one factor on all of them changes nothing."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from stickslip.reservoir import (
    echo_state_property,
    fit_readout,
    information_processing_capacity,
    memory_capacity,
    predict_held_out,
    RecursiveLeastSquares,
    RecursiveLeastSquaresReadout,
    RidgeReadout,
    state_rank,
)
from stickslip.tasks import BodyReservoir, MEASURES, random_bits, TASKS

FACTORS = [1e-12, 1e-6, 2.0**-10, 1e3, 1e9]
BODY = BodyReservoir(virtual_nodes=2)
BITS = random_bits(1500, seed=3).astype(float)
STATES = BODY(BITS)
RUN = {"length": 1000, "seed": 0, "washout": 100}


@dataclass(frozen=True)
class InUnits:
    """A reservoir whose states are told in other units."""

    reservoir: Any
    factor: float

    def __call__(self, series, seed):
        return self.factor * self.reservoir(series, seed)

    def on_grounds(self, series, grounds):
        return self.factor * self.reservoir.on_grounds(series, grounds)

    @property
    def candidates(self):
        return [InUnits(each, self.factor) for each in getattr(self.reservoir, "candidates", ())]


@pytest.mark.parametrize("name", [*TASKS, *MEASURES])
def test_the_score_of_every_task_and_measure(name):
    task = {**TASKS, **MEASURES}[name]
    found = [task.attempt(InUnits(BODY, factor), **RUN).score for factor in FACTORS]
    assert found == pytest.approx([task.attempt(BODY, **RUN).score] * len(FACTORS), rel=1e-6)


def recursive(states, forgetting=1.0):
    model = RecursiveLeastSquares(states.shape[1], 1, forgetting=forgetting)
    return [model.learn(row, [bit])[0] for row, bit in zip(states[1:400], BITS[:399], strict=True)]


def echo_index(states):
    found = echo_state_property(states[:1200].reshape(3, 400, -1))
    return [found.echo_index, found.consistency, found.exponent]


FUNCTIONS = {
    "memory": lambda x: memory_capacity(x, BITS, 10).profile,
    "memory, corrected, and its interval": lambda x: (
        (found := memory_capacity(x, BITS, 10, resamples=100)).corrected,
        *found.total_interval,
        *found.corrected_interval,
    ),
    "memory by leaving one out": lambda x: memory_capacity(x, BITS, 10, scoring="leave one out").total,
    "memory read by noisy sensors": lambda x: memory_capacity(x, BITS, 10, noise=40.0).total,
    "memory with a ridge that matters": lambda x: memory_capacity(x, BITS, 10, ridge=0.1).total,
    "information": lambda x: information_processing_capacity(x, BITS, max_degree=2, delays=8).total,
    "rank": state_rank,
    "predictions": lambda x: predict_held_out(x, BITS)[0],
    "readout": lambda x: fit_readout(x, BITS, ridge=1e-3).predict(x),
    "RidgeReadout": lambda x: RidgeReadout().fit(x, BITS).predict(x),
    "RidgeReadout of one penalty": lambda x: RidgeReadout(0.01).fit(x, BITS).predict(x),
    "RecursiveLeastSquaresReadout": lambda x: RecursiveLeastSquaresReadout().fit(x, BITS).predict(x),
    "recursive least squares": recursive,
    "recursive least squares that forgets": lambda x: recursive(x, forgetting=0.99),
    "echo index": echo_index,
}


@pytest.mark.filterwarnings("ignore:.*Lyapunov:UserWarning")
@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize("name", FUNCTIONS)
def test_what_every_function_of_states_finds(name, factor):
    expected, found = FUNCTIONS[name](STATES), FUNCTIONS[name](factor * STATES)
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-7)
