"""From body to policy: what the demo shows, step by step."""

import json
import time
from pathlib import Path

import numpy as np

from ..common.extras import optional_import
from ..common.figures import save_figure
from ..common.files import atomically
from ..common.threads import library_threads
from ..crawler import Groups, Scene, simulate
from ..envs import StickSlipCrawlerEnv
from ..reservoir import memory_capacity
from ..studies.benchmark import run_benchmark, STANDARD_RESERVOIRS, table
from ..tasks import known_reservoirs, plot_memory_profile, random_bits
from ..train.evaluation import film, measure
from ..train.figures import plot_trade
from ..train.policies import read_policy
from ..train.schedules import necklaces, Performance, performances, repeat
from .classroom import Classroom, Lesson
from .page import write_page

with optional_import():
    from rich.console import Console
    from rich.table import Table

__all__ = ["run_demo"]

_HOLD = 0.5
_DITHER = 0.1
_BEST_WORD = "11100"
_LONGEST_WORD = 7
_HOLDS = 6000
_PROFILE_BITS = 8000
_DELAYS = 20


_SPEED = Lesson("speed policy", "speed", {"memory_weight": 0.0, "dither": 0.0, "valve_history": 4})
_MEMORY = Lesson("memory_weight = 0.5 policy", "memory", {"memory_weight": 0.5, "dither": _DITHER, "valve_history": 4})
_LESSONS = (_SPEED, _MEMORY)


def run_demo(folder: Path, seed: int = 0, steps: int | None = None) -> None:
    """Write figures, a clip, numbers and ``index.html`` into a folder, and print a short table.

    Parameters
    ----------
    folder : Path
        Made if it is missing. Policies that an interrupted demo left half trained are trained on from their last
        checkpoint; everything else is made anew.
    seed : int, >= 0
        Of everything random.
    steps : int, optional
        Environment steps of each training, instead of the hyperparameter file's.

    Raises
    ------
    OSError
        If the folder cannot be written.
    """
    console = Console()
    began = time.perf_counter()
    folder.mkdir(parents=True, exist_ok=True)
    # The two trainings take a core each; BLAS beside them must not take another.
    with library_threads(1), Classroom(folder / "policies", _LESSONS, seed, steps) as classroom:
        crawl = simulate(Groups(), repeat(_BEST_WORD, 40)[0], _HOLD, samples_per_hold=20)
        save_figure(crawl.plot(), folder / "trajectory.png")
        console.print(f"trajectory: {crawl.foot[-1]:.1f} z_c in {crawl.time[-1]:.0f} t_c with {crawl.slips} slips")

        bits = random_bits(_PROFILE_BITS, seed)
        known = known_reservoirs(hold=_HOLD)
        reservoirs = {name: known[name] for name in STANDARD_RESERVOIRS}
        profiles = {name: memory_capacity(drive(bits, seed), bits, _DELAYS) for name, drive in reservoirs.items()}
        save_figure(plot_memory_profile(profiles), folder / "memory.png")
        scores = run_benchmark(reservoirs=reservoirs, seeds=range(seed, seed + 5))
        tasks = table(scores)
        _print_table(console, "tasks, mean [95% interval of the mean] over 5 seeds", tasks)

        schedules = _open_loop(list(necklaces(_LONGEST_WORD)), seed)
        best = _open_loop([_BEST_WORD], seed, dither=0.0)[_BEST_WORD].speed
        classroom.show(console)

    policies = {lesson.name: read_policy(classroom.run(lesson).best_policy) for lesson in _LESSONS}
    quiet = StickSlipCrawlerEnv(**_SPEED.env_kwargs)
    noiseless = measure(policies[_SPEED.name], quiet, steps=2000, seed=seed)[0].speed
    measured = {
        name: measure(policy, StickSlipCrawlerEnv(**_MEMORY.env_kwargs), steps=_HOLDS, seed=seed)[0]
        for name, policy in policies.items()
    }
    save_figure(plot_trade(schedules, measured), folder / "trade.png")
    film(policies[_SPEED.name], folder / "gait.mp4", env_kwargs=_SPEED.env_kwargs, seed=seed)

    fastest = max(schedules, key=lambda word: schedules[word].speed)
    trade = _trade_table(
        {**{f"open loop {fastest}": schedules[fastest], "valve held open": schedules["1"]}, **measured}
    )
    _print_table(console, f"speed against memory, dither {_DITHER}", trade)
    console.print(
        f"speed policy without dither: {noiseless:.4f} z_c/t_c, "
        f"{noiseless / best:.1%} of the open-loop word {_BEST_WORD} ({best:.4f})"
    )
    elapsed = time.perf_counter() - began
    results = {
        "seed": seed,
        "seconds": elapsed,
        "scores": [score._asdict() for score in scores],
        "memory capacity": {name: profile.corrected for name, profile in profiles.items()},
        "open loop": {word: _numbers(result) for word, result in schedules.items()},
        "policies": {name: _numbers(result) for name, result in measured.items()},
        "speed policy without dither": noiseless,
        f"word {_BEST_WORD} without dither": best,
    }
    atomically(
        folder / "results.json", lambda path: path.write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")
    )
    write_page(
        folder / "index.html",
        crawl=crawl,
        tasks=tasks,
        trade=trade,
        profiles=profiles,
        noiseless=noiseless,
        best=best,
        word=_BEST_WORD,
        dither=_DITHER,
        hold=_HOLD,
        elapsed=elapsed,
        seed=seed,
    )
    console.print(f"all of it in {elapsed:.0f} s: open [bold]{folder / 'index.html'}[/bold]")


def _open_loop(words: list[str], seed: int, dither: float = _DITHER) -> dict[str, Performance]:
    schedules = [repeat(word, _HOLDS, dither=dither, seed=seed) for word in words]
    commands, valves = (np.array(each) for each in zip(*schedules, strict=True))
    found = performances(commands, valves, dither=dither, groups=Groups(), hold=_HOLD, scene=Scene(), delays=_DELAYS)
    return dict(zip(words, found, strict=True))


def _numbers(result: Performance) -> dict[str, float]:
    numbers = {"speed": result.speed}
    if result.memory is not None:
        numbers |= {"memory capacity": result.memory.corrected, "raw": result.memory.total}
    return numbers


def _print_table(console: Console, title: str, rows: list[list[str]]) -> None:
    header, *body = rows
    printed = Table(title=title, title_justify="left")
    for index, name in enumerate(header):
        printed.add_column(name, justify="left" if index == 0 else "right")
    for row in body:
        printed.add_row(*row)
    console.print(printed)


def _trade_table(results: dict[str, Performance]) -> list[list[str]]:
    rows = [["schedule", "speed (z_c/t_c)", "memory capacity"]]
    for name, (speed, memory) in results.items():
        rows.append([name, f"{speed:.3f}", "" if memory is None else f"{memory.corrected:.2f}"])
    return rows
