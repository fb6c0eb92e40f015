"""The work of each cell: settings in, numbers out and perhaps a policy. Nothing is written here."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Lock
from typing import Any, NamedTuple

import numpy as np

from ...common.threads import library_threads
from ...envs.settings import Settings
from ...train.policies import Policy, read_policy
from ...train.scores import roll_outs
from .attribution import feedback_cut
from .conditions import conditions
from .judgement import held_out_seeds, judge, Judgement
from .open_loop import open_loop_front, schedule_runs
from .plan import Cell, CONDITIONED, EPISODE, JUDGED, LIMIT, OPEN_LOOP, Trade, TRAINED
from .registers import simple_registers
from .speed_limit import speed_limit

__all__ = ["Job", "Outcome", "finish"]


class Job(NamedTuple):
    """A cell with all that its work depends on."""

    trade: Trade
    cell: Cell
    policies: tuple[Policy, ...] = ()
    """What is judged, or distilled."""


class Outcome(NamedTuple):
    """What came of a cell."""

    result: dict[str, Any]
    """Ready for JSON."""
    policy: Policy | None = None
    """What was trained."""


# Trainings draw from torch's and NumPy's global generators: on a worker of several threads, one at a time.
_ALONE = Lock()


def finish(job: Job) -> Outcome:
    """Do the work of a cell: the same to the bit wherever and however often it is done.

    Parameters
    ----------
    job : Job

    Returns
    -------
    Outcome
    """
    with _ALONE, library_threads(1):
        return _WORK[job.cell.kind](job)


def _train(job: Job) -> Outcome:
    # torch takes seconds, and most cells do without
    from ...train import verdict
    from ...train.training import train

    cell = job.cell
    assert cell.seed is not None
    with TemporaryDirectory(prefix="stickslip_") as folder:
        # Of words the front tells more, and on the seeds that judge it.
        judging = replace(verdict.STANDARD, longest_word=1)
        asked = job.trade.configuration(cell.dither, cell.weight, cell.seed, cell.floor)
        begin = None if cell.floor is None else simple_registers(asked.env_kwargs).above(cell.floor)
        run = train(asked, Path(folder), judging=judging, begin=begin)
        return Outcome({}, read_policy(run.best_policy))


def _distil(job: Job) -> Outcome:
    from ...train.distilled import distil

    assert job.cell.seed is not None
    return Outcome({}, distil(job.policies, seed=job.cell.seed))


def _open_loop(job: Job) -> Outcome:
    trade = job.trade
    found = open_loop_front(
        longest=trade.longest,
        seeds=trade.judges,
        holds=trade.holds,
        threads=1,
        **{**trade.env_kwargs, "dither": job.cell.dither},
    )
    held = ["0", "1"]
    runs = schedule_runs(held, job.cell.dither, trade.holds)
    judgement = judge(held, runs, found.settings, seeds=found.front.seeds)
    return Outcome({"front": _numbers(found.front), "held": _numbers(judgement)})


def _limit(job: Job) -> Outcome:
    trade = job.trade
    found = speed_limit(
        resolution=trade.resolution,
        seeds=trade.judges,
        holds=trade.holds,
        threads=1,
        **{**trade.env_kwargs, "dither": job.cell.dither},
    )
    told = {"speeds": found.speeds.tolist(), "seeds": list(found.seeds), "holds": found.holds}
    return Outcome({**told, "grid speed": found.grid_speed, "outside": found.outside})


def _judge(job: Job) -> Outcome:
    [policy], weight = job.policies, job.cell.weight
    seeds = held_out_seeds(job.trade.judges)
    acting = policy if weight is None or not policy.conditioned else policy.at(weight)
    runs = roll_outs(acting, policy.env_kwargs, steps=job.trade.holds, seeds=seeds)
    memories = [0.0 if run.performance.memory is None else run.performance.memory.corrected for run in runs]
    paid = np.array([run.paid[:, :EPISODE].mean(axis=1) for run in runs])
    told: dict[str, Any] = {
        "speeds": [run.performance.speed for run in runs],
        "memories": memories,
        "episodes": {"speeds": paid[:, 0].tolist(), "memories": paid[:, 1].tolist()},
        "seeds": list(seeds),
        "holds": job.trade.holds,
    }
    if not policy.conditioned:
        told["evaluated"] = {name: policy.scores[name]["mean"] for name in ("reward", "speed", "memory")}
    if job.cell.dither:
        commands = {seed: run.command[np.newaxis] for seed, run in zip(seeds, runs, strict=True)}
        cut = feedback_cut(lambda seed: (commands[seed], commands[seed]), job.cell.dither)
        told["body memories"] = judge([job.cell.name], cut, conditions_of(policy), seeds=seeds).memories[0].tolist()
    return Outcome(told)


def conditions_of(policy: Policy) -> Settings:
    """What a policy was trained in, but for what it was rewarded for."""
    return conditions(**{name: value for name, value in policy.env_kwargs.items() if name != "memory_weight"})


def _numbers(judgement: Judgement) -> dict[str, Any]:
    return {
        "names": list(judgement.names),
        "speeds": judgement.speeds.tolist(),
        "memories": judgement.memories.tolist(),
        "seeds": list(judgement.seeds),
        "holds": judgement.holds,
    }


_WORK: Mapping[str, Callable[[Job], Outcome]] = {
    TRAINED: _train,
    CONDITIONED: _distil,
    OPEN_LOOP: _open_loop,
    LIMIT: _limit,
    JUDGED[TRAINED]: _judge,
    JUDGED[CONDITIONED]: _judge,
}
