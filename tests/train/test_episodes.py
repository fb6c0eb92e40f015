"""One long episode of a batch: what the environment tells at each step, and that nothing is left open."""

import numpy as np
import pytest

from stickslip.envs import StickSlipCrawlerVectorEnv
from stickslip.train.episodes import long_episode


def three():
    return StickSlipCrawlerVectorEnv(3, dither=0.1, max_episode_steps=None)


def test_an_episode_is_what_stepping_the_environment_comes_to():
    environment, seen = three(), []
    observations, _ = environment.reset(seed=[5, 6, 7])

    def act(k, now):
        seen.append(now)
        return np.array([k % 2, 1, 0])

    for k, commands, rewards, infos in long_episode(three(), act, 6, seed=(5, 6, 7)):
        np.testing.assert_array_equal(seen[k], observations)
        observations, expected, _, _, told = environment.step(np.array([k % 2, 1, 0]))
        np.testing.assert_array_equal(commands, [k % 2, 1, 0])
        np.testing.assert_array_equal(rewards, expected)
        np.testing.assert_array_equal(infos["valve"], told["valve"])
    assert len(seen) == 6


def test_the_environment_is_closed_however_the_episode_ends():
    def refuse(k, _):
        if k == 2:
            raise ValueError("no more")
        return np.zeros(3, np.int64)

    whole, broken, left = three(), three(), three()
    assert len(list(long_episode(whole, lambda *_: np.ones(3, np.int64), 4, seed=0))) == 4
    with pytest.raises(ValueError, match="no more"):
        list(long_episode(broken, refuse, 4, seed=0))
    steps = long_episode(left, refuse, 4, seed=0)
    next(steps)
    assert not left.closed
    steps.close()
    assert whole.closed
    assert broken.closed
    assert left.closed
