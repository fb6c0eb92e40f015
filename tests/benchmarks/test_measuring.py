"""What benchmarks derive from times, with a clock that is told: per unit, in the same round, of the better peer."""

import argparse
import itertools
import json
import math
import sys

import condition_cost
import extremes
import measuring
import memory_reward
import numpy as np
import pytest
import readout_penalty
import remeasured
import scenes
import solver_choice
import vector_speed
from measuring import keep, machine, quartiles, refresh, refreshed, take_turns
from peer_solvers import comparison
from worth import cost
from worth.summary import loss

from stickslip.crawler import Groups, Scene, simulate


class Clock:
    """Wall and processor, which works move on."""

    def __init__(self, monkeypatch):
        self.wall = self.process = 0.0
        self.calls = []
        monkeypatch.setattr(measuring.time, "perf_counter", lambda: self.wall)
        monkeypatch.setattr(measuring.time, "process_time", lambda: self.process)

    def work(self, name, wall, process):
        def take():
            self.calls.append(name)
            self.wall += wall
            self.process += process

        return take


def test_turns_are_taken_forward_and_backward_by_the_lesser_of_two_clocks(monkeypatch):
    clock = Clock(monkeypatch)
    works = {"waits": clock.work("waits", 0.5, 0.02), "threads": clock.work("threads", 0.03, 0.06)}
    seconds = take_turns(works, 4)
    assert seconds == {
        "waits": pytest.approx(dict.fromkeys(range(4), 0.02)),
        "threads": pytest.approx(dict.fromkeys(range(4), 0.03)),
    }
    once, rounds = clock.calls[:2], clock.calls[2:]
    assert once == ["waits", "threads"]
    assert rounds == ["waits", "threads", "threads", "waits"] * 2


def test_a_short_work_is_repeated_and_a_dear_one_sits_rounds_out(monkeypatch):
    clock = Clock(monkeypatch)
    works = {"short": clock.work("short", 0.003, 0.003), "dear": clock.work("dear", 10.0, 10.0)}
    seconds = take_turns(works, 12, budget=60.0)
    # A hundredth of a second is four of the first; sixty seconds are six of the second.
    assert seconds["short"] == pytest.approx(dict.fromkeys(range(12), 0.003))
    assert clock.calls.count("short") == 1 + 4 * 12
    assert list(seconds["dear"]) == [0, 2, 4, 6, 8, 10]
    assert list(take_turns({"dear": clock.work("dear", 10.0, 10.0)}, 12, budget=1.0)["dear"]) == [0, 4, 8]
    assert list(take_turns({"dear": clock.work("dear", 10.0, 10.0)}, 2, budget=1.0)["dear"]) == [0, 1]


def test_quartiles_by_hand():
    assert quartiles([5.0, 1.0, 3.0, 2.0, 4.0]) == [2.0, 3.0, 4.0]
    assert all(type(each) is float for each in quartiles([1.0, 2.0]))


def test_a_table_goes_between_its_marks_and_nowhere_else(tmp_path):
    page = "a\n<!-- one -->\nold\nolder\n<!-- end -->\nb\n<!-- two -->\n<!-- end -->\nc\n"
    made = {"one": r"\1 | new", "two": "other"}
    expected = "a\n<!-- one -->\n\\1 | new\n<!-- end -->\nb\n<!-- two -->\nother\n<!-- end -->\nc\n"
    assert refreshed(page, made) == expected
    file = tmp_path / "page.md"
    file.write_text(page, encoding="utf-8")
    refresh(file, made)
    assert file.read_text(encoding="utf-8") == expected
    for text, times in (("<!-- o.e -->\n<!-- end -->", 0), (2 * "<!-- one -->\n<!-- end -->\n", 2)):
        with pytest.raises(
            ValueError, match=rf"^the page must have the marks of table 'one' once, found them {times} "
        ):
            refreshed(text, {"one": "x"})


