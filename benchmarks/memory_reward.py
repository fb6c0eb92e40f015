"""How well the memory reward of an episode stands for the memory capacity of a long run.

Run ``python benchmarks/memory_reward.py``: for several environments, and over schedules of the valve that any policy
might follow, the offline capacity of long runs beside the mean reward of episodes of several lengths. Below it,
policies that look one step ahead at what they are going to earn, for a reward that could be had without capacity would
show there. The same for rewards of other targets than memory. The tables go into ``docs/reward.md``; ``--only targets``
measures those alone again.
"""

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from measuring import keep, machine, refresh
from numpy.typing import NDArray

from stickslip.envs.settings import Settings
from stickslip.reservoir import memory_capacity, target_series
from stickslip.tasks import crawler_states, dithered, innovation, random_bits

Array = NDArray[np.float64]

NAME = "stickslip:StickSlipCrawler-v0"
PAGE = Path(__file__).parents[1] / "docs" / "reward.md"
RESULTS = Path(__file__).parent / "results" / "memory_reward.json"

RANGES = {
    "duffing": [0.0, 2.0],
    "damping_ratio": [0.02, 0.5],
    "deborah": [0.2, 2.0],
    "static_friction": [0.25, 0.6],
    "radial_coupling": [0.0, 0.5],
}
CASES: dict[str, dict[str, Any]] = {
    "the defaults": {},
    "`dither=0.5`": {"dither": 0.5},
    "`dither=0.02`": {"dither": 0.02},
    "`dither=0.01`": {"dither": 0.01},
    "`delays=100`": {"delays": 100},
    "`virtual_nodes=16`": {"virtual_nodes": 16},
    "`hold=2.0`": {"hold": 2.0},
    "five groups drawn": {"randomize": RANGES},
}
TARGETS: dict[str, dict[str, Any]] = {
    "products of 2, dither 0.1": {"target": "parity"},
    "products of 2, dither 0.25": {"target": "parity", "dither": 0.25},
    "the same, `delays=4`": {"target": "parity", "dither": 0.25, "delays": 4},
    "products of 3, dither 0.25": {"target": "parity", "target_order": 3, "dither": 0.25},
    "NARMA of order 2, dither 0.1": {"target": "narma"},
    "NARMA of order 2, dither 0.25": {"target": "narma", "dither": 0.25},
    "NARMA of order 5, dither 0.1": {"target": "narma", "target_order": 5},
}
RANDOM = "random"
SCHEDULES = ("0", "1", "10", "1100", "11100", "11110000", 6 * "1" + 6 * "0", RANDOM)
LENGTHS = (200, 500, 1000, 6000)
LONG = 40_000
LONGER = 80_000  # two flips in turn are rare
GREEDY_STEPS = 6000


def commands(schedule: str, steps: int, seed: int = 0) -> NDArray[np.int64]:
    if schedule == RANDOM:
        return random_bits(steps, seed)
    return np.resize(np.array(list(schedule), dtype=np.int64), steps)


def capacity(settings: Settings, groups: Any, schedule: str, steps: int) -> float:
    """Memory capacity of one long run of a body that follows a schedule, dithered."""
    command = commands(schedule, steps, 1)
    valve = dithered(command, settings.dither, 2)
    return capacity_of(settings, groups, valve, innovation(valve, command, settings.dither))


def capacity_of(settings: Settings, groups: Any, valve: Any, innovations: Array) -> float:
    message = target_series(innovations, settings.target, settings.target_order, settings.dither)
    states = crawler_states(
        valve, groups=groups, hold=settings.hold, virtual_nodes=settings.virtual_nodes, tolerance=settings.tolerance
    )
    return memory_capacity(states, message, settings.messages).corrected


