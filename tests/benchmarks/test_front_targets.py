"""What a policy is said to do is what its commands are."""

import front_targets
import pytest


@pytest.mark.parametrize(
    ("commands", "said"),
    [
        ([1] * 40, "held open"),
        ([0] * 40, "held shut"),
        ([0, 1, 1, 0, 0] * 8, "11000"),
        ([1, 0, 1, 1, 0] * 8, "11010"),
        ([int(bit) for bit in f"{0x5A3C96F1E8B74D20:064b}"], "no period"),
    ],
)
def test_commands_are_told_as_the_word_that_they_repeat(commands, said):
    assert front_targets.in_words(commands) == said


def test_targets_are_asked_as_the_environment_takes_them():
    worlds = {target: front_targets.trade_for(target).world(0.25) for target in front_targets.TARGETS}
    assert {target: (each.target, each.target_order) for target, each in worlds.items()} == {
        "parity": ("parity", 2),
        "narma": ("narma", 2),
    }
