"""What `benchmarks/accuracy_worth.py` makes of its measurements, and that none is lost."""

import json

import accuracy_worth
import numpy as np
import pytest
from measuring import refreshed
from scipy import stats
from worth.page import tables
from worth.settings import ENVIRONMENT_DEFAULT, SIMULATE_DEFAULT, TOLERANCES
from worth.summary import deviations, exponent_from, loss, tolerance_effect


@pytest.fixture
def two():
    """Two rows of results of ten seeds that share what the seeds do."""
    random = np.random.default_rng(0)
    return random.normal(size=10) + 0.3 * random.normal(size=(2, 10))


def test_a_constant_offset_is_bias_without_scatter():
    reference = np.array([1.0, 2.0, 3.0])
    result = loss(reference + 0.1, reference)
    assert result.bias == pytest.approx(0.1)
    assert result.scatter == pytest.approx(0.0, abs=1e-15)
    assert result.relative == pytest.approx(0.1 / 1.0)


def test_an_error_without_bias_still_counts():
    result = loss([1.1, 1.9, 3.0], [1.0, 2.0, 3.0])
    assert result.bias == pytest.approx(0.0, abs=1e-15)
    assert result.rms == pytest.approx(np.sqrt(0.02 / 3))


def test_the_effect_of_two_tolerances_is_judged_as_by_a_paired_t_test(two):
    assert tolerance_effect(two) == pytest.approx(stats.ttest_rel(*two).pvalue)


def test_an_effect_well_above_the_noise_is_found(two):
    assert tolerance_effect(two + np.array([[0.0], [1.0]])) < 1e-3


def test_deviations_are_half_the_paired_difference(two):
    difference = two[1] - two[0]
    deviation, error = deviations(two)
    assert deviation == pytest.approx([-difference.mean() / 2, difference.mean() / 2])
    assert error == pytest.approx([stats.sem(difference) / 2] * 2)


def test_the_rate_at_which_motions_part_is_recovered():
    tolerances = np.array([1e-3, 1e-6, 1e-9])
    assert exponent_from(tolerances, 7.0 - np.log(tolerances) / 0.05) == pytest.approx(0.05)


def test_a_table_is_put_between_its_marks():
    page = "before\n<!-- cost -->\nold\n<!-- end -->\nafter"
    once = refreshed(page, {"cost": "new"})
    assert once == "before\n<!-- cost -->\nnew\n<!-- end -->\nafter"
    assert refreshed(once, {"cost": "new"}) == once


def test_a_table_without_a_place_is_told():
    with pytest.raises(ValueError, match="'cost' once, found them 0 times"):
        refreshed("no marks", {"cost": "new"})


def test_the_page_shows_the_results_that_are_kept():
    results = json.loads(accuracy_worth.RESULTS.read_text(encoding="utf-8"))["results"]
    page = accuracy_worth.PAGE.read_text(encoding="utf-8")
    assert refreshed(page, tables(results)) == page


@pytest.mark.parametrize("default", [SIMULATE_DEFAULT, ENVIRONMENT_DEFAULT])
def test_a_default_has_a_looser_and_a_tighter_neighbour(default):
    assert default in TOLERANCES[1:-1]


@pytest.fixture
def experiments(monkeypatch, tmp_path):
    """Two small experiments, and the calls made of them."""
    calls = []

    def experiment(name, count):
        def work(key):
            calls.append(key)
            if key == "b/1" and calls.count(key) == 1:
                raise KeyboardInterrupt
            return len(calls)

        return lambda: ((f"{name}/{i}", lambda key=f"{name}/{i}": work(key)) for i in range(count))

    monkeypatch.setattr(accuracy_worth, "RESULTS", tmp_path / "results" / "kept.json")
    monkeypatch.setattr(accuracy_worth, "EXPERIMENTS", {"a": experiment("a", 2), "b": experiment("b", 2)})
    return calls


def test_a_stopped_run_goes_on_where_it_stopped(experiments):
    with pytest.raises(KeyboardInterrupt):
        accuracy_worth.measure(None)
    assert set(json.loads(accuracy_worth.RESULTS.read_text(encoding="utf-8"))["results"]) == {"a/0", "a/1", "b/0"}
    results, missing = accuracy_worth.measure(None)
    assert experiments == ["a/0", "a/1", "b/0", "b/1", "b/1"]
    assert (set(results), missing) == ({"a/0", "a/1", "b/0", "b/1"}, [])


def test_one_experiment_alone_is_measured_anew(experiments):
    first, missing = accuracy_worth.measure("a")
    assert missing == ["b"]
    again, _ = accuracy_worth.measure("a")
    assert first == {"a/0": 1, "a/1": 2}
    assert again == {"a/0": 3, "a/1": 4}
