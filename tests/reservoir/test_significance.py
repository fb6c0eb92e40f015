"""What chance explains, against draws of it and at the edges of its rules."""

import warnings

import numpy as np
import pytest
from scipy import stats

from stickslip.reservoir import (
    delay_line,
    information_processing_capacity,
    kernel_quality,
    mean_over_runs,
    memory_capacity,
    ranks,
)
from stickslip.reservoir.decomposition import intervals, sequential_capacity, SequentialCapacity
from stickslip.reservoir.orthonormal import orthonormal_basis
from stickslip.reservoir.significance import chance, effective_events, events_needed, tail_quantile


def heavy(samples, features, seed=0):
    """An orthonormal basis of states with outliers."""
    return orthonormal_basis(np.random.default_rng(seed).standard_t(3, size=(samples, features)))


def shares(q, rows):
    return np.sum((rows @ q) ** 2, axis=1) / np.sum(rows**2, axis=1)


@pytest.mark.parametrize("significance", [0.1, 0.01])
@pytest.mark.parametrize("uneven", [0.0, 0.8])
def test_the_cutoff_is_a_quantile_of_what_random_signs_are_explained(uneven, significance):
    """Rows of given sizes and fair signs, which states cannot know."""
    rng = np.random.default_rng(1)
    q = orthonormal_basis(rng.normal(size=(400, 6)))
    size = np.exp(uneven * rng.normal(size=400))
    drawn = shares(q, size * rng.choice([-1.0, 1.0], (20_000, 400)))
    found = chance(q, (size * np.tile([1, -1], 200))[None], significance)
    assert 0.65 * significance < np.mean(drawn > found.cutoff[0]) < 1.25 * significance
    assert found.mean[0] == pytest.approx(drawn.mean(), rel=0.03)


def test_shares_that_are_given_change_no_verdict():
    """And those in doubt get the very cutoff; others one on their side of it."""
    q, rng = heavy(300, 4), np.random.default_rng(2)
    rows = np.concatenate(
        [rng.standard_t(3, (60, 300)), rng.choice([-1.0, 1.0], (20, 300)), 5 * q.T, np.ones((1, 300))]
    )
    explained = np.append(shares(q, (rows - rows.mean(axis=1, keepdims=True))[:-1]), 0.5)
    for significance in (0.3, 0.05, 1e-4):
        exact, quick = (chance(q, rows, significance, *given) for given in ((), (explained,)))
        np.testing.assert_array_equal(explained > quick.cutoff, explained > exact.cutoff)
        np.testing.assert_array_equal(quick.mean, exact.mean)
        doubtful = (explained > quick.cutoff * 0.999) & (quick.cutoff < 1)
        assert doubtful.any()
        assert (quick.cutoff <= 1).all()
    # What does not move has the mean share of any, and the cutoff of what is constant in size.
    law = stats.beta(2, (300 - 1 - 4) / 2)
    assert exact.mean[-1] == 4 / 300
    assert exact.cutoff[-1] == pytest.approx(law.isf(1e-4))


def test_sizes_that_differ_by_a_tenth_count_as_constant_and_others_do_not():
    q = orthonormal_basis(np.random.default_rng(0).normal(size=(40, 3)))
    law = stats.beta(3 / 2, (40 - 1 - 3) / 2).isf(1e-3)
    for spread, constant in ((0.099, True), (0.101, False)):
        # Half of the squares are larger and half smaller by the spread, signs of either among both.
        square = 1 + spread * np.repeat([1, -1], 20)
        plain = max(1, np.sum(q**2, axis=1) @ square / 3) * law
        found = chance(q, (np.tile([1.0, -1.0], 20) * np.sqrt(square))[None], 1e-3).cutoff[0]
        assert found == pytest.approx(plain, rel=1e-9) if constant else found > 1.01 * plain


def test_effective_events_by_hand():
    q = heavy(200, 3)
    rows = np.random.default_rng(0).normal(size=(2, 200)) + 1
    for row, found in zip(rows, effective_events(q, rows), strict=True):
        y = row - row.mean()
        alone = [q[k] @ (q.T @ y - q[k] * y[k]) * y[k] for k in range(200)]
        assert found == pytest.approx(np.sum(np.square(alone)) ** 2 / np.sum(np.power(alone, 4)))
    assert effective_events(q, np.ones((1, 200))) == [0]


