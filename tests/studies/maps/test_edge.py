"""Where an exponent changes its sign, and what is largest where."""

import numpy as np
import pytest

from stickslip.studies.maps.edge import best_cell, chaotic, difference, edge_cells, rank_correlation


def test_the_edge_is_the_nearer_side_of_each_change_of_sign():
    exponent = np.array([[-3.0, -1.0, 2.0], [-2.0, -0.5, 0.25], [0.1, 1.0, 4.0]])
    edge = [[False, True, False], [False, True, True], [True, False, False]]
    assert edge_cells(exponent).tolist() == edge
    assert edge_cells(np.array([-2.0, -1.0, 3.0, 0.5, -0.1])).tolist() == [False, True, False, False, True]
    assert not edge_cells(-np.abs(exponent)).any()


def test_the_best_cell_is_not_judged_by_the_seeds_that_chose_it():
    random = np.random.default_rng(0)
    values = 3.0 + random.normal(0.0, 1.0, (30, 20, 8))  # all cells alike: only luck tells them apart
    best = best_cell(values)
    assert values[best.cell].mean() == values.mean(axis=-1).max() > 4.0
    assert best.estimate.low < 3.0 < best.estimate.high
    chosen = np.unravel_index(values[..., ::2].mean(axis=-1).argmax(), (30, 20))
    assert best.judged[1::2].tolist() == values[chosen][1::2].tolist()
    chosen = np.unravel_index(values[..., 1::2].mean(axis=-1).argmax(), (30, 20))
    assert best.judged[::2].tolist() == values[chosen][::2].tolist()
    values[4, 5] += 10.0
    assert best_cell(values).cell == (4, 5)
    assert best_cell(values).judged.tolist() == values[4, 5].tolist()
    among = np.zeros((30, 20), bool)
    assert best_cell(values, among) is None
    among[7, 3] = True
    assert best_cell(values, among).cell == (7, 3)
    values[7, 3, 0] = np.nan
    assert best_cell(values, among) is None


def test_cells_are_compared_on_the_same_seeds():
    common = 10.0 * np.arange(12.0)
    one = best_cell((common + 20.0 + np.tile([0.0, 0.1, 0.0, -0.1], 3))[None])
    other = best_cell((common + 18.0)[None])
    more = difference(one, other)
    assert more.low < 2.0 < more.high
    assert more.high - more.low < 0.3
    assert one.estimate.high - one.estimate.low > 3.0
    assert (difference(one, one).mean, difference(one, one).high) == (0.0, 0.0)


def test_chaos_is_told_by_three_standard_errors():
    exponents = np.array([[1.0, 1.2, 0.8, 1.0], [1.0, 3.0, -1.5, 1.0], [-1.0, -1.1, -0.9, -1.0]])
    assert chaotic(exponents).tolist() == [True, False, False]
    assert chaotic(exponents[:, :1], np.full((3, 1), 0.3)).tolist() == [True, True, False]
    assert chaotic(exponents[:, :1], np.full((3, 1), 0.4)).tolist() == [False, False, False]
    assert not chaotic(exponents[:, :1]).any()


def test_ranks_are_correlated_over_cells_that_have_both():
    one = np.array([[1.0, 2.0], [3.0, np.nan]])
    assert rank_correlation(one, -(one**3)) == pytest.approx(-1.0)
    assert rank_correlation(one, np.array([[1.0, 3.0], [2.0, 9.0]])) == pytest.approx(0.5)
    assert np.isnan(rank_correlation(one, np.ones((2, 2))))
