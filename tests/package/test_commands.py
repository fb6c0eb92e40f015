"""Every option of every command changes what it says, and what is printed is what was found."""

import json
import os
import re
import signal
from dataclasses import replace

import numpy as np
import pytest
import typer
import yaml

from stickslip import ahead, cli, demo
from stickslip.commands import app, run
from stickslip.common.extras import MissingExtra
from stickslip.crawler import Groups, Scene
from stickslip.crawler.solvers import choose, SOLVERS
from stickslip.studies import search, work_precision
from stickslip.studies.benchmark import bench
from stickslip.tasks import BodyReservoir, known_reservoirs, TASKS
from stickslip.train import report
from stickslip.train.evaluations import best_of, Evaluation, read_evaluations, write_evaluations
from stickslip.train.run import Run
from stickslip.train.verdict import read_report

DEFAULTS = {
    "list": {},
    "compile": {},
    "demo": {"output": "runs/demo", "seed": 0, "steps": None},
    "train": {
        "memory_weight": 0.2,
        "dither": 0.1,
        "hold": "0.5",
        "groups": None,
        "env_kwargs": "{}",
        "floor": None,
        "start": "even",
        "steps": None,
        "seed": 0,
        "algorithm": "ppo",
        "hyperparameters": None,
        "resume": False,
        "trust": False,
    },
    "evaluate": {
        "checkpoint": None,
        "output": None,
        "steps": 6000,
        "seeds": 10,
        "seed": 2_000_000,
        "dither": None,
        "weight": None,
        "video": True,
        "trust": False,
    },
    "export": {
        "output": None,
        "weight": None,
        "holds": 200,
        "hold": None,
        "dither": None,
        "seed": 0,
        "actuator": None,
        "open_volts": 24.0,
        "shut_volts": 0.0,
    },
    "run": {
        "plant": None,
        "dry_run": False,
        "actuator": "ecoflex",
        "hold": None,
        "holds": 200,
        "readings": 8,
        "weight": None,
        "dither": None,
        "seed": 0,
        "volts": None,
        "pace": 1.0,
        "log": None,
        "report": None,
    },
    "speed": {
        "output": "runs/speed",
        "groups": None,
        "scene": "{}",
        "hold": "0.5",
        "holds": 400,
        "error": 1e-6,
        "rounds": 31,
        "seed": 0,
    },
    "bench": {
        "output": "runs/bench",
        "tasks": None,
        "reservoirs": None,
        "sweep": None,
        "seeds": 15,
        "features": 12,
        "length": 4000,
        "washout": 200,
        "hold": None,
        "groups": None,
        "scene": "{}",
        "against": None,
        "processes": 1,
        "resume": False,
    },
    "map": {
        "y": None,
        "output": "runs/map",
        "measure": "memory",
        "groups": None,
        "scene": "{}",
        "hold": "0.5",
        "inputs": "bits",
        "nodes": 4,
        "holds": 4000,
        "washout": 200,
        "delays": 20,
        "seeds": 1,
        "tolerance": 1e-6,
        "processes": None,
        "dask": None,
    },
    "lyapunov": {
        "groups": None,
        "scene": "{}",
        "hold": "0.5",
        "inputs": "bits",
        "holds": 4200,
        "washout": 200,
        "seeds": 1,
        "tolerance": 1e-9,
        "over": None,
        "output": "runs/lyapunov",
    },
    "identify": {
        "free": None,
        "guess": None,
        "actuator": None,
        "scene": "{}",
        "hold": None,
        "level": 0.95,
        "design": None,
        "output": "runs/identification",
    },
    "reproduce": {"figures": None, "output": "runs/claims", "quick": False, "processes": None},
    "explore": {"port": 5080, "open_browser": True, "preset": "fastest-word", "groups": None},
    "trade": {
        "output": "runs/trade",
        "quick": False,
        "weights": None,
        "floors": None,
        "dithers": None,
        "seeds": None,
        "hold": "0.5",
        "groups": None,
        "env_kwargs": "{}",
        "algorithm": "ppo",
        "hyperparameters": None,
        "steps": None,
        "conditioned": True,
        "longest": None,
        "resolution": None,
        "judges": None,
        "holds": None,
        "processes": None,
        "dask": None,
    },
    "search": {
        "output": "runs/search",
        "reservoir": "body",
        "features": 60,
        "fixed": "{}",
        "evaluations": 300,
        "seconds": float("inf"),
        "length": 3000,
        "tests": 10,
        "seed": 0,
    },
}