def test_results_are_kept_with_the_machine(tmp_path):
    told = machine("scipy", "no-such-library")
    keep(tmp_path / "results.json", {"machine": told, "µ": [1.5]})
    again = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert again == {"machine": told, "µ": [1.5]}
    assert told["versions"]["numpy"] == np.__version__
    assert set(told["versions"]) == {"stickslip", "numpy", "numba", "scipy", "no-such-library"}
    assert told["versions"]["no-such-library"] is None
    assert told["python"] == ".".join(map(str, sys.version_info[:3]))
    assert told["processor"]


@pytest.fixture
def printed(monkeypatch, tmp_path):
    """What a script keeps and puts into its page, its command line empty and its works timed as is told."""

    def run(script, seconds):
        made = {}
        monkeypatch.setattr(script, "take_turns", seconds)
        monkeypatch.setattr(script, "keep", lambda path, results: made.update(results=results))
        monkeypatch.setattr(script, "refresh", lambda page, tables: made.update(tables=tables))
        monkeypatch.setattr(argparse.ArgumentParser, "parse_args", lambda self: self.parse_known_args([])[0])
        script.main()
        return made["results"], made["tables"]

    return run


def test_the_cost_of_a_condition_is_that_over_the_run_without_in_the_same_round(printed, monkeypatch):
    asked = []
    monkeypatch.setattr(condition_cost, "simulate", lambda *_, **arguments: asked.append(arguments))

    def seconds(works, rounds):
        taken = {
            name: {turn: (turn + 1.0) * (3.0 if name.endswith("True") else 2.0) for turn in range(3)} for name in works
        }
        for name, work in works.items():
            taken[name] = {turn: (turn + 1.0) * (3.0 if name.endswith("True") else 2.0) for turn in range(3)}
            work()
            assert asked[-1]["condition"] == name.endswith("True")
            assert f"{asked[-1]['tolerance']:g}" in name
            case = next(case for case in condition_cost.CASES if name.startswith(f"{case} "))
            assert (asked[-1]["scene"], asked[-1]["solver"]) == condition_cost.CASES[case][1:]
        return taken

    results, tables = printed(condition_cost, seconds)
    assert len(results["ratios"]) == len(condition_cost.CASES)
    assert {each for row in results["ratios"].values() for ratio in row.values() for each in ratio} == {1.5}
    assert "| linear | closed form | 1.50 [1.50, 1.50] |" in tables["condition"]


@pytest.mark.slow
def test_the_cost_of_a_scene_is_a_unit_of_time_s_and_over_the_crawler_s(printed, monkeypatch):
    short = {name: scenes.CASES[name] for name in (scenes.CRAWLER, "anchored, linear")}
    monkeypatch.setattr(scenes, "CASES", short)
    monkeypatch.setattr(scenes, "PAIRS", dict(itertools.islice(scenes.PAIRS.items(), 1)))
    monkeypatch.setattr(scenes, "WORDS", 5)

    def seconds(works, rounds):
        return {name: {0: 0.1 * place, 1: 0.4 * place, 2: 0.2 * place} for place, name in enumerate(works, 1)}

    results, _ = printed(scenes, seconds)
    for place, row in enumerate(results["scenes"].values(), 1):
        assert row["ratio"] == pytest.approx([place] * 3)
        # Five words of eight holds of one unit of time.
        assert row["us_per_time"] == pytest.approx(np.array([0.15, 0.2, 0.3]) * place * 1e6 / 40)
    models = {name: row["model"] for name, row in results["scenes"].items()}
    assert models["anchored, linear"] == simulate("linear", [1], 1.0, scene=Scene(anchored=True)).model
    assert models[scenes.CRAWLER] == simulate(Groups(), [1], 1.0).model
    (difference,) = results["disagreements"].values()
    one, other = (
        simulate("linear", scenes.WORD * 2, 1.0, solver=each, tolerance=1e-12) for each in ("closed_form", "taylor")
    )
    larger = max(np.abs(one.foot - other.foot).max(), np.abs(one.deformation - other.deformation).max())
    assert difference == larger > 0


