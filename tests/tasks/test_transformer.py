import array
import doctest
import pickle
import subprocess
import sys
import warnings
from collections import deque

import numpy as np
import pandas
import polars
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.base import clone
from sklearn.exceptions import NotFittedError
from sklearn.linear_model import Ridge
from sklearn.model_selection import cross_val_score, GridSearchCV, TimeSeriesSplit
from sklearn.pipeline import make_pipeline
from sklearn.utils.estimator_checks import parametrize_with_checks

import stickslip
from stickslip import CrawlerReservoir, Groups, Scene, simulate
from stickslip.tasks import BodyReservoir, transformer

SERIES = np.random.default_rng(0).random(60)
DELAYED = np.roll(SERIES, 1)

EXPECTED_FAILURES = {
    "check_fit1d": "a series may have one dimension",
    "check_methods_sample_order_invariance": "samples are in order of time, and each state holds those before it",
    "check_methods_subset_invariance": "every call starts the body at rest, as a series of its own",
}


@parametrize_with_checks(
    [CrawlerReservoir(washout=3)], expected_failed_checks=lambda _: EXPECTED_FAILURES, xfail_strict=True
)
def test_scikit_learns_checks(estimator, check):
    check(estimator)


def test_rows_are_the_body_read_while_each_sample_drives_it():
    reservoir = CrawlerReservoir(virtual_nodes=3, washout=0, input_range=(0, 1), hold=0.7)
    motion = simulate(Groups(), SERIES, 0.7, samples_per_hold=3)
    expected = np.hstack([getattr(motion, name).reshape(60, 3) for name in ("deformation", "velocity", "pressure")])
    np.testing.assert_array_equal(reservoir.fit_transform(SERIES), expected)
    np.testing.assert_array_equal(reservoir.fit_transform(SERIES[:, None]), expected)


USUAL = {
    "groups": None,
    "scene": None,
    "hold": 0.5,
    "encoding": "pulse_width",
    "holds_per_sample": 1,
    "virtual_nodes": 4,
    "readings": ("deformation", "velocity", "pressure"),
    "tolerance": 1e-9,
}


@pytest.mark.parametrize(
    "change",
    [
        {},
        {"groups": {"duffing": 2.0}},
        {"scene": {"slope": 0.1}},
        {"hold": 1.1},
        {"encoding": "threshold"},
        {"holds_per_sample": 2},
        {"virtual_nodes": 2},
        {"readings": ("foot_velocity", "velocity")},
        {"tolerance": 1e-3},
    ],
    ids=str,
)
def test_every_argument_of_the_body_is_heard(change):
    """The judge is the reservoir of that body, driven by the first sample a hundred times and then by the series."""
    expected = BodyReservoir(**{**USUAL, **change})(np.concatenate([np.repeat(SERIES[0], 100), SERIES]))[100:]
    np.testing.assert_array_equal(CrawlerReservoir(input_range=(0, 1), **change).fit_transform(SERIES), expected)
    assert (
        not change
        or expected.shape != (60, 12)
        or (expected != CrawlerReservoir(input_range=(0, 1)).fit_transform(SERIES)).any()
    )


def test_arguments_by_default():
    usual = {**USUAL, "washout": 100, "input_range": None, "carry_on": False}
    assert CrawlerReservoir().get_params() == usual


def test_what_was_fitted_is_a_copy():
    """The caller may write over the fitted series, and a range, and transform as before."""
    for carry_on in (False, True):
        series = SERIES[:30, None].copy()
        reservoir = CrawlerReservoir(carry_on=carry_on, washout=5, virtual_nodes=1).fit(series)
        before = reservoir.transform(SERIES[:20])
        assert not any(np.shares_memory(kept, series) for kept in (reservoir.past_, reservoir.input_range_))
        assert reservoir.past_.base is None  # nor does it keep the series alive
        assert reservoir.past_.shape == (30 if carry_on else 0, 1)
        series[:] = 0.5
        np.testing.assert_array_equal(reservoir.transform(SERIES[:20]), before)
    limits = np.array([0.0, 1.0])
    reservoir = CrawlerReservoir(input_range=limits).fit(SERIES)
    before = reservoir.transform(SERIES[:5])
    limits[1] = 9.0
    np.testing.assert_array_equal(reservoir.transform(SERIES[:5]), before)
    given = SERIES.copy()
    CrawlerReservoir(washout=2).fit_transform(given)
    np.testing.assert_array_equal(given, SERIES)


