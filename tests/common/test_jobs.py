"""Jobs done by processes of this computer and on a real Dask cluster: every result is given, and given once."""

import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import joblib
import pytest

from stickslip.common.jobs import as_done


def square(job):
    return job * job, os.getpid()


def deaf(_):
    return signal.getsignal(signal.SIGINT) is signal.SIG_IGN


def refuse_two(job):
    if job == 2:
        raise ValueError("not two")
    return job


def sleepy(job):
    time.sleep(0.3)
    return job, os.getpid()


def fatal(job):
    os.kill(os.getpid(), signal.SIGKILL)


def leave_a_note(folder):
    (Path(folder) / str(os.getpid())).touch()
    time.sleep(600)


def squares(done):
    return sorted((index, square) for index, (square, _) in done)


SQUARES = [(0, 9), (1, 16), (2, 25), (3, 36)]


def test_one_process_is_this_one_and_does_no_more_than_is_asked_for():
    begun = []
    results = as_done(begun.append, [3, 4])
    assert next(results) == (0, None)
    assert begun == [3]
    assert list(as_done(square, [3, 4])) == [(0, (9, os.getpid())), (1, (16, os.getpid()))]
    assert list(as_done(square, [], processes=2)) == []
    assert list(as_done(square, [], dask="tcp://127.0.0.1:1")) == []  # nobody is asked to do nothing


def test_several_processes_do_each_job_once_and_leave_interrupts_to_this_one():
    done = list(as_done(square, [3, 4, 5, 6], processes=2))
    assert squares(done) == SQUARES
    assert os.getpid() not in {pid for _, (_, pid) in done}
    assert list(as_done(deaf, [0], processes=2)) == [(0, True)]
    with pytest.raises(ValueError, match="not two"):
        list(as_done(refuse_two, range(4), processes=2))


PARENT = """
import sys
sys.path.insert(0, {folder!r})
from test_jobs import as_done, leave_a_note
list(as_done(leave_a_note, [sys.argv[1]] * 2, processes=2))
"""


def test_processes_end_with_the_one_that_was_killed(tmp_path):
    program = PARENT.format(folder=str(Path(__file__).parent))
    parent = subprocess.Popen([sys.executable, "-c", program, str(tmp_path)])
    try:
        until = time.monotonic() + 60
        while len(workers := [int(file.name) for file in tmp_path.iterdir()]) < 2:
            assert time.monotonic() < until
            time.sleep(0.02)
    finally:
        parent.kill()
        parent.wait()
    until = time.monotonic() + 20
    while any(alive(worker) for worker in workers):
        assert time.monotonic() < until
        time.sleep(0.02)


def alive(process):
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


class Future:
    def __init__(self, run):
        self.run, self.released, self.lost = run, False, False

    def release(self):
        self.released = True

    def cancelled(self):
        return self.lost


class Client:
    """What Dask's client does for `as_done`, at once and in this process, the job of most priority first."""

    def __init__(self, address="", set_as_default=True):
        self.address, self.is_default, self.loop = address, set_as_default, object()
        self.waiting, self.cancelled, self.closed = {}, [], False
        CLIENTS.append(self)

    def submit(self, work, job, *, key, priority):
        future = Future(partial(work, job))
        assert key not in self.waiting
        self.waiting[key] = priority, future
        return future

    def cancel(self, futures):
        self.cancelled += futures

    def close(self):
        self.closed = True


def as_completed(futures, *, loop, with_results):
    [client] = [each for each in CLIENTS if each.loop is loop]
    for _, future in sorted(client.waiting.values(), key=lambda each: -each[0]):
        if future in futures:
            yield future, future.run()


CLIENTS = []


