"""The command line: what it prints, and that it refuses in one line."""

import json
import os
import re
import subprocess
import sys
from importlib.metadata import version

import numpy as np
import pytest

from stickslip.commands import run
from stickslip.crawler import PRESETS, simulate
from stickslip.studies.benchmark import run_benchmark
from stickslip.studies.benchmark.sweep import parse_sweep
from stickslip.studies.claims.claim import Claim, Number
from stickslip.tasks import known_reservoirs, MEASURES, RESERVOIRS, SeriesTask, TASKS
from stickslip.train.algorithms import ALGORITHMS
from stickslip.train.run import Configuration


def refuse(capsys, *arguments):
    """Run a command that must be refused, and return the line it printed."""
    assert run(list(arguments)) != 0
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "Traceback" not in captured.err
    (line,) = captured.err.strip().splitlines()
    return line


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--dither", "0.7"], "error: dither must be in [0, 0.5], got 0.7"),
        (["--dither", "0"], "error: dither must be in (0, 0.5] where memory_weight = 0.2 > 0, got 0.0"),
        (["--memory-weight", "2"], "error: memory_weight must be in [0, 1], got 2.0"),
        (["--hold", "nan"], "error: hold must be in (0, 10000], got nan"),
        (["--groups", "octopus"], "error: groups must be one of the presets ["),
        (["--groups", '{"duffing": -1}'], "error: duffing must be in [0, inf), got -1"),
        (["--groups", '{"duffing": '], "error: --groups must be a JSON object, got '{\"duffing\": '"),
        (["--env-kwargs", "[1]"], "error: --env-kwargs must be a JSON object, got '[1]'"),
        (["--env-kwargs", '{"wheels": 4}'], "error: --env-kwargs has no 'wheels'; allowed are ['scene', 'tolerance', "),
        (["--env-kwargs", '{"max_episode_steps": 4}'], "error: --env-kwargs has no 'max_episode_steps'; allowed are"),
        (["--env-kwargs", '{"scene": {"wheels": 4}}'], "error: scene has no 'wheels'; allowed are"),
        (["--env-kwargs", '{"delays": 2, "delays": 3}'], "error: --env-kwargs must name 'delays' once, got it 2 times"),
        (["--groups", '{"duffing": 1, "duffing": 2}'], "error: --groups must name 'duffing' once, got it 2 times"),
        (["--env-kwargs", '{"dither": 0.2}'], "error: --env-kwargs must not set dither"),
        (["--env-kwargs", '{"render_mode": "human"}'], "error: --env-kwargs must not set render_mode"),
        (
            ["--env-kwargs", '{"virtual_nodes": 1000000000000}'],
            "error: virtual_nodes must be a whole number in ",
        ),
        (["--groups", '{"duffing": 1' + "0" * 310 + "}"], "error: duffing must be in [0, inf), got a number of 311"),
        (["--seed", "-1"], "error: seed must be a whole number in [0, 4294967295], got -1"),
        (["--steps", "0"], "error: --steps must be a whole number >= 1, got 0"),
        (
            ["--algorithm", "magic"],
            f"error: algorithm must be one of {list(ALGORITHMS)}, got 'magic'",
        ),
        (["--hyperparameters", "/nowhere.yml"], "error: [Errno 2] No such file or directory: '/nowhere.yml'"),
    ],
)
def test_training_is_refused_in_one_line(capsys, tmp_path, arguments, message):
    line = refuse(capsys, "train", "--output", str(tmp_path / "run"), *arguments)
    assert line.startswith(message)
    assert not (tmp_path / "run").exists()


def test_the_version_is_told(capsys):
    assert run(["--version"]) == 0
    assert capsys.readouterr().out == f"stickslip {version('stickslip')}\n"


def test_all_that_is_known_by_name_is_listed(capsys):
    assert run(["list"]) == 0
    listed, kind = {}, ""
    for line in capsys.readouterr().out.splitlines():
        if line.startswith("  "):
            listed[kind].append(line.strip())
        else:
            kind = line
            listed[kind] = []
    assert listed["tasks"] == list(TASKS)
    assert listed["measures"] == list(MEASURES)
    assert listed["reservoirs"] == list(RESERVOIRS)
    assert listed["presets"] == list(PRESETS)
    assert "recurrent_ppo" in listed["algorithms"]
    # What is listed is taken where it is asked for.
    for name in listed["algorithms"]:
        Configuration(algorithm=name)
    for name in listed["sweeps"]:
        assert parse_sweep(f"{name}=0.1,0.2")[0] == name
    for name in listed["solvers"]:
        simulate("linear", [1], 1.0, solver=name)
    assert {"duffing", "deborah", "slope", "hold"} <= set(listed["numbers of a map"])
    assert {"speed", "memory", "lyapunov"} <= set(listed["measures of a map"])