def test_what_is_not_said_is_as_the_pages_say():
    commands = typer.main.get_command(app).commands
    found = {
        name: {
            option.name: str(option.default) if option.name == "output" and option.default else option.default
            for option in command.params
            if not option.required and option.name != "help"
        }
        for name, command in commands.items()
    }
    assert found == DEFAULTS
    assert all(each.help for command in commands.values() for each in command.params)


def told(capsys, *arguments, bar=None):
    """Run a command that must succeed; the words it printed, whatever the width of the terminal.

    `bar` is the one on standard error that it leaves: what is done, and how much of how much.
    """
    status, printed = run(list(map(str, arguments))), capsys.readouterr()
    assert status == 0, printed.err
    if bar is not None:
        time = r"\d:\d\d:\d\d"
        assert re.search(rf"^{bar[0]} \S+ {bar[1]} {time} ({time}|-:--:--)\s*$", printed.err, re.MULTILINE), printed.err
    return " ".join(printed.out.split())


@pytest.fixture
def calls(monkeypatch):
    """Have a function's calls noted, and made."""

    def note(module, name, result=None):
        noted, function = [], getattr(module, name)

        def instead(*arguments, **named):
            noted.append((arguments, {k: v for k, v in named.items() if k != "on_progress"}))
            return function(*arguments, **named) if result is None else result

        monkeypatch.setattr(module, name, instead)
        return noted

    return note


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    """A training with all options but the defaults."""
    folder = tmp_path_factory.mktemp("train")
    file = folder / "mine.yml"
    file.write_text("StickSlipCrawler-v0: {n_envs: 2, n_timesteps: 99, policy: MlpPolicy, n_steps: 4}", "utf-8")
    command = ["train", "--output", folder / "run", "--memory-weight", 0.25, "--dither", 0.2, "--hold", 0.75]
    command += ["--groups", '{"duffing": 2}', "--env-kwargs", '{"delays": 3, "scene": {"slope": 0.125}}']
    command += ["--steps", 16, "--seed", 5, "--algorithm", "a2c", "--hyperparameters", file]
    command += ["--start", "open"]
    assert run(list(map(str, command))) == 0
    return folder / "run"


def test_a_training_is_of_all_that_was_asked_for(trained):
    assert yaml.safe_load((trained / "configuration.yml").read_text(encoding="utf-8")) == {
        "algorithm": "a2c",
        "environment": "StickSlipCrawler-v0",
        "env_kwargs": {
            "memory_weight": 0.25,
            "dither": 0.2,
            "hold": 0.75,
            "groups": {"duffing": 2},
            "delays": 3,
            "scene": {"slope": 0.125},
        },
        "hyperparameters": {"n_envs": 2, "n_timesteps": 16, "policy": "MlpPolicy", "n_steps": 4},
        "seed": 5,
        "floor": None,
        "start": "open",
    }
    assert Run.open(trained).latest_checkpoint().name == "16_steps.zip"


def test_the_best_evaluation_is_told_and_not_another(trained, capsys):
    # The best is neither the first, the last, the worst, nor that of most speed or memory.
    rows = [Evaluation(8, 0.5, 9.0, 9.0), Evaluation(16, 0.75, 0.123449, 1.5), Evaluation(16, 0.25, 0.0, 0.0)]
    write_evaluations(trained / "evaluations.csv", rows)
    said = told(capsys, "train", "--output", trained, "--resume")
    where = " ".join(str(trained / "best.zip").split())
    verdict = read_report(trained)["verdict"]
    assert said == (
        f"best policy: 0.7500 reward per step (speed 0.1234, memory 1.5000) after 16 steps, kept in {where} {verdict}"
    )
    write_evaluations(trained / "evaluations.csv", [rows[1]._replace(speed=float("nan"))])
    assert told(capsys, "train", "--output", trained, "--resume") == (
        f"best policy: 0.7500 reward per step after 16 steps, kept in {where} {verdict}"
    )


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--memory-weight", "0.5"], "env_kwargs.memory_weight must be 0.25 to go on with run"),
        (["--dither", "0.1"], "env_kwargs.dither must be 0.2"),
        (["--hold", "0.5"], "env_kwargs.hold must be 0.75"),
        (["--groups", "linear"], "env_kwargs.groups must be {'duffing': 2}"),
        (["--env-kwargs", '{"delays": 20}'], "env_kwargs.delays must be 3"),
        (["--env-kwargs", '{"virtual_nodes": 4}'], "env_kwargs.virtual_nodes must be absent"),
        (["--seed", "0"], "seed must be 5"),
        (["--algorithm", "ppo"], "algorithm must be 'a2c'"),
    ],
)
def test_what_is_said_of_a_run_that_goes_on_is_compared_even_where_it_is_the_default(trained, capsys, options, message):
    assert run(["train", "--output", str(trained), "--resume", *options]) == 1
    assert message in capsys.readouterr().err


