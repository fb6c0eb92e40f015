"""What must be true of a package once its recipe has run, each named as the recipe.

A check is given a function that runs the block and returns what it leaves: its variables, or for a block of the shell
what it printed and the folder it ran in. Packages are imported in the checks: no one environment has all of them.
"""

import contextlib
import itertools
import os
import re
import tempfile

import gymnasium as gym
import numpy as np

__all__ = ["CHECKS"]

ID = "StickSlipCrawler-v0"
SPEED = {"memory_weight": 0.0, "dither": 0.0}
RANDOM_SPEED = 0.2548  # of coin flips, in `docs/training.md`


def alone(seed, actions, *, resets=1, **arguments):
    """Observations, rewards and infos of the environment by itself, the reset's first."""
    env = gym.make(ID, **arguments)
    observation, info = env.reset(seed=seed)
    for _ in range(resets - 1):
        observation, info = env.reset()
    observations, rewards, infos = [observation], [], [info]
    for action in actions:
        observation, reward, _, _, info = env.step(action)
        observations.append(observation)
        rewards.append(reward)
        infos.append(info)
    env.close()
    return np.array(observations), np.array(rewards), infos


def crawl(act, steps=200):
    """Mean speed of a deterministic policy in the speed task."""
    env = gym.make(ID, **SPEED)
    observation, _ = env.reset(seed=0)
    for _ in range(steps):
        observation, _, _, _, info = env.step(int(act(observation)))
    return info["distance"] / (steps * env.unwrapped.settings.hold)


def gymnasium(run):
    left = run()
    space = gym.spaces.MultiDiscrete([2] * 1024)
    space.seed(0)
    actions = np.array([space.sample() for _ in range(100)])
    for i in (0, 517, 1023):
        observations, rewards, infos = alone(i, actions[:, i], memory_weight=0.25)
        np.testing.assert_array_equal(left["observations"][i], observations[-1])
        assert left["rewards"][i] == rewards[-1]
        assert {name: left["infos"][name][i] for name in ("speed", "memory", "distance", "slips")} == {
            name: infos[-1][name] for name in ("speed", "memory", "distance", "slips")
        }


def play(run):
    import pygame

    # The keyboard, frame by frame: space down at 5, up at 9, down at 15, up at 19; the window is closed at 30.
    turns = {5: pygame.KEYDOWN, 9: pygame.KEYUP, 15: pygame.KEYDOWN, 19: pygame.KEYUP}
    frames = itertools.count()

    def events():
        frame = next(frames)
        if frame == 30:
            return [pygame.event.Event(pygame.QUIT)]
        return [pygame.event.Event(turns[frame], key=pygame.K_SPACE)] if frame in turns else []

    genuine, pygame.event.get = pygame.event.get, events
    try:
        left = run()
    finally:
        pygame.event.get = genuine
    # Frame 0 resets. Keys are looked at when a frame ends; what is pressed then the next frame commands.
    commands = [int(5 < frame <= 9 or 15 < frame <= 19) for frame in range(1, 31)]
    assert left["distances"] == [info["distance"] for info in alone(0, commands, **SPEED)[2][1:]]
    assert left["distances"][-1] > 0.1


def stable_baselines3(run):
    left = run()
    speed = crawl(lambda observation: left["model"].predict(observation, deterministic=True)[0])
    assert abs(left["mean"] / 200 - speed) < 1e-5  # SB3 keeps rewards in single precision
    assert speed > 2 * RANDOM_SPEED


def cleanrl(run):
    printed = run()["printed"]
    (before,) = re.findall(r"^untrained policy: (\S+) a step", printed, re.MULTILINE)
    (after,) = re.findall(r"^trained policy: (\S+) a step", printed, re.MULTILINE)
    assert float(before) < 1.5 * RANDOM_SPEED
    assert float(after) > 2 * RANDOM_SPEED


def torchrl(run):
    rollout = run()["rollout"]
    assert rollout.batch_size == (64, 120)
    after = rollout["next"]
    for i in (0, 31, 63):
        # `set_seed` has given sub-environment i the seed i, and the rollout has reset it once more; so does its end.
        env = gym.make(ID, max_episode_steps=50)
        env.reset(seed=i)
        observation, _ = env.reset()
        for step, action in enumerate(rollout["action"][i].tolist()):
            np.testing.assert_array_equal(rollout["observation"][i, step].numpy(), observation)
            observation, reward, _, truncated, info = env.step(action)
            np.testing.assert_array_equal(after["observation"][i, step].numpy(), observation)
            assert after["reward"][i, step].item() == np.float32(reward)
            assert (after["speed"][i, step].item(), after["memory"][i, step].item()) == (info["speed"], info["memory"])
            assert after["truncated"][i, step].item() == truncated == (step % 50 == 49)
            if truncated:
                observation, _ = env.reset()


