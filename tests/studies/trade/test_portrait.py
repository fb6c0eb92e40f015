"""What is said of a policy, for policies of which it is known."""

import numpy as np
import pytest
from policies_by_hand import negation, relay

from stickslip.studies.trade.portrait import imitation, portrait, response
from stickslip.studies.trade.portrait_figure import plot_learned, telling_past


@pytest.fixture(scope="module")
def negating():
    return portrait(negation(3), holds=300, seeds=range(4))


def test_a_portrait_is_what_the_policy_saw_and_did(negating):
    assert negating.observations.shape == (4, 300, 7)
    np.testing.assert_array_equal(negating.commands, 1 - negating.observations[..., 6])
    for age in range(3):
        np.testing.assert_array_equal(negating.valves[:, 2 - age : -1 - age], negating.observations[:, 3:, 4 + age])
    flipped = np.mean(negating.commands != negating.valves)
    assert 0.06 < flipped < 0.14
    again = portrait(negation(3), holds=10, seeds=[3])
    np.testing.assert_array_equal(again.valves[0], negating.valves[3, :10])


def test_a_register_is_imitated_by_itself(negating):
    """Its table is the negation of the third bit; of fewer bits nothing is known but through the gait."""
    assert imitation(negating, 3).agreement == 1.0
    np.testing.assert_array_equal(imitation(negating, 3).table, [1, 1, 1, 1, 0, 0, 0, 0])
    assert imitation(negating, 5).agreement > 0.99  # pasts that never came are guesses
    agreements = [imitation(negating, bits).agreement for bits in range(3)]
    assert max(agreements) < 0.9
    assert 0.4 < agreements[0] < 0.6


@pytest.mark.parametrize("bits", [-1, 9])
def test_registers_of_no_such_bits_are_refused(negating, bits):
    with pytest.raises(ValueError, match=rf"bits must be in \[0, 8\], got {bits}"):
        imitation(negating, bits)


def test_one_run_alone_judges_no_register():
    with pytest.raises(ValueError, match="portrait must have two runs at least, got 1"):
        imitation(portrait(negation(1), holds=10, seeds=[0]), 1)


def test_a_negation_hands_a_flip_on_for_ever_and_a_relay_takes_the_body_s_answer():
    answered = response(negation(3), pairs=8)
    np.testing.assert_array_equal(answered, [k > 0 and k % 3 == 0 for k in range(len(answered))])
    forgotten = response(relay(0.3), pairs=64)
    assert forgotten[0] == 0 < forgotten[1:].max() < 1


def test_the_telling_past_is_that_after_which_both_commands_are_given():
    pasts = np.array([[0, 0]] * 6 + [[0, 1]] * 4 + [[1, 1]] * 3, np.float32)
    asked = np.array([1] * 6 + [1, 0, 1, 0] + [1, 0, 0])
    np.testing.assert_array_equal(telling_past(pasts, asked), [0, 1])


def test_the_picture_shows_what_was_found(negating):
    other = portrait(relay(0.3), holds=200, seeds=range(2))
    portraits = {"one": negating, "other": other}
    imitations = {name: {bits: imitation(each, bits) for bits in (3, 0, 1)} for name, each in portraits.items()}
    answered = {name: np.linspace(0, 1, 5) ** power for name, power in (("one", 1), ("other", 2))}
    figure = plot_learned(portraits, answered, imitations)
    schedule, switching, answers, registers = figure.axes
    np.testing.assert_array_equal(schedule.lines[0].get_ydata(), negating.observations[0, :49, 0])
    for ax, expected in (
        (answers, answered),
        (registers, {name: [each[b].agreement for b in (0, 1, 3)] for name, each in imitations.items()}),
    ):
        drawn = {line.get_label(): line.get_ydata() for line in ax.lines}
        assert list(drawn) == ["one", "other"]
        for name, values in expected.items():
            np.testing.assert_array_equal(drawn[name], values)
    assert schedule.get_title("left") == "a  one: schedule"
    assert switching.get_title("left") == "b  other: switching line"
    # The relay changes its command at 0.3, whatever the velocity.
    [line] = [each for each in switching.collections if hasattr(each, "levels")]
    np.testing.assert_allclose(np.concatenate([path.vertices for path in line.get_paths()])[:, 0], 0.3, atol=1e-3)
