"""Policies trained beside other work, a process each."""

import multiprocessing
import shutil
import time
from collections.abc import Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..common.extras import optional_import
from ..common.workers import worker_processes
from ..train.hyperparameters import read_hyperparameters
from ..train.run import Configuration, Run
from ..train.training import train
from ..train.verdict import Judging

with optional_import():
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

__all__ = ["Classroom", "Lesson"]


@dataclass(frozen=True)
class Lesson:
    """A policy to train."""

    name: str
    folder: str
    env_kwargs: dict[str, Any]


class Classroom:
    """Trains policies by PPO while its block does other work, a process each.

    Parameters
    ----------
    folder : Path
        Of the runs.
    lessons : sequence of Lesson
    seed : int
    steps : int or None
        Environment steps of each training; the hyperparameter file's by default.
    judging : Judging or None
        How each is judged at its end; `stickslip.train.verdict.STANDARD` by default.
    """

    def __init__(
        self,
        folder: Path,
        lessons: Sequence[Lesson],
        seed: int,
        steps: int | None,
        judging: Judging | None = None,
    ) -> None:
        self._judging = judging
        self._folder = folder
        self._lessons = lessons
        entry = read_hyperparameters("ppo", Configuration.environment)
        self._total = entry["n_timesteps"] if steps is None else steps
        context = multiprocessing.get_context("spawn")
        self._steps = {lesson.folder: context.Value("q", 0) for lesson in lessons}
        self._configurations = {
            lesson.folder: Configuration(
                env_kwargs=lesson.env_kwargs, hyperparameters={**entry, "n_timesteps": self._total}, seed=seed
            )
            for lesson in lessons
        }
        self._workers = worker_processes(len(lessons), _share, (self._steps,))

    def __enter__(self) -> "Classroom":
        pool = self._workers.__enter__()
        self._futures: dict[str, Future[None]] = {
            name: pool.submit(_teach, configuration, self._folder / name, name, self._judging)
            for name, configuration in self._configurations.items()
        }
        return self

    def __exit__(self, *error: Any) -> None:
        self._workers.__exit__(*error)

    def show(self, console: Console) -> None:
        """Wait for the trainings, with a bar for each."""
        bars = Progress(TextColumn("training {task.description}"), BarColumn(), TimeElapsedColumn(), console=console)
        with bars:
            tasks = {lesson.folder: bars.add_task(lesson.name, total=self._total) for lesson in self._lessons}
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

    def run(self, lesson: Lesson) -> Run:
        """The finished run of a lesson."""
        return Run.open(self._folder / lesson.folder)


_shared_steps: dict[str, Any] = {}


def _share(steps: dict[str, Any]) -> None:
    """Give a worker process the counters that the bars are drawn from."""
    _shared_steps.update(steps)


def _teach(configuration: Configuration, folder: Path, name: str, judging: Judging | None) -> None:
    """Train one policy, in a worker process."""

    def progress(done: int) -> None:
        _shared_steps[name].value = done

    unfinished = (folder / "configuration.yml").exists() and not (folder / "final.zip").exists()
    if unfinished and Run.open(folder).configuration == configuration:
        train(configuration, folder, resume=True, on_progress=progress, judging=judging)
    else:
        shutil.rmtree(folder, ignore_errors=True)
        train(configuration, folder, on_progress=progress, judging=judging)