def test_a_run_that_goes_on_may_be_told_what_it_knows_and_further_steps(trained, capsys):
    command = ["train", "--output", trained, "--resume", "--hold", 0.75, "--seed", 5]
    best = best_of(read_evaluations(trained / "evaluations.csv"))
    assert f"after {best.steps} steps" in told(capsys, *command, "--env-kwargs", '{"delays": 3}')
    told(capsys, *command, "--steps", 24, bar=("training", "24/24"))
    assert Run.open(trained).configuration.hyperparameters["n_timesteps"] == 24
    assert Run.open(trained).latest_checkpoint().name == "24_steps.zip"


def test_an_evaluation_is_asked_for_option_by_option(capsys, calls, tmp_path):
    estimates = {"speed": {"mean": 0.5, "low": 0.25, "high": 0.75}, "memory": {"mean": 1.25, "low": None, "high": None}}
    noted = calls(report, "evaluate_run", {"steps": 1200, "seeds": [7, 8, 9], **estimates})
    options = (
        "--checkpoint c.zip --output o --steps 1200 --seed 7 --seeds 3 --dither 0.2 --weight 0.5 --trust --no-video"
    )
    assert run(["evaluate", "a run", *options.split()]) == 0
    ((folder,), named) = noted[0]
    assert str(folder) == "a run"
    assert {name: str(value) for name, value in named.items()} == {
        "checkpoint": "c.zip",
        "output": "o",
        "steps": "1200",
        "seeds": "range(7, 10)",
        "dither": "0.2",
        "weight": "0.5",
        "video": "False",
        "trust": "True",
    }
    assert capsys.readouterr().out.splitlines() == [
        "steps                    1200",
        "seeds                    7 to 9",
        "speed                    0.5000 [0.2500, 0.7500]",
        "memory                   1.2500",
    ]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--steps", "999"], "error: --steps must be a whole number >= 1000, got 999"),
        (["--seed", "-1"], "error: --seed must be a whole number in [0, 4294967285], got -1"),
        (["--seed", "4294967286"], "error: --seed must be a whole number in [0, 4294967285], got 4294967286"),
        (["--seeds", "0"], "error: --seeds must be a whole number >= 1, got 0"),
    ],
)
def test_an_evaluation_of_wrong_numbers_is_refused(capsys, options, message):
    assert run(["evaluate", "run", *options]) == 1
    assert capsys.readouterr().err.strip() == message


def test_a_measurement_of_speed_is_of_all_that_was_asked_for(capsys, monkeypatch, tmp_path):
    noted, studies, original = [], [], work_precision.measure

    def one_miscounts(case, **named):
        noted.append(named["rounds"])
        study = original(case, **named)
        first, *others = study.rows
        studies.append(replace(study, rows=(replace(first, slips=77, slips_agree=False), *others)))
        return studies[-1]

    monkeypatch.setattr(work_precision, "measure", one_miscounts)
    monkeypatch.setenv("COLUMNS", "60")  # the table is wider, and none of it is cut
    command = ["speed", "--output", tmp_path / "speed", "--groups", "linear", "--scene", '{"slope": 0.125}']
    command += ["--hold", 0.75, "--holds", 12, "--error", 1e-4, "--rounds", 3, "--seed", 5]
    said = told(capsys, *command, bar=("measuring", r"(?P<n>\d+)/(?P=n)"))
    found = json.loads((tmp_path / "speed" / "work_precision.json").read_text(encoding="utf-8"))
    assert noted == [3]
    assert found["groups"] == Groups.of("linear").to_dict()
    assert found["scene"] == Scene(slope=0.125).to_dict()
    assert [found[name] for name in ("hold", "holds", "wanted", "seed")] == [0.75, 12, 1e-4, 5]
    assert found["recommendation"] == work_precision.recommend(studies[0], 1e-4).sentence
    assert " ".join(found["recommendation"].split()) in said
    assert f"Figureandtable:{tmp_path / 'speed'}" in said.replace(" ", "")  # folded within the path

    # Each row as it is printed, from the numbers that are kept.
    floors = found["reference"]["floors"]
    cheapest = min(row["timing"]["median"] for row in found["rows"])
    assert f"solver tolerance {' '.join(floors)} slips µs per unit quartiles ratio" in said
    assert "≤: at the floor of what can be told; ✗: not the reference's slip count" in said
    for row in found["rows"]:
        time = row["timing"]
        cells = [row["solver"], "any" if row["tolerance"] is None else f"{row['tolerance']:.0e}"]
        cells += [
            f"≤{floor:.1e}" if row["errors"][name] <= floor else f"{row['errors'][name]:.1e}"
            for name, floor in floors.items()
        ]
        cells += ["77 ✗" if row is found["rows"][0] else str(row["slips"])]
        cells += [f"{time['median']:.2f}", f"{time['low']:.2f}–{time['high']:.2f}"]
        assert f"{' '.join(cells)} {time['median'] / cheapest:.2f}" in said
    assert "…" not in said
    assert said.count("✗") == 2
    assert said.count("≤") > 1


