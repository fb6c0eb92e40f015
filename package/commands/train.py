"""``stickslip train``."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

from ..common.extras import optional_import
from ..common.validation import known_names, whole_number
from ..train.algorithms import ALGORITHMS
from .options import groups_of, GroupsOption, HoldOption, json_object, number_or_text, said_in, TrustOption
from .printing import progress

with optional_import():
    import typer

__all__ = ["train"]

_ENVIRONMENT = "StickSlipCrawler-v0"
*_FIRST, _LAST = ALGORITHMS
_ALGORITHM_HELP = f"{', '.join(_FIRST)} or {_LAST}."


def train(
    context: typer.Context,
    output: Annotated[Path, typer.Option(help="Folder of the run.")],
    memory_weight: Annotated[float, typer.Option(help="Share of memory in the reward, 0 to 1.")] = 0.2,
    dither: Annotated[float, typer.Option(help="Probability that a command is flipped, 0 to 0.5.")] = 0.1,
    hold: HoldOption = "0.5",
    groups: GroupsOption = None,
    env_kwargs: Annotated[str, typer.Option(help="Further arguments of the environment, as JSON.")] = "{}",
    steps: Annotated[
        int | None,
        typer.Option(help="Environment steps in all, instead of the file's or the resumed run's; updates are whole."),
    ] = None,
    seed: Annotated[int, typer.Option(help="Of everything random.")] = 0,
    start: Annotated[
        str, typer.Option(help="What the policy does before it has learned: even chances, or mostly open, or shut.")
    ] = "even",
    floor: Annotated[
        float | None, typer.Option(help="On speed: learn memory above it instead of the weighted reward.")
    ] = None,
    algorithm: Annotated[str, typer.Option(help=_ALGORITHM_HELP)] = "ppo",
    hyperparameters: Annotated[Path | None, typer.Option(help="YAML file in rl-baselines3-zoo's form.")] = None,
    resume: Annotated[
        bool,
        typer.Option("--resume", help="Go on from the last checkpoint in the folder, which says all but the steps."),
    ] = False,
    trust: TrustOption = False,
) -> None:
    """Train a policy, with evaluations, checkpoints and TensorBoard logs in the output folder."""
    from ..crawler.model.holds import natural_hold
    from ..envs.settings import HOLDS
    from ..train.evaluations import best_of, read_evaluations
    from ..train.hyperparameters import read_hyperparameters
    from ..train.run import Configuration, ENV_ARGUMENTS, Run
    from ..train.training import train as train_policy
    from ..train.verdict import read_report

    said = said_in(context)
    body = None if groups is None else groups_of(groups)
    arguments: dict[str, Any] = {
        "memory_weight": memory_weight,
        "dither": dither,
        "hold": natural_hold(number_or_text(hold), body, HOLDS),
    }
    if body is not None:
        arguments["groups"] = body
    further = json_object("--env-kwargs", env_kwargs)
    for name in (*arguments, "groups", "render_mode"):
        if name in further:
            raise ValueError(f"--env-kwargs must not set {name}: it has an option of its own, or is not for training")
    known_names("--env-kwargs", further, [name for name in ENV_ARGUMENTS if name not in (*arguments, "groups")])
    asked = {name: value for name, value in arguments.items() if name in said} | further
    if resume:
        # What is not said is as in the folder, and what is said is compared with it.
        kept = Run.open(output).configuration
        arguments = kept.env_kwargs | asked
        algorithm = algorithm if "algorithm" in said else kept.algorithm
        seed = seed if "seed" in said else kept.seed
        start = start if "start" in said else kept.start
        floor = floor if "floor" in said else kept.floor
    # The algorithm is checked before a file of its name is looked for.
    arguments = arguments | further
    configuration = Configuration(
        algorithm=algorithm, environment=_ENVIRONMENT, env_kwargs=arguments, seed=seed, start=start, floor=floor
    )
    if resume and hyperparameters is None:
        entry = dict(kept.hyperparameters)
    else:
        entry = read_hyperparameters(algorithm, _ENVIRONMENT, hyperparameters)
    if steps is not None:
        entry["n_timesteps"] = whole_number("--steps", steps, 1)
    if not resume:
        # The file's choice of environment comes before an option's default, and after what is said.
        arguments = arguments | entry.get("env_kwargs", {}) | asked
    configuration = replace(configuration, env_kwargs=arguments, hyperparameters=entry)

    with progress("training") as show:
        total = entry["n_timesteps"]
        finished = train_policy(
            configuration, output, resume=resume, trust=trust, on_progress=lambda done: show(min(done, total), total)
        )
    best = best_of(read_evaluations(finished.folder / "evaluations.csv"))
    terms = "" if math.isnan(best.speed) else f" (speed {best.speed:.4f}, memory {best.memory:.4f})"
    typer.echo(
        f"best policy: {best.reward:.4f} reward per step{terms} after {best.steps} steps, kept in {finished.best}"
    )
    report = read_report(finished.folder)
    if report is not None:
        typer.echo(report["verdict"])
