"""The area that a front dominates."""

import numpy as np
import pytest

from stickslip.studies.trade import hypervolume


def test_a_rectangle_and_a_staircase():
    assert hypervolume([[2.0, 3.0]]) == 6.0
    assert hypervolume([[3.0, 1.0], [1.0, 2.0], [2.0, 1.5]]) == 3.0 * 1.0 + 2.0 * 0.5 + 1.0 * 0.5
    assert hypervolume([[3.0, 1.0], [1.0, 2.0]], reference=(1.0, 0.5)) == 2.0 * 0.5


def test_what_is_dominated_or_not_above_the_reference_adds_nothing():
    front = [[3.0, 1.0], [1.0, 2.0]]
    assert hypervolume([*front, [1.0, 1.0], [3.0, 1.0], [-1.0, 50.0], [50.0, 0.0]]) == hypervolume(front)
    assert hypervolume([[-1.0, 2.0]]) == 0.0


def test_it_is_the_share_of_random_points_below_the_front():
    random = np.random.default_rng(0)
    points, thrown = random.random((12, 2)), random.random((40_000, 2))
    below = (thrown[:, None] < points).all(axis=2).any(axis=1).mean()
    assert hypervolume(points) == pytest.approx(below, abs=4 * np.sqrt(below * (1 - below) / len(thrown)))


@pytest.mark.parametrize(
    ("points", "reference", "message"),
    [
        ([[1.0, 2.0, 3.0]], (0.0, 0.0), r"points must have shape \(n, 2\), got \(1, 3\)"),
        ([[1.0, 2.0]], (0.0,), r"reference must have shape \(2,\), got \(1,\)"),
        ([[1.0, np.nan]], (0.0, 0.0), "points must be finite"),
    ],
)
def test_what_has_no_hypervolume_is_refused(points, reference, message):
    with pytest.raises(ValueError, match=message):
        hypervolume(points, reference)
