"""The evaluation of a run, written beside it."""

import json
from pathlib import Path
from typing import Any

from ..common.figures import save_figure
from ..common.files import atomically
from ..crawler import simulate
from ..envs import StickSlipCrawlerEnv
from ..tasks import plot_memory_profile
from .evaluation import film, measure
from .figures import plot_learning
from .run import Run
from .training import load_policy

__all__ = ["evaluate_run"]

_GAIT_HOLDS = 40


def evaluate_run(
    folder: Path,
    *,
    checkpoint: Path | None = None,
    output: Path | None = None,
    steps: int = 6000,
    seed: int = 0,
    video: bool = True,
) -> dict[str, Any]:
    """Replay a run's policy; write ``results.json``, ``gait.png``, ``learning.png``, ``memory.png``, ``clip.mp4``.

    Parameters
    ----------
    folder : Path
        Of the run.
    checkpoint : Path, optional
        The best policy by default.
    output : Path, optional
        ``folder / "evaluation"`` by default.
    steps : int
        Steps to measure over.
    seed : int
        Of the flips.
    video : bool
        Whether to film the policy.

    Returns
    -------
    dict
        What is in ``results.json``: the figures' numbers by name.

    Raises
    ------
    ValueError
        If there is no run, or the checkpoint is not one of its configuration.
    OSError
        If the output cannot be written.
    """
    run = Run.open(folder)
    policy = load_policy(run, checkpoint)
    output = folder / "evaluation" if output is None else output
    output.mkdir(parents=True, exist_ok=True)
    arguments = run.configuration.env_kwargs
    environment = StickSlipCrawlerEnv(**arguments)
    result, command, valve = measure(policy, environment, steps=steps, seed=seed)

    summary: dict[str, Any] = {"steps": steps, "speed": result.speed}
    settings = environment.settings
    if settings.randomize:
        summary["groups drawn"] = environment.episode_groups.to_dict()
        summary["slope drawn"] = environment.episode_scene.slope
    if result.memory is not None:
        summary["memory capacity"] = result.memory.corrected
        summary["memory capacity, raw"] = result.memory.total
        save_figure(plot_memory_profile({"policy": result.memory}), output / "memory.png")
    # From the middle of the episode, where the start is forgotten.
    middle = slice(steps // 2, steps // 2 + _GAIT_HOLDS)
    summary["commands"] = "".join(str(bit) for bit in command[middle])
    body: dict[str, Any] = {"scene": environment.episode_scene, "tolerance": settings.tolerance}
    before = simulate(environment.episode_groups, valve[: middle.start], settings.hold, **body)
    gait = simulate(
        environment.episode_groups,
        valve[middle],
        settings.hold,
        samples_per_hold=20,
        initial=before.final_state._replace(foot=0.0),
        **body,
    )
    save_figure(gait.plot(), output / "gait.png")
    save_figure(plot_learning(folder / "evaluations.csv"), output / "learning.png")
    atomically(
        output / "results.json", lambda path: path.write_text(json.dumps(summary, indent=2) + "\n", encoding="utf-8")
    )
    if video:
        film(policy, output / "clip.mp4", env_kwargs=arguments, seed=seed)
    return summary
