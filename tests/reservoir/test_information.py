import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from stickslip.reservoir import delay_line, EchoStateNetwork, information_processing_capacity
from stickslip.reservoir.product_basis import count_terms, legendre_polynomials, products, terms, walsh


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


def test_without_the_factor_two_chance_passes_as_often_as_the_significance_says():
    """The threshold at 0.05 is twice the quantile, so what passes half of it is binomial."""
    noise = np.random.default_rng(3).normal(size=(6000, 5))
    u = bits(6000)
    capacity = information_processing_capacity(
        noise, u, threshold="surrogates", significance=0.05, max_degree=2, patience=None
    )
    tried = sum(capacity.tried.values())
    assert tried > 1000
    assert abs(len(capacity.terms) - 0.05 * tried) < 5 * np.sqrt(0.05 * tried)
    assert capacity.thresholds[2] == pytest.approx(11.07 / 5800, rel=0.1)
    doubled = information_processing_capacity(noise, u, significance=0.05, max_degree=2).thresholds[2]
    assert doubled == pytest.approx(2 * 11.07 / 5800, rel=1e-3)


@settings(max_examples=15, deadline=None)
@given(st.integers(1, 8), st.integers(60, 400), st.floats(0.3, 1.5), st.integers(0, 2**32 - 1))
def test_the_total_is_at_most_the_rank_however_short_the_series(features, samples, scaling, seed):
    """At a significance that lets chance pass freely, hundreds of functions are found."""
    u = bits(samples, seed)
    states = EchoStateNetwork(features, input_scaling=scaling, seed=seed % 1000).states(u)
    capacity = information_processing_capacity(
        states, u, washout=20, delays=10, threshold="surrogates", significance=0.5, surrogates=2, patience=None
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
    with pytest.warns(UserWarning, match="no capacity below 1.00 can be told from chance with 100 samples"):
        information_processing_capacity(states, u, max_degree=1)


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
