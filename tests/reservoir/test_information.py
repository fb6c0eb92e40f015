import warnings

import numpy as np
import plain_reservoir as plain
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from stickslip.reservoir import delay_line, EchoStateNetwork, information_processing_capacity
from stickslip.reservoir.product_basis import count_terms, legendre_polynomials, products, terms, walsh
from stickslip.reservoir.significance import tail_quantile


def bits(samples, seed=0, p=0.5):
    return (np.random.default_rng(seed).random(samples) < p).astype(float)


def signs(samples, seed=0):
    return 2 * bits(samples, seed) - 1


@pytest.mark.parametrize("threshold", ["chi-squared", "surrogates"])
@pytest.mark.parametrize("taps", [1, 6])
def test_a_delay_line_has_as_much_linear_capacity_as_taps_and_no_other(taps, threshold):
    u = bits(4000)
    capacity = information_processing_capacity(delay_line(u, taps), u, threshold=threshold, delays=20)
    assert capacity.terms == tuple(((delay, 1),) for delay in range(taps))
    assert capacity.total == pytest.approx(taps, abs=1e-9)
    assert capacity.by_degree() == pytest.approx({1: taps, 2: 0, 3: 0}, abs=1e-9)
    assert capacity.rank == taps
    assert capacity.nonlinear_share == 0


def test_distinct_linear_modes_fill_their_rank_with_linear_capacity():
    u = bits(50_000)
    states = np.column_stack([lfilter([1], [1, -pole], u) for pole in (0.2, -0.5, 0.8)])
    capacity = information_processing_capacity(states, u, max_degree=2, delays=40)
    assert capacity.total == pytest.approx(3, abs=0.01)
    assert set(capacity.degree) == {1}


def test_the_products_of_a_delay_line_are_found_one_by_one():
    """The states are mixed, so that no single one of them is any of the functions."""
    z = signs(5000)
    line = delay_line(z, 6)
    computed = [line[:, 0] * line[:, 1], line[:, 2], line[:, 0] * line[:, 3] * line[:, 5]]
    states = np.column_stack(computed) @ np.random.default_rng(1).normal(size=(3, 3))
    capacity = information_processing_capacity(states, z)
    assert capacity.terms == (((2, 1),), ((0, 1), (1, 1)), ((0, 1), (3, 1), (5, 1)))
    np.testing.assert_allclose(capacity.capacity, 1, atol=0.005)
    assert capacity.degree.tolist() == [1, 2, 3]
    assert capacity.delay.tolist() == [2, 1, 5]
    assert capacity.nonlinear_share == pytest.approx(2 / 3, abs=0.002)
    profile = capacity.profile()
    np.testing.assert_allclose(profile[2][:3], [0, 1, 0], atol=0.005)
    assert profile[3].argmax() == 5
    assert sum(degree.sum() for degree in profile.values()) == pytest.approx(capacity.total)


def test_exclusive_or_of_two_delays_is_one_function_of_degree_two():
    u = bits(4000).astype(int)
    late, later = np.roll(u, 2), np.roll(u, 5)
    capacity = information_processing_capacity((late ^ later)[:, None], u)
    assert capacity.terms == (((2, 1), (5, 1)),)
    # The share of ones is that of the sample, and the bits as good as fair.
    assert capacity.total == pytest.approx(1, abs=0.002)


def test_a_majority_has_the_spectrum_of_a_majority():
    """Of three bits: (a + b + c - abc) / 2, so three times 1/4 in degree one and 1/4 in degree three."""
    u = bits(20_000)
    majority = (delay_line(u, 3).sum(axis=1) >= 2)[:, None]
    capacity = information_processing_capacity(majority, u)
    assert capacity.by_degree() == pytest.approx({1: 0.75, 2: 0, 3: 0.25}, abs=0.02)
    assert capacity.total == pytest.approx(1, abs=0.002)


@pytest.mark.parametrize("p", [0.1, 0.5, 0.8])
def test_biased_bits_have_a_complete_basis_too(p):
    """Four functions of two bits, less the constant."""
    u = bits(20_000, p=p)
    line = delay_line(u, 2)
    states = np.column_stack([line, line[:, 0] * line[:, 1]])
    capacity = information_processing_capacity(states, u, delays=5)
    assert capacity.total == pytest.approx(3, abs=1e-9)
    assert capacity.by_degree()[2] == pytest.approx(1, abs=0.01)