def test_what_the_real_body_does_is_told_of_the_claims_that_have_it(capsys, monkeypatch, tmp_path):
    of_a_body = Claim("C1", "reproduced", "It crawls.", body={"way": Number(77.3, unit="mm")})
    claims = [of_a_body, Claim("C9", "overturned", "It can.", remark="By far.")]
    monkeypatch.setattr("stickslip.studies.claims.reproduce.reproduce", lambda *_, **__: claims)
    assert run(["reproduce", "--output", str(tmp_path)]) == 0
    first, body, second, *_ = capsys.readouterr().out.splitlines()
    assert (first, second) == ("C1  reproduced: It crawls.", "C9  overturned: It can. By far.")
    assert body == "    the real body: way 77.3 mm"


def test_an_output_that_cannot_be_written_is_refused_in_one_line(capsys, tmp_path):
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    for command in (["train", "--dither", "0.1"], ["demo"]):
        line = refuse(capsys, *command, "--output", str(tmp_path / "file" / "run"))
        assert line.startswith("error: ")
        assert str(tmp_path / "file") in line


def test_a_fault_nobody_thought_of_is_one_line_too(capsys, monkeypatch, tmp_path):
    def fail(*_):
        raise AssertionError("two\nlines")

    monkeypatch.setattr("stickslip.train.hyperparameters.read_hyperparameters", fail)
    assert refuse(capsys, "train", "--output", str(tmp_path / "run")) == "error: two lines"
    monkeypatch.setenv("STICKSLIP_DEBUG", "1")
    with pytest.raises(AssertionError, match="two"):
        run(["train", "--output", str(tmp_path / "run")])


def test_an_evaluation_of_nothing_is_refused_in_one_line(capsys, tmp_path):
    assert refuse(capsys, "evaluate", str(tmp_path)).startswith("error: run must be a folder with a configuration.yml")


def test_what_is_not_understood_is_told_apart(capsys):
    assert run(["crawl"]) == 2
    assert run(["train", "--output", "x", "--steps", "many"]) == 2
    assert "Traceback" not in capsys.readouterr().err


def test_a_policy_is_trained_resumed_and_evaluated(capsys, tmp_path):
    folder = str(tmp_path / "run")
    command = ["train", "--output", folder, "--memory-weight", "0", "--dither", "0", "--steps", "100"]
    assert run(command) == 0
    assert "best policy: " in capsys.readouterr().out
    assert run(command) == 1
    assert "holds a run already" in capsys.readouterr().err
    assert run([*command, "--resume"]) == 0
    capsys.readouterr()
    assert run(["train", "--output", folder, "--resume", "--hold", "0.25"]) == 1
    assert "hold must be 0.5 to go on with run" in capsys.readouterr().err
    assert run(["train", "--output", folder, "--resume", "--steps", "9000"]) == 0  # the folder says all else
    assert re.search(r"reward per step \(speed \S+, memory 0\.0000\) after \d+ steps", capsys.readouterr().out)
    assert (tmp_path / "run" / "evaluations.csv").read_text(encoding="utf-8").splitlines()[-1].startswith("16384,")
    assert run(["evaluate", folder, "--steps", "1000", "--no-video"]) == 0
    assert "speed" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--groups", "octopus"], "error: groups must be one of the presets ["),
        (["--groups", '{"duffing": -1}'], "error: duffing must be in [0, inf), got -1"),
        (["--groups", '{"duffing": '], "error: --groups must be a JSON object, got '{\"duffing\": '"),
        (["--scene", "[1]"], "error: --scene must be a JSON object, got '[1]'"),
        (["--scene", '{"wheels": 4}'], "error: scene has no 'wheels'"),
        (["--hold", "nan"], "error: hold must be in (0, inf), got nan"),
        (["--holds", "0"], "error: --holds must be a whole number >= 1, got 0"),
        (["--error", "0"], "error: --error must be in (0, inf), got 0"),
        (["--rounds", "0"], "error: --rounds must be a whole number >= 1, got 0"),
        (["--seed", "-1"], "error: --seed must be a whole number >= 0, got -1"),
    ],
)
def test_a_measurement_of_speed_is_refused_in_one_line(capsys, tmp_path, arguments, message):
    assert refuse(capsys, "speed", "--output", str(tmp_path / "speed"), *arguments).startswith(message)
    assert not (tmp_path / "speed").exists()


