# %% [markdown]
# # Tutorial: train a policy
#
# ![A learned gait: the body stretches, the foot sticks, then slides](../images/gait.gif)
#
# You have trained agents on CartPole or MuJoCo, and want to see what this body asks of one. In ten minutes: step the
# environment, train PPO for speed, see what a policy of the knee does differently, and keep a policy as plain numbers.
#
# You need [the extras](../installation.md) `train`, `plot` and `render`. Every cell below was run when this page was built.

# %%
import gymnasium as gym
import matplotlib.pyplot as plt
import numpy as np

import stickslip  # registers the environments

speed_alone = {"memory_weight": 0.0, "dither": 0.0}
env = gym.make("StickSlipCrawler-v0", **speed_alone, render_mode="rgb_array")
observation, info = env.reset(seed=0)
pictures = []
for step in range(23):
    observation, reward, terminated, truncated, info = env.step(int(observation[0] < 0.3))
    if step >= 20:
        pictures.append(env.render())

figure, panels = plt.subplots(3, figsize=(6, 6), layout="constrained")
for step, (panel, picture) in enumerate(zip(panels, pictures, strict=True), 20):
    panel.imshow(picture)
    panel.set(ylabel=f"step {step}", xticks=[], yticks=[])

# %% [markdown]
# ## The loop
#
# The action is the valve: 1 opens it and the body inflates, 0 shuts it. One step is one *hold* of half a natural time
# unit. The observation is deformation, its rate, pressure, the foot's velocity and the valve's state, and the reward,
# with `memory_weight=0`, is the speed of the foot. Nothing terminates; `gym.make` truncates after 1000 steps.
#
# Two policies that need no learning say what a number is worth: coin flips, and the rule above, which opens the valve
# while the body is short.


# %%
def speed_of(act, steps=400):
    """Mean speed of a policy, in lengths z_c per time t_c."""
    observation, info = env.reset(seed=1)
    for _ in range(steps):
        observation, _, _, _, info = env.step(int(act(observation)))
    return info["distance"] / (steps * env.unwrapped.settings.hold)


generator = np.random.default_rng(0)
speeds = {
    "coin flips": speed_of(lambda observation: generator.integers(2)),
    "open while short": speed_of(lambda observation: observation[0] < 0.3),
}
for name, speed in speeds.items():
    print(f"{name:18} speed {speed:.3f}")

# %% [markdown]
# ## PPO over a batch
#
# `StickSlipVecEnv` hands Stable-Baselines3 a batch of crawlers that one compiled call steps, and that is to the bit what
# so many single environments would be. PPO is as it comes but for a few hyperparameters.

# %%
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecMonitor

from stickslip.train import library_threads, StickSlipVecEnv


class Curve(BaseCallback):
    """Mean reward of each rollout, which here is the mean speed."""

    def _on_training_start(self):
        self.steps, self.rewards = [], []

    def _on_step(self):
        return True

    def _on_rollout_end(self):
        self.steps.append(self.num_timesteps)
        self.rewards.append(self.model.rollout_buffer.rewards.mean())


envs = VecMonitor(StickSlipVecEnv(256, **speed_alone, max_episode_steps=200, sparse_infos=True))
chosen = {"n_steps": 32, "batch_size": 2048, "learning_rate": 1e-3, "gamma": 0.98}
model = PPO("MlpPolicy", envs, **chosen, device="cpu", seed=0)
curve = Curve()
with library_threads(1):
    model.learn(150_000, callback=curve)
speeds["PPO"] = speed_of(lambda observation: model.predict(observation, deterministic=True)[0])

figure, axes = plt.subplots(figsize=(6, 3), layout="constrained")
axes.plot(curve.steps, curve.rewards, "o-", label="PPO while it explores")
axes.axhline(speeds["PPO"], color="C0", ls="--", lw=1, label="PPO, its best action")
axes.axhline(speeds["open while short"], color="C1", label="open while short")
axes.axhline(speeds["coin flips"], color="0.5", label="coin flips")
axes.set(xlabel="steps of a crawler", ylabel="speed ($z_c / t_c$)", ylim=(0, 1.2))
axes.legend(loc="lower right")
print(f"PPO: speed {speeds['PPO']:.3f}")

# %% [markdown]
# Speed alone is easy: PPO comes to what the rule has. With flips the fastest that any policy can be is known, too,
# [by dynamic programming](../trade_limits.md). Longer trainings,
# other algorithms, evaluations, checkpoints and a verdict in words are one command, `stickslip train`: see
# [training](../training.md).
#
# ## What the reward of memory asks for
#
# Every command is flipped with probability `dither`. The flips are a message that nobody could have known, and what a
# linear readout can tell of them from the body's motion is its *memory*. A policy is paid
# `(1 - memory_weight) * speed + memory_weight * memory`. The package ships policies of this trade. Here are the fast one
# and the one of the knee, each in the environment that it was trained in, beside the valve held open.

# %%
from stickslip import memory_capacity
from stickslip.tasks import innovation


def judge(policy, steps=4000, **settings):
    """Speed and memory capacity of a policy over one long run with flips."""
    crawler = gym.make("StickSlipCrawler-v0", max_episode_steps=-1, **settings).unwrapped
    observation, _ = crawler.reset(seed=7)
    states, commands, valves = [], [], []
    for _ in range(steps):
        command = policy(observation)
        observation, _, _, _, info = crawler.step(int(command))
        states.append(crawler.readout_states())
        commands.append(command)
        valves.append(info["valve"])
    message = innovation(np.array(valves), np.array(commands), dither=crawler.settings.dither)
    memory = memory_capacity(np.array(states), message, delays=20)
    return info["distance"] / (steps * crawler.settings.hold), memory.corrected


points = {"valve held open": judge(lambda observation: 1, dither=0.1)}
for name in ("speed", "knee"):
    policy = stickslip.pretrained(name)
    points[f'policy "{name}"'] = judge(policy.predict, **policy.env_kwargs)

figure, axes = plt.subplots(figsize=(6, 3.2), layout="constrained")
for name, (speed, memory) in points.items():
    axes.plot(speed, memory, "o", ms=9, label=name)
axes.set(xlabel="speed ($z_c / t_c$)", ylabel="memory capacity", xlim=(0, 1), ylim=(0, 5))
axes.legend()
for name, (speed, memory) in points.items():
    print(f"{name:18} speed {speed:.2f}, memory {memory:.2f}")

# %% [markdown]
# The policy of the knee gives up little speed and keeps far more of the message. [The front](../trade.md) has all between,
# and says what such a policy has learned.
#
# ## Keep it
#
# A policy is two files of plain numbers. To read them runs no code, and to act needs NumPy alone.

# %%
import tempfile
from pathlib import Path

from stickslip.train.policies import policy_of, read_policy, write_policy
from stickslip.train.run import Configuration

mine = policy_of(model, Configuration("ppo", env_kwargs=speed_alone))
with tempfile.TemporaryDirectory() as folder:
    write_policy(mine, Path(folder) / "mine")
    again = read_policy(Path(folder) / "mine")
observation, _ = env.reset(seed=3)
print(again, "acts", again.predict(observation))

# %% [markdown]
# ## From here
#
# - [The environment](../environment.md): actions, observations, rewards, arguments.
# - [Recipes](../recipes.md): TorchRL, RLlib, CleanRL, skrl, MO-Gymnasium and others.
# - [Thousands of crawlers at once](../vector.md), and bodies drawn at every reset.
# - [The memory reward](../reward.md), and other targets than memory.
