"""Crawlers that a batch draws at once against those that single environments draw, to the last bit."""

import gymnasium as gym
import numpy as np
import pytest

from stickslip.crawler.model.variations import Range
from stickslip.envs import StickSlipCrawlerEnv

COUNT, STEPS = 9, 18
RANDOMIZE = {"deborah": Range(0.3, 0.7, log=True), "slope": (-0.05, 0.05), "static_friction": (0.3, 0.4)}


@pytest.mark.parametrize("groups", [{}, "linear", {"damping_ratio": 30.0}], ids=str)
@pytest.mark.parametrize("noise", [{}, {"dither": 0.0, "memory_weight": 0.0}], ids=["dithered", "undithered"])
def test_a_batch_draws_what_its_sub_environments_would(groups, noise):
    arguments = {"groups": groups, "randomize": RANDOMIZE, **noise}
    batch = gym.make_vec("stickslip:StickSlipCrawler-v0", COUNT, max_episode_steps=5, **arguments)
    singles = [StickSlipCrawlerEnv(**arguments) for _ in range(COUNT)]
    _, told = batch.reset(seed=5)
    own = [single.reset(seed=5 + i)[1] for i, single in enumerate(singles)]
    seen, rng = set(), np.random.default_rng(0)
    for k in range(STEPS):
        for i, single in enumerate(own):
            assert single["slope"] == told["slope"][i]
            assert single["groups"] == {name: values[i] for name, values in told["groups"].items() if name[0] != "_"}
            assert batch.call("episode_groups")[i].to_dict() == single["groups"]
        seen |= {single["groups"]["deborah"] for single in own}
        actions = rng.integers(0, 2, COUNT)
        observations, rewards, *_, told = batch.step(actions)
        # Every sixth step is the reset that follows five.
        answers = [single.reset() if k % 6 == 5 else single.step(a) for single, a in zip(singles, actions, strict=True)]
        own = [answer[-1] for answer in answers]
        np.testing.assert_array_equal(observations, [answer[0] for answer in answers])
        np.testing.assert_array_equal(rewards, [0.0 if k % 6 == 5 else answer[1] for answer in answers])
    assert len(seen) == COUNT * 3
    assert 0.3 <= min(seen) < max(seen) < 0.7


def test_some_that_begin_again_leave_the_others_who_they_were():
    batch = gym.make_vec("stickslip:StickSlipCrawler-v0", COUNT, randomize=RANDOMIZE, groups="linear")
    batch.reset(seed=1)
    before = batch.call("episode_groups")
    mask = np.arange(COUNT) % 2 == 1
    batch.reset(options={"reset_mask": mask})
    after = batch.call("episode_groups")
    assert [one != other for one, other in zip(before, after, strict=True)] == mask.tolist()
    assert [each for each, _ in batch.unwrapped.crawlers_by_name] == [each.to_dict() for each in after]
