"""Plan by branching: a thousand futures of one crawler, tried out side by side in one batch.

Run ``python examples/branching.py``. A crawler is steered by random shooting: at every decision its state is copied
into a thousand sub-environments, which follow a hundred random schedules of the valve, ten each, and the crawler takes
the first steps of the schedule that earned most on average. The branches have flips of their own, since a planner does
not know those to come.
"""

import argparse
from collections.abc import Iterator

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

BRANCHES, FUTURES, HORIZON, KEPT = 1000, 10, 12, 3


def plan(branches: gym.vector.VectorEnv, state, generator: np.random.Generator) -> NDArray[np.int64]:
    """Random schedule that earns most from a state on, in the mean of FUTURES flips, shape (HORIZON,)."""
    branches.unwrapped.set_state(state)
    schedules = generator.integers(0, 2, (HORIZON, branches.num_envs // FUTURES))
    earned = sum(branches.step(np.repeat(commands, FUTURES))[1] for commands in schedules)
    return schedules[:, np.argmax(earned.reshape(-1, FUTURES).mean(axis=1))]


def steer(env: gym.Env, branches: gym.vector.VectorEnv, seed: int) -> Iterator[tuple[float, dict]]:
    """Reward and info of each step of one planned episode."""
    generator = np.random.default_rng(seed)
    env.reset(seed=seed)
    branches.reset(seed=seed)
    while True:
        state = env.unwrapped.get_state(generator=False)
        for command in plan(branches, state, generator)[:KEPT].tolist():
            _, reward, _, truncated, info = env.step(command)
            yield reward, info
            if truncated:
                return


def main(steps: int, memory_weight: float) -> None:
    """Print what the planned episode earns, beside that of the fastest schedule known."""
    arguments = {"memory_weight": memory_weight}
    env = gym.make("stickslip:StickSlipCrawler-v0", max_episode_steps=steps, **arguments)
    batch = gym.make_vec("stickslip:StickSlipCrawler-v0", BRANCHES, max_episode_steps=None, **arguments)
    planned = [reward for reward, _ in steer(env, batch, seed=0)]
    env.reset(seed=0)
    periodic = [env.step([1, 1, 1, 0, 0][k % 5])[1] for k in range(steps)]
    print(f"mean reward over {steps} steps: planned {np.mean(planned):.3f}, schedule 11100 {np.mean(periodic):.3f}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Random shooting over branches of one state.")
    parser.add_argument("--steps", type=int, default=200)
    parser.add_argument("--memory-weight", type=float, default=0.0)
    chosen = parser.parse_args()
    main(chosen.steps, chosen.memory_weight)
