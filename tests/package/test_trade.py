"""``stickslip trade``: what it is asked for, and that a front killed at any moment comes to the same in the end."""

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time

import pytest

from stickslip.commands import run
from stickslip.studies.trade import report, running
from stickslip.studies.trade.plan import FULL, OPEN_LOOP, QUICK, Trade
from stickslip.studies.trade.running import Finished

HYPERPARAMETERS = """
StickSlipCrawler-v0:
  n_envs: 4
  n_timesteps: 1500
  policy: MlpPolicy
  n_steps: 64
  batch_size: 64
  n_epochs: 2
  policy_kwargs: dict(net_arch=[8])
"""
WORDS = {"names": ["1"], "speeds": [[0.1, 0.2]], "memories": [[3.0, 3.1]]}
NUMBERS = {
    "speeds": [0.1, 0.2],
    "memories": [3.0, 3.1],
    "episodes": {"speeds": [0.1, 0.1], "memories": [2.0, 2.0]},
}


@pytest.fixture
def asked(monkeypatch):
    """The trades that are asked for, and how their work is to be shared; none of it is done."""
    found = []

    class Folder:
        def __init__(self, folder, trade):
            self.folder, self.trade = folder, trade

        def run(self, **sharing):
            found.append((self.folder, self.trade, sharing))
            yield Finished(0, 2, None)
            yield Finished(2, 2, None)

        def results(self):
            cells = [cell for stage in self.trade.cells() for cell in stage]
            held = {"names": ["0", "1"], "speeds": [[0.0, 0.0]] * 2, "memories": [[3.0, 3.0]] * 2}
            kinds = {OPEN_LOOP: {"front": WORDS, "held": held}, "speed limit": {"speeds": [0.8, 0.9]}}
            return {cell: kinds.get(cell.kind, NUMBERS) for cell in cells}

    monkeypatch.setattr(running, "TradeFolder", Folder)
    monkeypatch.setattr(report, "write_report", lambda *_, **__: None)
    return found


def test_a_trade_is_asked_for_option_by_option(asked, capsys, tmp_path):
    file = tmp_path / "own.yml"
    file.write_text(HYPERPARAMETERS, encoding="utf-8")
    command = f"trade --output {tmp_path} --weights 0,0.5 --dithers 0.05,0.2 --seeds 2 --hold 0.75 --algorithm a2c"
    command += f" --hyperparameters {file} --steps 90 --longest 5 --resolution 9 --judges 3 --holds 1200 --processes 3"
    options = [
        "--no-conditioned",
        "--floors",
        "0.25,0.3",
        "--groups",
        '{"duffing": 2}',
        "--env-kwargs",
        '{"delays": 3}',
        "--dask",
        "tcp://here",
    ]
    assert run([*command.split(), *options]) == 0
    [(folder, trade, sharing)] = asked
    assert folder == tmp_path
    assert sharing == {"processes": 3, "dask": "tcp://here"}
    assert trade == Trade(
        weights=(0.0, 0.5),
        dithers=(0.05, 0.2),
        seeds=2,
        floors=(0.25, 0.3),
        env_kwargs={"hold": 0.75, "groups": {"duffing": 2}, "delays": 3},
        algorithm="a2c",
        hyperparameters=trade.hyperparameters,
        conditioned=False,
        longest=5,
        resolution=9,
        judges=3,
        holds=1200,
        steps=90,
    )
    assert trade.hyperparameters["n_timesteps"] == 90
    assert trade.hyperparameters["batch_size"] == 64
    printed = " ".join(capsys.readouterr().out.split())
    assert "dither 0.05, mean [95% interval] over 3 seeds" in printed
    assert "dither 0.2, mean [95% interval] over 3 seeds" in printed


