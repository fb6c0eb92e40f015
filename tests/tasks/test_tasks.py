"""The tasks themselves: what drives, what is to be read out, and how it is scored."""

import math
from dataclasses import replace

import numpy as np
import pytest

from stickslip import Groups, Scene
from stickslip.reservoir import mean_over_runs, memory_capacity
from stickslip.reservoir.ridge import samples_needed
from stickslip.tasks import (
    ACCURACY,
    BodyReservoir,
    CAPACITY,
    DelayLine,
    EchoState,
    FrictionTask,
    known_reservoirs,
    lorenz,
    mackey_glass,
    MEASURES,
    Metric,
    narma,
    NRMSE,
    parity,
    Problem,
    random_bits,
    SeriesTask,
    Solution,
    TASKS,
)
from stickslip.tasks import task as task_module
from stickslip.tasks.closed_loop import VALID_TIME
from stickslip.tasks.task import mean_score, tuned

SERIES_TASKS = {name: task for name, task in TASKS.items() if isinstance(task, SeriesTask)}


@pytest.mark.parametrize("name", SERIES_TASKS)
def test_a_draw_is_repeatable_bounded_and_scaled_by_constants(name):
    task = SERIES_TASKS[name]
    first, same, other = task.draw(400, 0), task.draw(400, 0), task.draw(400, 1)
    np.testing.assert_array_equal(first.drive, same.drive)
    np.testing.assert_array_equal(first.targets, same.targets)
    assert (first.drive != other.drive).any()
    assert len(first.drive) == len(first.inputs) == len(first.targets) == 400
    for problem in (first, other):
        assert 0.0 <= problem.drive.min() < problem.drive.max() <= 1.0
    # One affine map serves all seeds, so that nothing is learned of the samples to be scored.
    slope, offset = np.polyfit(first.inputs, first.drive, 1)
    np.testing.assert_allclose(other.drive, slope * other.inputs + offset, rtol=0, atol=1e-9)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_parities_do_not_depend_on_the_bits_before_once_warmed_up(order):
    problem = TASKS["memory capacity" if order == 1 else f"parity-{order} capacity"].draw(300, 0)
    late = parity(problem.inputs[50:].astype(int), order)
    assert problem.warm_up == order - 1
    np.testing.assert_array_equal(late[problem.warm_up :], problem.targets[50 + problem.warm_up :])


@pytest.mark.parametrize("order", [2, 5, 10, 20])
def test_narma_tasks_give_their_inputs(order):
    for kind, height in (("", 0.2), (" uniform", 0.5)):
        problem = TASKS[f"NARMA-{order}{kind} NRMSE"].draw(300, 0)
        np.testing.assert_array_equal(problem.targets, narma(problem.inputs, order))
        np.testing.assert_allclose(problem.inputs, height * problem.drive, rtol=1e-15)
        assert problem.warm_up == order


def test_forecasts_are_of_the_series_itself():
    glass = TASKS["Mackey-Glass NRMSE"].draw(200, 0)
    np.testing.assert_array_equal(glass.targets[:-14], glass.inputs[14:])
    wing = TASKS["Lorenz NRMSE"].draw(200, 0)
    np.testing.assert_array_equal(wing.targets[:-10], wing.inputs[10:])
    assert glass.inputs.std() == pytest.approx(mackey_glass(2000, step=6.0).std(), rel=0.1)
    assert wing.inputs.std() == pytest.approx(lorenz(2000)[:, 0].std(), rel=0.2)


def oracle(name):
    """A reservoir that knows the target."""
    problem = SERIES_TASKS[name].draw(1500, 5)
    return lambda drive, seed: problem.targets[:, None] + 0.0


@pytest.mark.parametrize("name", SERIES_TASKS)
def test_who_knows_the_target_scores_best_and_who_knows_nothing_by_chance(name):
    task = SERIES_TASKS[name]
    best = task.attempt(oracle(name), length=1500, seed=5, washout=100)
    noise = np.random.default_rng(0).standard_normal((1500, 4))
    chance = task.attempt(lambda drive, seed: noise, length=1500, seed=5, washout=100)
    ideal = {"NRMSE": 0.0, "accuracy": 1.0, "capacity": 1.0}[task.metric.name]
    assert best.score == pytest.approx(ideal, abs=2e-4)
    assert chance.score == pytest.approx(task.metric.chance, abs=0.12)
    assert task.metric.prefers(best.score, chance.score)
    assert not task.metric.prefers(chance.score, best.score)