def test_batches_are_beside_the_better_setting_of_a_peer_in_the_same_round(monkeypatch):
    def seconds(works, rounds):
        assert rounds == 3
        return {
            vector_speed.CARTPOLE: {0: 1.0, 1: 2.0, 2: 4.0},
            f"{vector_speed.ENVPOOL}, threads=1": {0: 1.0, 2: 1.0},
            f"{vector_speed.ENVPOOL}, threads=2": {0: 0.5, 1: 1.0, 2: 2.0},
            **{
                f"{name}, threads={threads}": {turn: base * 2.0**turn / threads for turn in range(3)}
                for base, name in enumerate((vector_speed.READOUT, vector_speed.SPEED, vector_speed.ANCHORED), 1)
                for threads in (1, 2)
            },
        }

    monkeypatch.setattr(vector_speed, "contenders", dict)
    monkeypatch.setattr(vector_speed, "take_turns", seconds)
    found = vector_speed.peers(3)
    assert found[vector_speed.CARTPOLE] == {"steps/s": quartiles([4096.0, 2048.0, 1024.0])}
    # Turns 0 and 2 are shared: 0.5 / 1, and 1 / 4.
    one = found[f"{vector_speed.READOUT}, threads=1"]
    assert (one["peer"], one["target"]) == (vector_speed.ENVPOOL, 2.0)
    assert one["ratio"] == quartiles([0.5, 0.25])
    assert found[f"{vector_speed.ANCHORED}, threads=1"]["ratio"] == quartiles([1 / 3] * 3)
    assert found[f"{vector_speed.SPEED}, threads=2"]["over one thread"] == [2.0, 2.0, 2.0]
    assert "over one thread" not in one
    monkeypatch.setattr(vector_speed, "stepping", lambda env, count: count)
    monkeypatch.setattr(vector_speed.gym, "make_vec", lambda name, count: None)
    monkeypatch.setattr(
        vector_speed,
        "take_turns",
        lambda works, rounds, budget: {name: {0: 2.0 * each} for name, each in works.items()},
    )
    assert vector_speed.sizes(1) == {count: pytest.approx([2e6] * 3) for count in vector_speed.SIZES}


ROW = {
    "groups": {"duffing": 2.0, "damping_ratio": 0.1, "foot_mass_fraction": 0.25},
    "scene": {},
    "initial": [0.5, 0.0, 0.0, 0.0, 0.0],
    "samples_per_hold": 1,
    "valve": "10",
    "hold": 20.0,
    "samples": {"deformation": ["0.25", "-0.75"], "foot": ["0", "0"]},
    "slips": 2,
    "events": [],
    "condition": 3.0,
}


def test_cycles_of_the_physics_by_hand():
    """The largest |z| is that of a sample, the mass that of the payload, or less once it slides."""
    k = 1 + 3 * 2 * 0.75**2
    assert extremes.cycles_per_time(ROW) == pytest.approx(math.sqrt(k / 0.75 - (0.1 / 0.75) ** 2) / (2 * math.pi))
    sliding = math.sqrt(k / 0.1875 - (0.1 / 0.1875) ** 2) / (2 * math.pi)
    assert extremes.cycles_per_time({**ROW, "events": [1]}) == pytest.approx(sliding)
    assert extremes.cycles_per_time({**ROW, "initial": [-2.0, 0, 0, 0, 0]}) == pytest.approx(
        math.sqrt((1 + 6 * 4) / 0.75 - (0.1 / 0.75) ** 2) / (2 * math.pi)
    )
    damped = {**ROW, "groups": {**ROW["groups"], "damping_ratio": 9.0}}
    assert extremes.cycles_per_time(damped) == 0.05  # 2 slips and 1 edge in 40 and 20 units of time
    assert extremes.cycles_per_time({**damped, "slips": 8}) == 0.2
    assert extremes.cycles_per_time({**damped, "slips": 0, "hold": 0.1}) == 10.0


