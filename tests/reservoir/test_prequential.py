import numpy as np
import pytest

from stickslip.reservoir import delay_line
from stickslip.reservoir.prequential import PrequentialMemory, RIDGE


def bits(steps, dither, seed=0):
    """Innovations of flips at the rate `dither`."""
    return (np.random.default_rng(seed).random(steps) < dither) - dither


def echoes(message, features, seed=0):
    """States that mix the last few messages with some noise, far from zero mean and unit scale."""
    rng = np.random.default_rng(seed)
    taps = delay_line(message, 6) @ rng.normal(size=(6, features))
    return 3.0 + 1e-2 * (taps + 0.3 * rng.normal(size=taps.shape))


def scores(memory, states, message):
    return np.array([memory.score(state, e) for state, e in zip(states, message.tolist(), strict=True)])


def slow_scores(calibration, states, message, delays, variance):
    """What PrequentialMemory says of itself, with one batch ridge solve a step and delay."""
    centre, spread = calibration.mean(axis=0), calibration.std(axis=0)
    seen = np.column_stack([(states - centre) / spread, np.ones(len(states))])
    penalty = RIDGE * np.eye(seen.shape[1])
    earned = np.zeros(len(states))
    for k in range(len(states)):
        gram = penalty + seen[:k].T @ seen[:k]
        leverage = seen[k] @ np.linalg.solve(gram, seen[k])
        for d in range(min(k + 1, delays)):
            # The readout of delay d has nothing to learn in the first d steps: it is told its own prediction.
            target = np.concatenate([np.zeros(d), message])[:k]
            guess = seen[k] @ np.linalg.solve(gram, seen[:k].T @ target)
            e, share = message[k - d], (k + 1 - d) / (k + 1)
            earned[k] += (e**2 - (e - guess) ** 2 / (1 + leverage * share)) / variance
        earned[k] *= np.clip(2 - leverage, 0, 1)
    return earned


@pytest.mark.parametrize("dither", [0.05, 0.5])
def test_it_is_a_ridge_readout_solved_anew_at_every_step(dither):
    variance = dither * (1 - dither)
    calibration, message = echoes(bits(300, dither, 1), 4, 0), bits(80, dither, 2)
    states = echoes(message, 4, 0)
    memory = PrequentialMemory(calibration, 8, variance=variance)
    expected = slow_scores(calibration, states, message, 8, variance)
    np.testing.assert_allclose(scores(memory, states, message), expected, rtol=0, atol=1e-8)


def test_a_packed_readout_goes_on_as_it_would_have():
    message = bits(300, 0.2)
    states = echoes(message, 5)
    memory, other = (PrequentialMemory(states, 10, variance=0.16) for _ in range(2))
    scores(memory, states[:100], message[:100])
    packed = memory.packed()
    expected = scores(memory, states[100:], message[100:])
    other.unpack(packed, 100)
    np.testing.assert_array_equal(scores(other, states[100:], message[100:]), expected)


@pytest.mark.parametrize("delays", [1, 20, 100])
@pytest.mark.parametrize("features", [1, 12])
@pytest.mark.parametrize("dither", [0.1, 0.5])
def test_a_state_that_knows_nothing_earns_nothing_on_average(dither, features, delays):
    """However short the episode: what the weights still lack is not charged."""
    steps, episodes = 300, 200
    rng = np.random.default_rng(0)
    memory = PrequentialMemory(rng.normal(size=(2000, features)), delays, variance=dither * (1 - dither))
    means = []
    for _ in range(episodes):
        memory.reset()
        message = (rng.random(steps) < dither) - dither
        means.append(scores(memory, rng.normal(size=(steps, features)), message).mean())
    # Least squares without the division would pay about this.
    cost = delays * (features + 1) * np.log(steps / (features + 1)) / steps
    assert abs(np.mean(means)) < 4 * np.std(means) / np.sqrt(episodes) + 0.03 * cost


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9])
def test_a_noisy_echo_earns_what_it_holds_from_a_short_episode_on(share):
    """States of which each mixes one message with noise: the capacity is the squared correlation, a delay."""
    steps, episodes, delays, dither = 200, 400, 8, 0.3
    rng = np.random.default_rng(1)
    variance = dither * (1 - dither)
    noise = np.sqrt(variance * (1 - share) / max(share, 1e-9)) if share else 1.0
    means = []
    memory = PrequentialMemory(rng.normal(size=(2000, delays)), delays, variance=variance)
    for _ in range(episodes):
        memory.reset()
        message = (rng.random(steps) < dither) - dither
        states = (delay_line(message, delays) if share else 0.0) + noise * rng.normal(size=(steps, delays))
        means.append(scores(memory, states, message).mean())
    error = 4 * np.std(means) / np.sqrt(episodes)
    # A step counts for nothing until there are samples enough, here two a weight.
    lost = share * delays * 3 * delays / steps
    assert -lost - error < np.mean(means) - share * delays < error


