"""The measurement by which a run is told from one of another body or reward."""

import numpy as np
import pytest

from stickslip.envs import StickSlipCrawlerEnv
from stickslip.train.probe import first_rewards


def test_a_word_of_three_holds_open_and_three_shut_is_tried_for_sixteen():
    environment = StickSlipCrawlerEnv(hold=0.75, dither=0.3, memory_weight=0.5)
    environment.reset(seed=0)
    rewards = [environment.step(command)[1] for command in [1, 1, 1, 0, 0, 0] * 2 + [1, 1, 1, 0]]
    found = first_rewards({"hold": 0.75, "dither": 0.3, "memory_weight": 0.5})
    assert found == pytest.approx(rewards, rel=1e-4)
    assert np.ptp(rewards) > 0.0
