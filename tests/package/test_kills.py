"""Real fronts and trainings killed at random moments, forty times together, and a cluster that loses a worker."""

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from concurrent.futures import ThreadPoolExecutor

import pytest

from stickslip.train.evaluations import read_evaluations
from stickslip.train.policies import read_policy

MAIN = "from stickslip.cli import main; main()"
FRONT = "trade --weights 0 --floors 0.25 --seeds 1 --no-conditioned --longest 3 --resolution 6 --judges 2 --holds 1000"
ENTRY = """
StickSlipCrawler-v0:
  n_envs: 8
  n_timesteps: {steps}
  policy: MlpPolicy
  n_steps: 32
  batch_size: 64
  n_epochs: 2
  policy_kwargs: dict(net_arch=[8])
"""
# Two of each at once, as there are two processors at least.
KILLS_OF_A_FRONT, KILLS_OF_A_TRAINING = 10, 10

pytestmark = pytest.mark.slow


def start(command, folder, *options):
    return subprocess.Popen(
        [sys.executable, "-W", "ignore", "-c", MAIN, *command.split(), "--output", str(folder), *map(str, options)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        env=os.environ | {"OMP_NUM_THREADS": "1"},
    )


def finish(command, folder, *options):
    process = start(command, folder, *options)
    _, said = process.communicate(timeout=3600)
    assert process.returncode == 0, said
    return contents(folder)


def killed(process, after):
    """Whether a process had to be killed after so many seconds; if not, it has ended well."""
    try:
        _, said = process.communicate(timeout=after)
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGKILL)
        process.communicate()
        return True
    assert process.returncode == 0, said
    return False


def contents(folder):
    """What a folder consists of; what a killed process was writing starts with a dot."""
    found = {path.relative_to(folder): path for path in folder.rglob("*") if path.is_file()}
    return {name: path.read_bytes() for name, path in found.items() if not name.name.startswith(".")}


def hyperparameters(folder, steps):
    file = folder / "own.yml"
    file.write_text(ENTRY.format(steps=steps), encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory):
    """Hyperparameters of a front, what it comes to, and the seconds that it lasts once all is compiled."""
    folder = tmp_path_factory.mktemp("uninterrupted")
    file = hyperparameters(folder, steps=256)
    finish(FRONT, folder / "compiled", "--hyperparameters", file, "--processes", 2)
    began = time.monotonic()
    whole = finish(FRONT, folder / "whole", "--hyperparameters", file, "--processes", 2)
    return file, whole, time.monotonic() - began


def test_fronts_killed_at_random_moments_lose_nothing_and_come_to_the_same(uninterrupted, tmp_path):
    file, whole, lasting = uninterrupted

    def front(lane):
        chance, folder = random.Random(lane), tmp_path / f"front {lane}"
        kills, whole_lasts = 0, lasting
        while kills < KILLS_OF_A_FRONT:
            finished, began = contents(folder), time.monotonic()
            process = start(FRONT, folder, "--hyperparameters", file, "--processes", 1 + kills % 2)
            if killed(process, chance.uniform(0.2, 1.0) * whole_lasts):
                kills += 1
            elif not finished:
                whole_lasts = time.monotonic() - began  # the machine is less busy than it was
            now = contents(folder)
            # What was finished is as it was, and what is there is whole.
            assert finished == {name: now[name] for name in finished}
            assert now == {name: whole[name] for name in now}
            if now == whole:
                shutil.rmtree(folder)
        assert finish(FRONT, folder, "--hyperparameters", file, "--processes", 2) == whole

    with ThreadPoolExecutor(2) as lanes:
        list(lanes.map(front, (0, 1)))


def test_trainings_killed_at_random_moments_lose_no_evaluation_and_come_to_their_end(tmp_path):
    file = hyperparameters(tmp_path, steps=2048)
    began = time.monotonic()
    finish("train", tmp_path / "whole", "--hyperparameters", file)
    lasting = time.monotonic() - began

    def go_on(folder):
        """What goes on with a training, or begins it."""
        return ["--resume"] if (folder / "configuration.yml").exists() else ["--hyperparameters", file]

    def done(folder):
        """Rows of the evaluations, and the checkpoints before them."""
        table = folder / "evaluations.csv"
        rows = read_evaluations(table) if table.exists() else []
        zips = {path.name: path.read_bytes() for path in folder.glob("checkpoints/[!.]*.zip")}
        return rows, {f"{row.steps}_steps.zip": zips[f"{row.steps}_steps.zip"] for row in rows}

    def training(lane):
        chance, folder = random.Random(lane), tmp_path / f"training {lane}"
        kills, whole_lasts = 0, lasting
        while kills < KILLS_OF_A_TRAINING:
            rows, checkpoints = done(folder)
            began = time.monotonic()
            if killed(start("train", folder, *go_on(folder)), chance.uniform(0.2, 1.0) * whole_lasts):
                kills += 1
            elif not rows:
                whole_lasts = time.monotonic() - began
            now, kept = done(folder)
            assert now[: len(rows)] == rows
            assert {name: kept[name] for name in checkpoints} == checkpoints
            for path in folder.rglob("[!.]*.zip"):
                assert zipfile.ZipFile(path).testzip() is None
            if (folder / "report.json").exists():
                shutil.rmtree(folder)
        finish("train", folder, *go_on(folder))
        rows, _ = done(folder)
        assert [row.steps for row in rows] == list(range(256, 2049, 256))
        assert json.loads((folder / "report.json").read_text(encoding="utf-8"))
        assert read_policy(folder / "best").scores

    with ThreadPoolExecutor(2) as lanes:
        list(lanes.map(training, (0, 1)))


def test_a_front_made_by_a_cluster_of_which_a_worker_is_killed_is_the_same(uninterrupted, tmp_path):
    distributed = pytest.importorskip("distributed")
    file, whole, _ = uninterrupted
    with distributed.LocalCluster(n_workers=2, threads_per_worker=2, dashboard_address=None) as cluster:
        folder = tmp_path / "front"
        process = start(FRONT, folder, "--hyperparameters", file, "--dask", cluster.scheduler_address)
        until = time.monotonic() + 300
        while not list(folder.glob("cells/[!.]*-*.json")):
            assert time.monotonic() < until
            assert process.poll() is None, process.communicate()
            time.sleep(0.05)
        with distributed.Client(cluster) as client:
            [worker, _] = client.run(os.getpid).values()
        os.kill(worker, signal.SIGKILL)
        _, said = process.communicate(timeout=3600)
        assert process.returncode == 0, said
    assert contents(folder) == whole


def test_a_folder_of_another_front_is_refused_in_one_sentence(uninterrupted, tmp_path):
    file, whole, _ = uninterrupted
    for name, content in whole.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(content)
    process = start(FRONT, tmp_path, "--hyperparameters", file, "--hold", "0.7")
    _, said = process.communicate(timeout=300)
    assert process.returncode == 1
    [line] = said.decode().strip().splitlines()
    assert line == f"error: env_kwargs.hold must be 0.5 to go on with the run in {tmp_path}, got 0.7"
    assert contents(tmp_path) == whole
