import math
from dataclasses import replace

import numpy as np
import pytest

from stickslip.crawler import Groups, Scene, simulate
from stickslip.reservoir import memory_capacity
from stickslip.studies.benchmark import estimates, Record, run_benchmark, STANDARD_RESERVOIRS, STANDARD_TASKS, table
from stickslip.studies.benchmark.attempts import attempts
from stickslip.tasks import (
    crawler_states,
    DelayLine,
    EchoState,
    known_reservoirs,
    Metric,
    narma,
    Problem,
    random_bits,
    RESERVOIRS,
    SeriesTask,
    Solution,
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
    scores = {score.task: score.score for score in run_benchmark(reservoirs=["delay line"], seeds=[0], length=3000)}
    assert scores["memory capacity"] == pytest.approx(12, abs=1e-6)
    assert scores["parity-2 capacity"] == scores["parity-3 capacity"] == 0
    states, target = RESERVOIRS["delay line"](BITS, 0)[200:], narma(0.2 * BITS, 10)[200:]
    design = np.column_stack([states, np.ones(2800)])
    weights = np.linalg.lstsq(design[:1400], target[:1400])[0]
    residual = design[1400:] @ weights - target[1400:]
    assert scores["NARMA-10 NRMSE"] == pytest.approx(residual.std() / target[1400:].std(), rel=1e-2)


def test_a_reservoir_that_computes_the_parity_scores_it():
    oracle = {"oracle": lambda bits, _: np.stack([np.abs(bits - np.roll(bits, 1)), bits], axis=1)}
    [score] = run_benchmark(tasks=["parity-2 capacity"], reservoirs=oracle, seeds=[1], length=2000)
    assert score.score == pytest.approx(1)


def test_the_standard_benchmark_ranks_the_crawler_between_nothing_and_its_features():
    scores = run_benchmark(seeds=[0, 1], length=2500)
    assert len(scores) == len(STANDARD_TASKS) * len(STANDARD_RESERVOIRS) * 2
    assert all(math.isfinite(score.score) for score in scores)
    summary = estimates(scores)
    assert 2 < summary["memory capacity", "crawler"].mean < 10
    assert summary["parity-2 capacity", "crawler"].mean > 0.2
    assert summary["NARMA-2 NRMSE", "crawler"].mean < 0.5
    # A network tuned for each capacity is not one network, so that no bound holds for their sum.
    for reservoir in ("crawler", "delay line"):
        capacities = (summary[task, reservoir].mean for task in STANDARD_TASKS if "capacity" in task)
        assert sum(capacities) < 12.1


def test_every_task_runs_on_every_reservoir():
    reservoirs = {
        name: replace(reservoir, tune=False) if isinstance(reservoir, EchoState) else reservoir
        for name, reservoir in known_reservoirs(6).items()
    }
    scores = run_benchmark(tasks=TASKS, reservoirs=reservoirs, seeds=[0], length=1200)
    assert len(scores) == len(TASKS) * len(RESERVOIRS)
    assert all(math.isfinite(score.score) for score in scores)


def test_friction_is_what_computes_on_bits():
    """A linear readout of the anchored body finds hardly a parity; of the crawler, half of one."""
    summary = estimates(run_benchmark(tasks=["parity-2 capacity"], reservoirs=RESERVOIRS, seeds=[0, 1], length=3000))
    scores = {reservoir: summary["parity-2 capacity", reservoir].mean for reservoir in RESERVOIRS}
    assert scores["pressure only"] == scores["linear"] == scores["delay line"] == 0
    assert scores["anchored"] < 0.1 < 0.3 < scores["crawler"]


def test_equal_seeds_give_equal_scores():
    runs = [run_benchmark(tasks=["memory capacity"], seeds=[s], length=1500) for s in (3, 3, 4)]
    assert runs[0] == runs[1]
    assert [a.score for a in runs[0]] != [b.score for b in runs[2]]


def test_a_series_drives_a_reservoir_once_however_many_tasks_share_it():
    calls = []

    def counted(drive, seed):
        calls.append(seed)
        return DelayLine(4)(drive)

    run_benchmark(
        tasks=["memory capacity", "parity-2 capacity", "NARMA-2 NRMSE"],
        reservoirs={"counted": counted},
        seeds=[0, 1],
        length=800,
    )
    assert calls == [0, 1]


def test_arguments_by_default_and_given():
    asked = []

    class Task:
        metric = Metric("score", None, True, 0.0)

        def attempt(self, reservoir, *, length, seed, washout):
            asked.append((length, seed, washout))
            return Solution(float(seed), details={"washout": washout})

    of = {"tasks": {"t": Task()}, "reservoirs": {"r": DelayLine(2)}}
    records = run_benchmark(**of)
    assert asked == [(4000, seed, 200) for seed in range(5)]
    assert records[3] == Record("t", "r", 3, 3.0, {"washout": 200})
    asked.clear()
    run_benchmark(**of, seeds=[7], length=30, washout=0)
    assert asked == [(30, 7, 0)]
    both = {"one": DelayLine(2), "other": DelayLine(3)}
    order = [record[:3] for record in run_benchmark(tasks={"t": Task(), "u": Task()}, reservoirs=both, seeds=[1, 0])]
    assert order == [(task, name, seed) for seed in (1, 0) for name in both for task in ("t", "u")]


def test_what_is_done_is_left_out():
    of = {"length": 500, "washout": 0}
    tasks = {name: TASKS[name] for name in ("memory capacity", "NARMA-2 NRMSE")}
    lines = {"a": DelayLine(2), "b": DelayLine(3)}
    done = {("memory capacity", "a", 0), ("NARMA-2 NRMSE", "b", 1)}
    left = [record[:3] for record in attempts(tasks, lines, [0, 1], done=done, **of)]
    assert left == [
        (task, name, seed) for seed in (0, 1) for name in lines for task in tasks if (task, name, seed) not in done
    ]


def test_registered_names_reach_the_runner(monkeypatch):
    count = Metric("features", lambda states, targets, start: Solution(float(states.shape[1])), True, 0.0)
    bits = SeriesTask(lambda length, seed: Problem(*[random_bits(length, seed).astype(float)] * 3, 0), count)
    monkeypatch.setitem(TASKS, "features", bits)
    monkeypatch.setitem(RESERVOIRS, "bits", lambda drive, seed: drive[:, None])
    [score] = run_benchmark(tasks=["features"], reservoirs="bits", seeds=[0], length=10, washout=0)
    assert score == Record("features", "bits", 0, 1.0, {})


def test_the_table_of_a_task_of_ones_own_and_of_known_ones():
    """t(0.975, 1) s / sqrt(2) = 12.706; a capacity is not negative, and 3 times the mean is bound by no feature."""
    scores = [Record("t", "a", 0, 101.0, {}), Record("t", "a", 1, 103.0, {}), Record("t", "b", 0, 0.5, {})]
    found = estimates(scores)
    one = found["t", "a"]
    assert (one.mean, one.low, one.runs) == (102.0, pytest.approx(102 - 12.7062, abs=1e-3), 2)
    assert math.isnan(found["t", "b"].low)
    assert table(scores) == [["task", "a", "b"], ["t", f"102.00 [{one.low:.2f}, {one.high:.2f}]", "0.50"]]
    mine = SeriesTask(None, Metric("NRMSE", None, more_is_better=False, chance=1.0))
    assert table(scores, {"t": mine})[1][0] == "t ↓"
    assert table(scores[2:], {"t": mine}) == [["task", "b"], ["t ↓", "0.500"]]
    known = [Record("parity-2 capacity", "a", seed, score, {}) for seed, score in enumerate((0.5, 1.5))]
    assert table(known)[1][0] == "parity-2 capacity ↑"
    assert table(known)[1][1].startswith("1.00 [0.00, ")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"tasks": ["NARMA-3"]}, r"tasks must be among \['memory capacity', .*\], got 'NARMA-3'"),
        ({"reservoirs": "octopus"}, r"reservoirs must be among \['crawler', .*\], got 'octopus'"),
        ({"length": 0}, "length must be a whole number >= 1, got 0"),
        ({"length": 100}, "length must be more than the 200 samples .* got 100"),
        ({"length": 210}, "states must have at least .* got 210"),
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
        crawler_states([0, 1], virtual_nodes=1.5)
    with pytest.raises(ValueError, match=r"valve must be in \[0, 1\], got 2.0 at index 1"):
        crawler_states([0, 2])
    with pytest.raises(ValueError, match=r"valve must be 1-dimensional .* got shape \(2, 2\)"):
        crawler_states([[0, 1], [1, 0]])
    with pytest.raises(ValueError, match="hold must be"):
        crawler_states([0, 1], hold=0)
