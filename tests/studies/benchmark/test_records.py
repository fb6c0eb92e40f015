import json

import numpy as np
import pytest

from stickslip.reservoir import MemoryCapacity
from stickslip.studies.benchmark.attempts import Attempt
from stickslip.studies.benchmark.records import Record, Records, SHOWN
from stickslip.tasks import Solution

SETTINGS = {"length": 100, "groups": {"duffing": 2}}


def attempt(task="NARMA-2 NRMSE", reservoir="crawler", seed=0, score=0.5, **of):
    return Attempt(task, reservoir, seed, Solution(score, **of))


def test_what_is_kept_comes_back(tmp_path):
    records = Records(tmp_path / "finished", SETTINGS)
    series = np.linspace(0, 1, 500)
    memory = MemoryCapacity(np.arange(3), np.array([1.0, 0.5, 0.0]), cutoff=0.01, bound=7)
    kept = [
        records.keep(attempt(prediction=series, target=-series)),
        records.keep(attempt("memory", memory=memory)),
        records.keep(attempt(reservoir="echo index", details={"rank": 3})),
        records.keep(attempt(reservoir="echo-index", score=0.25)),
        records.keep(attempt(seed=1)),
    ]
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
    assert isinstance(Record.of(attempt()).score, float)