def test_an_nrmse_divides_by_the_standard_deviation():
    targets = np.random.default_rng(0).standard_normal(4000)
    noisy = targets[:, None] + 0.5 * np.random.default_rng(1).standard_normal((4000, 1))
    solution = NRMSE.solve(noisy, targets, 0)
    # The best linear readout of t + e leaves Var e / (1 + Var e) of the variance.
    assert solution.score == pytest.approx(np.sqrt(0.25 / 1.25), rel=0.03)
    np.testing.assert_array_equal(solution.target, targets[2000:])
    error = np.sqrt(np.mean((solution.prediction - solution.target) ** 2)) / solution.target.std()
    assert solution.score == pytest.approx(error)


def test_samples_before_the_washout_are_never_scored():
    task = TASKS["NARMA-2 NRMSE"]
    problem = task.draw(1000, 0)
    states = np.random.default_rng(0).standard_normal((1000, 3))
    states[:, 0] = problem.targets

    def spoiled(count):
        wrong = states.copy()
        wrong[:count] = 1e6
        return task.attempt(lambda drive, seed: wrong, length=1000, seed=0, washout=200).score

    assert spoiled(200) == task.attempt(lambda drive, seed: states, length=1000, seed=0, washout=200).score
    assert spoiled(201) > 10 * spoiled(200)
    # The warm-up is left out even without a washout.
    wrong = states.copy()
    wrong[: problem.warm_up] = 1e6
    scores = [
        task.attempt(lambda drive, seed, given=given: given, length=1000, seed=0, washout=0).score
        for given in (states, wrong)
    ]
    assert problem.warm_up == 2
    assert scores[0] == scores[1]


def test_the_scored_half_begins_in_the_middle_of_what_the_washout_leaves():
    """Of 1001 samples 101 are washed out, 450 fit the readout and 450 judge it."""
    targets = np.random.default_rng(1).standard_normal(1001)
    solution = NRMSE.solve(targets[:, None], targets, 101)
    np.testing.assert_array_equal(solution.target, targets[551:])
    seen = []
    spied = Metric(
        "spied", lambda states, t, start: seen.append((len(states), len(t), start)) or Solution(0.0), True, 0.0
    )
    task = SeriesTask(lambda length, seed: Problem(targets, targets, targets, 7), spied)

    class Tuned:
        candidates = (lambda drive, seed: drive[:, None],)

    task.attempt(Tuned(), length=1001, seed=0, washout=101)
    assert seen == [(551, 551, 101), (1001, 1001, 101)]
    task.attempt(lambda drive, seed: drive[:, None], length=1001, seed=0, washout=3)
    assert seen[-1] == (1001, 1001, 7)


def test_a_draw_is_shared_and_nobody_writes_to_it():
    draws = []

    def draw(length, seed):
        draws.append((length, seed))
        return Problem(np.zeros(length), np.zeros(length), np.arange(length, dtype=float), 0)

    def scribbling(drive, seed):
        drive[0] = 1.0
        return drive[:, None]

    task = SeriesTask(draw, CAPACITY)
    for _ in range(2):
        with pytest.raises(ValueError, match="read-only"):
            task.attempt(scribbling, length=300, seed=0, washout=0)
    noise = np.random.default_rng(0).random((400, 2))
    task.attempt(lambda drive, seed: noise[: len(drive)], length=300, seed=0, washout=0)
    task.attempt(lambda drive, seed: noise[: len(drive)], length=300, seed=1, washout=0)
    assert draws == [(300, 0), (300, 1)]

    def spoiling(states, targets, start):
        targets[0] = 9.0

    with pytest.raises(ValueError, match="read-only"):
        SeriesTask(draw, Metric("spoiling", spoiling, True, 0.0)).attempt(
            lambda drive, seed: noise[:300], length=300, seed=0, washout=0
        )
    problem = task_module._drawn(draw, 300, 0)
    assert not any(array.flags.writeable for array in (problem.drive, problem.inputs, problem.targets))


def test_the_first_of_equal_candidates_is_taken():
    class Tuned:
        candidates = ("a", "b", "c")

    scores = {"a": 1.0, "b": 3.0, "c": 3.0}
    assert tuned(Tuned(), scores.get, CAPACITY) == "b"
    assert tuned(Tuned(), {"a": 2.0, "b": 2.0, "c": 3.0}.get, NRMSE) == "a"
    assert tuned("alone", scores.get, NRMSE) == "alone"


