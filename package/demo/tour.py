"""From body to policy: what the demo shows, step by step."""

import json
import shutil
import time
from pathlib import Path
from typing import Any

from ..common.extras import optional_import
from ..common.figures import save_figure
from ..common.files import write_text
from ..common.sharing import processors
from ..common.threads import library_threads
from ..crawler import Groups, simulate
from ..reservoir import memory_capacity
from ..studies.benchmark import run_benchmark, STANDARD_RESERVOIRS, table
from ..studies.trade.figure import plot_front
from ..studies.trade.front import Front, fronts, gain
from ..studies.trade.learned import learned
from ..studies.trade.plan import Cell, Trade, TRAINED
from ..studies.trade.portrait_figure import plot_learned
from ..studies.trade.report import areas
from ..studies.trade.report import table as table_of_front
from ..studies.trade.running import TradeFolder
from ..tasks import known_reservoirs, plot_memory_profile, random_bits
from ..train.evaluation import film
from ..train.schedules import repeat
from .page import write_page

with optional_import():
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
    from rich.table import Table

__all__ = ["run_demo"]

_HOLD = 0.5
_QUIET, _DITHER = 0.0, 0.1
_MEMORY_WEIGHT = 0.2
_WORD = "11100"
_PROFILE_BITS = 8000
_DELAYS = 20
_TRADE: dict[str, Any] = {
    "weights": (0.0, _MEMORY_WEIGHT, 1.0),
    "longest": 8,
    "resolution": 14,
    "judges": 4,
    "holds": 4000,
}


def run_demo(folder: Path, seed: int = 0, steps: int | None = None) -> None:
    """Write figures, a clip, numbers and ``index.html`` into a folder, and print short tables.

    Parameters
    ----------
    folder : Path
        Made if it is missing. What an interrupted demo has finished of its trade, in ``trade/``, is not done again;
        everything else is made anew.
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
    asked = Trade(
        **_TRADE, dithers=(_QUIET, _DITHER), seeds=1, first_seed=seed, steps=steps, env_kwargs={"hold": _HOLD}
    )
    trade = _folder(folder / "trade", asked)
    with library_threads(1):
        crawl = simulate(Groups(), repeat(_WORD, 40)[0], _HOLD, samples_per_hold=20)
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

    _work(trade, console)
    quiet, front = fronts(asked, trade.results())
    save_figure(plot_front(front, weight=_MEMORY_WEIGHT), folder / "trade.png")
    looked_at = learned(trade, front)
    assert looked_at is not None
    save_figure(plot_learned(looked_at.portraits, looked_at.responses, looked_at.imitations), folder / "learned.png")
    gait = trade.policy(Cell(TRAINED, _QUIET, 0.0, seed))
    film(gait, folder / "gait.mp4", env_kwargs=gait.env_kwargs, seed=seed)

    shown, surfaces = table_of_front(front), areas(front)
    _print_table(
        console, f"speed against memory, dither {_DITHER}, mean [95% interval] over {asked.judges} seeds", shown
    )
    _print_table(console, "what of the plane is dominated", surfaces)
    noiseless, limit = _noiseless(quiet), quiet.speed_limit.mean
    console.print(
        f"speed policy without dither: {noiseless:.4f} z_c/t_c, {noiseless / limit:.1%} of the limit ({limit:.4f})"
    )
    elapsed = time.perf_counter() - began
    results = {
        "seed": seed,
        "seconds": elapsed,
        "scores": [score._asdict() for score in scores],
        "memory capacity": {name: profile.corrected for name, profile in profiles.items()},
        "trade": {str(each.dither): each.summary() for each in (quiet, front)},
    }
    write_text(folder / "results.json", json.dumps(results, indent=2) + "\n")
    write_page(
        folder / "index.html",
        crawl=crawl,
        tasks=tasks,
        trade=shown,
        areas=surfaces,
        gain=gain(front.chosen, front.open_loop).mean,
        knee=front.knee,
        held_open=next(point for point in front.held if point.kind == "held open"),
        profiles=profiles,
        noiseless=noiseless,
        limit=limit,
        limit_noisy=front.speed_limit.mean,
        word=_WORD,
        dither=_DITHER,
        weight=_MEMORY_WEIGHT,
        hold=_HOLD,
        judges=asked.judges,
        holds=asked.holds,
        elapsed=elapsed,
        seed=seed,
    )
    console.print(f"all of it in {elapsed:.0f} s: open [bold]{folder / 'index.html'}[/bold]")


def _folder(folder: Path, asked: Trade) -> TradeFolder:
    """The trade of an earlier demo, or, where that asked for something else, a new one in its place."""
    try:
        return TradeFolder(folder, asked)
    except ValueError:
        shutil.rmtree(folder)
        return TradeFolder(folder, asked)


def _work(trade: TradeFolder, console: Console) -> None:
    """Do what is left of the trade, with a bar."""
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    with Progress(*columns, console=console) as bar:
        task = bar.add_task("trade: open loop, limit, policies")
        for finished in trade.run(processes=processors()):
            bar.update(task, completed=finished.done, total=finished.of)


def _noiseless(quiet: Front) -> float:
    """Speed of the policy trained without flips, where there are none."""
    [speed] = {policy.mean[0] for policy in quiet.chosen}
    return speed


def _print_table(console: Console, title: str, rows: list[list[str]]) -> None:
    header, *body = rows
    printed = Table(title=title, title_justify="left")
    for index, name in enumerate(header):
        printed.add_column(name, justify="left" if index == 0 else "right")
    for row in body:
        printed.add_row(*row)
    console.print(printed)