def test_the_innovations_of_a_dithered_valve_are_bits():
    rng = np.random.default_rng(0)
    command = np.arange(8000) // 3 % 2
    innovation = (command ^ (rng.random(8000) < 0.2)) - np.where(command == 1, 0.8, 0.2)
    assert len(np.unique(innovation.round(12))) == 4
    z = walsh(innovation)
    assert (z**2).mean() == pytest.approx(1, abs=0.05)
    line = delay_line(innovation, 3)
    states = np.column_stack([line[:, 1], line[:, 0] * line[:, 2]])
    capacity = information_processing_capacity(states, innovation, max_degree=2, delays=10)
    assert capacity.terms == (((1, 1),), ((0, 1), (2, 1)))
    assert capacity.total == pytest.approx(2, abs=0.01)


def test_legendre_polynomials_are_told_apart_by_degree():
    u = np.random.default_rng(0).uniform(3, 5, 6000)
    x = u - 4
    states = np.column_stack([x**2, 5 * x**3 - 3 * x, np.roll(x, 1) * x])
    capacity = information_processing_capacity(states, u, basis="legendre", support=(3, 5), delays=8)
    assert capacity.terms == (((0, 2),), ((0, 1), (1, 1)), ((0, 3),))
    np.testing.assert_allclose(capacity.capacity, 1, atol=0.01)