def test_an_accuracy_counts_the_samples_on_the_right_side_of_a_half():
    kinds = np.tile([0.0, 1.0, 1.0, 0.0], 100)
    wrong = np.where(np.arange(400) % 8 == 5, 1 - kinds, kinds)
    solution = ACCURACY.solve(wrong[:, None], kinds, 0)
    expected = np.mean((solution.prediction >= 0.5) == (solution.target == 1.0))
    assert solution.score == expected == 7 / 8
    np.testing.assert_array_equal(solution.target, kinds[200:])


def test_a_capacity_is_the_corrected_total_over_forty_delays():
    bits = random_bits(600, 0)
    states = DelayLine(5)(bits)
    expected = memory_capacity(states, bits, 40, washout=70)
    solution = CAPACITY.solve(states, bits, 70)
    assert solution.score == expected.corrected
    np.testing.assert_array_equal(solution.memory.profile, expected.profile)
    assert solution.prediction is solution.target is None


@pytest.mark.parametrize("metric", [NRMSE, ACCURACY])
def test_as_few_samples_are_scored_as_can_be(metric):
    """Of 3 features both halves must have two samples more: 12 are enough."""
    states = np.random.default_rng(0).random((12, 3))
    needed = samples_needed(3, 0.5)
    assert math.isfinite(metric.solve(states[:needed], states[:needed, 0], 0).score)
    with pytest.raises(ValueError, match=rf"at least {needed} samples for 3 features to be scored, got {needed - 1}"):
        metric.solve(states[: needed - 1], states[: needed - 1, 0], 0)


BOUNDS = {"NRMSE": (0, math.inf), "capacity": (0, math.inf), "accuracy": (0, 1), "valid time": (0, math.inf)}
BOUNDS |= {"rank": (0, math.inf), "index": (1, math.inf)}


def test_every_metric_has_its_bounds_and_chance():
    for name, task in {**TASKS, **MEASURES}.items():
        assert task.metric.bounds == BOUNDS[task.metric.name], name
    assert Metric("another", None, True, 0.0).bounds is None
    assert [(m.name, m.more_is_better, m.chance) for m in (NRMSE, ACCURACY, CAPACITY, VALID_TIME)] == [
        ("NRMSE", False, 1.0), ("accuracy", True, 0.5), ("capacity", True, 0.0), ("valid time", True, 0.0)
    ]  # fmt: skip


def test_a_mean_score_keeps_to_the_bounds_of_its_task():
    scores = [1.0, 7.0, 7.5]
    free = mean_over_runs(scores)
    bounded = mean_over_runs(scores, bounds=(0.0, math.inf))
    named = {name: Metric(name, None, True, 0.0) for name in ("another", "capacity", "NRMSE", "rank")}
    of = {name: SeriesTask(None, metric) for name, metric in named.items()}
    assert mean_score(of["another"], scores, 4) == free
    assert mean_score(of["NRMSE"], scores, 4) == bounded
    assert mean_score(of["capacity"], scores) == bounded
    for name in ("capacity", "rank"):
        assert mean_score(of[name], scores, 8) == mean_over_runs(scores, bounds=(0.0, 8.0))
        # One seed's estimate beyond what can be true is no reason to fail.
        found = mean_score(of[name], scores, 7)
        assert (found.low, found.high) == (mean_over_runs(scores, bounds=(0.0, 7.5)).low, 7.0)
    loop = TASKS["Lorenz valid time"]
    assert mean_score(loop, scores, 4) == mean_over_runs(scores, bounds=(0.0, 8.0))
    assert mean_score(replace(loop, horizon=20.0), scores) == mean_over_runs(scores, bounds=(0.0, 20.0))


class Spied:
    """A reservoir whose states are the target where `known`, and noise elsewhere."""

    def __init__(self, targets, known, candidates=()):
        self.targets, self.known, self.candidates = targets, known, candidates

    def __call__(self, drive, seed):
        noise = np.random.default_rng(0).standard_normal(len(drive))
        return np.where(self.known, self.targets, noise)[:, None]


@pytest.mark.parametrize("name", ["NARMA-2 NRMSE", "memory capacity", "waveform accuracy"])
def test_tuning_sees_no_sample_that_is_scored(name):
    """Of two candidates it takes the one that knows the training half, though the other knows the scored half."""
    task = TASKS[name]
    targets = task.draw(1000, 0).targets
    training = np.arange(1000) < 600
    learned, scored = Spied(targets, training), Spied(targets, ~training)
    for candidates in ((learned, scored), (scored, learned)):
        chosen = task.attempt(Spied(targets, training, candidates), length=1000, seed=0, washout=200)
        assert chosen.score == task.attempt(learned, length=1000, seed=0, washout=200).score


