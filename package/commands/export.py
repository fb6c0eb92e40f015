"""``stickslip export``."""

from pathlib import Path
from typing import Annotated, Any, TYPE_CHECKING

from ..common.extras import optional_import
from ..common.validation import known_names, whole_number
from .options import actuator_of, hold_of, policy_of, WeightOption
from .printing import say

with optional_import():
    import typer

if TYPE_CHECKING:
    from ..train.policies import Policy

__all__ = ["export"]

_OF_POLICIES = ("safetensors", "onnx", "npz")
_OF_SCHEDULES = ("csv", "json")


def export(
    source: Annotated[
        str,
        typer.Argument(help="Folder of a run, a .safetensors, the name of a pretrained policy, or a word of 0 and 1."),
    ],
    to: Annotated[
        str,
        typer.Option(
            help="safetensors, measured on held-out seeds, onnx or npz, of a policy; csv or json, of what a word or a "
            "policy does to a valve."
        ),
    ],
    output: Annotated[Path | None, typer.Option(help="File to write; by default the source's name, here.")] = None,
    weight: WeightOption = None,
    holds: Annotated[int, typer.Option(help="How many, of csv and json.")] = 200,
    hold: Annotated[
        str | None,
        typer.Option(help="Length of one, natural time or such as '20 ms'; the policy's own, 0.5 of a word."),
    ] = None,
    dither: Annotated[
        float | None, typer.Option(help="Probability of a flip, 0 to 0.5; the policy's own, 0 of a word.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Of the flips.")] = 0,
    actuator: Annotated[
        str | None, typer.Option(help="The body, as JSON in SI units, or 'ecoflex', which is the default groups' body.")
    ] = None,
    open_volts: Annotated[float, typer.Option(help="Of the open valve.")] = 24.0,
    shut_volts: Annotated[float, typer.Option(help="Of the shut valve.")] = 0.0,
) -> None:
    """Write a policy, or what it or a word does to a valve in seconds and volts, for other programs and real bodies."""
    from ..crawler import Actuator
    from ..train.played import play_policy, play_word, write_csv, write_json

    known_names("--to", [to], (*_OF_POLICIES, *_OF_SCHEDULES))
    whole_number("--holds", holds, 1)
    whole_number("--seed", seed, 0, 2**32 - 1)
    word = bool(source) and not set(source) - {"0", "1"}
    if word and (weight is not None or to in _OF_POLICIES):
        raise ValueError(f"{source} must be a policy for --weight and --to {', '.join(_OF_POLICIES)}, it is a word")
    file = Path(f"{Path(source).name.removesuffix('.safetensors')}.{to}") if output is None else output
    if to in _OF_POLICIES:
        say(_write_policy(policy_of(source, weight), to, file))
        return
    body = None if actuator is None else actuator_of(actuator)
    natural = None if hold is None else hold_of(hold, Actuator.ecoflex() if body is None else body)
    asked = {name: value for name, value in {"hold": natural, "dither": dither}.items() if value is not None}
    settings: dict[str, Any] = {"holds": holds, "seed": seed, "open_volts": open_volts, "shut_volts": shut_volts}
    settings |= {"actuator": body} | asked
    schedule = play_word(source, **settings) if word else play_policy(policy_of(source, weight), **settings)
    if to == "csv":
        write_csv(schedule, file)
    else:
        told = {"source": source, "weight": weight, "seed": seed, **asked}
        write_json(schedule, file, Actuator.ecoflex() if body is None else body, told)
    say(f"{holds} holds of {schedule.time[1]:.4g} s: {file}")


def _write_policy(policy: "Policy", to: str, file: Path) -> str:
    """Write a policy in a form of policies, and say what was written."""
    from ..train.policies.files import DESCRIPTION, WEIGHTS
    from ..train.policies.portable import check_onnx, write_npz, write_onnx
    from ..train.shipping import ship

    if to == "safetensors":
        shipped = ship(policy, file.name.removesuffix(WEIGHTS), file.parent)
        return f"{shipped!r}: {file} and its {DESCRIPTION}, with what it scored"
    if to == "npz":
        write_npz(policy, file)
        return f"{policy!r}: {file}"
    write_onnx(policy, file)
    count = check_onnx(policy, file)
    return f"{policy!r}: {file}; onnxruntime acts on {count} observations as the policy does"