def test_legendre_polynomials_are_orthonormal():
    """By Gauss's rule, which is exact for these degrees."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    rows = legendre_polynomials(nodes, 6, (-1, 1))
    np.testing.assert_allclose((rows * weights / 2) @ rows.T, np.eye(6), atol=1e-13)


@pytest.mark.parametrize("threshold", ["chi-squared", "surrogates"])
@pytest.mark.parametrize("features", [1, 20])
def test_noise_computes_nothing(features, threshold):
    noise = np.random.default_rng(2).normal(size=(3000, features))
    capacity = information_processing_capacity(noise, bits(3000), threshold=threshold, delays=12, max_degree=2)
    # A significance of 1e-4 lets a function in a hundred runs of these by.
    assert capacity.terms == ()
    assert capacity.total == 0
    assert np.isnan(capacity.nonlinear_share)
    assert capacity.rank == features


@pytest.mark.parametrize("threshold", ["chi-squared", "surrogates"])
def test_chance_passes_as_often_as_the_significance_says(threshold):
    noise = np.random.default_rng(3).normal(size=(6000, 5))
    u = bits(6000)
    capacity = information_processing_capacity(
        noise, u, threshold=threshold, significance=0.05, max_degree=2, patience=None
    )
    tried = sum(capacity.tried.values())
    assert tried > 1000
    assert abs(len(capacity.terms) - 0.05 * tried) < 5 * np.sqrt(0.05 * tried)
    assert capacity.thresholds[2] == pytest.approx(11.07 / 5800, rel=0.1)
    by_law = information_processing_capacity(noise, u, significance=0.05, max_degree=2).thresholds[2]
    assert by_law == pytest.approx(11.07 / 5800, rel=1e-3)


@settings(max_examples=15, deadline=None)
@given(st.integers(1, 8), st.integers(60, 400), st.floats(0.3, 1.5), st.integers(0, 2**32 - 1))
def test_the_total_is_at_most_the_rank_however_short_the_series(features, samples, scaling, seed):
    """At a significance that lets chance pass freely, hundreds of functions are found."""
    u = bits(samples, seed)
    states = EchoStateNetwork(features, input_scaling=scaling, seed=seed % 1000).states(u)
    capacity = information_processing_capacity(
        states, u, washout=20, delays=10, threshold="surrogates", significance=0.5, patience=None
    )
    assert len(capacity.terms) > features
    assert capacity.total <= capacity.rank + 1e-9
    assert ((capacity.capacity >= 0) & (capacity.capacity <= 1)).all()


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(-6, 6))
def test_neither_units_nor_mixing_nor_copies_of_states_matter(seed, power):
    rng = np.random.default_rng(seed)
    u = bits(1500, seed)
    states = EchoStateNetwork(5, input_scaling=0.8, seed=seed % 1000).states(u)
    mixing = np.linalg.qr(rng.normal(size=(5, 5)))[0]
    arguments = {"delays": 8, "washout": 50}
    reference = information_processing_capacity(states, u, **arguments)
    mixed = np.column_stack([states @ mixing * 10.0**power + 3, states[:, 0]])
    other = information_processing_capacity(mixed, 7 * u - 2, **arguments)
    assert other.terms == reference.terms
    assert other.rank == reference.rank
    np.testing.assert_allclose(other.capacity, reference.capacity, atol=1e-6)


@pytest.mark.parametrize("threshold", ["chi-squared", "surrogates"])
def test_one_factor_on_all_states_changes_nothing(threshold):
    u = bits(1000)
    states = EchoStateNetwork(5, input_scaling=0.8).states(u)
    one = information_processing_capacity(states, u, delays=8, threshold=threshold)
    for power in (-600, -20, 500):
        other = information_processing_capacity(2.0**power * states, u, delays=8, threshold=threshold)
        np.testing.assert_array_equal(other.capacity, one.capacity)
        assert (other.terms, other.rank) == (one.terms, one.rank)


@pytest.mark.parametrize(("degree", "latest", "highest"), [(1, 0, 1), (3, 6, 1), (3, 4, 3), (5, 3, 2), (2, 0, 1)])
def test_terms_are_counted_and_come_once(degree, latest, highest):
    found = list(terms(degree, latest, highest))
    assert len(set(found)) == len(found) == count_terms(degree, latest, highest)
    for term in found:
        delays = [delay for delay, _ in term]
        assert delays == sorted(set(delays))
        assert delays[-1] == latest
        assert sum(each for _, each in term) == degree
        assert max(each for _, each in term) <= highest


def test_products_by_hand():
    functions = np.array([[1.0, 2, 3, 4], [10, 20, 30, 40]])
    rows = products(functions, [((1, 1),), ((0, 2), (2, 1))], 2)
    np.testing.assert_array_equal(rows, [[2, 3], [30, 80]])


def test_a_budget_that_is_spent_is_said():
    u = bits(2000)
    states = delay_line(u, 15)
    with pytest.warns(UserWarning, match="budget of 60 functions was spent; not tried: degree 2 from delay 10 on"):
        capacity = information_processing_capacity(states, u, max_degree=2, delays=15, budget=60)
    assert capacity.tried == {1: 15, 2: 45}
    assert capacity.reach == {1: 14, 2: 9}


def test_patience_waits_for_a_late_echo():
    u = bits(3000)
    states = np.roll(u, 30)[:, None]
    assert information_processing_capacity(states, u, max_degree=1).total == 0
    assert information_processing_capacity(states, u, max_degree=1, patience=None).terms == (((30, 1),),)


def test_too_short_to_tell_is_said():
    u = bits(300)
    states = np.random.default_rng(0).normal(size=(300, 60))
    with pytest.warns(UserWarning, match="no capacity below 0.83 can be told from chance with 100 samples"):
        information_processing_capacity(states, u, max_degree=1)


def innovations(samples, dither, seed=0):
    return (np.random.default_rng(seed).random(samples) < dither) - dither


@pytest.mark.parametrize("threshold", ["chi-squared", "surrogates"])
@pytest.mark.parametrize("dither", [0.1, 0.02])
@pytest.mark.parametrize("seed", range(2))
def test_products_of_four_innovations_are_of_no_lower_degree(dither, threshold, seed):
    """The capacity at degrees 1 to 3 is 0; a law for constant squares gave 0.86 at degree 3, or 3 of 4 at 0.02."""
    e = innovations(10_000, dither, seed)
    line = delay_line(e, 8)
    products_of_four = np.column_stack([line[:, i : i + 4].prod(axis=1) for i in range(4)])
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "[0-9]+ functions explain more than chance", UserWarning)
        capacity = information_processing_capacity(products_of_four, e, delays=12, threshold=threshold)
    assert capacity.by_degree() == {1: 0, 2: 0, 3: 0}


def test_what_rests_on_too_few_events_is_said():
    e = innovations(3000, 0.02)
    line = delay_line(e, 2)
    arguments = {"max_degree": 2, "delays": 4}
    rare = plain.information(line.prod(axis=1)[:, None], e, **arguments)["rare"]
    assert rare > 1
    with pytest.warns(
        UserWarning, match=rf"^{rare} functions explain more than chance, but on fewer than [78][0-9][0-9] "
    ):
        information_processing_capacity(line.prod(axis=1)[:, None], e, **arguments)
    fair = information_processing_capacity(delay_line(signs(3000), 2).prod(axis=1)[:, None], signs(3000), delays=4)
    assert fair.total == pytest.approx(1, abs=0.01)


@pytest.mark.parametrize("basis", ["walsh", "legendre"])
@pytest.mark.parametrize("kind", ["white", "slow", "heavy"])
def test_chance_passes_seldom_whatever_the_law_of_the_states(kind, basis):
    """At 0.01; 1800 functions let 18 by, with standard deviation 4."""
    passed = tried = 0
    for seed in range(4):
        rng = np.random.default_rng(seed)
        u = innovations(1200, 0.2, seed) if basis == "walsh" else rng.uniform(-1, 1, 1200)
        noise = rng.normal(size=(1200, 8)) if kind != "heavy" else rng.standard_t(2, size=(1200, 8))
        states = lfilter([1], [1, -0.99], noise, axis=0) if kind == "slow" else noise
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            capacity = information_processing_capacity(
                states, u, basis=basis, max_degree=2, delays=30, significance=0.01, patience=None
            )
        tried += sum(capacity.tried.values())
        passed += len(capacity.terms)
    assert passed < 2 * 0.01 * tried + 5 * np.sqrt(0.01 * tried)


def noisy_line(taps, samples, seed):
    """A share of 1/2 of each of so many bits."""
    z = signs(samples, seed)
    return z, delay_line(z, taps) + np.random.default_rng(seed + 1000).normal(size=(samples, taps))


def test_chance_is_taken_off_what_is_found():
    """60 states that hold half a bit each: 30.7 without."""
    totals, raw = [], []
    for seed in range(5):
        z, states = noisy_line(60, 1400, seed)
        capacity = information_processing_capacity(states, z, max_degree=1, delays=60)
        totals.append(capacity.total)
        raw.append(np.sum(1 - (1 - capacity.capacity) * (1 - capacity.chance)))
    assert np.mean(totals) == pytest.approx(30, abs=0.2)
    assert np.mean(raw) > 30.5
    assert capacity.chance[0] == pytest.approx(60 / 1200, rel=0.01)
    assert capacity.chance.mean() == pytest.approx(30 / 1200, rel=0.1)


def test_intervals_hold_the_truth_as_often_as_they_say():
    """90 of 100 would have standard deviation 3."""
    totals = each = 0
    for seed in range(100):
        z, states = noisy_line(4, 800, seed)
        capacity = information_processing_capacity(states, z, max_degree=1, delays=6, confidence=0.9)
        totals += capacity.total_interval[0] < 2 < capacity.total_interval[1]
        each += capacity.capacity_interval[0, 0] < 0.5 < capacity.capacity_interval[1, 0]
        assert capacity.total_interval[0] <= capacity.total <= capacity.total_interval[1]
    assert 90 - 4 * 3 < totals <= 100
    assert 90 - 4 * 3 < each <= 100


def test_a_value_that_never_comes_up_is_no_error():
    """Three of the four values of an innovation, as in a short run at a small dither."""
    command = np.arange(400) // 5 % 2
    flips = np.zeros(400, dtype=int)
    flips[[150, 251, 350]] = 1 - command[[150, 251, 350]]
    innovation = (command ^ flips) - np.where(command == 1, 0.99, 0.01)
    assert len(np.unique(innovation.round(12))) == 3
    np.testing.assert_allclose(walsh(innovation)[0], innovation / np.sqrt(0.01 * 0.99))
    states = np.random.default_rng(0).normal(size=(400, 2))
    assert information_processing_capacity(states, innovation, delays=5, washout=10).total == 0
    with pytest.raises(ValueError, match="two values for the Walsh basis"):
        walsh(np.array([-1.0, 0.0, 1.0]))


def test_sensors_that_are_noisy_leave_less():
    z = signs(5000)
    line = delay_line(z, 4) * [1, 10, 100, 1000]
    totals = [information_processing_capacity(line, z, max_degree=1, noise=db).total for db in (None, 60.0, 0.0)]
    # Noise of a signal's own variance takes half of it.
    assert totals == pytest.approx([4, 4, 2], abs=0.1)


def test_shuffles_too_few_for_the_significance_are_refused():
    u = bits(1000)
    states = delay_line(u, 2)
    with pytest.raises(
        ValueError, match=r"surrogates must be 125 at least for a significance of 0\.0001 with 8 functions"
    ):
        information_processing_capacity(states, u, threshold="surrogates", delays=8, surrogates=20)


@pytest.mark.parametrize("scale", [1.0, 0.3])
def test_a_fitted_tail_reaches_beyond_its_sample(scale):
    """Of an exponential law, from a thousand values: the 1e-4 quantile is ln(1e4)."""
    found = [tail_quantile(np.random.default_rng(seed).exponential(scale, 1000), 1e-4) / scale for seed in range(200)]
    assert np.mean(np.exp(-np.array(found))) < 3e-4
    assert np.median(found) == pytest.approx(np.log(1e4), rel=0.15)
    many = np.random.default_rng(0).exponential(scale, 200_000)
    assert tail_quantile(many, 1e-3) == pytest.approx(scale * np.log(1e3), rel=0.05)


def test_states_that_never_move_compute_nothing():
    capacity = information_processing_capacity(np.full((500, 2), 0.3), bits(500))
    assert (capacity.total, capacity.rank) == (0, 0)


@pytest.mark.parametrize(
    ("change", "error", "text"),
    [
        ({"states": np.zeros(500)}, ValueError, "states must be 2-dimensional"),
        ({"inputs": bits(499)}, ValueError, "inputs must have as many samples as states, 500, got 499"),
        ({"inputs": np.ones(500)}, ValueError, "inputs must vary, .* got 1.0 throughout"),
        ({"inputs": np.full(500, np.inf)}, ValueError, r"inputs must be finite, got inf at index \(0,\)"),
        ({"inputs": np.linspace(0, 1, 500)}, ValueError, "two values for the Walsh basis, .* got 500; .*legendre"),
        ({"basis": "fourier"}, ValueError, "basis has no 'fourier'"),
        ({"basis": "legendre", "support": (0.5, 2)}, ValueError, "support must hold all inputs, from 0.0 to 1.0"),
        ({"threshold": "luck"}, ValueError, "threshold has no 'luck'"),
        ({"max_degree": 0}, ValueError, "max_degree must be a whole number >= 1, got 0"),
        ({"delays": [5, 5]}, ValueError, "delays must be one number or one for each of 3 degrees, got 2"),
        ({"delays": 2.5}, TypeError, "delays must be a whole number >= 1, got 2.5"),
        ({"washout": 495}, ValueError, "states must have at least 505 samples for 8 features, washout=495"),
        ({"delays": 600}, ValueError, "at least 609 samples for 8 features, washout=200 and 600 delays, got 500"),
        ({"budget": 0}, ValueError, "budget must be a whole number >= 1, got 0"),
        ({"patience": 0}, ValueError, "patience must be a whole number >= 1, got 0"),
        ({"significance": 1.0}, ValueError, r"significance must be in \(0, 1\), got 1.0"),
    ],
)
def test_bad_input(change, error, text):
    good = {"states": np.random.default_rng(0).normal(size=(500, 8)), "inputs": bits(500), "delays": 5}
    information_processing_capacity(**good)
    with pytest.raises(error, match=text):
        information_processing_capacity(**{**good, **change})


@pytest.mark.parametrize("scale", [1.0, 1e6])
def test_inputs_are_of_one_value_up_to_a_billionth_of_their_spread(scale):
    """Of values that differ by less, whatever their unit; sizes of innovations likewise."""
    rng = np.random.default_rng(0)
    high = rng.random(400) < 0.3
    jitter = np.where(rng.random(400) < 0.5, 1e-9, 0)
    p = high.mean()
    expected = np.where(high, np.sqrt((1 - p) / p), -np.sqrt(p / (1 - p)))
    np.testing.assert_allclose(walsh(scale * (2 + 3 * high + 3 * 0.9 * jitter))[0], expected)
    with pytest.raises(ValueError, match=r"^inputs must have two values for the Walsh basis, .*got 4;"):
        walsh(scale * (2 + 3 * high + 3 * 1.1 * jitter))
    innovation = np.where(rng.random(400) < 0.5, 1, -1) * np.where(high, 0.7, 0.3)
    spread = 1.4 * jitter * (innovation > 0)
    np.testing.assert_allclose(walsh(scale * (innovation + 0.9 * spread))[0], innovation / np.sqrt(0.21), rtol=1e-8)
    with pytest.raises(ValueError, match=r"got 6;"):
        walsh(scale * (innovation + 1.1 * spread))
    # Zero is no size of an innovation, and three sizes are none of a bit's.
    for values in ([0.0, 0.5, -0.5], [0.1, 0.2, -0.3], [0.1, -0.1, 0.2, -0.2, 0.3]):
        with pytest.raises(ValueError, match=f"got {len(values)};"):
            walsh(scale * np.array(values))


@pytest.mark.parametrize("support", [(-1.0, 0.4), (-0.4, 1.0), (0.5, 0.5), (1.0, -1.0)])
def test_a_support_holds_all_inputs(support):
    inputs = np.array([-0.5, 0.5])
    with pytest.raises(ValueError, match=r"^support must hold all inputs, from -0.5 to 0.5, got \("):
        legendre_polynomials(inputs, 2, support)
    # Its ends may be inputs.
    np.testing.assert_allclose(legendre_polynomials(inputs, 2, (-0.5, 0.5)), np.sqrt([[3], [5]]) * [[-1, 1], [1, 1]])
    np.testing.assert_array_equal(legendre_polynomials(inputs, 2), legendre_polynomials(inputs, 2, (-0.5, 0.5)))