def test_a_tuned_network_beats_the_default_where_the_default_is_wrong():
    for name in ("parity-3 capacity", "NARMA-2 NRMSE"):
        task = TASKS[name]
        plain, tuned = (
            task.attempt(EchoState(12, tune=tune), length=2000, seed=0, washout=200).score for tune in (False, True)
        )
        assert task.metric.prefers(tuned, plain)
    assert EchoState(12).candidates == ()
    candidates = EchoState(12, tune=True, leak=0.5, topology="cycle").candidates
    assert len(set(candidates)) == len(candidates) > 16
    assert {candidate.centred for candidate in candidates} == {False, True}
    assert all((each.leak, each.topology, each.candidates) == (0.5, "cycle", ()) for each in candidates)


def test_a_centred_network_hears_the_series_about_its_middle():
    series = np.random.default_rng(0).random(50)
    centred = EchoState(5, topology="cycle", centred=True)
    np.testing.assert_array_equal(centred(series, 0), EchoState(5, topology="cycle")(2 * series - 1, 0))
    np.testing.assert_allclose(centred(1 - series, 0), -centred(series, 0), atol=1e-14)


def test_baselines_are_tuned_over_what_was_found_to_matter():
    """NARMA-10 of 12 nodes needs a small radius, a small input and a centred drive; the defaults miss all three."""
    task = TASKS["NARMA-10 uniform NRMSE"]
    tuned, usual = (
        np.mean([task.attempt(each, length=2500, seed=seed, washout=200).score for seed in range(2)])
        for each in (EchoState(12, tune=True), EchoState(12, 0.9, 0.15))
    )
    assert tuned < usual - 0.03


# The ground's friction


@pytest.mark.parametrize("which", ["static", "kinetic"])
def test_a_body_on_the_ground_feels_its_friction_and_nothing_else_does(which):
    task = FrictionTask(which)
    scores = {
        name: task.attempt(reservoir, length=6000, seed=0, washout=0).score
        for name, reservoir in known_reservoirs(6).items()
    }
    assert scores.pop("crawler") < 0.7
    assert scores.pop("chain of 3") < 0.9
    for score in scores.values():
        assert score == pytest.approx(task.metric.chance, abs=0.05)


def test_the_grounds_are_within_their_ranges_and_kinetic_friction_is_the_lesser():
    static, kinetic = FrictionTask().draw(2000, 0).T
    assert 0.05 <= static.min() < 0.06
    assert 0.49 < static.max() <= 0.5
    assert (kinetic / static).min() >= 0.4
    assert (kinetic <= static).all()


def test_grounds_are_drawn_static_friction_first():
    random = np.random.default_rng(5)
    static = random.uniform(0.05, 0.5, 30)
    expected = np.column_stack([static, static * random.uniform(0.4, 1.0, 30)])
    np.testing.assert_array_equal(FrictionTask().draw(30, 5), expected)


class Ground:
    """A reservoir that feels one of the frictions in its last hold, and neither in those before."""

    def __init__(self, column):
        self.column, self.met = column, []

    def on_grounds(self, series, grounds):
        self.met.append((series.tolist(), list(grounds)))
        felt = np.zeros((len(grounds), len(series), 1))
        felt[:, -1, 0] = np.array(grounds)[:, self.column]
        return felt


@pytest.mark.parametrize(("which", "column"), [("static", 0), ("kinetic", 1)])
def test_the_friction_to_be_told_is_the_one_that_is_named(which, column):
    task = FrictionTask(which, word="110", repeats=2)
    ground = Ground(column)
    solution = task.attempt(ground, length=125, seed=3, washout=50)
    [(gait, grounds)] = ground.met
    assert gait == [1, 1, 0, 1, 1, 0]
    np.testing.assert_array_equal(grounds, task.draw(20, 3))
    np.testing.assert_array_equal(solution.target, np.array(grounds)[10:, column])
    assert solution.score < 1e-6
    assert task.attempt(Ground(1 - column), length=600, seed=3, washout=0).score > 0.2


