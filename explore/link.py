"""A setup as the query of a link, and back."""

from typing import Any
from urllib.parse import parse_qsl, urlencode

from ..common.validation import known_names
from .presets import preset
from .setup import NUMBERS, Setup, setup_of, SWITCHES

__all__ = ["query_of", "setup_of_query"]

_PRESET = "preset"
_TRUTH = {"true": True, "false": False}
# A query of every field has some 300 characters.
_LONGEST = 2000


def query_of(setup: Setup) -> str:
    """The query of a link to a setup: the fields that are not the defaults, each float to its last bit.

    Parameters
    ----------
    setup : Setup

    Returns
    -------
    str
        Without the question mark; empty for the defaults.
    """
    usual = Setup().to_dict()
    told = {name: value for name, value in setup.to_dict().items() if value != usual[name]}
    return urlencode({name: str(value).lower() if name in SWITCHES else value for name, value in told.items()})


def setup_of_query(query: str) -> Setup:
    """The setup of a link's query. A link may be forged: what it asks for is checked as any input is.

    Parameters
    ----------
    query : str
        With or without the question mark: fields by name, and `preset` for what the others are taken from.

    Returns
    -------
    Setup

    Raises
    ------
    ValueError
        If it is too long, names something unknown or twice, or asks for what is not allowed; the message says which.
    """
    if len(query) > _LONGEST:
        raise ValueError(f"link must have at most {_LONGEST} characters, got {len(query)}")
    pairs = parse_qsl(query.removeprefix("?"), keep_blank_values=True)
    names = [name for name, _ in pairs]
    known_names("link", names, [_PRESET, *Setup().to_dict()])
    if twice := [name for name in names if names.count(name) > 1]:
        raise ValueError(f"link must name {twice[0]!r} once, got it {names.count(twice[0])} times")
    values = dict(pairs)
    base = preset(values.pop(_PRESET)) if _PRESET in values else Setup()
    return setup_of({name: _read(name, text) for name, text in values.items()}, base)


def _read(name: str, text: str) -> Any:
    if name in NUMBERS:
        return _number(name, text)
    return _truth(name, text) if name in SWITCHES else text


def _truth(name: str, text: str) -> bool:
    if text not in _TRUTH:
        raise ValueError(f"{name} must be one of {list(_TRUTH)}, got {text!r}")
    return _TRUTH[text]


def _number(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{name} must be a number in {NUMBERS[name].interval}, got {text!r}") from None
