"""Pickles are read where one is told to trust them, or wrote them: whoever forges one runs nothing."""

import base64
import json
import pickle
import shutil
import zipfile
from functools import partial
from pathlib import Path

import pytest

from stickslip.commands import run as command
from stickslip.train import report, StickSlipVecEnv
from stickslip.train.evaluations import read_evaluations
from stickslip.train.hyperparameters import read_hyperparameters
from stickslip.train.policies import read_policy
from stickslip.train.report import evaluate_run
from stickslip.train.run import Configuration, Run
from stickslip.train.training import load_policy, train
from stickslip.train.trust import read_pickle, record, write_pickle

QUIET = {"memory_weight": 0.0, "dither": 0.0}
SMALL = {"n_envs": 2, "n_steps": 16, "batch_size": 32}
SHORT = partial(StickSlipVecEnv, max_episode_steps=20)


def configuration(steps=32, algorithm="ppo", **changes):
    entry = read_hyperparameters(algorithm, "StickSlipCrawler-v0") | {"n_timesteps": steps} | changes
    return Configuration(algorithm=algorithm, env_kwargs=QUIET, hyperparameters=entry)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    return train(configuration(**SMALL), tmp_path_factory.mktemp("runs") / "run", vec_env=SHORT)


@pytest.fixture
def run(finished, tmp_path):
    """A copy of a run, whose zips are still those that the user wrote."""
    shutil.copytree(finished.folder, tmp_path / "run")
    return Run.open(tmp_path / "run")


@pytest.fixture(autouse=True)
def _nothing_is_drawn(monkeypatch):
    monkeypatch.setattr(report, "save_figure", lambda *_: None)


class Payload:
    """What writes a file as it is unpickled."""

    def __init__(self, file):
        self.file = file

    def __reduce__(self):
        return Path.write_text, (self.file, "ran")


def forge(zipped, mark):
    """Put a payload into a zip of Stable-Baselines3's, which stays one."""
    with zipfile.ZipFile(zipped) as archive:
        contents = {name: archive.read(name) for name in archive.namelist()}
    data = json.loads(contents["data"])
    data["policy_class"][":serialized:"] = base64.b64encode(pickle.dumps(Payload(mark))).decode()
    contents["data"] = json.dumps(data).encode()
    with zipfile.ZipFile(zipped, "w") as archive:
        for name, content in contents.items():
            archive.writestr(name, content)


def test_a_forged_zip_runs_nothing(run, tmp_path, capsys):
    mark = tmp_path / "ran"
    zips = [run.best, run.final, run.checkpoint(32)]
    for each in zips:
        forge(each, mark)
    further = configuration(64, **SMALL)
    for attempt in (
        partial(load_policy, run),
        partial(load_policy, run, run.final),
        partial(evaluate_run, run.folder, checkpoint=run.best, steps=1000, video=False),
        partial(train, further, run.folder, resume=True, vec_env=SHORT),
    ):
        with pytest.raises(ValueError, match=r"zip must be trusted to be read: it is a pickle.* set trust \(--trust\)"):
            attempt()
    for arguments in (
        ["evaluate", str(run.folder), "--checkpoint", str(run.final), "--no-video"],
        ["train", "--output", str(run.folder), "--resume", "--steps", "64"],
    ):
        assert command(arguments) == 1
        assert "must be trusted to be read" in capsys.readouterr().err
    # The policy is evaluated without one of them.
    assert evaluate_run(run.folder, steps=1000, video=False)["steps"] == 1000
    assert not mark.exists()
    # The forgery is a good one: whoever trusts it runs it.
    with pytest.raises(ValueError, match="is not one of ppo"):
        load_policy(run, trust=True)
    assert mark.read_text(encoding="utf-8") == "ran"


def test_a_forged_replay_buffer_runs_nothing(tmp_path):
    small = {"n_envs": 2, "batch_size": 8, "learning_starts": 8}
    run = train(configuration(16, "dqn", **small), tmp_path / "run", vec_env=SHORT)
    mark = tmp_path / "ran"
    run.replay_buffer.write_bytes(pickle.dumps(Payload(mark)))
    further = configuration(24, "dqn", **small)
    with pytest.raises(ValueError, match=r"replay_buffer\.pkl must be trusted"):
        train(further, run.folder, resume=True, vec_env=SHORT)
    assert not mark.exists()


