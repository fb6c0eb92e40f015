import math

import numpy as np
import pytest

from stickslip.crawler import Groups, Scene, simulate
from stickslip.reservoir import memory_capacity
from stickslip.tasks import (
    crawler_and_baselines,
    crawler_states,
    narma10,
    random_bits,
    RESERVOIRS,
    run_benchmark,
    Score,
    summarize,
    table,
    TASKS,
)

BITS = random_bits(3000, 0)


def test_crawler_states_are_the_trajectory_read_within_each_hold():
    states = crawler_states(BITS[:30], hold=0.7, virtual_nodes=3)
    motion = simulate(Groups(), BITS[:30], 0.7, samples_per_hold=3)
    assert states.shape == (30, 9)
    for k in (0, 11, 29):
        hold = slice(3 * k, 3 * k + 3)
        expected = [*motion.deformation[hold], *motion.velocity[hold], *motion.pressure[hold]]
        np.testing.assert_array_equal(states[k], expected)


def test_crawler_states_know_the_present_bit_and_not_the_next():
    states = crawler_states(BITS)
    assert memory_capacity(states, BITS, 1).total > 0.999
    assert memory_capacity(states, np.roll(BITS, -1), 1).corrected == 0


def test_a_linear_anchored_crawler_is_bounded_by_its_three_state_variables():
    """An affine map of three states: its virtual nodes see three past-dependent directions and the input."""
    linear = {"duffing": 0, "radial_coupling": 0, "damping_ratio": 0.2}
    states = crawler_states(BITS, groups=linear, scene=Scene(anchored=True))
    memory = memory_capacity(states, BITS, 60)
    assert memory.bound <= 4
    assert 3 < memory.corrected < 4.05


def test_scores_match_the_definitions():
    """The delay line knows its taps, and no parity. NARMA is fitted on one half and scored on the other."""
    scores = {score.task: score.value for score in run_benchmark(reservoirs=["delay line"], seeds=[0], length=3000)}
    assert scores["memory capacity"] == pytest.approx(12, abs=1e-6)
    assert scores["parity-2 capacity"] == scores["parity-3 capacity"] == 0
    states, target = RESERVOIRS["delay line"](BITS, 0)[200:], narma10(0.2 * BITS)[200:]
    design = np.column_stack([states, np.ones(2800)])
    weights = np.linalg.lstsq(design[:1400], target[:1400])[0]
    residual = design[1400:] @ weights - target[1400:]
    assert scores["NARMA-10 NRMSE"] == pytest.approx(residual.std() / target[1400:].std(), rel=1e-2)


def test_a_reservoir_that_computes_the_parity_scores_it():
    oracle = {"oracle": lambda bits, _: np.stack([bits ^ np.roll(bits, 1), bits], axis=1).astype(float)}
    [score] = run_benchmark(tasks=["parity-2 capacity"], reservoirs=oracle, seeds=[1], length=2000)
    assert score.value == pytest.approx(1)


def test_the_whole_benchmark_ranks_the_crawler_between_nothing_and_its_features():
    scores = run_benchmark(seeds=[0, 1], length=2500)
    assert len(scores) == len(TASKS) * len(RESERVOIRS) * 2
    assert all(math.isfinite(score.value) for score in scores)
    summary = summarize(scores)
    assert 2 < summary["memory capacity", "crawler"].mean < 10
    assert summary["parity-2 capacity", "crawler"].mean > 0.2
    assert summary["NARMA-2 NRMSE", "crawler"].mean < 0.5
    for reservoir in RESERVOIRS:
        capacities = (summary[task, reservoir].mean for task in TASKS if "capacity" in task)
        assert sum(capacities) < 12.1


def test_equal_seeds_give_equal_scores_and_baselines_match_in_size():
    reservoirs = crawler_and_baselines(virtual_nodes=2, hold=1.0)
    assert {drive(BITS, 0).shape for drive in reservoirs.values()} == {(3000, 6)}
    runs = [run_benchmark(tasks=["memory capacity"], seeds=[s], length=1500) for s in (3, 3, 4)]
    assert runs[0] == runs[1]
    assert [a.value for a in runs[0]] != [b.value for b in runs[2]]


def test_registered_names_reach_the_runner(monkeypatch):
    monkeypatch.setitem(TASKS, "features", lambda states, bits, washout: float(states.shape[1]))
    monkeypatch.setitem(RESERVOIRS, "bits", lambda bits, seed: bits[:, None].astype(float))
    [score] = run_benchmark(tasks=["features"], reservoirs="bits", seeds=[0], length=10)
    assert score == Score("features", "bits", 0, 1.0)


def test_the_table_by_hand():
    scores = [Score("t", "a", 0, 1.0), Score("t", "a", 1, 3.0), Score("t", "b", 0, 0.5)]
    assert summarize(scores)["t", "a"] == (2.0, pytest.approx(math.sqrt(2)), 2)
    assert math.isnan(summarize(scores)["t", "b"].std)
    assert table(scores) == [["task", "a", "b"], ["t", "2.00 ± 1.41", "0.50"]]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"tasks": ["NARMA-3"]}, r"tasks must be among \['memory capacity', .*\], got 'NARMA-3'"),
        ({"reservoirs": "octopus"}, r"reservoirs must be among \['crawler', .*\], got 'octopus'"),
        ({"length": 0}, "length must be a whole number >= 1, got 0"),
        ({"length": 100}, "states must have at least .* got 100"),
        ({"tasks": ["NARMA-2 NRMSE"], "washout": -1}, "washout must be a whole number >= 0, got -1"),
        ({"seeds": [-1]}, "seed must be a whole number >= 0, got -1"),
    ],
)
def test_bad_input(arguments, message):
    with pytest.raises(ValueError, match=message):
        run_benchmark(**arguments)


def test_bad_crawler_input():
    with pytest.raises(ValueError, match="virtual_nodes must be a whole number >= 1, got 0"):
        crawler_states([0, 1], virtual_nodes=0)
    with pytest.raises(TypeError, match=r"virtual_nodes must be a whole number >= 1, got 1\.5"):
        crawler_and_baselines(virtual_nodes=1.5)
    with pytest.raises(ValueError, match=r"valve must be 1-dimensional .* got shape \(2, 2\)"):
        crawler_states([[0, 1], [1, 0]])
    with pytest.raises(ValueError, match="hold must be"):
        crawler_states([0, 1], hold=0)
