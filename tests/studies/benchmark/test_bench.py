"""The benchmark in a folder, argument by argument."""

import json

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot as plt

from stickslip.studies.benchmark import bench as bench_module
from stickslip.studies.benchmark import STANDARD_RESERVOIRS, STANDARD_TASKS
from stickslip.studies.benchmark.bench import Bench
from stickslip.studies.benchmark.probe import probes
from stickslip.studies.benchmark.records import Records
from stickslip.tasks import BodyReservoir, known_reservoirs, MEASURES, TASKS
from stickslip.tasks.task import mean_score

mpl.use("agg")

SMALL = {"tasks": "NARMA-2 NRMSE", "reservoirs": "delay line, crawler", "features": 3, "length": 400, "seeds": 2}


def ran(folder, **of):
    bench = Bench(folder, **of)
    return bench, list(bench.run())


def told(folder):
    return json.loads((folder / "benchmark.json").read_text(encoding="utf-8"))


def test_arguments_by_default(tmp_path):
    bench = Bench(tmp_path / "run")
    assert bench.total == (len(TASKS) + len(MEASURES)) * 9 * 15
    kept = json.loads((tmp_path / "run" / "finished" / "settings.json").read_text(encoding="utf-8"))
    assert {name: kept[name] for name in ("features", "length", "washout", "sweep", "hold")} == {
        "features": 12, "length": 4000, "washout": 200, "sweep": None, "hold": 0.5
    }  # fmt: skip
    assert list(kept["tasks"]) == [*TASKS, *MEASURES]
    assert list(kept["reservoirs"]) == list(known_reservoirs())
    assert bench.against == "crawler"
    assert STANDARD_TASKS == (
        "memory capacity", "NARMA-2 NRMSE", "NARMA-10 NRMSE", "parity-2 capacity", "parity-3 capacity"
    )  # fmt: skip
    assert STANDARD_RESERVOIRS == ("crawler", "delay line", "echo-state network")


def test_scores_are_the_tasks_own_with_every_argument(tmp_path):
    of = {**SMALL, "washout": 30, "body": {"hold": 0.8, "groups": {"duffing": 1.5}}}
    bench, finished = ran(tmp_path, **of)
    assert finished == [0, 1, 2, 3, 4]
    bench.report()
    expected = [
        TASKS["NARMA-2 NRMSE"].attempt(reservoir, length=400, seed=seed, washout=30).score
        for seed in (0, 1)
        for reservoir in (known_reservoirs(3)["delay line"], BodyReservoir({"duffing": 1.5}, hold=0.8, virtual_nodes=1))
    ]
    scores = {(each["seed"], each["reservoir"]): each["score"] for each in told(tmp_path)["scores"]}
    assert [scores[seed, name] for seed in (0, 1) for name in ("delay line", "crawler")] == expected
    inputs = told(tmp_path)["inputs"]
    assert inputs == {
        "features": 3,
        "length": 400,
        "washout": 30,
        "sweep": None,
        "hold": 0.8,
        "groups": {"duffing": 1.5},
        "tasks": ["NARMA-2 NRMSE"],
        "reservoirs": {
            "delay line": repr(known_reservoirs(3)["delay line"]),
            "crawler": repr(BodyReservoir({"duffing": 1.5}, hold=0.8, virtual_nodes=1)),
        },
        "seeds": [0, 1],
        "against": "delay line",
    }
    assert told(tmp_path)["made for"] == probes(
        {"NARMA-2 NRMSE": TASKS["NARMA-2 NRMSE"]},
        {
            "delay line": known_reservoirs(3)["delay line"],
            "crawler": BodyReservoir({"duffing": 1.5}, hold=0.8, virtual_nodes=1),
        },
    )


def test_the_tables_are_those_of_the_page(tmp_path):
    bench, _ = ran(tmp_path, **SMALL, against="crawler")
    rows, compared = bench.report()
    assert rows[0] == ["task", "delay line", "crawler"]
    assert compared[0] == ["task", "delay line"]
    assert [row[0] for row in rows] == ["task", "NARMA-2 NRMSE ↓"]
    assert compared[1][1][0] in "+-"
    page = (tmp_path / "table.md").read_text(encoding="utf-8").splitlines()
    assert page[0] == "| task | delay line | crawler |"
    assert page[2] == f"| {' | '.join(rows[1])} |"
    assert page[4] == "Differences from crawler on the same draws:"
    assert page[8] == f"| {' | '.join(compared[1])} |"
    assert {path.name for path in tmp_path.glob("*.png")} == {"scores.png", "differences.png", "predictions.png"}
    assert told(tmp_path)["inputs"]["against"] == "crawler"


def test_means_keep_to_the_features_and_differences_are_drawn_from_their_reservoir(tmp_path, monkeypatch):
    drawn = []

    def seen(*of, **named):
        drawn.append((of, named))
        return plt.figure()

    monkeypatch.setattr(bench_module, "plot_scores", seen)
    bench, _ = ran(tmp_path, **{**SMALL, "tasks": "memory capacity", "seeds": 3}, against="crawler")
    bench.report()
    for mean in told(tmp_path)["means"]:
        scores = [each["score"] for each in told(tmp_path)["scores"] if each["reservoir"] == mean["reservoir"]]
        expected = mean_score(TASKS["memory capacity"], scores, 3)
        assert mean["mean"] == pytest.approx(np.mean(scores))
        if mean["reservoir"] == "crawler":
            assert mean["interval"] == [expected.low, expected.high]
    (found, tasks), (paired, _) = (of for of, _ in drawn)
    assert list(found) == [("memory capacity", "delay line"), ("memory capacity", "crawler")]
    assert list(paired) == [("memory capacity", "delay line")]
    assert list(tasks) == ["memory capacity"]
    assert [named for _, named in drawn] == [{}, {"against": "crawler"}]
    [difference] = told(tmp_path)["differences"]
    assert difference["mean"] == paired["memory capacity", "delay line"].mean
    assert difference["mean"] == pytest.approx(
        found["memory capacity", "delay line"].mean - found["memory capacity", "crawler"].mean
    )