def test_the_cost_of_an_extreme_is_a_unit_of_time_s_without_what_idles(monkeypatch):
    rows = {"one": ROW, "two": {**ROW, "valve": "1000"}}
    told = {name: {"cycles_per_time": cycles} for name, cycles in (("one", 0.5), ("two", 4.0))}
    monkeypatch.setattr(
        extremes, "accuracy", lambda row: told.get(next(n for n, r in rows.items() if r is row), {}).copy()
    )
    order = []

    def calls(row):
        name = next(name for name, each in rows.items() if each is row)
        return (name, "busy"), (name, "idle"), 10

    def seconds(call):
        order.append(call)
        name, kind = call
        turn = order.count(call) - 1
        return {"busy": [9.0, 5.0, 6.0], "idle": [1.0, 3.0, 2.0]}[kind][turn] * {"one": 1, "two": 2}[name]

    monkeypatch.setattr(extremes, "calls", calls)
    monkeypatch.setattr(extremes, "seconds", seconds)
    found = extremes.measure(rows, 3)
    # 6 - 2 seconds of ten crawlers and two holds of 20; twice as much a cycle would be no cost of one.
    assert found["one"]["us_per_time"] == pytest.approx(4e6 / 400)
    assert found["one"]["us_per_time_range"] == pytest.approx([3e6 / 400, 7e6 / 400])
    assert found["one"]["us_per_cycle"] == found["one"]["us_per_time"]
    assert found["two"]["us_per_time"] == pytest.approx(8e6 / 800)
    assert found["two"]["us_per_cycle"] == pytest.approx(8e6 / 800 / 4)
    assert [name for name, kind in order if kind == "busy"] == ["one", "two", "two", "one", "one", "two"]


def test_the_error_of_an_extreme_is_its_largest():
    done = type("Done", (), {"deformation": np.array([0.25, -0.5]), "foot": np.array([0.1, 0.0])})
    assert extremes.error_of(done, ROW) == 0.25


def choice(ratio, **cost):
    return {"ratio": ratio, "cost": cost, "steps": cost}


def test_a_choice_of_solver_is_summed_up_by_its_worst():
    ratios = [1.0 + 0.01 * k for k in range(101)]
    assert solver_choice.summary([choice(each) for each in ratios]) == {
        "median": 1.5,
        "worst tenth": 1.9,
        "worst hundredth": 1.99,
        "worst": 2.0,
    }
    rows = [choice(1.0, taylor=2.0, radau=1.0), choice(1.0, taylor=3.0, radau=6.0, closed_form=1.5)]
    found = solver_choice.always(rows)
    assert [found[name]["worst"] for name in ("taylor", "radau", "closed_form")] == [2.0, 4.0, 1.0]
    assert found["closed_form"]["median"] == 1.0


def test_steps_by_order_looks_and_predictions_by_hand(monkeypatch):
    drawn = [
        solver_choice.Drawn(Groups(), Scene(anchored=anchored), 1.0, tolerance, np.ones(2))
        for anchored, tolerance in ((False, 1e-6), (False, 1e-6), (True, 1e-12))
    ]
    rows = [
        {"drawn": each, "step cost": {"taylor": cost, "closed_form": 3 * cost}, "steps": {"taylor": 10.0 * cost}}
        for each, cost in zip(drawn, (1.0, 2.0, 8.0), strict=True)
    ]
    loose, tight = (str(solver_choice.SOLVERS["taylor"].order_for(each)) for each in (1e-6, 1e-12))
    assert solver_choice.step_costs(rows)["taylor"] == {loose: 1.5, tight: 8.0}
    assert solver_choice.looks_to_steps(rows) == [3.0, 3.0, 3.0]
    assert solver_choice.looks_to_steps(rows[2:]) == []
    monkeypatch.setattr(solver_choice, "predicted_steps", lambda name, *drawn: 40.0)
    assert solver_choice.predictions(rows) == {
        "taylor": np.percentile([4, 2, 0.5], [5, 25, 50, 75, 95]).round(2).tolist()
    }