def test_a_benchmark_is_of_all_that_was_asked_for(capsys, calls, tmp_path):
    noted = calls(bench, "Bench")
    folder = tmp_path / "bench"
    command = ["bench", "--output", folder, "--tasks", "NARMA-2 NRMSE", "--reservoirs", "crawler,delay line"]
    command += ["--seeds", 2, "--features", 6, "--length", 500, "--washout", 150, "--hold", 0.75]
    command += ["--groups", '{"duffing": 2}', "--scene", '{"slope": 0.125}', "--against", "delay line"]
    said = told(capsys, *command, bar=("scoring", "4/4"))
    body = {"hold": 0.75, "groups": {"duffing": 2}, "scene": {"slope": 0.125}}
    assert noted[0][1]["body"] == body
    inputs = json.loads((folder / "benchmark.json").read_text(encoding="utf-8"))["inputs"]
    expected = known_reservoirs(6, **body)
    assert inputs == {
        **body,
        "features": 6,
        "length": 500,
        "washout": 150,
        "sweep": None,
        "tasks": ["NARMA-2 NRMSE"],
        "reservoirs": {name: repr(expected[name]) for name in ("crawler", "delay line")},
        "seeds": [0, 1],
        "against": "delay line",
    }
    assert isinstance(expected["crawler"], BodyReservoir)
    assert "6 features, mean [95% interval of the mean] over 2 seeds" in said
    assert "differences from delay line on the same draws, mean [95% interval of the mean] over 2 seeds" in said
    assert f"Tables,figuresandscores:{folder}" in said.replace(" ", "")  # folded within the path
    # What is printed is what is written, cell by cell.
    for line in (folder / "table.md").read_text(encoding="utf-8").splitlines():
        if line.startswith("|") and "---" not in line:
            assert " ".join(cell.strip() for cell in line.strip("|").split("|")) in said


def test_one_draw_has_no_interval_and_one_reservoir_no_differences(capsys, tmp_path):
    command = ["bench", "--output", tmp_path / "b", "--tasks", "NARMA-2 NRMSE", "--reservoirs", "delay line"]
    said = told(capsys, *command, "--seeds", 1, "--features", 3, "--length", 400)
    assert said.startswith("3 features task delay line")
    assert "interval of" not in said
    assert "differences from" not in said


def test_a_wide_table_is_not_cut(capsys, monkeypatch, tmp_path):
    monkeypatch.setenv("COLUMNS", "40")
    command = ["bench", "--output", tmp_path / "b", "--tasks", "NARMA-2 NRMSE", "--reservoirs", "crawler,delay line"]
    said = told(capsys, *command, "--seeds", 2, "--features", 3, "--length", 400)
    assert "…" not in said
    for line in (tmp_path / "b" / "table.md").read_text(encoding="utf-8").splitlines()[2:3]:
        assert " ".join(cell.strip() for cell in line.strip("|").split("|")) in said


