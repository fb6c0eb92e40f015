"""What a file was made for: described, stored in it, and compared before the file is gone on with.

Whatever resumes keeps such a description beside its results, and refuses what it was not made for by naming it. A
description says what was asked for. What no description shows, such as a formula that has changed since, is told by a
number that was measured then and is measured again: see :func:`rounded`.
"""

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import fields, is_dataclass
from functools import partial
from hashlib import sha256
from inspect import signature
from pathlib import Path
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np

__all__ = ["Difference", "described", "differences", "refuse_other", "rounded"]

_DIGITS = 6
_OTHER_COMPUTER = 1e-3
_PLACE_IN_MEMORY: Any = object.__repr__


class _Absent:
    """What is not recorded."""

    def __repr__(self) -> str:
        return "absent"


_READ = 200  # letters of a value that a refusal tells
ABSENT = _Absent()


class Difference(NamedTuple):
    """What two descriptions disagree on: its dotted name, and both values."""

    name: str
    kept: Any
    asked: Any


def described(value: Any) -> Any:
    """Describe a value, ready for JSON, by what it was made of and not by where it lies in memory.

    Parameters
    ----------
    value : object
        Numbers, text, mappings and sequences are themselves. Of a function the description is its name with what it
        encloses, of a `partial` the arguments too, by name, of a dataclass its compared fields, of an array its shape
        and a digest; of any other object its `repr` where its class defines one, and its class's name otherwise.

    Returns
    -------
    object
        None, bool, int, float, str, list or dict.
    """
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, Mapping):
        return {str(key): described(each) for key, each in value.items()}
    if isinstance(value, list | range) or type(value) is tuple:
        return [described(each) for each in value]
    if isinstance(value, set | frozenset):
        return sorted((described(each) for each in value), key=repr)
    if isinstance(value, partial):
        given = signature(value.func).bind_partial(*value.args, **value.keywords).arguments
        return {"function": _text(value.func), **described(given)}
    return _text(value)


def differences(kept: Any, asked: Any, *, growing: Collection[str] = ()) -> list[Difference]:
    """What two descriptions disagree on.

    Parameters
    ----------
    kept, asked : mapping
        As from :func:`described`.
    growing : collection of str
        Entries of which either may hold what the other does not: only what both hold is compared.

    Returns
    -------
    list of Difference
        Of mappings, entry by entry. Numbers of an entry "probe", or within one, are measured, and the same where they
        agree to a thousandth: another computer adds up in another order, and chaos multiplies the difference.
    """
    return list(_differences("", kept, asked, growing))


def refuse_other(purpose: str, kept: Any, asked: Any, *, growing: Collection[str] = ()) -> None:
    """Refuse what a file was not made for.

    Parameters
    ----------
    purpose : str
        What equality is needed for, such as "to go on with the run in runs/bench".
    kept, asked, growing
        As in :func:`differences`.

    Raises
    ------
    ValueError
        If they differ. The message names every difference, what is kept and what was asked for; of entries "probe",
        which follow from the others, only where nothing else differs.
    """
    found = differences(kept, asked, growing=growing)
    if found:
        told = [each for each in found if not _is_measured(each.name)] or found
        raise ValueError(
            "; ".join(f"{name} must be {_short(was)} {purpose}, got {_short(now)}" for name, was, now in told)
        )


def _short(value: Any) -> str:
    """A value in a line that can be read, such as thousands of numbers by the first and the last of them."""
    text = repr(value)
    return text if len(text) <= _READ else f"{text[: _READ // 2]} ... {text[-_READ // 2 :]}"


def rounded(measured: float) -> float | str:
    """A measured number to six digits: what rounding errors leave alone, and a changed formula seldom does."""
    if not math.isfinite(measured):
        return str(measured)
    return float(f"{measured:.{_DIGITS}g}") if abs(measured) > 10.0**-_DIGITS else 0.0


def _differences(name: str, kept: Any, asked: Any, growing: Collection[str]) -> Iterator[Difference]:
    if not (isinstance(kept, Mapping) and isinstance(asked, Mapping)):
        if not _same(kept, asked, measured=_is_measured(name)):
            yield Difference(name, kept, asked)
        return
    for key in dict.fromkeys((*asked, *kept)):
        if name in growing and not (key in kept and key in asked):
            continue
        yield from _differences(
            f"{name}.{key}" if name else str(key), kept.get(key, ABSENT), asked.get(key, ABSENT), growing
        )


def _is_measured(name: str) -> bool:
    return "probe" in name.split(".")


def _same(kept: Any, asked: Any, measured: bool) -> bool:
    if isinstance(kept, list) and isinstance(asked, list):
        return len(kept) == len(asked) and all(_same(*pair, measured) for pair in zip(kept, asked, strict=True))
    if measured and isinstance(kept, float) and isinstance(asked, float):
        return math.isclose(kept, asked, rel_tol=_OTHER_COMPUTER, abs_tol=_OTHER_COMPUTER)
    return bool(kept == asked) and isinstance(kept, bool) == isinstance(asked, bool)


def _text(value: Any) -> str:
    if isinstance(value, partial):
        named = [f"{name}={_text(each)}" for name, each in value.keywords.items()]
        return f"{_text(value.func)}({', '.join([*map(_text, value.args), *named])})"
    if isinstance(value, FunctionType):
        enclosed = [
            f"{name}={_text(cell.cell_contents)}"
            for name, cell in zip(value.__code__.co_freevars, value.__closure__ or (), strict=True)
        ]
        return value.__qualname__ + (f"[{', '.join(enclosed)}]" if enclosed else "")
    if isinstance(value, type):
        return value.__qualname__
    name = type(value).__qualname__
    if is_dataclass(value):
        return f"{name}({', '.join(f'{f.name}={_text(getattr(value, f.name))}' for f in fields(value) if f.compare)})"
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return f"{name}({', '.join(f'{key}={_text(each)}' for key, each in zip(value._fields, value, strict=True))})"
    if isinstance(value, np.ndarray):
        digest = sha256(np.ascontiguousarray(value).tobytes()).hexdigest()[:12]
        return f"array(shape={value.shape}, dtype={value.dtype}, sha256={digest})"
    if type(value).__repr__ is _PLACE_IN_MEMORY:
        return name
    if isinstance(value, Mapping | list | tuple | range | set | frozenset | np.generic | Path):
        return repr(described(value))
    return repr(value)
