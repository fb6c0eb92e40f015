"""Grounds that count as never seen are beyond what was drawn, and tables tell means over trainings and grounds."""

import robustness


def test_grounds_never_seen_are_beyond_what_was_drawn():
    def within(ground):
        return all(low <= getattr(ground, name) <= high for name, (low, high) in robustness.DRAWN.items())

    assert within(robustness.HOME)
    assert len(robustness.NEVER_SEEN) == len(robustness.GROUNDS) - 1
    assert not any(map(within, robustness.NEVER_SEEN))


def on_grounds(rewards):
    return {ground.key: {"reward": rewards, "speed": [0.5, 0.5], "memory": [2.0, 2.0]} for ground in robustness.GROUNDS}


def test_differences_are_of_the_same_seeds_and_words_that_win_are_counted():
    found = {
        "0.2/one body/0": on_grounds([1.0, 2.0]),
        "0.2/one body/1": on_grounds([2.0, 3.0]),
        "0.2/drawn bodies/0": on_grounds([2.0, 3.0]),
        "0.2/best word": on_grounds([2.0, 2.5]),
    }
    row = robustness.table_of_grounds(found, 0.2).splitlines()[2]
    assert row.split(" | ")[5].startswith("+0.50")
    every = len(robustness.NEVER_SEEN)
    lost = [line.rsplit("|", 2)[1].strip() for line in robustness.table_of_trainings(found).splitlines()[2:]]
    assert lost == [f"{every} of {every}", f"0 of {every}", f"0 of {every}"]
