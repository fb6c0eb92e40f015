"""The evaluation of a policy, written into a folder."""

import json
from collections.abc import Sequence
from pathlib import Path
from statistics import fmean
from typing import Any

from ..common.figures import save_figure
from ..common.files import write_text
from ..common.fingerprint import refuse_other
from ..crawler import simulate
from ..envs import StickSlipCrawlerEnv
from ..tasks import plot_memory_profile
from . import verdict
from .evaluation import Acting, film
from .figures import plot_learning
from .policies.files import DESCRIPTION, read_policy, WEIGHTS
from .scores import HELD_OUT_SEEDS, interval, judging, roll_outs, Rollout, summary

__all__ = ["evaluate_policy", "evaluate_run"]

_GAIT_HOLDS = 40


def evaluate_run(
    folder: Path,
    *,
    checkpoint: Path | None = None,
    output: Path | None = None,
    steps: int = 6000,
    seeds: Sequence[int] = HELD_OUT_SEEDS,
    dither: float | None = None,
    weight: float | None = None,
    video: bool = True,
    trust: bool = False,
    judge: verdict.Judging | None = None,
) -> dict[str, Any]:
    """Replay a run's policy: see `evaluate_policy`; ``learning.png`` is written too.

    Parameters
    ----------
    folder : Path
        Of the run.
    checkpoint : Path, optional
        A zip of Stable-Baselines3's, or one of a policy's two files; the best policy by default, which is read without
        running its code unless it is recurrent.
    output : Path, optional
        ``folder / "evaluation"`` by default.
    steps, seeds, dither, video, judge
        As for `evaluate_policy`.
    weight : float, in [0, 1], optional
        Of memory, for a policy that is conditioned on it, and for no other.
    trust : bool
        Whether to read a zip: it is unpickled, and runs what its writer likes.

    Returns
    -------
    dict
        What is in ``results.json``: the figures' numbers by name.

    Raises
    ------
    ValueError
        If there is no run, or the checkpoint is not trusted or not one of its configuration.
    OSError
        If the output cannot be written.
    """
    # Reading a run takes yaml, and a zip torch, which the evaluation of a policy does without.
    from .run import Run

    run = Run.open(folder)
    plain = run.best_policy if checkpoint is None else checkpoint
    policy: Acting
    if (checkpoint is None and _beside(plain)) or plain.suffix in (WEIGHTS, DESCRIPTION):
        policy = read_policy(plain)
        asked = {"env_kwargs": run.configuration.env_kwargs}
        refuse_other(f"as in policy {plain}", {"env_kwargs": policy.env_kwargs}, asked)
        if weight is not None:
            policy = policy.at(weight)
    else:
        from .training import load_policy

        policy = load_policy(run, checkpoint, trust=trust)
        if weight is not None:
            raise ValueError(f"weight must be left out with a zip of Stable-Baselines3's, got {weight!r}")
    output = folder / "evaluation" if output is None else output
    arguments = run.configuration.env_kwargs
    told: dict[str, Any] = {"steps": steps, "seeds": seeds, "dither": dither, "video": video, "judge": judge}
    if weight is not None:
        arguments = arguments | {"memory_weight": weight}
    elif dither is None:
        told["against"] = verdict.read_baselines(folder, verdict.STANDARD if judge is None else judge)
    result = evaluate_policy(policy, arguments, output, **told)
    written = verdict.read_report(output)
    assert written is not None
    baselines = {name: fmean(each["reward"]) for name, each in written["baselines"].items()}
    save_figure(plot_learning(folder / "evaluations.csv", baselines=baselines), output / "learning.png")
    return result


