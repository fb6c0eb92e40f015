"""A thousand crawlers by other people's solvers: the same schedules, judged alike, and the page says what was kept."""

import json

import batch_peers
import numpy as np
import pytest
from measuring import refreshed
from peer_solvers.problem import FOOT, WORD

from stickslip.common.extras import MissingExtra


def test_the_table_is_that_of_the_results_that_are_kept():
    results = json.loads(batch_peers.RESULTS.read_text(encoding="utf-8"))
    page = batch_peers.PAGE.read_text(encoding="utf-8")
    assert refreshed(page, batch_peers.tables(results)) == page


def test_crawlers_out_of_step_begin_the_word_at_its_eight_bits():
    np.testing.assert_array_equal(batch_peers.words("in step", 3), [WORD] * 3)
    crowd = batch_peers.words("out of step", 10)
    assert [row[:8].tolist() for row in crowd[:3]] == [
        [1, 1, 1, 1, 0, 0, 0, 0],
        [1, 1, 1, 0, 0, 0, 0, 1],
        [1, 1, 0, 0, 0, 0, 1, 1],
    ]
    np.testing.assert_array_equal(crowd[8:], crowd[:2])
    assert len(np.unique(crowd, axis=0)) == 8


@pytest.mark.parametrize("name", ["heyoka", "heyoka batch", "stickslip"])
def test_a_crowd_comes_as_far_as_each_of_it(name):
    try:
        solver = batch_peers.solver(name, 1e-12)
    except MissingExtra:
        pytest.skip("heyoka is not installed")
    feet = solver(batch_peers.words("out of step", 9))
    assert feet[0] == pytest.approx(FOOT, abs=1e-11)
    assert feet[8] == feet[0]
    assert feet[1] == pytest.approx(solver(batch_peers.words("out of step", 2)[1:])[0], abs=1e-12)
    assert abs(feet[1] - feet[0]) > 0.1
    assert batch_peers.error(name, 1e-12) < 1e-11