def test_events_needed_by_hand():
    """Twice the logarithm, of the function with the largest fourth moment; 1 for fair signs."""
    signs = np.array([[1.0, -1, 1, -1]])
    assert events_needed(signs, 1e-4) == pytest.approx(2 * np.log(1e4))
    rare = np.array([[3.0, 0, 0, 0]])
    assert events_needed(np.concatenate([signs, rare]), 0.01) == pytest.approx(2 * np.log(100) * 4)


def hosking(values, significance):
    """The tail of Hosking and Wallis (1987), in their signs: x(F) = scale (1 - (1 - F)^k) / k above the start."""
    ordered = np.sort(values)
    count = len(values) // 10
    start, excess = ordered[-count - 1], ordered[-count:] - ordered[-count - 1]
    a0 = excess.mean()
    a1 = np.mean([(1 - (j - 0.35) / count) * each for j, each in enumerate(excess, 1)])
    k, scale = a0 / (a0 - 2 * a1) - 2, 2 * a0 * a1 / (a0 - 2 * a1)
    beyond = significance * len(values) / count
    return start + (scale * (1 - beyond**k) / k if k < 0 else -scale * np.log(beyond))


@pytest.mark.parametrize(
    "law",
    [stats.t(3), stats.expon(), stats.uniform(), stats.genpareto(0.4)],
    ids=["Student", "exponential", "uniform", "Pareto"],
)
def test_a_fitted_tail_is_that_of_hosking_and_wallis(law):
    """No shorter than an exponential one."""
    values = law.rvs(1234, random_state=np.random.default_rng(0))
    for significance in (1e-3, 1e-5):
        assert tail_quantile(values, significance) == pytest.approx(hosking(values, significance), rel=1e-9)


def test_ten_values_beyond_a_quantile_are_enough():
    values = np.random.default_rng(0).exponential(size=1000)
    assert tail_quantile(values, 0.01) == np.quantile(values, 0.99)
    assert tail_quantile(values, 0.0099) == pytest.approx(hosking(values, 0.0099))
    assert tail_quantile(np.full(1000, 0.3), 1e-4) == 0.3


def test_a_function_that_is_nothing_new_adds_nothing():
    q = heavy(300, 4)
    rows = np.random.default_rng(0).normal(size=(3, 300)) + 40 * q[:, :3].T + 2
    copied = np.vstack([rows[0], 3 * rows[0] + 1, rows[1], rows[0] - rows[1], rows[2]])
    found = sequential_capacity(q, copied, 20)
    # A copy's rounding takes one direction of three hundred from those after it.
    np.testing.assert_allclose(found.capacity[[0, 2, 4]], sequential_capacity(q, rows, 20).capacity, rtol=0.05)
    assert not found.capacity[[1, 3]].any()
    assert not found.influence[[1, 3]].any()
    # More functions than samples span them all, and no more.
    many = sequential_capacity(q[:30], np.random.default_rng(1).normal(size=(40, 30)), 5)
    assert many.capacity.shape == many.chance.shape == (40,)
    assert not many.capacity[30:].any()
    empty = sequential_capacity(q, np.zeros((0, 300)), 7)
    assert (empty.capacity.shape, empty.influence.shape) == ((0,), (0, 42))
    ends, total = intervals(empty, 0.95, 4)
    assert (ends.shape, total) == ((2, 0), (0.0, 0.0))


def said(call):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        call()
    return [str(each.message) for each in caught]