def test_the_range_is_told_by_column():
    both = np.stack([SERIES, 3 * SERIES - 5], axis=1)
    fitted = CrawlerReservoir().fit(both).input_range_
    np.testing.assert_array_equal(fitted, np.stack([both.min(axis=0), both.max(axis=0)], axis=1))
    np.testing.assert_array_equal(CrawlerReservoir(input_range=(-1, 2)).fit(both).input_range_, [[-1, 2], [-1, 2]])


def test_a_warning_points_at_the_line_that_transforms():
    reservoir = CrawlerReservoir(input_range=(0, 1)).fit(SERIES)
    for call in (reservoir.transform, reservoir.fit_transform):
        with pytest.warns(UserWarning, match="column 0 goes from 0.5 to 1.25, and was fitted for 0 to 1") as told:
            call([[0.5], [1.25]])
        assert told[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        reservoir.settled(2 * SERIES)


def test_the_washout_is_the_first_sample_held_before_the_series():
    given_range = {"input_range": (0, 1), "virtual_nodes": 2}
    washed = CrawlerReservoir(washout=7, **given_range).fit_transform(SERIES)
    from_rest = CrawlerReservoir(washout=0, **given_range)
    before = from_rest.fit_transform(np.concatenate([np.repeat(SERIES[0], 7), SERIES]))
    assert len(washed) == 60
    np.testing.assert_array_equal(washed, before[7:])


@settings(max_examples=20, deadline=None)
@given(st.integers(1, 50), st.floats(0.0, 1.0), st.sampled_from(["pulse_width", "threshold", "sigma_delta"]))
def test_no_row_knows_the_future(count, other, encoding):
    reservoir = CrawlerReservoir(encoding=encoding, holds_per_sample=2, washout=5, input_range=(0, 1)).fit(SERIES)
    changed = SERIES.copy()
    changed[count:] = other
    np.testing.assert_array_equal(reservoir.transform(changed)[:count], reservoir.transform(SERIES)[:count])


def test_nothing_of_one_series_is_left_in_the_next():
    reservoir = CrawlerReservoir(washout=0).fit(SERIES)
    first = reservoir.transform(SERIES)
    reservoir.transform(1 - SERIES)
    np.testing.assert_array_equal(reservoir.transform(SERIES), first)


def test_the_range_is_learned_from_what_is_fitted_and_the_valve_does_no_more():
    reservoir = CrawlerReservoir(washout=0, readings=["pressure"]).fit(2.0 * SERIES[:50] - 1.0)
    np.testing.assert_array_equal(reservoir.input_range_, [[2 * SERIES[:50].min() - 1, 2 * SERIES[:50].max() - 1]])
    inside = reservoir.transform([[reservoir.input_range_[0, 1]], [reservoir.input_range_[0, 0]]])
    with pytest.warns(UserWarning, match=r"X has 2 of 2 values beyond the fitted range.*from -1e\+09 to 1e\+09, and"):
        beyond = reservoir.transform([[1e9], [-1e9]])
    np.testing.assert_array_equal(beyond, inside)


def test_only_what_is_beyond_the_range_warns():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        CrawlerReservoir().fit(SERIES).transform(SERIES)
        CrawlerReservoir(input_range=(0, 1)).fit_transform(SERIES)
    wide = np.stack([SERIES, np.where(np.arange(60) == 7, 1.5, SERIES)], axis=1)
    with pytest.warns(UserWarning, match="1 of 120 values .*: column 1 goes from"):
        CrawlerReservoir(input_range=(0, 1)).fit_transform(wide)


@pytest.mark.parametrize("encoding", ["pulse_width", "sigma_delta"])
@pytest.mark.parametrize("scene", [None, {"segments": 2, "tube_mass": 0.3}])
def test_what_goes_on_is_the_whole_series_cut(encoding, scene):
    of = {"encoding": encoding, "scene": scene, "virtual_nodes": 2, "input_range": (0, 1), "washout": 9}
    whole = CrawlerReservoir(**of).fit_transform(SERIES)
    going_on = CrawlerReservoir(carry_on=True, **of)
    np.testing.assert_array_equal(going_on.fit_transform(SERIES[:37]), whole[:37])
    np.testing.assert_array_equal(going_on.transform(SERIES[37:]), whole[37:])
    np.testing.assert_array_equal(going_on.transform(SERIES[37:50]), whole[37:50])  # one transform leaves no trace
    from_rest = CrawlerReservoir(**of).fit(SERIES[:37]).transform(SERIES[37:])
    assert np.abs(from_rest - whole[37:]).max() > 0.01


def test_a_time_series_split_keeps_its_past():
    """The target is one sample old: without its past the first row of each test part cannot know it."""
    series = np.random.default_rng(1).random(400)
    target = np.roll(series, 1)
    scores = {
        carry_on: cross_val_score(
            make_pipeline(CrawlerReservoir(carry_on=carry_on, input_range=(0, 1)), Ridge(1e-6)),
            series[:, None],
            target,
            cv=TimeSeriesSplit(40, test_size=1),
            scoring="neg_mean_squared_error",
        ).mean()
        for carry_on in (False, True)
    }
    assert scores[True] > 0.5 * scores[False]


def test_settled_rows_are_those_that_every_start_leads_to():
    reservoir = CrawlerReservoir(input_range=(0, 1), washout=50).fit(SERIES)
    series = np.random.default_rng(2).random(400)
    settled = reservoir.settled(series)
    first = np.argmax(settled)
    assert 5 < first < 300
    assert not settled[:first].any()
    assert settled[first:].all()
    other = np.concatenate([np.random.default_rng(3).random(50), series])
    usual = reservoir.transform(series)
    difference = np.abs(reservoir.transform(other)[50:] - usual) / usual.std(axis=0)
    assert difference[settled].max() < 0.01 < difference[0].max()
    assert np.argmax(reservoir.settled(series, tolerance=1e-4)) > first
    damped = CrawlerReservoir({"damping_ratio": 0.6}, input_range=(0, 1), washout=50).fit(SERIES)
    assert np.argmax(damped.settled(series)) < first
    forgetful = CrawlerReservoir(
        {"damping_ratio": 1.0},
        scene={"anchored": True},
        hold=200.0,
        encoding="threshold",
        readings="deformation",
        input_range=(0, 1),
        washout=5,
    ).fit(SERIES)
    assert forgetful.settled(series).all()
    with pytest.raises(ValueError, match=r"tolerance must be in \(0, 1\), got 0"):
        reservoir.settled(series, tolerance=0)
    with pytest.raises(ValueError, match="washout must be a whole number >= 1, got 0"):
        CrawlerReservoir(washout=0).fit(SERIES).settled(series)


def test_settled_rows_by_hand():
    """Those after the last in which a start with the valve shut or open still differs, in shares of a deviation."""
    reservoir = CrawlerReservoir(input_range=(0, 1), washout=30, virtual_nodes=2).fit(SERIES)
    series = np.random.default_rng(2).random(200)
    body = BodyReservoir(virtual_nodes=2)
    usual, shut, opened = (body(np.concatenate([np.full(30, start), series]))[30:] for start in (series[0], 0.0, 1.0))
    for tolerance in (0.01, 0.3):
        apart = (np.maximum(abs(shut - usual), abs(opened - usual)) > tolerance * usual.std(axis=0)).any(axis=1)
        expected = np.arange(200) > np.flatnonzero(apart)[-1]
        np.testing.assert_array_equal(reservoir.settled(series, tolerance=tolerance), expected)
    np.testing.assert_array_equal(reservoir.settled(series), reservoir.settled(series, tolerance=0.01))
    assert not CrawlerReservoir(washout=1, scene={"slope": 0.0}).fit(SERIES[:3]).settled(SERIES[:3]).any()


def test_names_of_columns_are_those_that_were_fitted():
    frame = pandas.DataFrame({"left": SERIES[:9], "right": SERIES[9:18]})
    reservoir = CrawlerReservoir(virtual_nodes=1, readings="velocity").fit(frame)
    assert reservoir.get_feature_names_out().tolist() == ["left_velocity_0", "right_velocity_0"]
    assert (
        reservoir.get_feature_names_out().dtype
        == CrawlerReservoir().fit(SERIES).get_feature_names_out().dtype
        == object
    )
    assert reservoir.get_feature_names_out(["left", "right"]).tolist() == ["left_velocity_0", "right_velocity_0"]
    with pytest.raises(ValueError, match=r"input_features is not equal to feature_names_in_, \['left', 'right'\], got"):
        reservoir.get_feature_names_out(["right", "left"])
    assert CrawlerReservoir(virtual_nodes=1, readings="velocity").fit(SERIES).get_feature_names_out(["u"]).tolist() == [
        "velocity_0"
    ]


def test_a_constant_series_shuts_the_valve():
    np.testing.assert_array_equal(CrawlerReservoir().fit_transform(np.full(5, 3.0)), np.zeros((5, 12)))


def one_dimensional():
    """The same series as the array-likes that people have."""
    values = SERIES[:20]
    arrays = {
        "list": values.tolist(),
        "tuple": tuple(values),
        "array.array": array.array("d", values),
        "memoryview": memoryview(values),
        "polars": polars.Series("u", values),
        "pandas": pandas.Series(values, name="u", index=range(7, 27)),
        "pandas with missing values allowed": pandas.Series(values, dtype="Float64"),
        "torch": torch.from_numpy(values),
        "float32": values.astype(np.float32).astype(object),
        "not contiguous": np.repeat(values, 2)[::2],
        "deque": deque(values),
    }
    return [pytest.param(given, id=name) for name, given in arrays.items()]


@pytest.mark.parametrize("given", one_dimensional())
def test_a_series_may_be_any_array_of_one_dimension(given):
    expected = CrawlerReservoir(washout=3).fit_transform(np.asarray(given, dtype=float)[:, None])
    np.testing.assert_array_equal(CrawlerReservoir(washout=3).fit(given).transform(given), expected)
    fitted = CrawlerReservoir(washout=3).fit(SERIES[:20, None])
    np.testing.assert_allclose(fitted.transform(given), expected, rtol=0, atol=1e-5)


def test_whole_numbers_are_a_series_too():
    expected = CrawlerReservoir().fit_transform(np.arange(5.0))
    for series in (range(5), array.array("b", range(5)), polars.Series(range(5)), bytearray(range(5))):
        np.testing.assert_array_equal(CrawlerReservoir().fit_transform(series), expected)


@pytest.mark.parametrize("bad", [3.0, "0110", polars.Series([0.5, None]), {"u": [1.0]}, [[1.0], [1.0, 2.0]]], ids=repr)
def test_what_is_no_series_is_refused(bad):
    with pytest.raises((ValueError, TypeError)):
        CrawlerReservoir().fit(bad)


def test_every_column_drives_a_body_of_its_own():
    both = np.stack([SERIES, DELAYED], axis=1)
    reservoir = CrawlerReservoir(virtual_nodes=1).fit(both)
    left, right = (CrawlerReservoir(virtual_nodes=1).fit_transform(column) for column in both.T)
    np.testing.assert_array_equal(reservoir.transform(both), np.hstack([left, right]))
    names = reservoir.get_feature_names_out().tolist()
    assert names == [f"x{i}_{name}_0" for i in (0, 1) for name in ("deformation", "velocity", "pressure")]
    assert reservoir.get_feature_names_out(["a", "b"])[0] == "a_deformation_0"


def test_a_chain_gives_the_states_of_its_segments():
    reservoir = CrawlerReservoir(
        scene={"segments": 2, "tube_mass": 0.3}, virtual_nodes=2, washout=0, input_range=(0, 1)
    )
    states = reservoir.fit_transform(SERIES[:10])
    names = reservoir.get_feature_names_out().tolist()
    assert names[:4] == ["deformation0_0", "deformation0_1", "deformation1_0", "deformation1_1"]
    assert names[-2:] == ["pressure_0", "pressure_1"]
    assert states.shape == (10, len(names)) == (10, 10)
    scene = Scene(segments=2, tube_mass=0.3)
    motion = simulate(Groups(), SERIES[:10], 0.5, scene=scene, samples_per_hold=2)
    column = states[:, names.index("velocity1_1")]
    np.testing.assert_array_equal(column, motion.segment_velocity[1, 1::2])


@pytest.mark.parametrize(("holds", "nodes"), [(1, 4), (4, 1), (4, 6), (3, 5), (6, 4)])
def test_virtual_nodes_are_equally_spaced_over_a_sample_of_any_number_of_holds(holds, nodes):
    reservoir = CrawlerReservoir(
        holds_per_sample=holds, virtual_nodes=nodes, readings="pressure", washout=0, input_range=(0, 1)
    )
    states = reservoir.fit_transform(SERIES[:5])
    motion = simulate(Groups(), np.repeat(SERIES[:5], holds), 0.5, samples_per_hold=60)
    every = 60 * holds // nodes
    np.testing.assert_allclose(states.ravel(), motion.pressure[every - 1 :: every], rtol=1e-12)


def test_it_works_in_pipelines_searches_and_time_series_splits():
    model = make_pipeline(CrawlerReservoir(washout=20), Ridge(1e-6))
    scores = cross_val_score(model, SERIES[:, None], DELAYED, cv=TimeSeriesSplit(3))
    assert scores.shape == (3,)
    grid = {"crawlerreservoir__hold": [0.1, 0.5], "crawlerreservoir__groups": ["linear", {"deborah": 1.0}, Groups()]}
    search = GridSearchCV(model, grid, cv=TimeSeriesSplit(3)).fit(SERIES[:, None], DELAYED)
    assert np.isfinite(search.cv_results_["mean_test_score"]).all()
    weights = np.arange(60) >= 10
    fitted = clone(model).fit(SERIES[:, None], DELAYED, ridge__sample_weight=weights)
    late = Ridge(1e-6).fit(CrawlerReservoir(washout=20).fit_transform(SERIES)[10:], DELAYED[10:])
    np.testing.assert_allclose(fitted[-1].coef_, late.coef_, rtol=1e-5, atol=1e-8)


def test_it_is_cloned_set_and_pickled():
    reservoir = CrawlerReservoir({"deborah": 2.0}, scene=Scene(anchored=True)).set_params(hold=0.3)
    assert clone(reservoir).get_params() == reservoir.get_params()
    states = reservoir.fit_transform(SERIES)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(reservoir)).transform(SERIES), states)


