"""Steps per second through `gym.make(...).step` beside CartPole-v1.

Run ``python benchmarks/step_rate.py``. Actions are sampled and episodes reset when they end, all inside the timing.
The environments take turns, round after round in one process, so that the machine's drift falls on all alike; the
ratio to CartPole-v1 is that of neighbours in time, and its median and range over the rounds are printed.
"""

import time

import gymnasium as gym
import numpy as np

STEPS, ROUNDS = 10_000, 31
CARTPOLE = "CartPole-v1"
ENVIRONMENTS = {
    CARTPOLE: {"id": CARTPOLE},
    "StickSlipCrawler-v0": {"id": "stickslip:StickSlipCrawler-v0"},
    "... dither=0, memory_weight=0": {"id": "stickslip:StickSlipCrawler-v0", "dither": 0.0, "memory_weight": 0.0},
}


def steps_per_second(env: gym.Env, steps: int) -> float:
    start = time.perf_counter()
    for _ in range(steps):
        _, _, terminated, truncated, _ = env.step(env.action_space.sample())
        if terminated or truncated:
            env.reset()
    return steps / (time.perf_counter() - start)


def main() -> None:
    """Print the table."""
    envs = {}
    for name, arguments in ENVIRONMENTS.items():
        envs[name] = gym.make(**arguments)
        envs[name].reset(seed=0)
        envs[name].action_space.seed(0)
        steps_per_second(envs[name], 2000)  # compiles, fills caches

    rates: dict[str, list[float]] = {name: [] for name in envs}
    for turn in range(ROUNDS):
        # Every other round runs backward, so that no environment is always the first.
        for name in list(envs)[:: 1 if turn % 2 == 0 else -1]:
            rates[name].append(steps_per_second(envs[name], STEPS))

    print(f"{ROUNDS} rounds of {STEPS} steps: median [least, quartiles, most]\n")
    print(f"{'':32}{'steps/s':36}times {CARTPOLE}")
    for name, rate in rates.items():
        ratio = np.divide(rate, rates[CARTPOLE])
        print(f"{name:32}{spread(rate, '.0f'):36}{spread(ratio, '.2f') if name != CARTPOLE else ''}")


def spread(values: list[float], form: str) -> str:
    least, low, middle, high, most = np.quantile(values, [0, 0.25, 0.5, 0.75, 1])
    return f"{middle:{form}} [{least:{form}}, {low:{form}}, {high:{form}}, {most:{form}}]"


if __name__ == "__main__":
    main()
