"""The command line: what it prints, and that it refuses in one line."""

import json
import os
import subprocess
import sys

import pytest

from stickslip.commands import run


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
        (["--dither", "0"], "error: dither must be in (0, 0.5] where memory_weight = 0.5 > 0, got 0.0"),
        (["--memory-weight", "2"], "error: memory_weight must be in [0, 1], got 2.0"),
        (["--hold", "nan"], "error: hold must be in (0, 10000], got nan"),
        (["--groups", "octopus"], "error: groups must be one of the presets ["),
        (["--groups", '{"duffing": -1}'], "error: duffing must be in [0, inf), got -1"),
        (["--groups", '{"duffing": '], "error: --groups must be a JSON object, got '{\"duffing\": '"),
        (["--env-kwargs", "[1]"], "error: --env-kwargs must be a JSON object, got '[1]'"),
        (["--env-kwargs", '{"wheels": 4}'], "error: "),
        (["--env-kwargs", '{"dither": 0.2}'], "error: --env-kwargs must not set dither"),
        (["--env-kwargs", '{"render_mode": "human"}'], "error: --env-kwargs must not set render_mode"),
        (
            ["--env-kwargs", '{"virtual_nodes": 1000000000000}'],
            "error: virtual_nodes must be a whole number in ",
        ),
        (["--groups", '{"duffing": 1' + "0" * 310 + "}"], "error: duffing must be in [0, inf), got a number of 311"),
        (["--seed", "-1"], "error: seed must be a whole number in [0, 4294967295], got -1"),
        (["--steps", "0"], "error: --steps must be a whole number >= 1, got 0"),
        (["--algorithm", "magic"], "error: algorithm must be one of ['ppo'], got 'magic'"),
        (["--hyperparameters", "/nowhere.yml"], "error: [Errno 2] No such file or directory: '/nowhere.yml'"),
    ],
)
def test_training_is_refused_in_one_line(capsys, tmp_path, arguments, message):
    line = refuse(capsys, "train", "--output", str(tmp_path / "run"), *arguments)
    assert line.startswith(message)
    assert not (tmp_path / "run").exists()


def test_an_output_that_cannot_be_written_is_refused_in_one_line(capsys, tmp_path):
    (tmp_path / "file").write_text("in the way")
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
    shown = subprocess.run([program, "--help"], capture_output=True, text=True, check=True)
    assert {"demo", "train", "evaluate", "speed", "search"} <= set(shown.stdout.split())