def test_a_search_is_of_all_that_was_asked_for(capsys, calls, tmp_path):
    searched, tested = calls(search, "search"), calls(search, "held_out_scores")
    task = "NARMA-2 uniform NRMSE"
    command = ["search", "--task", task, "--output", tmp_path / "search", "--reservoir", "echo-state"]
    command += ["--features", 6, "--fixed", '{"leak": 0.5}', "--evaluations", 4, "--seconds", 1e6]
    command += ["--length", 500, "--tests", 3, "--seed", 5]
    said = told(capsys, *command, bar=(task, "4/4"))
    ((asked, space), named) = searched[0]
    assert asked is TASKS[task]
    assert repr(space) == repr(search.echo_state_space(6).where(leak=0.5))
    assert named == {
        "evaluations": 4,
        "seconds": 1e6,
        "seed": 5,
        "length": 500,
        "validation_seeds": range(3, 7),
        "file": tmp_path / "search" / "evaluations.json",
    }
    ((asked, reservoir, seeds), named) = tested[0]
    assert asked is TASKS[task]
    assert (seeds, named) == (range(3), {"validation_seeds": range(3, 7), "length": 500})
    best = json.loads((tmp_path / "search" / "best.json").read_text(encoding="utf-8"))
    scores, estimate = search.held_out_scores(TASKS[task], reservoir, range(3), length=500)
    assert best["test"] == scores
    assert (best["task"], best["reservoir"], best["evaluations"]) == (task, repr(reservoir), 4)
    assert best["values"]["leak"] == 0.5
    kept = json.loads((tmp_path / "search" / "evaluations.json").read_text(encoding="utf-8"))["evaluations"]
    assert len(kept) == 4
    assert said == " ".join(
        f"{reservoir!r} {task}: {estimate.mean:.4f}, 95% interval {estimate.low:.4f} to {estimate.high:.4f} over 3 "
        "test seeds".split()
    )


def test_a_search_may_be_told_when_to_stop(capsys, tmp_path):
    # Too little time for any but the first.
    command = ["search", "--task", "NARMA-2 uniform NRMSE", "--output", tmp_path / "search"]
    command += ["--reservoir", "echo-state", "--features", 6, "--length", 400, "--tests", 2]
    told(capsys, *command, "--seconds", 1e-9)
    best = json.loads((tmp_path / "search" / "best.json").read_text(encoding="utf-8"))
    assert best["evaluations"] < 300


def test_a_search_for_a_body_searches_bodies(capsys, calls, tmp_path):
    searched = calls(search, "body_space", search.echo_state_space(6))
    command = ["search", "--task", "NARMA-2 uniform NRMSE", "--output", tmp_path / "search", "--reservoir", "body"]
    told(capsys, *command, "--features", 9, "--evaluations", 2, "--length", 400, "--tests", 2)
    assert searched == [((9,), {})]


def test_a_demo_is_asked_for_option_by_option(calls, capsys, tmp_path):
    noted = calls(demo, "run_demo", "done")
    told(capsys, "demo", "--output", tmp_path / "d", "--seed", 7, "--steps", 300)
    told(capsys, "demo")
    assert [tuple(map(str, arguments)) for arguments, _ in noted] == [
        (str(tmp_path / "d"), "7", "300"),
        (os.path.join("runs", "demo"), "0", "None"),
    ]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--steps", "0"], "error: --steps must be a whole number >= 1, got 0"),
        (["--seed", "-1"], "error: --seed must be a whole number in [0, 4294967291], got -1"),
        (["--seed", "4294967292"], "error: --seed must be a whole number in [0, 4294967291], got 4294967292"),
    ],
)
def test_a_demo_of_wrong_numbers_is_refused(capsys, calls, options, message):
    noted = calls(demo, "run_demo", "done")
    assert run(["demo", *options]) == 1
    assert capsys.readouterr().err.strip() == message
    assert noted == []


def test_every_use_is_compiled_and_where_is_told(capsys, monkeypatch):
    made = []
    monkeypatch.setattr(ahead, "where_kept", lambda: "some/folder")
    monkeypatch.setattr(ahead, "uses", lambda: ((name, lambda name=name: made.append(name)) for name in "abc"))
    said = told(capsys, "compile", bar=("compiling", "3/3"))
    assert said == "every kernel is compiled; the solver's are kept in some/folder"
    assert made == ["a", "b", "c"]


KINDS = ("simulate", "environment", "batch", "batch without memory")