def test_warnings_begin_where_they_say():
    bits = np.random.default_rng(0).integers(0, 2, 2000).astype(float)
    noise = np.random.default_rng(1).normal(size=(2000, 20))

    def memory(training, **options):
        return said(lambda: memory_capacity(noise[: 2 * training], bits[: 2 * training], 1, washout=0, **options))

    assert memory(100) == []
    (text,) = memory(99)
    assert text == (
        "the readout is fitted on 99 samples of 20 independent states: below 5 samples a state it misses much of the "
        "memory that is there"
    )
    few = lambda samples: said(lambda: memory_capacity(noise[:samples, :4], signs[:samples], 1, washout=0))  # noqa: E731
    signs = np.tile([1.0, -1.0], 1000)
    # Fair signs have kurtosis 1, and ask for ln(1e4) = 9.2 scored samples.
    assert [text for text in few(20) if "moves so seldom" in text] == []
    (text,) = [text for text in few(18) if "moves so seldom" in text]
    assert text.startswith("9 scored samples are few for a message that moves so seldom: below some 9 a state that")

    def information(samples):
        return said(
            lambda: information_processing_capacity(noise[:samples], bits[:samples], washout=0, delays=1, max_degree=1)
        )

    assert information(200) == []
    (text,) = information(199)
    assert text.startswith("199 samples are few for 20 independent states: chance explains 10% of any function, and")
    half = [samples for samples in range(60, 130) if "no capacity below" in information(samples)[0]]
    cutoffs = [stats.beta(10, (samples - 21) / 2).isf(1e-4) for samples in (half[-1], half[-1] + 1)]
    assert cutoffs[0] > 0.5 >= cutoffs[1]
    assert half == list(range(60, half[-1] + 1))


def test_ranks_are_lower_bounds_where_inputs_bound_them():
    states = np.random.default_rng(0).normal(size=(6, 5))
    assert said(lambda: ranks(states, states)) == []
    assert said(lambda: ranks(states[:, :4], states[:5, :4])) == []
    different, similar = said(lambda: ranks(states[:5], states[:4]))
    assert different.startswith(
        "different has 5 inputs, whose states cannot span more than 4 directions: the rank is a "
    )
    assert similar.startswith(
        "similar has 4 inputs, whose states cannot span more than 3 directions: the rank is a lower"
    )


def test_guards_of_ranks_name_the_argument():
    states = np.random.default_rng(0).normal(size=(6, 3))
    with pytest.raises(ValueError, match=r"^similar must hold the states of two inputs at least, got 1$"):
        ranks(states, states[:1])
    with pytest.raises(ValueError, match=r"^threshold must be in \(0, 1\), got 0$"):
        ranks(states, states, threshold=0)
    for name, least in (("inputs", 2), ("length", 1), ("endings", 1), ("seed", 0)):
        with pytest.raises(ValueError, match=f"^{name} must be a whole number >= {least}, got {least - 1}$"):
            kernel_quality(lambda u: delay_line(u, 2), **{"inputs": 9, name: least - 1})


def test_a_direction_counts_above_the_threshold_and_not_at_it():
    # Two features of one size whose sum and difference are a share apart, to the last digit.
    wide, narrow = np.repeat([1.0, -1.0], 4), np.tile([1.0, -1.0], 4)
    states = np.column_stack([wide + narrow / 4, wide - narrow / 4])
    share = ranks(states, states).kernel_singular_values
    assert share[1] / share[0] == pytest.approx(0.25)
    assert ranks(states, states, threshold=0.2499).kernel_rank == 2
    assert ranks(states, states, threshold=0.2501).kernel_rank == 1


def test_a_skewed_interval_by_hand():
    """The logarithm of a run is a tenth of the mean at least, and the end no further than five of Student's."""
    values = np.array([0.0, 0.0, 1.0, 7.0])
    found = mean_over_runs(values, 0.9, bounds=(0, np.inf))
    t = stats.t(3).ppf(0.95)
    half = t * values.std(ddof=1) / 2
    end = 2 * np.exp(t * np.log([0.2, 0.2, 1.0, 7.0]).std(ddof=1) / 2)
    assert 2 + half < end < 2 + 5 * half
    assert (found.low, found.high) == pytest.approx((max(2 - half, 0), end))
    far = np.array([0.0, 0.0, 0.0, 0.0, 1e-4, 1.0])
    wild = mean_over_runs(far, 0.999, bounds=(0, np.inf))
    assert wild.high == pytest.approx(far.mean() + 5 * stats.t(5).ppf(0.9995) * stats.sem(far))
    assert mean_over_runs(far, 0.999, bounds=(0, 1)).high == 1
    # A bound elsewhere moves with the scores; without bounds and with either sign nothing is skewed.
    moved = mean_over_runs(values - 3, 0.9, bounds=(-3, np.inf))
    assert (moved.low, moved.high) == pytest.approx((found.low - 3, found.high - 3))
    plain = mean_over_runs([-1.0, 2.0, 5.0])
    assert plain.high - 2 == pytest.approx(2 - plain.low)
    assert mean_over_runs([1.0, 2.0, 3.0]).high > 2 + stats.t(2).ppf(0.975) / np.sqrt(3)
    assert plain.at_most(4.0).high == 4.0
    assert plain.at_most(1.0).high == plain.mean
    assert plain.at_most(100.0) == plain