def test_novelty_does_not_pay():
    """States that grow by a factor a step keep the leverage high for as long as numbers last: and earn nothing."""
    rng = np.random.default_rng(2)
    memory = PrequentialMemory(rng.normal(size=(2000, 6)), 10, variance=0.25)
    means = []
    for factor in (1.1, 1.3, 2.0):
        for _ in range(100):
            memory.reset()
            message = (rng.random(200) < 0.5) - 0.5
            growing = factor ** np.arange(200)[:, np.newaxis] * rng.normal(size=(200, 6))
            means.append(scores(memory, growing, message).mean())
    assert np.mean(means) < 3 * np.std(means) / np.sqrt(len(means))


def test_reset_forgets_all_that_was_scored():
    message = bits(500, 0.2)
    states = echoes(message, 5)
    memory = PrequentialMemory(states, 10, variance=0.16)
    first = scores(memory, states, message)
    memory.reset()
    np.testing.assert_array_equal(scores(memory, states, message), first)


def test_states_are_not_kept():
    message = bits(500, 0.2)
    states = echoes(message, 5)
    one, other = (PrequentialMemory(states, 10, variance=0.16) for _ in range(2))
    for state, e in zip(states, message, strict=True):
        scratch = state.copy()
        earned = one.score(scratch, e)
        scratch[:] = np.nan
        assert earned == other.score(state, e)


@pytest.mark.parametrize("taps", [1, 5])
def test_a_delay_line_earns_the_messages_that_it_holds(taps):
    """Prediction is perfect but for the ridge, so step k earns e^2 / Var e for each tap filled by then."""
    dither, steps = 0.1, 3000
    variance = dither * (1 - dither)
    calibration, message = bits(2000, dither, 1), bits(steps, dither, 2)
    held = delay_line(message, taps)
    for delays in (taps, 20):
        memory = PrequentialMemory(delay_line(calibration, taps), delays, variance=variance)
        earned = scores(memory, held, message)
        assert earned.mean() == pytest.approx((held[50:] ** 2).sum(axis=1).mean() / variance, abs=0.1 + 0.03 * delays)
    memory = PrequentialMemory(delay_line(calibration, taps), taps, variance=variance)
    earned = scores(memory, held, message)[200:]
    np.testing.assert_allclose(earned, (held[200:] ** 2).sum(axis=1) / variance, rtol=0, atol=0.05)


def test_a_readout_that_is_scaled_as_another_body_learns_this_one():
    dither, steps = 0.2, 4000
    message = bits(steps, dither)
    for factor in (0.01, -1.0, 100.0):
        memory = PrequentialMemory(factor * delay_line(bits(2000, dither, 1), 3), 3, variance=dither * (1 - dither))
        earned = scores(memory, delay_line(message, 3), message)
        assert earned.mean() == pytest.approx((message**2).mean() * 3 / 0.16, abs=0.1)


def test_a_feature_that_never_moves_does_no_harm():
    message = bits(2000, 0.2)
    states = np.column_stack([delay_line(message, 2), np.full(2000, 0.1)])
    memory = PrequentialMemory(states, 2, variance=0.16)
    assert scores(memory, states, message).mean() == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize(
    ("change", "error", "text"),
    [
        ({"states": np.zeros(50)}, ValueError, r"states must be 2-dimensional .* got shape \(50,\)"),
        ({"delays": 0}, ValueError, "delays must be a whole number >= 1, got 0"),
        ({"variance": 0.0}, ValueError, r"variance must be in \(0, inf\), got 0.0"),
        ({"variance": -1.0}, ValueError, r"variance must be in \(0, inf\), got -1.0"),
    ],
)
def test_bad_input(change, error, text):
    good = {"states": echoes(bits(50, 0.2), 2), "delays": 5, "variance": 0.16}
    PrequentialMemory(**good)
    with pytest.raises(error, match=text):
        PrequentialMemory(**{**good, **change})
