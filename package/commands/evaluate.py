"""``stickslip evaluate``."""

from pathlib import Path
from typing import Annotated, Any

from ..common.extras import optional_import
from ..common.validation import whole_number
from .options import TrustOption, WeightOption
from .printing import say

with optional_import():
    import typer

__all__ = ["evaluate"]


def evaluate(
    run: Annotated[str, typer.Argument(help="Folder of a training run, or the name of a pretrained policy.")],
    checkpoint: Annotated[
        Path | None,
        typer.Option(help="One of the run's zips, which needs --trust, or a .safetensors; the best policy by default."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option(help="Folder for what is made; RUN/evaluation or runs/NAME by default.")
    ] = None,
    steps: Annotated[int, typer.Option(help="Steps to measure over with each seed, 1000 at least.")] = 6000,
    seeds: Annotated[int, typer.Option(help="Episodes to measure, each with its own flips.")] = 10,
    seed: Annotated[int, typer.Option(help="Of the first episode; by default none that a training sees.")] = 2_000_000,
    dither: Annotated[
        float | None, typer.Option(help="Probability that a command is flipped, instead of the training's, 0 to 0.5.")
    ] = None,
    weight: WeightOption = None,
    video: Annotated[bool, typer.Option(help="Also film the policy.")] = True,
    trust: TrustOption = False,
) -> None:
    """Replay a policy: its speed and memory over several seeds, figures and a clip."""
    from ..train.policies.pretrained import PRETRAINED, pretrained
    from ..train.report import evaluate_policy, evaluate_run

    whole_number("--steps", steps, 1000)
    first = whole_number("--seed", seed, 0, 2**32 - 1 - whole_number("--seeds", seeds, 1))
    asked: dict[str, Any] = {"steps": steps, "seeds": range(first, first + seeds), "dither": dither, "video": video}
    if run in PRETRAINED:
        if checkpoint is not None:
            raise ValueError(f"--checkpoint must be left out with the pretrained policy {run}, got {checkpoint}")
        policy = pretrained(run) if weight is None else pretrained(run).at(weight)
        output = Path("runs") / run if output is None else output
        result = evaluate_policy(policy, policy.env_kwargs, output, **asked)
    else:
        result = evaluate_run(Path(run), checkpoint=checkpoint, output=output, weight=weight, trust=trust, **asked)
    for name, value in result.items():
        say(f"{name:<24} {_told(value)}")


def _told(value: Any) -> str:
    if isinstance(value, dict) and "mean" in value:
        ends = "" if value["low"] is None else f" [{value['low']:.4f}, {value['high']:.4f}]"
        return f"{value['mean']:.4f}{ends}"
    if isinstance(value, list) and len(value) > 2:
        return f"{value[0]} to {value[-1]}"
    return str(value)
