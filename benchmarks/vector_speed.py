"""Steps per second of the batched environment: beside other batched environments, and by the size of the batch.

Run ``python benchmarks/vector_speed.py`` (``--rounds N`` for more turns). Environments take turns in one process, so
that the machine's drift falls on all alike; ratios are of neighbours in time. Their median and quartiles are printed as
the tables of the docs and kept in `benchmarks/results/vector_speed.json`. Every step gets fresh random actions,
drawn beforehand, and episodes that end begin again inside the timing. EnvPool is one of the extra `peers`; without it
its rows are left out.
"""

import argparse
import os
import subprocess
import sys
from collections.abc import Callable
from itertools import cycle
from pathlib import Path
from typing import Any

# Matrices are small here: idle threads would take the processor from others. This must come before NumPy's import.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import gymnasium as gym
import numpy as np
from lanes import floor
from measuring import keep, machine, quartiles, refresh, take_turns

from stickslip.common.extras import MissingExtra, optional_import

RESULTS = Path(__file__).parent / "results" / "vector_speed.json"
PAGE = Path(__file__).parents[1] / "docs" / "vector.md"
NAME = "stickslip:StickSlipCrawler-v0"
MANY = 4096
SIZES = [1, 4, 16, 64, 256, 1024, 4096, 16384, 65536]
NO_READOUT: dict[str, Any] = {"dither": 0.0, "memory_weight": 0.0}
LINEAR: dict[str, Any] = {"groups": "linear", "scene": {"anchored": True}, **NO_READOUT}
ENVPOOL, CARTPOLE = "EnvPool CartPole-v1", "Gymnasium CartPoleVectorEnv"
READOUT, SPEED = "crawler, memory readout on", "crawler, readout off"
ANCHORED = "anchored linear crawler, readout off"
TARGETS = {READOUT: (ENVPOOL, 2.0), SPEED: (ENVPOOL, 5.0), ANCHORED: (CARTPOLE, 0.5)}


def stepping(env: Any, count: int, kind: type = np.int64) -> Callable[[], object]:
    """Steps of a batched environment, each with other actions."""
    env.reset(seed=0)
    actions = cycle(np.random.default_rng(0).integers(0, 2, (64, count)).astype(kind))
    for _ in range(30):
        env.step(next(actions))
    return lambda: env.step(next(actions))


def envpool(count: int, threads: int) -> Any:
    with optional_import():
        import envpool

    return _Seedless(envpool.make("CartPole-v1", env_type="gymnasium", num_envs=count, num_threads=threads))


class _Seedless:
    """EnvPool takes its seed when it is made."""

    def __init__(self, env: Any) -> None:
        self.step = env.step
        self._env = env

    def reset(self, seed: int) -> None:
        self._env.reset()


def contenders() -> dict[str, Callable[[], object]]:
    works = {CARTPOLE: stepping(gym.make_vec("CartPole-v1", MANY, vectorization_mode="vector_entry_point"), MANY)}
    for threads in (1, 2):
        try:
            works[f"{ENVPOOL}, threads={threads}"] = stepping(envpool(MANY, threads), MANY, np.int32)
        except MissingExtra as missing:
            print(missing, file=sys.stderr)
            break
    for name, arguments in ((READOUT, {}), (SPEED, NO_READOUT), (ANCHORED, LINEAR)):
        for threads in (1, 2):
            works[f"{name}, threads={threads}"] = stepping(gym.make_vec(NAME, MANY, threads=threads, **arguments), MANY)
    return works


def peers(rounds: int) -> dict[str, Any]:
    """Steps per second, and how many times those of a peer, by contender."""
    seconds = take_turns(contenders(), rounds)
    rates = {name: {turn: MANY / each for turn, each in turns.items()} for name, turns in seconds.items()}
    results: dict[str, Any] = {}
    for name, rate in rates.items():
        results[name] = {"steps/s": quartiles(list(rate.values()))}
        ours = name.rpartition(", ")[0]
        if ours not in TARGETS:
            continue
        peer, target = TARGETS[ours]
        # Against the better of the peer's settings in the same round.
        shared = [turn for turn in rate if all(turn in rates[other] for other in rates if other.startswith(peer))]
        others = [other for other in rates if other.startswith(peer)]
        if others:
            ratios = [rate[turn] / max(rates[other][turn] for other in others) for turn in shared]
            results[name] |= {"peer": peer, "target": target, "ratio": quartiles(ratios)}
    for ours in TARGETS:
        one, two = (rates[f"{ours}, threads={threads}"] for threads in (1, 2))
        results[f"{ours}, threads=2"]["over one thread"] = quartiles(
            [two[turn] / one[turn] for turn in one if turn in two]
        )
    return results


