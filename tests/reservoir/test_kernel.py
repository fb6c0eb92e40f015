import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stickslip.reservoir import delay_line, EchoStateNetwork, kernel_quality, ranks, state_rank


@pytest.mark.parametrize(("taps", "shared"), [(8, 0), (8, 3), (8, 8), (5, 20)])
def test_a_delay_line_tells_apart_all_that_it_holds(taps, shared):
    """The taps that hold what is shared stand still, and the others do not."""
    quality = kernel_quality(lambda u: delay_line(u, taps), inputs=60, length=40, shared=shared)
    assert quality.kernel_rank == taps
    assert quality.generalisation_rank == max(taps - shared, 0)
    assert quality.difference == min(taps, shared)


def test_a_memoryless_reservoir_tells_two_inputs_apart_and_forgets_the_rest():
    quality = kernel_quality(lambda u: np.column_stack([u, u**2, np.exp(u)]), inputs=30, length=5, shared=1)
    assert (quality.kernel_rank, quality.generalisation_rank) == (1, 0)


def test_the_threshold_is_the_noise_at_which_directions_drown():
    """A mode of 1e-4 the size of another, in the same unit, counts below that and not above."""
    rng = np.random.default_rng(0)
    common, small = rng.normal(size=(2, 500))
    states = np.column_stack([common + 1e-4 * small, common - 1e-4 * small])
    assert ranks(states, states, threshold=1e-5).kernel_rank == 2
    assert ranks(states, states, threshold=1e-3).kernel_rank == 1
    np.testing.assert_allclose(ranks(states, states).kernel_singular_values, [np.sqrt(2), np.sqrt(2) * 1e-4], rtol=0.1)


def test_what_is_similar_is_measured_in_the_units_of_what_is_different():
    rng = np.random.default_rng(0)
    different = rng.normal(size=(100, 4))
    assert ranks(different, 1e-6 * rng.normal(size=(100, 4))).generalisation_rank == 0
    assert ranks(different, 1e-2 * rng.normal(size=(100, 4))).generalisation_rank == 4


@settings(max_examples=20, deadline=None)
@given(st.integers(1, 6), st.integers(-6, 6), st.integers(0, 2**32 - 1))
def test_neither_units_nor_offset_nor_order_of_features_matter(rank, power, seed):
    rng = np.random.default_rng(seed)
    different, similar = rng.normal(size=(2, 50, rank)) @ rng.normal(size=(rank, 6))
    similar[:, 0] = 1
    one = ranks(different, similar)
    order = rng.permutation(6)
    other = ranks(different[:, order] * 10.0**power + 3, similar[:, order] * 10.0**power + 3)
    assert (one.kernel_rank, one.generalisation_rank) == (other.kernel_rank, other.generalisation_rank)
    np.testing.assert_allclose(other.kernel_singular_values, one.kernel_singular_values, atol=1e-6)


def test_a_chaotic_network_generalises_worse_than_one_that_forgets():
    calm, wild = (
        kernel_quality(EchoStateNetwork(20, spectral_radius=radius, input_scaling=0.5).states, inputs=60, shared=15)
        for radius in (0.5, 3.0)
    )
    assert calm.difference > wild.difference
    assert wild.generalisation_rank > calm.generalisation_rank


def test_the_generalisation_rank_is_a_mean_over_endings():
    rng = np.random.default_rng(0)
    different, one, other = rng.normal(size=(3, 40, 4))
    other[:, 1:] = 0
    assert ranks(different, one).generalisation_rank == 4
    assert ranks(different, [one, other, other]).generalisation_rank == 2
    assert ranks(different, [one, other]).generalisation_singular_values.shape == (2, 4)
    single, many = (
        [
            kernel_quality(
                EchoStateNetwork(12, input_scaling=0.3).states, inputs=26, length=60, endings=endings, seed=seed
            ).generalisation_rank
            for seed in range(6)
        ]
        for endings in (1, 5)
    )
    assert np.std(many) < np.std(single)


@pytest.mark.parametrize("db", [20.0, 60.0])
def test_directions_below_the_noise_of_the_sensors_do_not_count(db):
    """Two readings that differ by a known share of their common signal."""
    rng = np.random.default_rng(0)
    common, small = rng.normal(size=(2, 2000))
    noise = 10 ** (-db / 20)
    for share, rank in ((0.5 * noise, 1), (2 * noise, 2)):
        states = 7 * np.column_stack([common + share * small, common - share * small]) - 3
        assert state_rank(states, noise=db) == ranks(states, states, noise=db).kernel_rank == rank
    assert state_rank(states) == 2
    assert ranks(states, states, noise=db).threshold == pytest.approx(noise / np.sqrt(2), rel=0.05)


def test_states_that_never_move_have_no_rank():
    quality = ranks(np.ones((5, 3)), np.zeros((5, 3)))
    assert (quality.kernel_rank, quality.generalisation_rank) == (0, 0)


def test_too_few_inputs_are_said_to_be_few():
    with pytest.warns(UserWarning, match="different has 4 inputs, whose states cannot span more than 3 directions"):
        kernel_quality(lambda u: delay_line(u, 9), inputs=4, length=20, shared=20)


def test_bad_input():
    states = np.zeros((5, 2))
    with pytest.raises(ValueError, match="similar must have as many features as different, 2, got 3"):
        ranks(states, np.zeros((5, 3)))
    with pytest.raises(ValueError, match="different must hold the states of two inputs at least, got 1"):
        ranks(states[:1], states)
    with pytest.raises(ValueError, match=r"similar must be finite, got nan at index \(0, 0\)"):
        ranks(states, states * np.nan)
    with pytest.raises(ValueError, match=r"threshold must be in \(0, 1\), got 1.0"):
        ranks(states, states, threshold=1.0)
    with pytest.raises(ValueError, match=r"shared must be a whole number in \[0, 10\], got 11"):
        kernel_quality(lambda u: u[:, None], inputs=5, length=10, shared=11)
    with pytest.raises(ValueError, match="the reservoir must return a row of states an input, 10, got 9"):
        kernel_quality(lambda u: u[1:, None], inputs=5, length=10, shared=1)
    with pytest.raises(ValueError, match="the reservoir's states must be 2-dimensional"):
        kernel_quality(lambda u: u, inputs=5, length=10, shared=1)