def test_importing_the_package_leaves_it_out_until_it_is_used():
    code = (
        "import sys, stickslip; assert 'stickslip.tasks' not in sys.modules;"
        "stickslip.CrawlerReservoir; assert 'sklearn' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
    assert "CrawlerReservoir" in stickslip.__all__


def test_the_examples_of_the_docstring():
    assert doctest.testmod(transformer).failed == 0


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"groups": "octopus"}, ValueError, "groups must be one of the presets .* got 'octopus'"),
        ({"scene": {"tilt": 1}}, ValueError, "scene has no 'tilt'"),
        ({"hold": 0.0}, ValueError, r"hold must be in \(0, inf\), got 0.0"),
        ({"encoding": "morse"}, ValueError, r"encoding must be one of .* got 'morse'"),
        ({"holds_per_sample": 1.5}, TypeError, "holds_per_sample must be a whole number >= 1, got 1.5"),
        ({"virtual_nodes": 0}, ValueError, "virtual_nodes must be a whole number >= 1, got 0"),
        ({"readings": ["colour"]}, ValueError, "readings has no 'colour'"),
        ({"readings": []}, ValueError, r"readings must hold at least one reading and none twice, got \[\]"),
        ({"washout": -1}, ValueError, "washout must be a whole number >= 0, got -1"),
        ({"input_range": (1, 0)}, ValueError, r"input_range must be two ascending numbers, got \(1, 0\)"),
        ({"tolerance": 1.0}, ValueError, r"tolerance must be in \[1e-15, 1e-2\], got 1.0"),
    ],
)
def test_bad_parameters(change, error, message):
    with pytest.raises(error, match=message):
        CrawlerReservoir(**change).fit(SERIES)


def test_bad_input():
    with pytest.raises(ValueError, match="contains NaN"):
        CrawlerReservoir().fit([[0.0], [np.nan]])
    with pytest.raises(NotFittedError):
        CrawlerReservoir().transform(SERIES)
    with pytest.raises(ValueError, match="X has 2 features, but CrawlerReservoir is expecting 1"):
        CrawlerReservoir().fit(SERIES).transform(np.zeros((3, 2)))
    with pytest.raises(ValueError, match="input_features should have length equal to 1, got 2"):
        CrawlerReservoir().fit(SERIES).get_feature_names_out(["a", "b"])


def test_a_past_beyond_the_range_is_no_news_to_who_transforms():
    """What is said of a transform is said of what is transformed, however the body came there."""
    reservoir = CrawlerReservoir(input_range=(0.25, 0.75), carry_on=True, washout=2, virtual_nodes=1).fit(SERIES)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        gentle = reservoir.transform(np.full(3, 0.5))
    with pytest.warns(UserWarning, match="1 of 3 values") as told:
        reservoir.transform([[0.5], [0.5], [1.0]])
    assert len(told) == 1
    assert gentle.shape == (3, 3)