def test_speed_and_accuracy_are_measured_and_a_choice_recommended(capsys, tmp_path):
    folder = tmp_path / "speed"
    assert run(["speed", "--output", str(folder), "--groups", "linear", "--holds", "20", "--rounds", "2"]) == 0
    printed = capsys.readouterr().out
    assert "Reference: " in printed
    assert "For an error of 1e-06 use " in " ".join(printed.split())
    assert sorted(path.name for path in folder.iterdir()) == [
        f"work_precision.{form}" for form in ("json", "png", "svg")
    ]
    found = json.loads((folder / "work_precision.json").read_text(encoding="utf-8"))
    assert (found["groups"]["duffing"], found["holds"], found["wanted"]) == (0.0, 20, 1e-6)
    assert len(found["rows"]) >= 13


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--tasks", "NARMA-3"], "error: --tasks must be among ['memory capacity', "),
        (["--tasks", ""], "error: --tasks must be among ['memory capacity', "),
        (["--reservoirs", "crawler, octopus"], "error: --reservoirs must be among ['crawler', "),
        (["--features", "10"], "error: features must be a multiple of 3, got 10"),
        (["--features", "0"], "error: --features must be a whole number >= 3, got 0"),
        (["--seeds", "0"], "error: --seeds must be a whole number >= 1, got 0"),
        (["--length", "0"], "error: --length must be a whole number >= 1, got 0"),
        (["--washout", "-1"], "error: --washout must be a whole number >= 0, got -1"),
        (["--processes", "0"], "error: --processes must be a whole number >= 1, got 0"),
        (["--hold", "nan"], "error: hold must be in "),
        (["--groups", "octopus"], "error: groups must be one of the presets ["),
        (["--scene", '{"wheels": 4}'], "error: scene has no 'wheels'"),
        (["--sweep", "hold=1"], "error: sweep must be a name and two or more distinct values such as 'hold=0.25,0.5'"),
        (["--sweep", "wheels=1,2"], "error: sweep has no 'wheels'; allowed are ['hold', 'amplitude', "),
        (["--sweep", "hold=-1,2"], "error: hold must be in "),
        (["--sweep", "hold=1,2", "--reservoirs", "crawler"], "error: --reservoirs must be left out where --sweep is"),
        (["--sweep", "hold=1,2", "--hold", "1"], "error: hold must be left out where --sweep sets it, got 1.0"),
        (["--sweep", "hold=1,2", "--hold", "0.5"], "error: hold must be left out where --sweep sets it, got 0.5"),
        (
            ["--sweep", "duffing=1,2", "--groups", '{"duffing": 3}'],
            "error: duffing must be left out where --sweep sets it, got 3",
        ),
        (["--scene", '{"slope": 0, "slope": 1}'], "error: --scene must name 'slope' once, got it 2 times"),
        (["--reservoirs", "crawler", "--against", "delay line"], "error: --against has no 'delay line'"),
    ],
)
def test_a_benchmark_is_refused_in_one_line(capsys, tmp_path, arguments, message):
    assert refuse(capsys, "bench", "--output", str(tmp_path / "bench"), *arguments).startswith(message)
    assert not (tmp_path / "bench").exists()


def test_a_benchmark_is_run_and_resumed(capsys, monkeypatch, tmp_path):
    folder = tmp_path / "bench"
    tasks = "memory capacity, NARMA-2 NRMSE,information capacity"
    command = ["bench", "--output", str(folder), "--reservoirs", "crawler,delay line", "--length", "600"]
    command += ["--features", "6", "--tasks", tasks]
    attempted = []

    def fail_at_the_third(self, reservoir, **draw):
        if draw["length"] == 600:  # any other is a probe
            attempted.append(draw["seed"])
            if len(attempted) == 3:
                raise KeyboardInterrupt
        return original(self, reservoir, **draw)

    original = SeriesTask.attempt
    monkeypatch.setattr(SeriesTask, "attempt", fail_at_the_third)
    with pytest.raises((KeyboardInterrupt, SystemExit)):
        sys.exit(run([*command, "--seeds", "1"]))
    assert len(list((folder / "finished").glob("*-0.json"))) == 3  # two of the tasks, and the measure

    assert run([*command, "--seeds", "1"]) == 1
    assert "bench holds a run already: resume it, or choose another folder" in capsys.readouterr().err
    assert run([*command, "--seeds", "2", "--washout", "100", "--resume"]) == 1
    assert "washout must be 200 to go on with the run in " in capsys.readouterr().err
    with monkeypatch.context() as patch:
        patch.setattr("stickslip.tasks.task._HOLDOUT", 0.4)
        assert run([*command, "--seeds", "2", "--resume"]) == 1
        assert "tasks.NARMA-2 NRMSE.probe must be " in capsys.readouterr().err
    assert run([*command, "--seeds", "2", "--resume"]) == 0
    assert len(attempted) == 3 + 2 + 4  # the crawler's with the first seed are not made again

    printed = capsys.readouterr().out
    assert "6 features, mean [95% interval of the mean] over 2 seeds" in printed
    assert "NARMA-2 NRMSE ↓" in printed
    assert "differences from crawler on the same draws, mean [95% interval of the mean] over 2 seeds" in printed
    made = {f"{name}.png" for name in ("scores", "differences", "profiles", "information", "predictions")}
    assert made | {"benchmark.json", "table.md", "finished"} == {path.name for path in folder.iterdir()}
    found = json.loads((folder / "benchmark.json").read_text(encoding="utf-8"))
    assert (found["inputs"]["features"], found["inputs"]["seeds"]) == (6, [0, 1])
    again = run_benchmark(
        tasks=["memory capacity", "NARMA-2 NRMSE"],
        reservoirs={name: known_reservoirs(6)[name] for name in ("crawler", "delay line")},
        seeds=[0, 1],
        length=600,
    )
    scores = {(score["task"], score["reservoir"], score["seed"]): score["score"] for score in found["scores"]}
    [difference] = [each for each in found["differences"] if each["task"] == "memory capacity"]
    line, crawler = (
        np.mean([scores["memory capacity", name, seed] for seed in (0, 1)]) for name in ("delay line", "crawler")
    )
    assert (difference["reservoir"], difference["mean"]) == ("delay line", pytest.approx(line - crawler))
    assert len(scores) == 12
    for score in again:
        assert scores[score[:3]] == score.score
    assert (folder / "table.md").read_text(encoding="utf-8").startswith("| task | crawler | delay line |\n")