@pytest.mark.slow
def test_a_run_that_is_broken_off_counts_by_the_time_it_reached():
    drawn = solver_choice.Drawn(Groups(), Scene(), 0.5, 1e-6, np.array([1.0, 0.0, 1.0, 0.0]))
    done = solver_choice.run(drawn, "taylor", 100_000)
    assert (done.reached, done.finished) == (2.0, True)
    broken = solver_choice.run(drawn, "taylor", done.steps // 2)
    assert not broken.finished
    assert 0 < broken.reached < 2.0
    assert broken.steps <= done.steps // 2


def test_the_loss_of_an_encoding_is_a_root_mean_square():
    encodings = remeasured._encodings()
    drive = encodings.random_uniform(encodings.LENGTH, 0)
    assert encodings.loss("threshold", 1) == pytest.approx(np.sqrt(np.mean(((drive >= 0.5) - drive) ** 2)))
    assert encodings.loss("pulse_width", 1) == pytest.approx(0, abs=1e-12)


def test_a_tolerance_costs_per_unit_and_over_each_default_in_the_same_round(monkeypatch):
    tolerances = (1e-3, cost.ENVIRONMENT_DEFAULT, cost.SIMULATE_DEFAULT)
    seconds = np.array([[1.0, 2.0, 4.0], [2.0, 8.0, 4.0], [6.0, 3.0, 8.0]])
    monkeypatch.setattr(cost, "_in_turns", lambda works: seconds)
    found = cost._by_tolerance(cost._Job(dict.fromkeys(tolerances), 20.0))
    assert list(found) == [cost.name_of(each) for each in tolerances]
    for column, row in zip(seconds.T, found.values(), strict=True):
        assert row["microseconds"] == pytest.approx(quartiles(1e6 / 20 * column))
        for default, own in ((cost.ENVIRONMENT_DEFAULT, seconds[:, 1]), (cost.SIMULATE_DEFAULT, seconds[:, 2])):
            assert row["times"][cost.name_of(default)] == pytest.approx(quartiles(column / own))
    body = next(iter(cost.BODIES.values()))
    assert cost._simulations(body).units == 400 * body["hold"]
    assert list(cost._simulations(body).works) == list(cost.ALL)


def test_the_rounds_of_a_tolerance_run_forward_and_backward(monkeypatch):
    told, order = iter(itertools.count()), []
    monkeypatch.setattr(cost, "_ROUNDS", 3)
    monkeypatch.setattr(cost.time, "thread_time", lambda: float(next(told)))
    works = {tolerance: lambda tolerance=tolerance: order.append(tolerance) for tolerance in (1.0, 2.0)}
    np.testing.assert_array_equal(cost._in_turns(works), np.ones((3, 2)))
    assert order == [1.0, 2.0, 1.0, 2.0, 2.0, 1.0, 1.0, 2.0]


def test_peers_cost_per_time_unit_and_over_the_cheapest_of_ours_that_is_no_less_accurate(monkeypatch):
    offsets = {"loose": 1e-4, "tight": 1e-8, "peer": 1e-5, "wild": 1.0}
    tolerances = {"loose": 1e-3, "tight": 1e-7, "peer": 1e-6, "wild": 1e-2}
    contenders = [
        comparison.Contender(
            **dict.fromkeys(comparison.Contender._fields, None)
            | {
                "library": "other" if name in ("peer", "wild") else comparison.LIBRARY,
                "method": "any" if name in ("peer", "wild") else comparison.KERNEL,
                "setting": name,
                "tolerance": tolerances[name],
                "run": lambda word, offset=offset: (comparison.FOOT - offset, 7),
            }
        )
        for name, offset in offsets.items()
    ]
    taken = [{0: 1.0, 1: 2.0}, {0: 2.0, 1: 4.0, 2: 8.0}, {0: 10.0, 1: 10.0, 2: 10.0}, {0: 1.0, 1: 1.0}]
    monkeypatch.setattr(comparison, "take_turns", lambda works, rounds, budget: dict(zip(works, taken, strict=True)))
    loose, tight, peer, wild = rows = comparison.measure(contenders, 3)
    unit = 1e6 / comparison.DURATION
    assert comparison.HOLD * len(comparison.WORD) == comparison.DURATION
    assert [row["error"] for row in rows] == pytest.approx(list(offsets.values()), rel=1e-4)
    assert peer["microseconds per time unit"] == pytest.approx([10 * unit] * 3)
    assert tight["microseconds per time unit"] == pytest.approx([3 * unit, 4 * unit, 6 * unit])
    assert peer["times stickslip"][comparison.KERNEL] == {
        "setting": "tight",
        "quartiles": pytest.approx(quartiles([5.0, 2.5, 1.25])),
    }
    assert wild["times stickslip"][comparison.KERNEL] == {"setting": "loose", "quartiles": quartiles([1.0, 0.5])}
    assert peer["times stickslip"][comparison.SIMULATE] is None
    assert loose["times stickslip"][comparison.KERNEL]["quartiles"] == [1, 1, 1]
    met = list(comparison.meet(1e-3, rows))
    assert [(row["library"], row["setting"]) for row in met] == [(comparison.LIBRARY, "loose"), ("other", "peer")]
    assert [row["goal"] for row in met] == [1e-3, 1e-3]
    assert list(comparison.meet(1e-9, rows)) == []


def test_a_loss_by_hand():
    values, reference = [1.0, 4.0, 6.0], [1.0, 2.0, 6.0]
    found = loss(values, reference)
    assert found.bias == pytest.approx(2 / 3)
    assert found.scatter == pytest.approx(np.std([0, 2, 0], ddof=1))
    assert found.rms == pytest.approx(np.sqrt(4 / 3))
    assert found.spread == pytest.approx(np.std(reference, ddof=1))
    assert found.relative == pytest.approx(found.rms / found.spread)


def test_a_reward_stands_for_a_capacity_by_its_bias():
    found = {
        "truth": [2.0, 4.0],
        "earned": [[1.0, 1.5, 3.0, 3.0], [2.0, 3.0, 3.0, 3.3]],
        "spread": [[9.0, 9.0, 0.25, 9.0], [9.0, 9.0, 0.75, 9.0]],
        "worst": -7.4,
    }
    assert memory_reward.LENGTHS.index(1000) == 2
    assert memory_reward.row("any", found) == "| any | 3.00 | -50% | -25% | +0% | +5% | 0.50 | nan | -7 |"
    assert "| - |" in memory_reward.row("any", {**found, "truth": [3.0, 3.1]})
    assert memory_reward.commands("110", 5).tolist() == [1, 1, 0, 1, 1]
    one, other = (memory_reward.commands(memory_reward.RANDOM, 50, seed) for seed in (0, 1))
    assert set(one) == {0, 1}
    assert (one != other).any()


def test_a_change_of_penalty_is_the_chosen_less_the_fixed_seed_by_seed():
    def record(task, seed, score):
        return readout_penalty.Record(task, "body", seed, score, {})

    fixed = [record("a", 0, 1.0), record("a", 1, 2.0), record("b", 0, 5.0)]
    chosen = [record("b", 0, 4.0), record("a", 1, 2.5), record("a", 0, 1.25)]
    found = readout_penalty.changes(fixed, chosen)
    assert found == {("b", "body"): [-1.0], ("a", "body"): [0.5, 0.25]}
    # Student's interval of a difference, which no sign bounds: t for one degree of freedom is 12.7.
    lines = readout_penalty.markdown({("a", "body"): [0.5, 0.25], ("b", "body"): [0.1, 0.1]}).splitlines()
    assert lines == ["| change of | body |", "|---|---:|", "| a | +0.375 ± 1.588 |", "| b | +0.100 |"]