def test_what_is_compiled_ahead_is_every_order_of_every_kind():
    orders = {SOLVERS["taylor"].order_for(10.0**-digits) for digits in range(2, 16)}
    bodies = [*(f"Taylor series of order {order}" for order in sorted(orders)), "closed form", "Radau collocation"]
    names = [name for name, _ in ahead.uses()]
    assert len(set(names)) == len(names)
    assert set(names) == {
        *(
            f"{kind}, {body}"
            for kind in ("simulate", "environment", "batch", "batch without memory")
            for body in bodies
        ),
        *(f"simulate, a batch by Taylor series of order {order}" for order in orders),
        "episodes drawn",
        "simulate, chain of segments",
        "exponents, chain of segments",
        "sensitivities",
        "recursive least squares",
        "memory reward",
        "reward's target",
        "echo-state network",
        "Lorenz's flow",
    }


def test_what_is_compiled_ahead_is_used_as_its_name_says(monkeypatch):
    """Each use simulates, or makes environments, resets and steps them, with the solver and order of its name."""
    made = []

    class Environment:
        def __init__(self, **settings):
            made.append(("made", settings))

        def reset(self, seed):
            made.append("reset")

        def step(self, action):
            made.append(("step", np.shape(action)))

        def close(self):
            made.append("closed")

    monkeypatch.setattr(ahead, "simulate", lambda groups, valve, _, **named: made.append((groups, valve, named)))
    monkeypatch.setattr(ahead, "StickSlipCrawlerEnv", Environment)
    monkeypatch.setattr(ahead.gym, "make_vec", lambda name, count, **settings: Environment(name=name, **settings))
    for name, use in ahead.uses():
        made.clear()
        kind, _, body = name.partition(", ")
        if kind not in KINDS:
            continue
        use()
        rows, body = (2 if body.startswith("a batch by ") else 1), body.removeprefix("a batch by ")
        order = int(body.rpartition(" ")[2]) if body.startswith("Taylor") else None
        if body == "chain of segments":
            ((groups, _, named),) = made
            assert (groups, named["scene"].segments > 1, named["scene"].tube_mass > 0) == (Groups(), True, True)
            continue
        if kind == "simulate":
            ((groups, valve, named),) = made
            assert len(np.atleast_2d(valve)) == rows
            solver, tolerance = named["solver"], named["tolerance"]
            assert solver == {"T": "taylor", "c": "closed_form", "R": "radau"}[body[0]]
        else:
            (_, settings), *lived = made
            shape = () if kind == "environment" else (2,)
            assert lived == ["reset", ("step", shape), *(["closed"] if shape else [])]
            groups, tolerance = Groups.of(settings["groups"]), settings["tolerance"]
            solver = {"T": "taylor", "c": "closed_form", "R": "radau"}[body[0]]
            assert choose("auto", groups, Scene(), 0.5, tolerance) is SOLVERS[solver]
            assert (settings.get("dither") == 0.0) == (kind == "batch without memory")
            assert (settings.get("memory_weight") == 0.0) == (kind == "batch without memory")
            assert settings.get("name", "StickSlipCrawler-v0") == "StickSlipCrawler-v0"
        if order is not None:
            assert SOLVERS["taylor"].order_for(tolerance) == order
        if solver == "closed_form":
            assert groups.duffing == groups.radial_coupling == 0.0


@pytest.mark.parametrize("status", [0, 1, 2])
def test_the_program_ends_with_its_command_s_status(monkeypatch, status):
    monkeypatch.setattr("stickslip.commands.run", lambda: status)
    with pytest.raises(SystemExit) as end:
        cli.main()
    assert end.value.code == status


@pytest.mark.parametrize("how", ["by status", "by exception"])
def test_an_interrupted_program_ends_at_once_once_it_has_tidied_up(monkeypatch, how):
    class Ended(Exception):
        pass

    did = []

    def end(status):
        did.append(status)
        raise Ended

    def interrupted():
        if how == "by exception":
            raise KeyboardInterrupt
        return 130

    monkeypatch.setattr("stickslip.commands.run", interrupted)
    monkeypatch.setattr("os._exit", end)
    monkeypatch.setattr("atexit._run_exitfuncs", lambda: did.append("tidied"))
    with pytest.raises(Ended):
        cli.main()
    assert did == ["tidied", 128 + signal.SIGINT]


def test_a_missing_extra_is_one_line(monkeypatch):
    def missing():
        raise MissingExtra("typer is not installed: run this")

    monkeypatch.setattr("stickslip.commands.run", missing)
    with pytest.raises(SystemExit) as end:
        cli.main()
    assert end.value.code == "error: typer is not installed: run this"