def minari(run):
    with tempfile.TemporaryDirectory() as folder, _environment_variable("MINARI_DATASETS_PATH", folder):
        run()
        import minari as package

        dataset = package.load_dataset("stickslip/random-v0")  # from the disk
        assert dataset.recover_environment().spec.id == ID
        assert dataset.recover_environment(eval_env=True).unwrapped.settings.memory_weight == 0.2
        episodes = list(dataset.iterate_episodes())
        assert len(episodes) == 5
        for seed, episode in enumerate(episodes):
            observations, rewards, infos = alone(seed, episode.actions)
            np.testing.assert_array_equal(episode.observations, observations)
            np.testing.assert_array_equal(episode.rewards, rewards)
            for name in ("speed", "memory", "distance", "innovation", "valve", "slips"):
                np.testing.assert_array_equal(episode.infos[name], [info[name] for info in infos])
            assert episode.truncations.tolist() == [False] * 99 + [True]


def skrl(run):
    left = run()
    learned = left["runner"].agent.memory.get_tensor_by_name("rewards").mean().item()
    assert learned > 2 * RANDOM_SPEED

    import torch
    from skrl.envs.wrappers.torch import wrap_env

    env = wrap_env(gym.make_vec(ID, num_envs=8))
    observations, _ = env.reset()
    seeds = env.unwrapped.np_random_seed
    generator = np.random.default_rng(0)
    actions = generator.integers(0, 2, (50, 8))
    steps = [env.step(torch.as_tensor(action)[:, None])[:2] for action in actions]
    for i, seed in enumerate(seeds):
        expected, rewards, _ = alone(seed, actions[:, i])
        np.testing.assert_array_equal(observations[i].numpy(), expected[0])
        np.testing.assert_array_equal([observation[i].numpy() for observation, _ in steps], expected[1:])
        np.testing.assert_array_equal([reward[i, 0].item() for _, reward in steps], np.float32(rewards))


def mo_gymnasium(run):
    left = run()
    _, _, infos = alone(0, [1] * 200)
    speeds, memories = (np.array([info[name] for info in infos[1:]]) for name in ("speed", "memory"))
    episode = left["info"]["episode"]
    np.testing.assert_allclose(episode["r"], [speeds.sum(), memories.sum()], rtol=1e-5)  # kept in single precision
    discounts = 0.98 ** np.arange(200)
    np.testing.assert_allclose(episode["dr"], [discounts @ speeds, discounts @ memories], rtol=1e-5)
    assert episode["l"] == 200
    vector = left["info"]["vector_reward"]
    assert vector[0] == speeds[-1]
    assert left["reward"] == np.dot(vector, [0.7, 0.3])
    of_each = left["infos"]["episode"]["r"]
    assert of_each.shape == (64, 2)
    np.testing.assert_allclose(of_each[0], [speeds.sum(), memories.sum()], rtol=1e-5)
    # Memory alone is divided, by the standard deviation of its discounted return so far.
    returns = list(itertools.accumulate(memories, lambda before, memory: 0.99 * before + memory))
    assert abs(vector[1] * np.std(returns) / memories[-1] - 1) < 0.01
    _other_wrappers()


def _other_wrappers():
    """Those that the page does not show."""
    import mo_gymnasium as package
    from mo_gymnasium.wrappers import MOClipReward, MOMaxAndSkipObservation
    from mo_gymnasium.wrappers.vector import MOSyncVectorEnv

    def make():
        return package.make(f"{ID[:-3]}MO-v0", max_episode_steps=200)

    expected = [alone(i, [1] * 8)[2] for i in range(2)]
    vectors = np.array([[[info["speed"], info["memory"]] for info in infos[1:]] for infos in expected])
    skipping = MOMaxAndSkipObservation(make(), skip=4)
    skipping.reset(seed=0)
    np.testing.assert_allclose(skipping.step(1)[1], vectors[0, :4].sum(axis=0), rtol=1e-6)
    clipped = MOClipReward(make(), 1, -0.01, 0.01)
    clipped.reset(seed=0)
    np.testing.assert_array_equal(
        [clipped.step(1)[1] for _ in range(8)],
        np.column_stack([vectors[0, :, 0], np.clip(vectors[0, :, 1], -0.01, 0.01)]),
    )
    # MOAsyncVectorEnv of 1.3 cannot be made under Gymnasium 1.4, whatever the environment.
    batch = MOSyncVectorEnv([make, make])
    batch.reset(seed=0)
    rewards = np.array([batch.step(np.ones(2, int))[1] for _ in range(8)])
    np.testing.assert_array_equal(rewards, np.float32(vectors.swapaxes(0, 1)))


