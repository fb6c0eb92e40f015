"""Means over seeds: what one seed does not tell, no mean of the others tells in its place."""

import numpy as np
import pytest

from stickslip.studies.maps import over_seeds

xr = pytest.importorskip("xarray")


def test_a_cell_without_one_of_its_seeds_has_no_mean_and_the_others_have_theirs():
    values = np.array([[1.0, 2.0, 6.0], [np.nan, 2.0, 3.0]])
    means = over_seeds(xr.Dataset({"speed": (("x", "seed"), values)}))
    for name in ("speed", "speed_error", "speed_low", "speed_high"):
        assert np.isnan(means[name].values).tolist() == [False, True]
    assert means.speed[0] == pytest.approx(3.0, rel=1e-15)
    assert means.speed_error[0] == pytest.approx(np.sqrt(7.0 / 3.0), rel=1e-15)
    # Student's 97.5% with two degrees of freedom, in closed form: t = p sqrt(2 / (1 - p^2)) with p = 0.95.
    student = 0.95 * np.sqrt(2.0 / (1.0 - 0.95**2))
    assert means.speed_high[0] == pytest.approx(3.0 + student * np.sqrt(7.0 / 3.0), rel=1e-12)
    assert means.speed_low[0] == pytest.approx(3.0 - student * np.sqrt(7.0 / 3.0), rel=1e-12)


def test_a_single_seed_has_a_mean_alone():
    one = over_seeds(xr.Dataset({"speed": (("x", "seed"), [[4.0], [5.0]])}))
    assert one.speed.values.tolist() == [4.0, 5.0]
    assert all(np.isnan(one[f"speed_{end}"].values).all() for end in ("error", "low", "high"))