def test_a_policy_is_evaluated_where_there_is_no_zip(run, tmp_path):
    expected = evaluate_run(run.folder, steps=1000, video=False)
    for zipped in run.folder.rglob("*.zip"):
        zipped.unlink()
    again = evaluate_run(run.folder, steps=1000, output=tmp_path / "out", video=False)
    named = evaluate_run(run.folder, checkpoint=run.folder / "best.json", steps=1000, video=False)
    assert again == named == expected
    run.configure(Configuration(env_kwargs={**QUIET, "hold": 0.25}, hyperparameters={}))
    with pytest.raises(ValueError, match=r"env_kwargs\.hold must be absent as in policy .*best"):
        evaluate_run(run.folder, steps=1000, video=False)
    (run.folder / "best.json").unlink()
    with pytest.raises(ValueError, match=r"best\.json is no file"):
        evaluate_run(run.folder, steps=1000, video=False)


def test_one_s_own_run_goes_on_wherever_it_lies(run):
    done = train(configuration(64, **SMALL), run.folder, resume=True, vec_env=SHORT)
    assert done.latest_checkpoint() == run.checkpoint(64)


def test_another_s_run_goes_on_only_where_it_is_trusted(run, monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "other"))
    further = configuration(64, **SMALL)
    with pytest.raises(ValueError, match=r"32_steps\.zip must be trusted .* was not written by you on this machine"):
        train(further, run.folder, resume=True, vec_env=SHORT)
    done = train(further, run.folder, resume=True, trust=True, vec_env=SHORT)
    assert done.latest_checkpoint() == run.checkpoint(64)
    # What was written since is the user's own, and what was there is still another's.
    read_pickle(run.checkpoint(64), trust=False, own=True)
    with pytest.raises(ValueError, match=r"32_steps\.zip must be trusted"):
        read_pickle(run.checkpoint(32), trust=False, own=True)


def test_what_a_crash_kept_from_being_evaluated_is_evaluated_again(run):
    """It may come between weights and description, so that neither is of the other and no row tells of them."""
    rows, policy = read_evaluations(run.folder / "evaluations.csv"), read_policy(run.best_policy)
    (run.folder / "evaluations.csv").unlink()
    (run.folder / "best.safetensors").write_bytes(b"")
    train(configuration(64, **SMALL), run.folder, resume=True, vec_env=SHORT)
    again = read_evaluations(run.folder / "evaluations.csv")
    assert again[:1] == rows
    mended = read_policy(run.best_policy)
    if mended.description["algorithm"]["steps"] == 32:
        assert mended.scores == policy.scores


def test_what_was_cut_in_the_record_hides_nothing(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    first, second = tmp_path / "first", tmp_path / "second"
    write_pickle(first, lambda path: path.write_bytes(b"one"))
    with record().open("ab") as file:
        file.write(b"\n0123456789abc")
    write_pickle(second, lambda path: path.write_bytes(b"two"))
    assert read_pickle(first, trust=False, own=True).read() == b"one"
    assert read_pickle(second, trust=False, own=True).read() == b"two"
    assert record().stat().st_mode & 0o77 == 0
    with pytest.raises(ValueError, match="must be trusted"):
        read_pickle(first, trust=False)
    second.write_bytes(b"2")
    with pytest.raises(ValueError, match="must be trusted"):
        read_pickle(second, trust=False, own=True)


def test_where_nothing_can_be_noted_a_file_is_written_and_another_s(tmp_path, monkeypatch):
    (tmp_path / "state").touch()
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    write_pickle(tmp_path / "file", lambda path: path.write_bytes(b"one"))
    assert (tmp_path / "file").read_bytes() == b"one"
    with pytest.raises(ValueError, match="must be trusted"):
        read_pickle(tmp_path / "file", trust=False, own=True)


def test_a_relative_state_folder_is_ignored(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_STATE_HOME", "state")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert record() == tmp_path / ".local" / "state" / "stickslip" / "written"