def test_dask_is_given_jobs_in_order_and_a_client_of_our_own_is_closed(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", SimpleNamespace(Client=Client, as_completed=as_completed))
    theirs = Client()
    for dask in (theirs, "tcp://somewhere"):
        assert list(as_done(refuse_two, [5, 4, 3], dask=dask)) == [(0, 5), (1, 4), (2, 3)]
        with pytest.raises(ValueError, match="not two"):
            list(as_done(refuse_two, [0, 2, 1], dask=dask))
    assert not theirs.closed
    ours = CLIENTS[1:]
    assert [(each.address, each.is_default, each.closed) for each in ours] == [("tcp://somewhere", False, True)] * 2
    for each, released in zip(ours, (3, 1), strict=True):
        futures = [future for _, future in each.waiting.values()]
        assert [future.released for future in futures] == [k < released for k in range(3)]
        assert each.cancelled == futures


def test_a_job_that_a_cluster_has_given_up_ends_them_all(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", SimpleNamespace(as_completed=as_completed))
    client = Client()
    results = as_done(lambda job: job, [5, "gone", 3], dask=client)
    assert next(results) == (0, 5)
    futures = [future for _, future in client.waiting.values()]
    futures[1].lost = True
    with pytest.raises(ConnectionError, match=r"^the cluster went away: gone$"):
        next(results)
    assert [future.released for future in futures] == [True, False, False]
    assert client.cancelled == futures


@pytest.mark.slow  # on a machine that is far too busy its scheduler gives up starting
def test_a_cluster_is_left_as_it_was_found():
    """One in this process, by its client and by its address, to work that ends well and to work that does not."""
    distributed = pytest.importorskip("distributed")
    here = distributed.LocalCluster(1, threads_per_worker=2, processes=False, dashboard_address=None)
    with here as cluster, distributed.Client(cluster, set_as_default=False) as client:
        known = set(cluster.scheduler.clients)
        for dask in (client, cluster.scheduler_address):
            assert squares(as_done(square, [3, 4, 5, 6], dask=dask)) == SQUARES
            with pytest.raises(ValueError, match="not two"):
                list(as_done(refuse_two, range(4), dask=dask))
            assert client.status == "running"
            assert set(cluster.scheduler.clients) == known
        assert not client.futures


@pytest.fixture
def cluster():
    distributed = pytest.importorskip("distributed")
    import dask

    # A worker that was killed begins anew, on a busy machine in minutes: after 15 s the cluster would do without it.
    patient = dask.config.set({"distributed.deploy.lost-worker-timeout": "10 minutes"})
    with patient, distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        yield cluster


@pytest.mark.slow
def test_a_cluster_does_each_job_though_workers_are_killed(cluster):
    done, killed = [], 0
    for index, (job, worker) in as_done(sleepy, range(20), dask=cluster.scheduler_address):
        done.append((index, job))
        if len(done) in (2, 9):
            os.kill(worker, signal.SIGKILL)
            killed += 1
    assert killed == 2
    assert sorted(done) == [(k, k) for k in range(20)]


@pytest.mark.slow
def test_what_fails_on_a_cluster_fails_here(cluster):
    from distributed import Client, KilledWorker

    with Client(cluster) as client:
        assert squares(as_done(square, [3, 4, 5, 6], dask=client)) == SQUARES
        with pytest.raises(ValueError, match="not two"):
            list(as_done(refuse_two, range(4), dask=client))
        with pytest.raises(KilledWorker):
            list(as_done(fatal, [0], dask=client))
        assert client.status == "running"


@pytest.mark.slow
def test_a_backend_of_joblib_that_the_caller_has_chosen_does_the_work(cluster):
    from distributed import Client

    with Client(cluster) as client, joblib.parallel_config("dask", client=client):
        assert squares(as_done(square, [3, 4, 5, 6], processes=2)) == SQUARES
    with joblib.parallel_config("threading"):
        done = list(as_done(square, [3, 4, 5, 6], processes=2))
    assert squares(done) == SQUARES
    assert {pid for _, (_, pid) in done} == {os.getpid()}


@pytest.mark.slow
def test_a_cluster_that_goes_away_is_told(cluster):
    results = as_done(sleepy, range(20), dask=cluster.scheduler_address)
    next(results)
    cluster.close()
    with pytest.raises(ConnectionError, match="the cluster went away"):
        list(results)