def test_one_reservoir_alone_is_compared_with_none(tmp_path):
    bench, _ = ran(tmp_path, **{**SMALL, "reservoirs": "delay line", "tasks": "memory capacity, echo index"})
    _, compared = bench.report()
    assert compared == []
    assert told(tmp_path)["differences"] == []
    assert "Differences" not in (tmp_path / "table.md").read_text(encoding="utf-8")
    assert {path.name for path in tmp_path.glob("*.png")} == {"scores.png", "profiles.png"}


def test_a_run_is_gone_on_with_and_may_grow(tmp_path):
    ran(tmp_path, **{**SMALL, "seeds": 1})
    with pytest.raises(ValueError, match="holds a run already"):
        Bench(tmp_path, **SMALL)
    bench, finished = ran(tmp_path, **SMALL, resume=True)
    assert (finished, bench.total) == ([2, 3, 4], 4)
    bench, finished = ran(tmp_path, **{**SMALL, "tasks": "NARMA-2 NRMSE,memory capacity"}, resume=True)
    assert (finished, bench.total) == ([4, 5, 6, 7, 8], 8)
    bench, finished = ran(tmp_path, **{**SMALL, "seeds": 1}, resume=True)
    assert (finished, bench.total) == ([2], 2)
    with pytest.raises(ValueError, match="length must be 400 to go on with the run in"):
        Bench(tmp_path, **{**SMALL, "length": 401}, resume=True)


def test_a_sweep_has_a_body_a_value(tmp_path, monkeypatch):
    of = {"sweep": "hold=2,0.5", "features": 3, "length": 400, "seeds": 1}
    bench = Bench(tmp_path, **of)
    assert bench.total == 2 * len(STANDARD_TASKS)
    assert bench.against == "hold = 0.5"
    bench, _ = ran(tmp_path, **of, tasks="NARMA-2 NRMSE", resume=True)
    drawn = []
    plot = bench_module.plot_sweep
    monkeypatch.setattr(bench_module, "plot_sweep", lambda *of: drawn.append(of) or plot(*of))
    bench.report()
    [(name, values, found, tasks)] = drawn
    assert (name, values, list(found), list(tasks)) == ("hold", [0.5, 2.0], ["NARMA-2 NRMSE"], ["NARMA-2 NRMSE"])
    scores = {each["reservoir"]: each["score"] for each in told(tmp_path)["scores"]}
    assert scores == {
        f"hold = {hold:g}": TASKS["NARMA-2 NRMSE"]
        .attempt(BodyReservoir(hold=hold, virtual_nodes=1), length=400, seed=0, washout=200)
        .score
        for hold in (0.5, 2.0)
    }
    assert [path.name for path in tmp_path.glob("*.png")] == ["sweep.png"]
    assert told(tmp_path)["inputs"]["sweep"] == "hold"


def test_attempts_of_others_are_kept_and_not_told(tmp_path):
    """A folder may hold more seeds and reservoirs than are asked for now."""
    ran(tmp_path, **{**SMALL, "seeds": 2})
    bench, _ = ran(tmp_path, **{**SMALL, "seeds": 1, "reservoirs": "crawler"}, resume=True)
    bench.report()
    assert [(each["reservoir"], each["seed"]) for each in told(tmp_path)["scores"]] == [("crawler", 0)]
    settings = json.loads((tmp_path / "finished" / "settings.json").read_text(encoding="utf-8"))
    assert len(Records(tmp_path / "finished", settings, resume=True).load()) == 4


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"seeds": 0}, "--seeds must be a whole number >= 1, got 0"),
        ({"length": 0}, "--length must be a whole number >= 1, got 0"),
        ({"washout": -1}, "--washout must be a whole number >= 0, got -1"),
        ({"features": 2}, "--features must be a whole number >= 3, got 2"),
        ({"tasks": "NARMA-3"}, "--tasks must be among .* got 'NARMA-3'"),
        ({"tasks": " , "}, "--tasks must be among .* got ' , '"),
        ({"reservoirs": "octopus"}, "--reservoirs must be among .* got 'octopus'"),
        ({"against": "anchored"}, "--against has no 'anchored'"),
        ({"sweep": "hold=1,2"}, "--reservoirs must be left out where --sweep is given, got 'delay line, crawler'"),
        ({"sweep": "hold=1,2", "reservoirs": None, "body": {"hold": 1}}, "hold must be left out where --sweep sets it"),
        (
            {"sweep": "slope=0,0.1", "reservoirs": None, "body": {"scene": {"slope": 0.2}, "groups": {"deborah": 1}}},
            "slope must be left out where --sweep sets it, got 0.2",
        ),
    ],
)
def test_bad_input(tmp_path, change, message):
    with pytest.raises(ValueError, match=message):
        Bench(tmp_path / "run", **{**SMALL, **change})
    assert not (tmp_path / "run").exists()


def test_names_are_read_between_commas_and_each_once(tmp_path):
    bench = Bench(tmp_path, **{**SMALL, "tasks": "echo index,, NARMA-2 NRMSE,echo index", "reservoirs": " all "})
    assert bench.total == 2 * 9 * 2
    with pytest.raises(ValueError, match="--processes must be a whole number >= 1, got 0"):
        list(bench.run(0))