def measure(arguments: dict[str, Any], episodes: int, long: int = LONG) -> dict[str, Any]:
    """Offline capacities and rewards: arrays over schedules, and over schedules and lengths."""
    envs = gym.make_vec(NAME, episodes, max_episode_steps=None, **arguments)
    truth, earned, spread, worst = [], [], [], 0.0
    for number, schedule in enumerate(SCHEDULES):
        _, infos = envs.reset(seed=1000 * number)
        settings = envs.unwrapped.settings
        bodies = [settings.groups]
        if settings.randomize:
            drawn = {name: each for name, each in infos["groups"].items() if not name.startswith("_")}
            bodies = [{name: float(each[i]) for name, each in drawn.items()} for i in range(episodes)]
        truth.append(np.mean([capacity(settings, body, schedule, long // len(bodies) + 10_000) for body in bodies]))
        steps = commands(schedule, max(LENGTHS))
        memory = np.array([envs.step(np.full(episodes, command))[4]["memory"] for command in steps])
        means = [memory[:length].mean(axis=0) for length in LENGTHS]
        earned.append([float(each.mean()) for each in means])
        spread.append([float(each.std()) for each in means])
        worst = min(worst, float(memory[:1000].min()))
    return {"truth": truth, "earned": earned, "spread": spread, "worst": worst}


def greedy(sign: float, steps: int, **arguments: Any) -> tuple[float, float]:
    """Mean reward, and offline capacity, of a policy that looks one step ahead at what it will earn, or lose."""
    env = gym.make(NAME, max_episode_steps=-1, **arguments).unwrapped
    branches = gym.make_vec(NAME, 4, max_episode_steps=None, **arguments).unwrapped
    dither = env.settings.dither
    flips = {flip: next(seed for seed in range(1000) if flipped(seed, dither) is flip) for flip in (True, False)}
    seeds = [flips[flip] for flip in (False, True, False, True)]
    env.reset(seed=0)
    earned, valves, message = [], [], []
    for _ in range(steps):
        branches.set_state(env.get_state(generator=False))
        branches.np_random = [np.random.default_rng(seed) for seed in seeds]
        ahead = branches.step([0, 0, 1, 1])[4]["memory"].reshape(2, 2) @ [1 - dither, dither]
        info = env.step(int(np.argmax(sign * ahead)))[4]
        earned.append(info["memory"])
        valves.append(info["valve"])
        message.append(info["innovation"])
    return float(np.mean(earned)), capacity_of(env.settings, env.settings.groups, valves, np.array(message))


def flipped(seed: int, dither: float) -> bool:
    return bool(np.random.default_rng(seed).random() < dither)


def row(name: str, found: dict[str, Any]) -> str:
    truth, earned, spread = (np.array(found[key]) for key in ("truth", "earned", "spread"))
    bias = [f"{100 * (each.mean() / truth.mean() - 1):+.0f}%" for each in earned.T]
    place = LENGTHS.index(1000)
    cells = [
        name,
        f"{truth.mean():.2f}",
        *bias,
        f"{spread[:, place].mean():.2f}",
        f"{np.corrcoef(truth, earned[:, place])[0, 1]:.3f}" if np.std(truth) > 0.1 else "-",
        f"{found['worst']:.0f}",
    ]
    return f"| {' | '.join(cells)} |"


def table(cases: dict[str, dict[str, Any]]) -> str:
    heads = ["environment", "capacity", *(f"{length} steps" for length in LENGTHS)]
    heads += ["s.d. of 1000", "correlation", "worst step"]
    lines = [f"| {' | '.join(heads)} |", f"|---|{'---:|' * (len(heads) - 1)}"]
    return "\n".join([*lines, *(row(name, found) for name, found in cases.items())])


def target_row(name: str, found: dict[str, Any]) -> str:
    truth, earned = np.array(found["truth"]), np.array(found["earned"])
    shown = [truth[SCHEDULES.index(schedule)] for schedule in ("1", "11100", RANDOM)]
    bias = (earned - truth[:, np.newaxis]).mean(axis=0)
    cells = [f"{each:.2f}" for each in shown] + [f"{truth.mean():.2f}"] + [f"{each:+.2f}" for each in bias]
    spread = np.array(found["spread"])[:, LENGTHS.index(1000)].mean()
    return f"| {' | '.join([name, *cells, f'{spread:.2f}', f'{np.corrcoef(truth, earned[:, -1])[0, 1]:.3f}'])} |"


def target_table(cases: dict[str, dict[str, Any]]) -> str:
    heads = ["target", "held open", "11100", RANDOM, "mean of all", *(f"{length} steps" for length in LENGTHS)]
    heads += ["s.d. of 1000", "correlation"]
    lines = [f"| {' | '.join(heads)} |", f"|---|{'---:|' * (len(heads) - 1)}"]
    return "\n".join([*lines, *(target_row(name, found) for name, found in cases.items())])


def adversaries(found: dict[str, tuple[float, float]]) -> str:
    lines = [f"| policy | mean reward of {GREEDY_STEPS} steps | capacity of its run |", "|---|---:|---:|"]
    return "\n".join([*lines, *(f"| {name} | {earned:.2f} | {truth:.2f} |" for name, (earned, truth) in found.items())])


def main() -> None:
    """Print the tables, put them into the page and keep the results."""
    parser = argparse.ArgumentParser(description="Memory reward against offline memory capacity.")
    parser.add_argument("--episodes", type=int, default=64, help="of each schedule (default 64)")
    parser.add_argument("--only", choices=["targets"], help="what to measure again; the rest is as it was kept")
    chosen = parser.parse_args()
    episodes = chosen.episodes
    targets = {name: measure(arguments, episodes, LONGER) for name, arguments in TARGETS.items()}
    aimed = {
        "takes what earns more, products of 2": greedy(1.0, GREEDY_STEPS, target="parity", dither=0.25),
        "takes what earns more, NARMA of order 2": greedy(1.0, GREEDY_STEPS, target="narma", dither=0.25),
    }
    others = {"machine": machine(), "episodes": episodes, "cases": targets, "greedy": aimed}
    made = {"targets": target_table(targets), "target adversaries": adversaries(aimed)}
    if chosen.only:
        print("\n\n".join(made.values()))
        refresh(PAGE, made)
        keep(RESULTS, {**json.loads(RESULTS.read_text(encoding="utf-8")), "targets": others})
        return
    cases = {name: measure(arguments, episodes) for name, arguments in CASES.items()}
    policies: dict[str, Callable[[], tuple[float, float]]] = {
        "takes what earns more in the next step": lambda: greedy(1.0, GREEDY_STEPS),
        "takes what earns less": lambda: greedy(-1.0, GREEDY_STEPS),
        "takes what earns more, `delays=100`": lambda: greedy(1.0, GREEDY_STEPS, delays=100),
    }
    looking = {name: policy() for name, policy in policies.items()}
    made |= {"reward": table(cases), "adversaries": adversaries(looking)}
    print("\n\n".join(made.values()))
    refresh(PAGE, made)
    found = {"machine": machine(), "episodes": episodes, "lengths": LENGTHS, "cases": cases, "greedy": looking}
    keep(RESULTS, {**found, "targets": others})


if __name__ == "__main__":
    main()
