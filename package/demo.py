"""``stickslip demo``: from body to policy in one command, with a page to open at the end."""

import json
import multiprocessing
import shutil
import time
from concurrent.futures import Future
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from .common.extras import optional_import
from .common.figures import save_figure
from .common.files import atomically
from .common.workers import worker_processes
from .crawler import Groups, Scene, simulate
from .envs import StickSlipCrawlerEnv
from .reservoir import memory_capacity
from .studies.benchmark import run_benchmark, STANDARD_RESERVOIRS, table
from .tasks import known_reservoirs, plot_memory_profile, random_bits
from .train.evaluation import film, measure
from .train.figures import plot_trade
from .train.hyperparameters import read_hyperparameters
from .train.run import Configuration, Run
from .train.schedules import necklaces, Performance, performance, repeat
from .train.training import load_policy, train

with optional_import():
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
    from rich.table import Table
    from threadpoolctl import threadpool_limits

__all__ = ["run_demo"]

_HOLD = 0.5
_DITHER = 0.1
_BEST_WORD = "11100"
_LONGEST_WORD = 7
_HOLDS = 6000
_PROFILE_BITS = 8000
_DELAYS = 20


@dataclass(frozen=True)
class _Lesson:
    """A policy to train."""

    name: str
    folder: str
    env_kwargs: dict[str, Any]


_SPEED = _Lesson("speed policy", "speed", {"memory_weight": 0.0, "dither": 0.0})
_MEMORY = _Lesson("memory_weight = 0.5 policy", "memory", {"memory_weight": 0.5, "dither": _DITHER})


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
    with threadpool_limits(1), _Classroom(folder / "policies", seed, steps) as classroom:
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

        schedules = {word: _open_loop(word, seed) for word in necklaces(_LONGEST_WORD)}
        best = _open_loop(_BEST_WORD, seed, dither=0.0).speed
        classroom.show(console)

    policies = {lesson.name: load_policy(classroom.run(lesson)) for lesson in (_SPEED, _MEMORY)}
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
    page = _page(
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
    atomically(folder / "index.html", lambda path: path.write_text(page, encoding="utf-8"))
    console.print(f"all of it in {elapsed:.0f} s: open [bold]{folder / 'index.html'}[/bold]")


class _Classroom:
    """Trains the two policies beside the rest of the demo, a process each."""

    def __init__(self, folder: Path, seed: int, steps: int | None) -> None:
        self._folder = folder
        entry = read_hyperparameters("ppo", Configuration.environment)
        self._total = entry["n_timesteps"] if steps is None else steps
        context = multiprocessing.get_context("spawn")
        self._steps = {lesson.folder: context.Value("q", 0) for lesson in (_SPEED, _MEMORY)}
        self._configurations = {
            lesson.folder: Configuration(
                env_kwargs=lesson.env_kwargs, hyperparameters={**entry, "n_timesteps": self._total}, seed=seed
            )
            for lesson in (_SPEED, _MEMORY)
        }
        self._workers = worker_processes(2, _share, (self._steps,))

    def __enter__(self) -> "_Classroom":
        pool = self._workers.__enter__()
        self._futures: dict[str, Future[None]] = {
            name: pool.submit(_teach, configuration, self._folder / name, name)
            for name, configuration in self._configurations.items()
        }
        return self

    def __exit__(self, *error: Any) -> None:
        self._workers.__exit__(*error)

    def show(self, console: Console) -> None:
        """Wait for the trainings, with a bar for each."""
        bars = Progress(TextColumn("training {task.description}"), BarColumn(), TimeElapsedColumn(), console=console)
        with bars:
            tasks = {lesson.folder: bars.add_task(lesson.name, total=self._total) for lesson in (_SPEED, _MEMORY)}
            while not all(future.done() for future in self._futures.values()):
                for future in self._futures.values():
                    if future.done():
                        future.result()  # a training that failed fails at once, not after the other
                for name, task in tasks.items():
                    bars.update(task, completed=min(self._steps[name].value, self._total))
                time.sleep(0.2)
            for name, task in tasks.items():
                bars.update(task, completed=min(self._steps[name].value, self._total))
        for future in self._futures.values():
            future.result()

    def run(self, lesson: _Lesson) -> Run:
        """The finished run of a lesson."""
        return Run.open(self._folder / lesson.folder)


_shared_steps: dict[str, Any] = {}


def _share(steps: dict[str, Any]) -> None:
    """Give a worker process the counters that the bars are drawn from."""
    _shared_steps.update(steps)


def _teach(configuration: Configuration, folder: Path, name: str) -> None:
    """Train one policy, in a worker process."""

    def progress(done: int) -> None:
        _shared_steps[name].value = done

    unfinished = (folder / "configuration.yml").exists() and not (folder / "final.zip").exists()
    if unfinished and Run.open(folder).configuration == configuration:
        train(configuration, folder, resume=True, on_progress=progress)
    else:
        shutil.rmtree(folder, ignore_errors=True)
        train(configuration, folder, on_progress=progress)


def _open_loop(word: str, seed: int, dither: float = _DITHER) -> Performance:
    command, valve = repeat(word, _HOLDS, dither=dither, seed=seed)
    return performance(command, valve, dither=dither, groups=Groups(), hold=_HOLD, scene=Scene(), delays=_DELAYS)


def _numbers(result: Performance) -> dict[str, float]:
    numbers = {"speed": result.speed}
    if result.memory is not None:
        numbers |= {"memory capacity": result.memory.corrected, "raw": result.memory.total}
    return numbers


def _trade_table(results: dict[str, Performance]) -> list[list[str]]:
    rows = [["schedule", "speed (z_c/t_c)", "memory capacity"]]
    for name, (speed, memory) in results.items():
        rows.append([name, f"{speed:.3f}", "" if memory is None else f"{memory.corrected:.2f}"])
    return rows


def _print_table(console: Console, title: str, rows: list[list[str]]) -> None:
    header, *body = rows
    printed = Table(title=title, title_justify="left")
    for index, name in enumerate(header):
        printed.add_column(name, justify="left" if index == 0 else "right")
    for row in body:
        printed.add_row(*row)
    console.print(printed)


def _page(**content: Any) -> str:
    with optional_import():
        import jinja2

    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True)
    return environment.from_string((resources.files("stickslip") / "demo.html.jinja").read_text("utf-8")).render(
        **content
    )