def test_bounds_hold_all_values_but_for_rounding():
    within = mean_over_runs([-0.9e-9, 1.0, 2.0 + 0.9e-9], bounds=(0, 2))
    assert (within.low, within.high) == (0, 2)
    for values, bounds in (([-1.1e-9, 1.0], (0, 2)), ([1.0, 2.0 + 1.1e-9], (0, 2)), ([1.0, 1.0], (1, 1))):
        with pytest.raises(ValueError, match=r"^bounds must hold all values, from "):
            mean_over_runs(values, bounds=bounds)


def test_a_function_is_new_from_a_millionth_on():
    q = orthonormal_basis(np.random.default_rng(0).normal(size=(300, 4)))
    other = np.random.default_rng(1).normal(size=300)
    other -= other.mean() + q @ (q.T @ other)
    other /= np.linalg.norm(other)
    for share, new in ((0.97e-6, False), (1.03e-6, True)):
        found = sequential_capacity(q, np.vstack([other, other + share * q[:, 0]]), 10)
        assert (found.capacity[1] > 0.9) == new
        assert (found.capacity[1] > 0) == new


def test_an_interval_holds_its_capacity_to_the_last_digit():
    """Where its logit ends: at 0, at 1, and a rounding from them; and by hand between."""
    capacity = np.array([0.0, 1.0, 1e-15, 1 - 1e-15, 0.3])
    influence = np.zeros((5, 8))
    influence[4] = 0.01 * np.arange(-3, 5)
    ends, total = intervals(SequentialCapacity(capacity, 0 * capacity, influence), 0.9, 3)
    assert (ends[0] <= capacity).all()
    assert (capacity <= ends[1]).all()
    np.testing.assert_allclose(ends[:, :4], [capacity[:4]] * 2, rtol=0, atol=2e-12)
    half = stats.t(7).ppf(0.95) * np.sqrt(8 / 7 * np.sum(influence**2))
    logit = np.log(0.3 / 0.7)
    np.testing.assert_allclose(ends[:, 4], 1 / (1 + np.exp(-(logit + np.array([-1, 1]) * half / 0.21))))
    half_of_sum = stats.t(7).ppf(0.95) * np.sqrt(8 / 7 * np.sum(influence[4] ** 2))
    assert total == pytest.approx((2.3 - half_of_sum, 2.3 + half_of_sum))
    # It ends at the rank and at 0; a single block tells as little as two would.
    assert intervals(SequentialCapacity(capacity, 0 * capacity, 100 * influence), 0.9, 3)[1] == (0, 3)
    assert intervals(SequentialCapacity(capacity, 0 * capacity, 100 * influence), 0.9, 2)[1] == (0, pytest.approx(2.3))
    _, single = intervals(SequentialCapacity(capacity, 0 * capacity, influence[:, :1]), 0.9, 3)
    assert single == pytest.approx((2.3 - 0.03 * stats.t(1).ppf(0.95), 2.3 + 0.03 * stats.t(1).ppf(0.95)))


def test_what_is_explained_in_whole_is_beyond_chance_even_where_that_might_explain_all():
    """The cutoff is looked at closely: its upper bound of 1 would let nothing be found."""
    q = orthonormal_basis(np.random.default_rng(0).standard_t(2, size=(60, 6)))
    rows = np.random.default_rng(1).standard_t(2, size=(5, 60))
    alone = chance(q, rows, 1e-4).cutoff
    np.testing.assert_array_equal(chance(q, rows, 1e-4, np.ones(5)).cutoff, alone)
    most = 2 * chance(q, rows, 1e-4).mean * stats.gamma(0.5).isf(1e-4)
    assert (most > 1).any()
    assert alone[most > 1].max() < 1


def test_states_that_tell_nothing_rest_on_no_events():
    rows = np.random.default_rng(0).normal(size=(2, 20))
    assert effective_events(np.zeros((20, 0)), rows).tolist() == [0.0, 0.0]