def test_a_sweep_is_run_by_two_processes(capsys, tmp_path):
    folder = tmp_path / "sweep"
    command = ["bench", "--output", str(folder), "--length", "400", "--features", "3", "--seeds", "2"]
    assert run([*command, "--sweep", "hold=1,0.5", "--tasks", "NARMA-2 NRMSE", "--processes", "2"]) == 0
    assert "hold = 0.5" in capsys.readouterr().out
    found = json.loads((folder / "benchmark.json").read_text(encoding="utf-8"))
    assert [mean["reservoir"] for mean in found["means"]] == ["hold = 0.5", "hold = 1"]
    assert found["inputs"]["sweep"] == "hold"
    assert (folder / "sweep.png").stat().st_size > 1000
    [score] = run_benchmark(
        tasks=["NARMA-2 NRMSE"], reservoirs={"body": known_reservoirs(3, hold=1)["crawler"]}, seeds=[1], length=400
    )
    assert score.score in [each["score"] for each in found["scores"]]


def test_a_search_finds_tests_and_goes_on(capsys, tmp_path):
    folder = str(tmp_path / "search")
    command = ["search", "--task", "NARMA-2 uniform NRMSE", "--output", folder, "--reservoir", "echo-state"]
    command += ["--features", "6", "--length", "500", "--tests", "2", "--evaluations"]
    assert run([*command, "5"]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert printed.startswith("EchoState(features=6, ")
    assert "over 2 test seeds" in printed
    assert run([*command, "7"]) == 0
    found = json.loads((tmp_path / "search" / "best.json").read_text(encoding="utf-8"))
    assert (found["evaluations"], len(found["test"])) == (7, 2)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--task", "NARMA-3"], "error: --task has no 'NARMA-3'"),
        (["--reservoir", "octopus"], "error: --reservoir has no 'octopus'"),
        (["--features", "2"], "error: features must be a whole number >= 3, got 2"),
        (["--fixed", '{"wheels": 4}'], "error: space has no 'wheels'"),
        (["--fixed", '{"ground": "sea"}'], "error: ground has no 'sea'; allowed are ['anchored', 'ratchet', 'free']"),
        (["--fixed", '{"segments": "x"}'], "error: segments has no 'x'; allowed are [1, 2, "),
        (["--fixed", '{"slope": "x"}'], "error: slope must be a number in (-inf, inf), got 'x'"),
        (["--fixed", '{"slope": 0, "slope": 1}'], "error: --fixed must name 'slope' once, got it 2 times"),
        (["--fixed", "4"], "error: --fixed must be a JSON object, got '4'"),
        (["--tests", "1"], "error: --tests must be a whole number >= 2, got 1"),
        (["--evaluations", "0"], "error: evaluations must be a whole number >= 1, got 0"),
        (["--seconds", "0"], "error: seconds must be in (0, inf), got 0.0"),
        (["--length", "100"], "error: length must be more than the 200 samples"),
    ],
)
def test_a_search_is_refused_in_one_line(capsys, tmp_path, arguments, message):
    command = ["search", "--task", "parity-2 capacity", "--output", str(tmp_path / "search"), *arguments]
    assert refuse(capsys, *command).startswith(message)


def test_the_program_is_installed():
    program = os.path.join(os.path.dirname(sys.executable), "stickslip")
    shown = subprocess.run([program, "--help"], capture_output=True, text=True, check=True, encoding="utf-8")
    assert {"demo", "train", "evaluate", "speed", "bench", "search"} <= set(shown.stdout.split())
