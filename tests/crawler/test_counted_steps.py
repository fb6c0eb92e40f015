"""Every solver keeps to its tolerance, and to the steps that this takes: no fewer and no more.

Steps are counted from outside: with as many as the budget a run ends, and with fewer it is refused.
"""

import math

import numpy as np
import pytest
from counted_steps import attempt, cases, COUNTED, error_of, STEADY, written

# Of the errors and the steps that `tests/judges/counted_steps.py` has counted.
ERRORS, STEPS = 3.0, 0.1
# What rounding alone may come to, whatever the tolerance, and in a step.
ROUNDING, ROUNDING_A_STEP = 1e-13, 2e-16
TABLE = written()


def test_the_table_is_of_these_rows():
    assert {name: [f"{solver} {tolerance:g}" for solver, tolerance in cases(name)] for name in COUNTED} == {
        name: list(row) for name, row in TABLE.items()
    }


@pytest.mark.parametrize("name", COUNTED)
def test_errors_and_steps_are_those_that_were_counted(name):
    row = COUNTED[name]
    for solver, tolerance in cases(name):
        steps, error, steady = TABLE[name][f"{solver} {tolerance:g}"]
        enough, few = math.ceil((1.0 + STEPS) * steps) + 1, math.floor((1.0 - STEPS) * steps) - 2
        done = attempt(row, solver, tolerance, enough)
        assert done is not None, f"{solver} at {tolerance:g} takes more than {enough} steps"
        allowed = ERRORS * error * tolerance + ROUNDING + ROUNDING_A_STEP * steps
        assert error_of(name, done) <= allowed, f"{solver} at {tolerance:g}"
        if steady:
            # Whatever else a step is to be will show here, though all would be as right as this is.
            assert error_of(name, done) == pytest.approx(error * tolerance, rel=3 * STEADY), (
                f"{solver} at {tolerance:g}"
            )
        if few > 0:
            assert attempt(row, solver, tolerance, few) is None, f"{solver} at {tolerance:g} takes {few} steps or fewer"


@pytest.mark.parametrize("solver", ["taylor", "radau"])
@pytest.mark.parametrize("tolerance", ["0.001", "1e-06", "1e-09"])
def test_the_errors_counted_are_a_fraction_of_the_tolerance(solver, tolerance):
    counts = [row[f"{solver} {tolerance}"] for row in TABLE.values() if f"{solver} {tolerance}" in row]
    errors = [error for _, error, _ in counts]
    assert np.mean([steady for *_, steady in counts]) > (0.15 if tolerance == "1e-09" else 0.7)
    assert np.median(errors) < 0.05
    assert np.percentile(errors, 85) < 0.3
