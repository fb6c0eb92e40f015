"""Options that several commands take, and what is made of them."""

import json
from dataclasses import fields, MISSING
from pathlib import Path
from typing import Annotated, Any, TYPE_CHECKING, TypeAlias

from ..common.extras import optional_import
from ..common.validation import known_names

with optional_import():
    import typer

if TYPE_CHECKING:
    from ..crawler import Actuator, GroupsLike
    from ..train.policies import Policy

__all__ = [
    "GroupsOption",
    "HoldOption",
    "InputsOption",
    "SceneOption",
    "TrustOption",
    "WeightOption",
    "actuator_of",
    "groups_of",
    "hold_of",
    "json_object",
    "number_or_text",
    "policy_of",
    "said_in",
]

GroupsOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        help="A preset's name, or JSON such as '{\"duffing\": 2}'; or a body in SI units: JSON of an Actuator, or "
        "'ecoflex'."
    ),
]
HoldOption: TypeAlias = Annotated[
    str, typer.Option(help="Length of a hold: 0.5 of natural time, or '20 ms' where --groups is a body in SI units.")
]
SceneOption: TypeAlias = Annotated[str, typer.Option(help="JSON such as '{\"ratchet\": false}'.")]

InputsOption: TypeAlias = Annotated[
    str, typer.Option(help="'bits', 'bernoulli:0.3', or a word and the probability of a flip, 'word:0011:0.1'.")
]

TrustOption: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--trust", help="Read zips of Stable-Baselines3 that others may have written: they run what they like."
    ),
]

WeightOption: TypeAlias = Annotated[
    float | None, typer.Option(help="Weight of memory, 0 to 1, for a policy that was trained for any weight.")
]


def actuator_of(text: str) -> "Actuator":
    """The preset "ecoflex", or an `Actuator` of its fields from JSON.

    Raises
    ------
    ValueError
        If a field is unknown, missing or out of range; the message names it.
    """
    # Imported where it is used: the physics takes half a second.
    from ..crawler import Actuator

    if text == "ecoflex":
        return Actuator.ecoflex()
    return _actuator_with("--actuator", json_object("--actuator", text))


def groups_of(text: str, option: str = "--groups") -> "str | dict[str, Any] | Actuator":
    """A preset's name, a mapping of fields from JSON, or an `Actuator`.

    Raises
    ------
    ValueError
        As `actuator_of`, of what has a field that no groups have.
    """
    from ..crawler import Actuator
    from ..crawler.model.groups import RANGES

    if text == "ecoflex":
        return Actuator.ecoflex()
    if not text.lstrip().startswith("{"):
        return text
    given = json_object(option, text)
    in_si = {each.name for each in fields(Actuator)} - set(RANGES)
    return _actuator_with(option, given) if in_si & set(given) else given


def hold_of(text: str, groups: "GroupsLike | None") -> float:
    """Natural time of a hold, which is a number or has a unit.

    Raises
    ------
    ValueError, TypeError
        If it is neither, out of range, or in seconds of a body that is not in SI units.
    """
    from ..crawler.model.holds import natural_hold

    return natural_hold(number_or_text(text), groups)


def number_or_text(text: str) -> float | str:
    """A number where there is one."""
    try:
        return float(text)
    except ValueError:
        return text


def json_object(option: str, text: str) -> dict[str, Any]:
    """A mapping from JSON.

    Raises
    ------
    ValueError
        If `text` is none, or names something twice; the message begins with the option.
    """
    try:
        value = json.loads(text, object_pairs_hook=lambda pairs: _distinct(option, pairs))
    except json.JSONDecodeError as error:
        raise ValueError(f"{option} must be a JSON object, got {text!r}: {error}") from None
    if not isinstance(value, dict):
        raise ValueError(f"{option} must be a JSON object, got {text!r}")
    return value


def policy_of(source: str, weight: float | None) -> "Policy":
    """A pretrained policy by name, or that of a file or of a run's folder; at a weight, if one is given.

    Raises
    ------
    ValueError
        If there is none, or it takes no weight.
    """
    from ..train.policies.files import DESCRIPTION, read_policy, WEIGHTS
    from ..train.policies.pretrained import PRETRAINED, pretrained

    if source in PRETRAINED:
        policy = pretrained(source)
    else:
        policy = read_policy(source if source.endswith((WEIGHTS, DESCRIPTION)) else Path(source) / "best")
    return policy if weight is None else policy.at(weight)


def said_in(context: typer.Context) -> set[str]:
    """Names of the options that stand on the command line."""
    sources = {name: context.get_parameter_source(name) for name in context.params}
    return {name for name, source in sources.items() if source is not None and source.name == "COMMANDLINE"}


def _actuator_with(option: str, given: dict[str, Any]) -> "Actuator":
    from ..crawler import Actuator

    known = fields(Actuator)
    known_names(option, given, [each.name for each in known])
    if missing := [each.name for each in known if each.default is MISSING and each.name not in given]:
        raise ValueError(f"{option} must set {missing} too, got {sorted(given)}")
    return Actuator(**given)


def _distinct(option: str, pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A JSON object's names and values, of which JSON would keep the last of a name silently."""
    names = [name for name, _ in pairs]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"{option} must name {name!r} once, got it {names.count(name)} times")
    return dict(pairs)