def morl_baselines(run):
    speed, memory = run()["returns"] / 100
    assert speed > 2 * RANDOM_SPEED  # after so few steps
    assert np.isfinite(memory)


def rl_zoo3(run):
    import torch
    from stable_baselines3 import PPO

    from stickslip.train.hyperparameters import read_hyperparameters
    from stickslip.train.run import Configuration
    from stickslip.train.training import train

    left = run()
    (file,) = left["folder"].glob("zoo/ppo/*/*.zip")
    theirs = PPO.load(file, device="cpu")
    # The same training by our own command, over the batch: the same policy, to the bit.
    hyperparameters = read_hyperparameters("ppo", ID) | {"n_timesteps": 20_000}
    ours = train(Configuration("ppo", env_kwargs=SPEED, hyperparameters=hyperparameters), left["folder"] / "ours")
    weights = PPO.load(ours.final, device="cpu").policy.state_dict()
    for name, value in theirs.policy.state_dict().items():
        assert torch.equal(value, weights[name]), name
    assert theirs.num_timesteps == 24_576  # three rollouts


def rllib(run):
    left = run()
    from ray.rllib.env.single_agent_env_runner import SingleAgentEnvRunner

    from stickslip.envs import StickSlipCrawlerVectorEnv

    assert isinstance(left["algorithm"].env_runner.env.unwrapped, StickSlipCrawlerVectorEnv)
    assert left["results"]["num_episodes"] == 32
    assert 0.5 * RANDOM_SPEED < left["results"]["episode_return_mean"] / 200 < 2 * RANDOM_SPEED
    left["algorithm"].stop()

    config = left["config"].copy(copy_frozen=False).environment(env_config={"memory_weight": 0.2, "dither": 0.1})
    runner = SingleAgentEnvRunner(config=config)
    episodes = runner.sample(num_timesteps=32 * 40, random_actions=True)
    assert len(episodes) == 32
    for seed, episode in zip(runner.env.unwrapped.np_random_seed, episodes, strict=True):
        observations, rewards, infos = alone(seed, episode.get_actions())
        np.testing.assert_array_equal(np.array(episode.get_observations()), observations)
        np.testing.assert_array_equal(np.array(episode.get_rewards()), rewards)
        assert [info["innovation"] for info in episode.get_infos()] == [info["innovation"] for info in infos]
    runner.stop()


def tianshou(run):
    left = run()
    assert left["stats"].returns.mean() / 100 > 1.5 * RANDOM_SPEED

    from tianshou.data import Collector, VectorReplayBuffer
    from tianshou.env import DummyVectorEnv

    envs = DummyVectorEnv([lambda: gym.make(ID, max_episode_steps=60)] * 4)
    envs.seed(7)
    buffer = VectorReplayBuffer(4 * 60, 4)
    Collector(left["algorithm"], envs, buffer).collect(n_episode=4, random=True, reset_before_collect=True)
    for i, each in enumerate(buffer.buffers):
        observations, rewards, infos = alone(7 + i, each.act, resets=2)  # to seed is to reset
        np.testing.assert_array_equal(each.obs, observations[:-1])
        np.testing.assert_array_equal(each.obs_next, observations[1:])
        np.testing.assert_array_equal(each.rew, rewards)
        np.testing.assert_array_equal(each.info.memory, [info["memory"] for info in infos[1:]])
        assert each.truncated.tolist() == [False] * 59 + [True]


@contextlib.contextmanager
def _environment_variable(name, value):
    before = os.environ.get(name)
    os.environ[name] = value
    try:
        yield
    finally:
        if before is None:
            del os.environ[name]
        else:
            os.environ[name] = before


CHECKS = {
    "Gymnasium": gymnasium,
    "Play": play,
    "Stable-Baselines3": stable_baselines3,
    "CleanRL": cleanrl,
    "TorchRL": torchrl,
    "Minari": minari,
    "skrl": skrl,
    "MO-Gymnasium": mo_gymnasium,
    "MORL-Baselines": morl_baselines,
    "rl-zoo3": rl_zoo3,
    "RLlib": rllib,
    "Tianshou": tianshou,
}
