"""The environments take a hold in seconds of an actuator, and are those of its natural time to the bit."""

from dataclasses import asdict, replace

import gymnasium as gym
import numpy as np
import pytest

import stickslip  # noqa: F401  (registers)
from stickslip.crawler import Actuator, Groups
from stickslip.envs import StickSlipCrawlerEnv, StickSlipCrawlerVectorEnv
from stickslip.train.run import Configuration

ECOFLEX = Actuator.ecoflex()
SOFT = replace(ECOFLEX, stiffness=70.0)


def episode(env):
    observation, _ = env.reset(seed=3)
    rows = [observation]
    for k in range(12):
        action = int(k % 5 < 3)
        observation, reward, *_ = env.step(action if not hasattr(env, "num_envs") else np.full(env.num_envs, action))
        rows.append(np.append(observation, reward))
    return rows


def test_one_crawler_and_a_batch():
    wanted = episode(StickSlipCrawlerEnv(groups=ECOFLEX, hold=0.5))
    env = StickSlipCrawlerEnv(groups=ECOFLEX, hold="31.25 ms")
    assert (env.settings.hold, env.hold_seconds) == (0.5, 0.03125)
    for found, expected in zip(episode(env), wanted, strict=True):
        np.testing.assert_array_equal(found, expected)
    several = StickSlipCrawlerVectorEnv(2, groups=ECOFLEX, hold="31.25 ms")
    assert (several.settings.hold, several.hold_seconds) == (0.5, 0.03125)
    rows = episode(several)
    several.close()
    for found, expected in zip(rows[1:], wanted[1:], strict=True):
        np.testing.assert_array_equal(found.reshape(-1)[:5], expected[:5])
    alike = StickSlipCrawlerVectorEnv(2, groups=[ECOFLEX, replace(ECOFLEX, damping=0.3)], hold="31.25 ms")
    assert (alike.settings.hold, alike.hold_seconds) == (0.5, 0.03125)


def test_without_an_actuator_there_are_no_seconds():
    assert StickSlipCrawlerEnv().hold_seconds is None
    assert StickSlipCrawlerVectorEnv(2, groups=[ECOFLEX, SOFT]).hold_seconds is None
    for make in (StickSlipCrawlerEnv, lambda **given: StickSlipCrawlerVectorEnv(2, **given)):
        with pytest.raises(ValueError, match=r"in units of t_c, such as 0\.5, where groups is no Actuator"):
            make(hold="20 ms")
        with pytest.raises(ValueError, match=r"hold must be in \(0, 10000\] t_c, which is \(0, 625\] s"):
            make(groups=ECOFLEX, hold="1100 s")


def test_a_batch_has_one_natural_time():
    with pytest.raises(ValueError, match="hold must be as many t_c for each sub-environment, got '20 ms', which is"):
        StickSlipCrawlerVectorEnv(2, groups=[ECOFLEX, SOFT], hold="20 ms")


def test_what_made_an_environment_is_kept_in_natural_units():
    env = gym.make("StickSlipCrawler-v0", groups=ECOFLEX, hold="20 ms")
    assert env.spec.kwargs == {"groups": Groups().to_dict(), "hold": 0.32}
    again = gym.make(gym.envs.registration.EnvSpec.from_json(env.spec.to_json()))
    assert again.unwrapped.settings == env.unwrapped.settings
    kept = asdict(Configuration(env_kwargs={"groups": ECOFLEX, "hold": "20 ms"}))["env_kwargs"]
    assert kept == {"groups": Groups().to_dict(), "hold": 0.32}