def sizes(rounds: int) -> dict[int, list[float]]:
    """Microseconds per crawler and step, by the size of the batch."""
    works = {str(count): stepping(gym.make_vec(NAME, count), count) for count in SIZES}
    seconds = take_turns(works, rounds, budget=10.0)
    return {
        int(name): quartiles([1e6 * each / int(name) for each in turns.values()]) for name, turns in seconds.items()
    }


def bytes_each(**arguments: Any) -> float:
    """Resident memory that a crawler adds to a process."""
    program = (
        "import resource, sys, gymnasium as gym, numpy as np\n"
        f"env = gym.make_vec({NAME!r}, int(sys.argv[1]), **{arguments!r}); env.reset(seed=0)\n"
        "env.step(np.zeros(int(sys.argv[1]), int))\n"
        "print(int(open('/proc/self/statm').read().split()[1]) * resource.getpagesize())"
    )
    few, many = 4096, 65536
    sizes = [int(subprocess.check_output([sys.executable, "-c", program, str(n)])) for n in (few, many)]
    return (sizes[1] - sizes[0]) / (many - few)


def tables(results: dict[str, Any]) -> dict[str, str]:
    """Tables of the docs, by their marks."""
    peers = ["| environment, n = 4096 | steps/s | ratio | target |", "|---|---:|---:|---:|"]
    for name, row in results["peers"].items():
        low, middle, high = (each / 1e6 for each in row["steps/s"])
        ratio, target = "", ""
        if "ratio" in row:
            ratio = "{1:.2f} [{0:.2f}, {2:.2f}] of {3}".format(*row["ratio"], row["peer"])
            target = f"{row['target']:g}"
        peers.append(f"| {name} | {middle:.2f}M [{low:.2f}, {high:.2f}] | {ratio} | {target} |")
    threads = ["| two threads over one, n = 4096 | ratio |", "|---|---:|"]
    for name, row in results["peers"].items():
        if "over one thread" in row:
            threads.append(
                "| {3} | {1:.2f} [{0:.2f}, {2:.2f}] |".format(*row["over one thread"], name.rpartition(",")[0])
            )
    by_size = ["| n | us per crawler and step |", "|---:|---:|"]
    for count, (low, middle, high) in results["sizes"].items():
        by_size.append(f"| {count} | {middle:.3g} [{low:.3g}, {high:.3g}] |")
    memory = ["| | kB per crawler |", "|---|---:|"]
    memory += [f"| {name} | {size / 1e3:.1f} |" for name, size in results["bytes"].items()]
    least, core = results["floor"], results["peers"][f"{SPEED}, threads=1"]["steps/s"][1]
    bound = [
        "| physics of a hold, one core | |",
        "|---|---:|",
        f"| steps of the Taylor series | {least['steps a hold']:.2f} |",
        f"| operations in a step | {least['operations a step']} |",
        f"| operations in each of 4 samples | {least['operations a sample']} |",
        f"| peak measured, multiply-adds in all lanes | {least['peak, operations a us'] / 1e3:.0f} operations/ns |",
        f"| so the floor is | {least['us a hold']:.3f} us |",
        f"| a step of the environment, readout off, takes | {1e6 / core:.2f} us |",
    ]
    made = {"floor": bound, "peers": peers, "threads": threads, "sizes": by_size, "memory": memory}
    return {f"vector {name}": "\n".join(lines) for name, lines in made.items()}


def main() -> None:
    """Measure, print the tables, and keep them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=31)
    rounds = parser.parse_args().rounds
    results = {
        "machine": machine("gymnasium", "envpool"),
        "rounds": rounds,
        "peers": peers(rounds),
        "sizes": sizes(rounds),
        "floor": floor(),
        "bytes": {"memory readout on": bytes_each(), "readout off": bytes_each(**NO_READOUT)},
    }
    made = tables(results)
    print("\n\n".join(made.values()))
    keep(RESULTS, results)
    refresh(PAGE, made)


if __name__ == "__main__":
    main()