def evaluate_policy(
    policy: Acting,
    env_kwargs: dict[str, Any],
    output: Path,
    *,
    steps: int = 6000,
    seeds: Sequence[int] = HELD_OUT_SEEDS,
    dither: float | None = None,
    video: bool = True,
    judge: verdict.Judging | None = None,
    against: Sequence[verdict.Baseline] | None = None,
) -> dict[str, Any]:
    """Replay a policy; write ``results.json``, ``gait.png``, ``memory.png`` and ``clip.mp4`` into a folder.

    Also ``report.md`` and ``report.json``: the policy beside the valve held open, held shut and the best word.

    Parameters
    ----------
    policy : Policy or BaseAlgorithm
        That takes no weight; `Policy.at` makes one.
    env_kwargs : dict
        Arguments of the environment.
    output : Path
        Made if it is missing.
    steps : int
        To measure over, for each seed.
    seeds : sequence of int
        Of the flips and the draws; the figures and the clip are of the first.
    dither : float, in [0, 1/2], optional
        Instead of that of `env_kwargs`.
    video : bool
        Whether to film the policy.
    judge : Judging, optional
        How the policy is compared with what needs no training; `stickslip.train.verdict.STANDARD` by default.
    against : sequence of Baseline, optional
        What needs no training, if it is known for the environment.

    Returns
    -------
    dict
        What is in ``results.json``: means over the seeds, with their 95% intervals, and what was drawn and commanded
        with the first.

    Raises
    ------
    ValueError, TypeError
        If an argument is out of range or of the wrong type.
    OSError
        If the output cannot be written.
    """
    arguments = judging(env_kwargs) | ({} if dither is None else {"dither": dither})
    settings = StickSlipCrawlerEnv(**arguments).settings
    runs = roll_outs(policy, arguments, steps=steps, seeds=seeds)
    first = runs[0]
    output.mkdir(parents=True, exist_ok=True)
    result = _numbers(runs, steps, seeds)
    if settings.randomize:
        result["groups drawn"] = first.groups.to_dict()
        result["slope drawn"] = first.scene.slope
    if first.performance.memory is not None:
        save_figure(plot_memory_profile({"policy": first.performance.memory}), output / "memory.png")
    rewarded = env_kwargs | ({} if dither is None else {"dither": dither})
    if settings.dither == 0.0:
        rewarded |= {"memory_weight": 0.0}  # there is nothing to remember
    judged = verdict.judge(policy, rewarded, verdict.STANDARD if judge is None else judge, against=against)
    verdict.write_verdict(judged, output)
    result["verdict"] = judged.sentence
    # From the middle of the episode, where the start is forgotten.
    middle = slice(steps // 2, steps // 2 + _GAIT_HOLDS)
    result["commands"] = "".join(str(bit) for bit in first.command[middle])
    body: dict[str, Any] = {"scene": first.scene, "tolerance": settings.tolerance}
    before = simulate(first.groups, first.valve[: middle.start], settings.hold, **body)
    gait = simulate(
        first.groups,
        first.valve[middle],
        settings.hold,
        samples_per_hold=20,
        initial=before.final_state._replace(foot=0.0),
        **body,
    )
    save_figure(gait.plot(), output / "gait.png")
    text = json.dumps(result, indent=2) + "\n"
    write_text(output / "results.json", text)
    if video:
        film(policy, output / "clip.mp4", env_kwargs=arguments, seed=int(seeds[0]))
    return result


def _numbers(runs: Sequence[Rollout], steps: int, seeds: Sequence[int]) -> dict[str, Any]:
    performances = [each.performance for each in runs]
    told = summary(performances, steps, seeds)
    numbers: dict[str, Any] = {"steps": steps, "seeds": told["seeds"], "speed": told["speed"]}
    memories = [each.memory for each in performances if each.memory is not None]
    if memories:
        numbers["memory capacity"] = told["memory"]
        numbers["memory capacity, raw"] = interval([each.total for each in memories])
    return numbers


def _beside(path: Path) -> bool:
    """Whether there is a policy of plain numbers, or what is left of one."""
    return any(path.with_name(path.name + suffix).exists() for suffix in (WEIGHTS, DESCRIPTION))
