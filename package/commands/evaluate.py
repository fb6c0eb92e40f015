"""``stickslip evaluate``."""

from pathlib import Path
from typing import Annotated

from ..common.extras import optional_import
from ..common.validation import whole_number

with optional_import():
    import typer

__all__ = ["evaluate"]


def evaluate(
    run: Annotated[Path, typer.Argument(help="Folder of a training run.")],
    checkpoint: Annotated[Path | None, typer.Option(help="One of its checkpoints; the best policy by default.")] = None,
    output: Annotated[Path | None, typer.Option(help="Folder for what is made; RUN/evaluation by default.")] = None,
    steps: Annotated[int, typer.Option(help="Steps to measure over, 1000 at least.")] = 6000,
    seed: Annotated[int, typer.Option(help="Of the flips.")] = 0,
    video: Annotated[bool, typer.Option(help="Also film the policy.")] = True,
) -> None:
    """Replay a policy: its speed and memory, figures and a clip."""
    from ..train.report import evaluate_run

    whole_number("--steps", steps, 1000)
    whole_number("--seed", seed, 0, 2**32 - 1)
    result = evaluate_run(run, checkpoint=checkpoint, output=output, steps=steps, seed=seed, video=video)
    for name, value in result.items():
        typer.echo(f"{name:<24} {value}")
