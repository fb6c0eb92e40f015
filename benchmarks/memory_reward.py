"""How well the memory reward of an episode stands for the memory capacity of a long run.

Run ``python benchmarks/memory_reward.py``: for eleven schedules, the offline capacity of one long run beside the mean
reward of episodes of 500, 1000 and 6000 steps, from a readout that starts cold and from the environment's own. Below
it, over schedules: the bias, the correlation with the offline capacity of single episodes and of their means.

Run ``python benchmarks/memory_reward.py --scan`` for what chose `weight` and `_RIDGE` in
`stickslip.reservoir.prequential`: root-mean-square error of single episodes of 1000 steps and their bias, for three
strengths of dither, two holds and three bodies. Schedules, seeds and flips are the same for all settings compared.
"""

import argparse
from collections.abc import Iterator
from itertools import product

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from stickslip.reservoir import memory_capacity, prequential, RecursiveLeastSquares
from stickslip.tasks import crawler_states, dithered, innovation, random_bits

Array = NDArray[np.float64]

DELAYS, NODES = 20, 4  # the environment's defaults
LENGTHS = (500, 1000, 6000)
EPISODES = 20
LONG = 60_000

WORDS = ["0", "1", "10", "110", "1100", "11100", "111000", "11110000", 6 * "1" + 6 * "0", 12 * "1" + 12 * "0"]
RANDOM = "random"
SCHEDULES = [*WORDS, RANDOM]

# The scan: fewer episodes, as it makes many, each after a calibration run like the environment's.
SCAN_EPISODES, SCAN_STEPS, CALIBRATION = 5, 1000, 2000
DITHERS = (0.02, 0.1, 0.5)
WEIGHTS = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0)
RIDGES = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2)


def commands(schedule: str, steps: int, seed: int) -> NDArray[np.int64]:
    if schedule == RANDOM:
        return random_bits(steps, seed)
    return np.resize(np.array(list(schedule), dtype=np.int64), steps)


def label(schedule: str) -> str:
    names = {"0": "always shut", "1": "always open", RANDOM: "random"}
    return names.get(schedule, schedule if len(schedule) <= 8 else f"period {len(schedule)}")


def run(schedule: str, steps: int, seed: int, dither: float, hold: float, groups: str | None) -> tuple[Array, Array]:
    """States (steps, 3 * NODES) and innovations (steps,) of a crawler that follows a schedule, dithered."""
    command = commands(schedule, steps, seed)
    valve = dithered(command, dither, seed + 1)
    states = crawler_states(valve, groups=groups, hold=hold, virtual_nodes=NODES, tolerance=1e-6)
    return states, innovation(valve, command, dither)


def offline(schedule: str, dither: float, hold: float, groups: str | None) -> float:
    """Memory capacity of a run long enough for its error not to matter."""
    return memory_capacity(*run(schedule, LONG, 1000, dither, hold, groups), DELAYS).corrected


def rewards_of_the_environment(schedule: str, steps: int, seed: int) -> tuple[Array, Array, Array]:
    """Memory rewards of the default environment, and the states and innovations they were earned with."""
    env = gym.make("stickslip:StickSlipCrawler-v0", max_episode_steps=steps)
    env.reset(seed=seed)
    infos = [env.step(int(action))[4] for action in commands(schedule, steps, seed)]
    states = crawler_states([info["valve"] for info in infos], virtual_nodes=NODES, tolerance=1e-6)
    return np.array([info["memory"] for info in infos]), states, np.array([info["innovation"] for info in infos])


def rewards_from_cold(states: Array, message: Array, variance: float) -> Array:
    """Memory rewards of a readout that starts without weights, and with the penalty of one sample."""
    scaled = (states - states.mean(axis=0)) / states.std(axis=0)  # which flatters it: a real start knows neither
    features = np.column_stack([scaled, np.ones(len(states))])
    # Messages from before the start are taken as 0, which earns nothing: 20 of the steps are hardly a difference.
    past = np.lib.stride_tricks.sliding_window_view(np.concatenate([np.zeros(DELAYS - 1), message]), DELAYS)[:, ::-1]
    readout = RecursiveLeastSquares(features.shape[1], DELAYS)
    guess = np.array([readout.learn(row, target) for row, target in zip(features, past, strict=True)])
    earned: Array = (past**2 - (past - guess) ** 2).sum(axis=1) / variance
    return earned


