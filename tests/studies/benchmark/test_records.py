import json
import multiprocessing
import re

import numpy as np
import pytest

from stickslip.reservoir import MemoryCapacity
from stickslip.studies.benchmark.records import Record, Records, SHOWN
from stickslip.tasks import Solution

SETTINGS = {"length": 100, "groups": {"duffing": 2}}


def attempt(task="NARMA-2 NRMSE", reservoir="crawler", seed=0, score=0.5, **of):
    return Record.of(task, reservoir, seed, Solution(score, **of))


def test_what_is_kept_comes_back(tmp_path):
    records = Records(tmp_path / "finished", SETTINGS)
    series = np.linspace(0, 1, 500)
    memory = MemoryCapacity(np.arange(3), np.array([1.0, 0.5, 0.0]), cutoff=0.01, bound=7)
    kept = [
        attempt(prediction=series, target=-series),
        attempt("memory", memory=memory),
        attempt(reservoir="echo index", details={"rank": 3}),
        attempt(reservoir="echo-index", score=0.25),
        attempt(seed=1),
    ]
    for record in kept:
        records.keep(record)
    records = Records(tmp_path / "finished", SETTINGS, resume=True)
    assert set(records.load()) == {(record.task, record.reservoir, record.seed) for record in kept}
    for record in kept:
        assert records.load()[record[:3]] == record
    assert kept[0].details["prediction"] == series[:SHOWN].tolist()
    assert kept[1].details == {"profile": [1.0, 0.5, 0.0], "cutoff": 0.01, "bound": 7}


def test_what_was_being_written_when_a_process_was_killed_is_not_read(tmp_path):
    records = Records(tmp_path, SETTINGS)
    records.keep(attempt())
    [file] = tmp_path.glob("narma*")
    (tmp_path / f".{file.stem}-123.json").write_text('{"task": "half', encoding="utf-8")
    assert list(records.load()) == [("NARMA-2 NRMSE", "crawler", 0)]


def test_a_run_is_not_mixed_with_another(tmp_path):
    folder = tmp_path / "run" / "finished"
    Records(folder, SETTINGS)
    Records(folder, {**SETTINGS, "length": 50}).keep(attempt())  # nothing was kept yet, so nothing is lost
    with pytest.raises(ValueError, match="run holds a run already: resume it, or choose another folder"):
        Records(folder, {**SETTINGS, "length": 50})
    with pytest.raises(ValueError, match=r"length must be 50 to go on with the run in .*run, got 100"):
        Records(folder, SETTINGS, resume=True)
    assert len(Records(folder, {**SETTINGS, "length": 50}, resume=True).load()) == 1


def test_names_may_be_added_but_not_changed(tmp_path):
    def records(**named):
        return Records(tmp_path / "run" / "finished", {**SETTINGS, **named}, resume=True)

    records(tasks={"a": {"probe": 1.0}}, reservoirs={"r": 1})
    records(tasks={"b": {"probe": 2.0}}, reservoirs={"r": 1, "s": 2})
    assert json.loads((tmp_path / "run" / "finished" / "settings.json").read_text(encoding="utf-8")) == {
        **SETTINGS, "tasks": {"a": {"probe": 1.0}, "b": {"probe": 2.0}}, "reservoirs": {"r": 1, "s": 2}
    }  # fmt: skip
    with pytest.raises(ValueError, match=r"tasks\.a\.probe must be 1\.0 to go on with the run in .*run, got 1\.5"):
        records(tasks={"a": {"probe": 1.5}, "b": {"probe": 2.0}}, reservoirs={"r": 1})
    with pytest.raises(ValueError, match=r"reservoirs\.s must be 2 to go on with the run in .*run, got 3"):
        records(tasks={}, reservoirs={"s": 3})
    with pytest.raises(ValueError, match=r"tasks must be \{.*\} to go on with the run in .*run, got absent"):
        records()


def test_a_record_is_plain_json(tmp_path):
    Records(tmp_path, SETTINGS).keep(attempt(details={"exponent": None}))
    [file] = tmp_path.glob("narma*")
    assert json.loads(file.read_text(encoding="utf-8")) == {
        "task": "NARMA-2 NRMSE",
        "reservoir": "crawler",
        "seed": 0,
        "score": 0.5,
        "details": {"exponent": None},
    }
    assert isinstance(attempt().score, float)


def kept_again_and_again(folder, turn, times):
    records = Records(folder, SETTINGS, resume=True)
    for _ in range(times):
        records.keep(attempt(score=float(turn), details={"filling": [turn] * 5_000}))


def test_two_processes_that_keep_the_same_attempt_leave_one_of_the_two_whole(tmp_path):
    """Whoever reads in between reads one or the other, and never a half of each."""
    Records(tmp_path, SETTINGS).keep(attempt(score=0.0, details={"filling": [0] * 5_000}))
    context = multiprocessing.get_context("fork")
    writers = [context.Process(target=kept_again_and_again, args=(tmp_path, turn, 40)) for turn in (1, 2)]
    for writer in writers:
        writer.start()
    reader, seen = Records(tmp_path, SETTINGS, resume=True), set()
    while any(writer.is_alive() for writer in writers):
        [record] = reader.load().values()
        assert record.details["filling"] == [int(record.score)] * 5_000
        seen.add(record.score)
    assert [writer.exitcode for writer in writers] == [0, 0]
    [record] = reader.load().values()
    assert record.score in (1.0, 2.0)
    assert seen <= {0.0, 1.0, 2.0}
    assert sorted(path.suffix for path in tmp_path.iterdir()) == [".json", ".json"]  # the settings, and one attempt


def test_what_is_shown_of_a_prediction_is_its_beginning():
    series = np.arange(200.0)
    record = attempt(prediction=series, target=series + 1)
    assert (record.details["prediction"], record.details["target"]) == (list(range(120)), list(range(1, 121)))
    assert attempt(target=series).details == attempt(prediction=series).details == {}
    details = {"rank": 3}
    assert attempt(details=details).details is not details


def test_names_that_read_alike_have_files_of_their_own(tmp_path):
    records = Records(tmp_path, SETTINGS)
    for k, (task, reservoir) in enumerate([("a b", "c"), ("a", "b c"), ("a-b", "c"), ("A b", "c"), ("x" * 300, "y")]):
        records.keep(attempt(task, reservoir, score=float(k)))
    assert sorted(record.score for record in records.load().values()) == [0.0, 1.0, 2.0, 3.0, 4.0]
    names = sorted(path.name for path in tmp_path.glob("a-*"))
    assert all(re.fullmatch(r"a-b-c-[0-9a-f]{8}-0\.json", name) for name in names)
    [long] = tmp_path.glob("x*")
    assert re.fullmatch(r"x{80}-[0-9a-f]{8}-0\.json", long.name)


def test_a_folder_that_fits_is_left_as_it_is(tmp_path):
    settings = {**SETTINGS, "tasks": {"a": 1}, "reservoirs": {"r": 1}}
    Records(tmp_path, settings)
    before = (tmp_path / "settings.json").stat().st_mtime_ns
    Records(tmp_path, {**settings, "tasks": {}}, resume=True)
    assert (tmp_path / "settings.json").stat().st_mtime_ns == before
    with pytest.raises(ValueError, match="must be"):
        Records(tmp_path, {**settings, "seeds": 3}, resume=True)
