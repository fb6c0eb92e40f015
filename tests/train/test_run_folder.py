"""A run on disk: what its folder is called, holds, and refuses."""

import json

import numpy as np
import pytest
import yaml

from stickslip.crawler import Groups, Scene
from stickslip.train.algorithms import ALGORITHMS
from stickslip.train.run import Configuration, ENV_ARGUMENTS, Run

ASKED = Configuration(
    algorithm="dqn",
    env_kwargs={"groups": Groups(duffing=2.0), "scene": Scene(slope=0.125), "hold": np.float64(0.25)},
    hyperparameters={"n_envs": 3, "n_timesteps": 9, "policy": "MlpPolicy", "learning_rate": "lin_0.1"},
    seed=7,
)


def test_a_configuration_is_kept_in_plain_words(tmp_path):
    run = Run.create(tmp_path / "deep" / "run", ASKED)
    written = yaml.safe_load((run.folder / "configuration.yml").read_text(encoding="utf-8"))
    assert written == {
        "algorithm": "dqn",
        "environment": "StickSlipCrawler-v0",
        "env_kwargs": {"groups": Groups(duffing=2.0).to_dict(), "scene": Scene(slope=0.125).to_dict(), "hold": 0.25},
        "hyperparameters": {"n_envs": 3, "n_timesteps": 9, "policy": "MlpPolicy", "learning_rate": "lin_0.1"},
        "seed": 7,
        "start": "even",
        "floor": None,
    }
    assert json.loads(json.dumps(written)) == written
    assert Run.open(run.folder).configuration == ASKED
    assert {path.name for path in run.folder.iterdir()} == {"configuration.yml", "checkpoints"}


def test_what_is_not_said_is_as_documented():
    usual = Configuration()
    assert (usual.algorithm, usual.environment, usual.seed) == ("ppo", "StickSlipCrawler-v0", 0)
    assert usual.env_kwargs == usual.hyperparameters == {}
    assert usual.env_kwargs is not Configuration().env_kwargs
    assert ENV_ARGUMENTS == (
        "groups",
        "scene",
        "hold",
        "tolerance",
        "dither",
        "memory_weight",
        "delays",
        "target",
        "target_order",
        "virtual_nodes",
        "valve_history",
        "randomize",
    )
    assert next(iter(ALGORITHMS)) == "ppo"


def test_a_configuration_keeps_arguments_of_its_own():
    arguments = {"randomize": {"duffing": [0.0, 1.0]}}
    kept = Configuration(env_kwargs=arguments)
    arguments["randomize"]["duffing"][1] = 9.0
    arguments["hold"] = 3.0
    assert kept.env_kwargs == {"randomize": {"duffing": [0.0, 1.0]}}


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"start": "ajar"}, ValueError, r"start must be one of \['even', 'open', 'shut', 'policy'\], got 'ajar'"),
        ({"floor": -0.1}, ValueError, r"floor must be in \[0, inf\), got -0.1"),
        ({"seed": -1}, ValueError, r"seed must be a whole number in \[0, 4294967295\], got -1"),
        ({"seed": 2**32}, ValueError, r"seed must be a whole number in \[0, 4294967295\], got 4294967296"),
        ({"seed": 1.0}, TypeError, r"seed must be a whole number"),
        ({"env_kwargs": {"wheels": 4}}, ValueError, "env_kwargs has no 'wheels'; allowed are"),
        ({"env_kwargs": [1]}, TypeError, r"env_kwargs must be a mapping, got \[1\]"),
        ({"hyperparameters": None}, TypeError, "hyperparameters must be a mapping, got None"),
    ],
)
def test_what_configures_nothing_is_refused(arguments, error, message):
    with pytest.raises(error, match=message):
        Configuration(**arguments)
    assert Configuration(seed=2**32 - 1).seed == 2**32 - 1


def test_the_files_of_a_run_have_the_names_that_its_page_tells(tmp_path):
    run = Run.create(tmp_path, ASKED)
    names = (run.best, run.final, run.replay_buffer, run.checkpoint(12))
    assert [str(path.relative_to(tmp_path)) for path in names] == [
        "best.zip",
        "final.zip",
        "replay_buffer.pkl",
        "checkpoints/12_steps.zip",
    ]


def test_the_latest_checkpoint_has_most_steps(tmp_path):
    run = Run.create(tmp_path, ASKED)
    assert run.latest_checkpoint() is None
    # Neither the order of letters nor a file that was never finished decides.
    for name in ("900_steps.zip", "1000_steps.zip", ".2000_steps-17.zip", "3000_steps.zip.part", "4000.zip", "old.zip"):
        (run.folder / "checkpoints" / name).touch()
    assert run.latest_checkpoint() == run.checkpoint(1000)


@pytest.mark.parametrize(
    "name",
    [
        "configuration.yml",
        "checkpoints",
        "best.zip",
        "best.safetensors",
        "best.json",
        "final.zip",
        "evaluations.csv",
        "replay_buffer.pkl",
    ],
)
def test_what_is_left_of_another_run_is_in_the_way(tmp_path, name):
    (tmp_path / name).touch()
    with pytest.raises(ValueError, match="holds a run already; resume it or name another folder"):
        Run.create(tmp_path, ASKED)
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_what_is_no_run_s_may_be_there(tmp_path):
    (tmp_path / "notes.txt").touch()
    Run.create(tmp_path, ASKED)


def test_a_configuration_that_was_changed_is_written_at_once(tmp_path):
    run = Run.create(tmp_path, ASKED)
    other = Configuration(seed=9)
    run.configure(other)
    assert run.configuration == Run.open(tmp_path).configuration == other
    assert {path.name for path in tmp_path.iterdir()} == {"configuration.yml", "checkpoints"}


@pytest.mark.parametrize("change", [{"seed": None}, {"wheels": 4}])
def test_a_configuration_with_more_or_less_than_it_needs_is_refused(tmp_path, change):
    run = Run.create(tmp_path, ASKED)
    file = run.folder / "configuration.yml"
    written = yaml.safe_load(file.read_text(encoding="utf-8")) | change
    file.write_text(yaml.safe_dump({k: v for k, v in written.items() if v is not None}), encoding="utf-8")
    with pytest.raises(ValueError, match=r"configuration\.yml must set \['algorithm', 'env_kwargs', .*\], got"):
        Run.open(tmp_path)