def compare() -> None:
    """Print the reward of the default environment beside the offline capacity."""
    dither, hold = 0.1, 0.5
    capacity = np.array([offline(schedule, dither, hold, None) for schedule in SCHEDULES])
    starts = ("cold", "environment")
    earned = {key: np.empty((len(SCHEDULES), EPISODES)) for key in product(starts, LENGTHS)}
    for row, schedule in enumerate(SCHEDULES):
        for episode in range(EPISODES):
            warm, states, message = rewards_of_the_environment(schedule, max(LENGTHS), 100 + episode)
            for steps in LENGTHS:
                cold = rewards_from_cold(states[:steps], message[:steps], dither * (1 - dither))
                earned["environment", steps][row, episode] = warm[:steps].mean()
                earned["cold", steps][row, episode] = cold.mean()

    print(
        f"default environment, dither {dither}, hold {hold}: mean memory reward of {EPISODES} episodes (s.d. of one)\n"
    )
    heads = "".join(f"{start + ' ' + str(steps):>18}" for start, steps in earned)
    print(f"{'schedule':24}{'offline':>9}{heads}")
    for row, schedule in enumerate(SCHEDULES):
        cells = "".join(f"{scores[row].mean():11.2f} ({scores[row].std():.2f})" for scores in earned.values())
        print(f"{label(schedule):24}{capacity[row]:9.2f}{cells}")
    print()
    for name, values in statistics(capacity, list(earned.values())):
        print(f"{name:33}" + "".join(f"{value:18.3f}" for value in values))


def statistics(capacity: Array, earned: list[Array]) -> Iterator[tuple[str, list[float]]]:
    """What the table comes to, one number a column; `earned` holds arrays (schedules, episodes)."""

    def correlation(scores: Array) -> float:
        return float(np.corrcoef(scores, capacity)[0, 1])

    yield "bias", [float((scores.mean(axis=1) - capacity).mean()) for scores in earned]
    yield "root-mean-square error", [float(np.sqrt(((scores - capacity[:, None]) ** 2).mean())) for scores in earned]
    yield "correlation of episodes", [float(np.mean([correlation(one) for one in scores.T])) for scores in earned]
    yield "correlation of means", [correlation(scores.mean(axis=1)) for scores in earned]


def scan() -> None:
    """Print the error of a single episode for every weight and ridge of the calibrated start."""
    bodies = [(0.5, None), (0.5, "high-damping"), (0.5, "extreme-fluid-lag")]
    bodies += [(2.0, groups) for _, groups in bodies]
    print(f"root-mean-square error (bias) of episodes of {SCAN_STEPS} steps over {len(SCHEDULES)} schedules")
    print("across: ridge " + ", ".join(f"{ridge:g}" for ridge in RIDGES))
    mean = {dither: np.zeros((len(WEIGHTS), len(RIDGES))) for dither in DITHERS}
    for dither, (hold, groups) in product(DITHERS, bodies):
        capacity = np.array([offline(schedule, dither, hold, groups) for schedule in SCHEDULES])
        calibration = run(RANDOM, CALIBRATION, 7, dither, hold, groups)
        episodes = [
            [run(schedule, SCAN_STEPS, 100 + 2 * seed, dither, hold, groups) for seed in range(SCAN_EPISODES)]
            for schedule in SCHEDULES
        ]
        print(f"\ndither {dither}, hold {hold}, {groups or 'default groups'}: capacity ", end="")
        print(" ".join(f"{value:.2f}" for value in capacity))
        for i, weight in enumerate(WEIGHTS):
            line = []
            for j, ridge in enumerate(RIDGES):
                error = _errors(calibration, episodes, capacity, dither, weight, ridge)
                rms = np.sqrt((error**2).mean())
                mean[dither][i, j] += rms / len(bodies)
                line.append(f"{rms:6.3f} ({error.mean():+.3f})")
            print(f"weight {weight:5g}  " + "  ".join(line))
    for dither, table in mean.items():
        print(f"\ndither {dither}: root-mean-square error, mean over holds and bodies")
        for weight, row in zip(WEIGHTS, table, strict=True):
            print(f"weight {weight:5g}  " + "  ".join(f"{value:6.3f}" for value in row))


def _errors(
    calibration: tuple[Array, Array],
    episodes: list[list[tuple[Array, Array]]],
    capacity: Array,
    dither: float,
    weight: float,
    ridge: float,
) -> Array:
    """Mean reward less offline capacity, (schedules, episodes)."""
    prequential._RIDGE = ridge  # a constant to all others
    memory = prequential.PrequentialMemory(*calibration, DELAYS, variance=dither * (1 - dither), weight=weight)
    error = np.empty((len(episodes), len(episodes[0])))
    for row, several in enumerate(episodes):
        for column, (states, message) in enumerate(several):
            memory.reset()
            earned = [memory.score(state, e) for state, e in zip(states, message.tolist(), strict=True)]
            error[row, column] = np.mean(earned) - capacity[row]
    return error


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Memory reward against offline memory capacity.")
    parser.add_argument("--scan", action="store_true", help="vary the weight and the ridge of the calibrated start")
    scan() if parser.parse_args().scan else compare()