def test_who_cannot_feel_the_ground_has_the_last_state_of_the_gait_everywhere():
    heard = []

    def reservoir(gait, seed):
        heard.append((gait.tolist(), seed))
        return np.arange(len(gait), dtype=float)[:, None]

    states = []
    metric = Metric("kept", lambda x, targets, start: states.append((x, start)) or Solution(0.0), True, 0.0)
    FrictionTask("static", word="10", repeats=3, metric=metric).attempt(reservoir, length=30, seed=2, washout=4)
    assert heard == [([1, 0, 1, 0, 1, 0], 2)]
    np.testing.assert_array_equal(states[0][0], np.full((5, 1), 5.0))
    assert states[0][1] == 0


def test_each_ground_is_met_at_rest_by_a_body_of_that_friction():
    body = BodyReservoir(virtual_nodes=2)
    grounds = [(0.4, 0.3), (0.1, 0.05), (0.4, 0.3)]
    states = body.on_grounds([1.0, 0.0, 1.0], grounds)
    for row, (s, k) in zip(states, grounds, strict=True):
        alone = BodyReservoir(groups=Groups(static_friction=s, kinetic_friction=k), virtual_nodes=2)
        np.testing.assert_array_equal(row, alone([1.0, 0.0, 1.0]))


# Reservoirs


@pytest.mark.parametrize("features", [6, 12, 60])
@pytest.mark.parametrize("encoding", ["pulse_width", "sigma_delta"])
def test_every_reservoir_has_the_features_it_counts_and_no_more_than_asked_for(features, encoding):
    drive = np.random.default_rng(0).random(20)
    for name, reservoir in known_reservoirs(features, encoding=encoding, holds_per_sample=2).items():
        states = reservoir(drive, 0)
        assert states.shape == (20, reservoir.features)
        assert np.isfinite(states).all()
        if "chain" not in name:
            assert reservoir.features == features
        elif features >= 7:
            assert features - 7 < reservoir.features <= features


def test_the_ladder_of_bodies_adds_one_part_at_a_time():
    known = known_reservoirs(12, groups={"deborah": 0.7})
    assert known["anchored"].scene == Scene(anchored=True)
    assert known["linear"].groups == Groups(deborah=0.7, duffing=0.0, radial_coupling=0.0)
    assert known["pressure only"].readings == ("pressure",)
    drive = np.random.default_rng(0).random(50)
    # The pressure obeys the lag alone: p' = (u - p) / deborah, with a state of one number.
    p, rows = 0.0, []
    for value in drive:
        for j in range(1, 13):
            t = 0.5 * j / 12
            top = 1 - (1 - p) * np.exp(-min(t, 0.5 * value) / 0.7)
            rows.append(top * np.exp(-max(0.0, t - 0.5 * value) / 0.7))
        p = rows[-1]
    np.testing.assert_allclose(known["pressure only"](drive, 0).ravel(), rows, rtol=1e-12)


def test_the_linear_body_is_an_affine_map_of_three_states():
    drive = np.random.default_rng(0).integers(0, 2, 400).astype(float)
    memory = TASKS["memory capacity"].metric.solve(known_reservoirs(12)["linear"](drive, 0), drive, 100).memory
    assert memory.bound == 4


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: known_reservoirs(10), "features must be a multiple of 3, got 10"),
        (lambda: known_reservoirs(12, segments=1), "segments must be a whole number >= 2, got 1"),
        (lambda: EchoState(0), "nodes must be a whole number >= 1, got 0"),
        (lambda: BodyReservoir(readings=["pressure", "pressure"]), "none twice"),
        (lambda: BodyReservoir()([0.5, 1.5]), r"series must be in \[0, 1\], got 1.5 at index 1"),
        (lambda: FrictionTask("rolling"), "which must be 'static' or 'kinetic', got 'rolling'"),
        (lambda: FrictionTask(word="12"), "word must be of 0 and 1 and not empty, got '12'"),
        (lambda: FrictionTask(repeats=0), "repeats must be a whole number >= 1, got 0"),
        (
            lambda: TASKS["static friction NRMSE"].attempt(BodyReservoir(), length=10, seed=0, washout=0),
            "length must be a whole number >= 60, got 10",
        ),
        (
            lambda: TASKS["NARMA-20 NRMSE"].attempt(BodyReservoir(), length=20, seed=0, washout=5),
            "length must be more than the 20 samples that are washed out or warm up, got 20",
        ),
        (
            lambda: TASKS["Lorenz NRMSE"].attempt(BodyReservoir(), length=100, seed=0, washout=99),
            "states must have at least 24 samples for 12 features",
        ),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_metrics_know_their_direction():
    assert CAPACITY.prefers(2.0, 1.0)
    assert ACCURACY.prefers(0.9, 0.5)
    assert NRMSE.prefers(0.1, 0.5)
