import numpy as np
import pytest

from stickslip.reservoir import delay_line
from stickslip.reservoir.prequential import _RIDGE, PrequentialMemory


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


def slow_scores(calibration, states, message, delays, variance, weight):
    """What PrequentialMemory says of itself, with one batch ridge solve a step and delay."""
    past_states, past_message = calibration
    centre, spread = past_states.mean(axis=0), past_states.std(axis=0)

    def features(rows):
        return np.column_stack([(rows - centre) / spread, np.ones(len(rows))])

    x = features(past_states)[delays - 1 :]
    size = x.shape[1]
    prior = weight * (x.T @ x / len(x) + _RIDGE * np.eye(size))
    y = delay_line(past_message, delays)[delays - 1 :]
    start = np.linalg.solve(prior, weight * x.T @ y / len(x))

    seen = features(states)
    earned = np.zeros(len(states))
    for d in range(delays):
        # The readout of delay d has nothing to learn in the first d steps: it is told its own prediction.
        target = np.concatenate([seen[:d] @ start[:, d], message])[: len(states)]
        for k in range(d, len(states)):
            gram = prior + seen[:k].T @ seen[:k]
            known = np.linalg.solve(gram, prior @ start[:, d] + seen[:k].T @ target[:k])
            e = message[k - d]
            earned[k] += (e**2 - (e - seen[k] @ known) ** 2) / variance
    return earned


@pytest.mark.parametrize("weight", [0.5, 30.0, 1000.0])
@pytest.mark.parametrize("dither", [0.05, 0.5])
def test_it_is_a_ridge_readout_solved_anew_at_every_step(weight, dither):
    variance = dither * (1 - dither)
    calibration = echoes(bits(300, dither, 1), 4, 0), bits(300, dither, 1)
    message = bits(80, dither, 2)
    states = echoes(message, 4, 0)
    memory = PrequentialMemory(*calibration, 8, variance=variance, weight=weight)
    expected = slow_scores(calibration, states, message, 8, variance, weight)
    np.testing.assert_allclose(scores(memory, states, message), expected, rtol=0, atol=1e-8)


def test_reset_forgets_all_but_the_calibration():
    message = bits(500, 0.2)
    states = echoes(message, 5)
    memory = PrequentialMemory(states, message, 10, variance=0.16)
    first = scores(memory, states, message)
    memory.reset()
    np.testing.assert_array_equal(scores(memory, states, message), first)


def test_states_are_not_kept():
    message = bits(500, 0.2)
    states = echoes(message, 5)
    one, other = (PrequentialMemory(states, message, 10, variance=0.16) for _ in range(2))
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
    memory = PrequentialMemory(delay_line(calibration, taps), calibration, taps, variance=variance)
    np.testing.assert_allclose(scores(memory, held, message), (held**2).sum(axis=1) / variance, rtol=0, atol=0.01)

    # Delays beyond the taps cost what is spent on learning that they hold nothing.
    memory = PrequentialMemory(delay_line(calibration, taps), calibration, 20, variance=variance)
    mean = scores(memory, held, message).mean()
    assert taps - 0.5 < mean < taps + 0.1


@pytest.mark.parametrize("features", [1, 12])
def test_a_state_that_knows_nothing_earns_nothing(features):
    dither, steps = 0.1, 6000
    rng = np.random.default_rng(0)
    calibration = rng.normal(size=(2000, features)), bits(2000, dither, 1)
    memory = PrequentialMemory(*calibration, 20, variance=dither * (1 - dither))
    earned = scores(memory, rng.normal(size=(steps, features)), bits(steps, dither, 2))
    # Learning 20 x (features + 1) weights from nothing costs about that times log(1 + steps / 30) / steps.
    cost = 20 * (features + 1) * np.log(1 + steps / 30) / steps
    assert -1.5 * cost < earned.mean() < 0


def test_a_readout_calibrated_on_another_body_learns_this_one():
    dither, steps = 0.2, 4000
    message = bits(steps, dither)
    other = bits(2000, dither, 1)
    memory = PrequentialMemory(-delay_line(other, 3), other, 3, variance=dither * (1 - dither))
    earned = scores(memory, delay_line(message, 3), message)
    assert earned[:20].mean() < 0
    assert earned[2000:].mean() == pytest.approx((message[2000:] ** 2).mean() * 3 / 0.16, abs=0.02)


def test_a_feature_that_never_moves_does_no_harm():
    message = bits(2000, 0.2)
    states = np.column_stack([delay_line(message, 2), np.full(2000, 0.1)])
    memory = PrequentialMemory(states, message, 2, variance=0.16)
    assert scores(memory, states, message).mean() == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize(
    ("change", "error", "text"),
    [
        ({"states": np.zeros(50)}, ValueError, r"states must be 2-dimensional .* got shape \(50,\)"),
        ({"message": np.full(50, np.nan)}, ValueError, r"message must be finite, got nan at index \(0,\)"),
        ({"message": np.zeros(49)}, ValueError, "states and message must have one length .* got 50 and 49"),
        ({"delays": 0}, ValueError, "delays must be a whole number >= 1, got 0"),
        ({"delays": 50}, ValueError, "one length above delays = 50, got 50 and 50"),
        ({"variance": 0.0}, ValueError, r"variance must be in \(0, inf\), got 0.0"),
        ({"variance": -1.0}, ValueError, r"variance must be in \(0, inf\), got -1.0"),
        ({"weight": 0.0}, ValueError, r"weight must be in \(0, inf\), got 0.0"),
        ({"weight": np.nan}, ValueError, r"weight must be in \(0, inf\), got nan"),
    ],
)
def test_bad_input(change, error, text):
    good = {"states": echoes(bits(50, 0.2), 2), "message": bits(50, 0.2), "delays": 5, "variance": 0.16, "weight": 30.0}
    PrequentialMemory(**good)
    with pytest.raises(error, match=text):
        PrequentialMemory(**{**good, **change})
