"""A trade in a folder: done cell by cell, kept as it goes, gone on with wherever it was broken off."""

import json
from collections import Counter

import numpy as np
import pytest
from policies_by_hand import policy_of_layers

from stickslip.studies.trade import running
from stickslip.studies.trade.cells import Outcome
from stickslip.studies.trade.plan import CONDITIONED, Trade, TRAINED
from stickslip.studies.trade.running import TradeFolder


def policy(number):
    return policy_of_layers([(np.full((2, 5), number), np.zeros(2))])


def number_of(policy):
    return float(policy.layers[0].weight[0, 0])


@pytest.fixture
def work(monkeypatch):
    """Cells whose work is told, and fails where it is asked to; a judgement tells which policy it was given."""

    class Work:
        def __init__(self):
            self.done = Counter()
            self.fail_after = None

        def __call__(self, job):
            if self.fail_after is not None and self.done.total() == self.fail_after:
                raise KeyboardInterrupt
            self.done[job.cell] += 1
            if job.cell.kind in (TRAINED, CONDITIONED):
                teachers = job.trade.teachers(job.cell.dither) if job.cell.kind == CONDITIONED else []
                assert len(job.policies) == len(teachers)
                return Outcome({}, policy(len(job.cell.name) + 100 * (job.cell.weight or 0)))
            return Outcome({"judged": [number_of(policy) for policy in job.policies]})

    work = Work()
    monkeypatch.setattr(running, "finish", work)
    return work


TRADE = {"weights": (0.0, 0.5), "seeds": 1, "steps": 10}


def files(folder):
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_every_cell_is_done_once_and_judged_by_its_own_policy(tmp_path, work):
    trade = Trade(**TRADE)
    folder = TradeFolder(tmp_path, trade)
    cells = [cell for stage in trade.cells() for cell in stage]
    progress = list(folder.run())
    assert [each.done for each in progress] == list(range(len(cells) + 1))
    assert {each.of for each in progress} == {len(cells)}
    assert [each.cell for each in progress] == [None, *cells]
    assert work.done == Counter(cells)
    for cell, result in folder.results().items():
        if cell.judges is not None:
            assert result["judged"] == [number_of(folder.policy(cell.judges))]
    assert list(TradeFolder(tmp_path, trade).run()) == [(len(cells), len(cells), None)]
    assert work.done == Counter(cells)


def test_a_trade_broken_off_anywhere_comes_to_the_same(tmp_path, work):
    trade = Trade(**TRADE)
    whole, broken = tmp_path / "whole", tmp_path / "broken"
    list(TradeFolder(whole, trade).run())
    work.done.clear()
    cells = sum(map(len, trade.cells()))
    for stop in range(cells):
        work.fail_after = stop
        with pytest.raises(KeyboardInterrupt):
            list(TradeFolder(broken, trade).run())
        assert len(TradeFolder(broken, trade).results()) == stop
    work.fail_after = None
    list(TradeFolder(broken, trade).run())
    assert set(work.done.values()) == {1}
    assert files(whole) == files(broken)


def test_a_folder_grows_by_weights_and_seeds_and_refuses_another_trade(tmp_path, work):
    list(TradeFolder(tmp_path, Trade(**TRADE)).run())
    done = work.done.copy()
    more = Trade(**{**TRADE, "weights": (0.0, 0.2, 0.5), "seeds": 2})
    list(TradeFolder(tmp_path, more).run())
    assert set(work.done.values()) == {1}
    assert set(done) < set(work.done)
    assert len(TradeFolder(tmp_path, Trade(**TRADE)).results()) == len(done)
    before = files(tmp_path)
    with pytest.raises(ValueError, match=r"holds must be 6000 to go on with the run in .*, got 1000$"):
        TradeFolder(tmp_path, Trade(**TRADE, holds=1000))
    assert files(tmp_path) == before


def test_settings_of_which_nothing_came_bind_nobody(tmp_path, work):
    TradeFolder(tmp_path, Trade(**TRADE))
    list(TradeFolder(tmp_path, Trade(**TRADE, holds=1000)).run())
    assert json.loads((tmp_path / "cells" / "settings.json").read_text(encoding="utf-8"))["holds"] == 1000


def test_a_cell_of_another_trade_is_refused(tmp_path, work):
    one, other = tmp_path / "one", tmp_path / "other"
    list(TradeFolder(one, Trade(**TRADE)).run())
    list(TradeFolder(other, Trade(**TRADE, longest=3)).run())
    name = "open-loop-dither-0.1.json"
    (other / "cells" / name).rename(one / "cells" / name)
    with pytest.raises(ValueError, match=rf"cells/{name} must be of this trade, it is of other settings"):
        TradeFolder(one, Trade(**TRADE)).results()


def test_a_training_whose_result_was_not_kept_is_done_again(tmp_path, work):
    """Its policy is written first: a crash between the two leaves what is not finished."""
    trade = Trade(**TRADE)
    list(TradeFolder(tmp_path, trade).run())
    before = files(tmp_path)
    cell = trade.cells()[0][-1]
    (tmp_path / "cells" / f"{cell.name}.json").unlink()
    list(TradeFolder(tmp_path, trade).run())
    assert work.done[cell] == 2
    assert files(tmp_path) == before