@pytest.mark.parametrize(("option", "defaults"), [([], FULL), (["--quick"], QUICK)])
def test_what_is_not_said_of_a_trade_is_a_full_or_a_quick_one(asked, option, defaults):
    assert run(["trade", *option]) == 0
    assert run(["trade", *option, "--judges", "7"]) == 0
    env_kwargs = {"hold": 0.5}
    assert [each[1] for each in asked] == [
        Trade(**defaults, env_kwargs=env_kwargs),
        Trade(**{**defaults, "judges": 7}, env_kwargs=env_kwargs),
    ]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--weights", "0,x"], "error: --weights must be numbers with commas between them, got '0,x'"),
        (["--env-kwargs", '{"hold": 1}'], "error: --env-kwargs must not set hold: it has an option of its own"),
        (["--processes", "0"], "error: --processes must be a whole number >= 1, got 0"),
        (["--dithers", "0.7"], "error: dithers must be in [0, 0.5], got 0.7"),
    ],
)
def test_a_trade_of_what_cannot_be_is_refused(capsys, tmp_path, options, message):
    assert run(["trade", "--output", str(tmp_path / "t"), *options]) == 1
    assert capsys.readouterr().err.strip() == message
    assert not (tmp_path / "t").exists()


def start(folder, file, *options):
    command = f"trade --output {folder} --weights 0,0.5 --seeds 1 --longest 3 --resolution 6 --judges 2 --holds 1500"
    return subprocess.Popen(
        [
            *(sys.executable, "-W", "ignore", "-c", "from stickslip.cli import main; main()", *command.split()),
            *("--hyperparameters", str(file), *options),
        ],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        env=os.environ | {"OMP_NUM_THREADS": "1"},
    )


def finish(folder, file, *options):
    process = start(folder, file, *options)
    _, said = process.communicate(timeout=900)
    assert process.returncode == 0, said
    return contents(folder)


def contents(folder):
    """What a front consists of; what a killed process was writing starts with a dot."""
    found = {path.relative_to(folder): path for path in folder.rglob("*") if path.is_file()}
    return {name: path.read_bytes() for name, path in found.items() if not name.name.startswith(".")}


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory):
    folder = tmp_path_factory.mktemp("uninterrupted")
    file = folder / "own.yml"
    file.write_text(HYPERPARAMETERS, encoding="utf-8")
    finish(folder / "compiled", file, "--processes", "2")
    began = time.monotonic()
    whole = finish(folder / "whole", file, "--processes", "2")
    return file, whole, time.monotonic() - began


@pytest.mark.slow
def test_fronts_killed_forty_times_lose_nothing_and_come_to_the_same(uninterrupted, tmp_path):
    file, whole, lasting = uninterrupted
    chance = random.Random(13)
    folder, fronts = tmp_path / "front", 0
    for kill in range(40):
        finished = contents(folder)
        process = start(folder, file, "--processes", str(1 + kill % 2))
        try:
            process.wait(timeout=chance.uniform(0.3, 1.0) * lasting)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.communicate()
        now = contents(folder)
        # What was finished is as it was, and what is there is whole.
        assert finished == {name: now[name] for name in finished}
        assert now == {name: whole[name] for name in now}
        if now == whole:
            shutil.rmtree(folder)
            fronts += 1
    assert fronts > 0
    assert finish(folder, file, "--processes", "2") == whole


@pytest.mark.slow
def test_a_front_made_by_a_cluster_of_which_a_worker_is_killed_is_the_same(uninterrupted, tmp_path):
    distributed = pytest.importorskip("distributed")
    file, whole, _ = uninterrupted
    with distributed.LocalCluster(n_workers=2, threads_per_worker=2, dashboard_address=None) as cluster:
        process = start(tmp_path / "front", file, "--dask", cluster.scheduler_address)
        until = time.monotonic() + 300
        while not list((tmp_path / "front").glob("cells/[!.]*-*.json")):
            assert time.monotonic() < until
            time.sleep(0.05)
        with distributed.Client(cluster) as client:
            [worker, _] = client.run(os.getpid).values()
        os.kill(worker, signal.SIGKILL)
        _, said = process.communicate(timeout=900)
        assert process.returncode == 0, said
    assert contents(tmp_path / "front") == whole


@pytest.mark.slow
def test_a_folder_of_another_front_is_refused_in_one_sentence(uninterrupted, tmp_path):
    file, whole, _ = uninterrupted
    for name, content in whole.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(content)
    process = start(tmp_path, file, "--hold", "0.7")
    _, said = process.communicate(timeout=300)
    assert process.returncode == 1
    [line] = said.decode().strip().splitlines()
    assert line == f"error: env_kwargs.hold must be 0.5 to go on with the run in {tmp_path}, got 0.7"
    assert contents(tmp_path) == whole
    assert json.loads(whole[next(name for name in whole if name.name == "front.json")])
