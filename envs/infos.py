"""What `reset` and `step` tell beside the observation: one table for single and batched environment."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from numpy.typing import NDArray

from ..compiling.compilation import formula
from ..crawler import Groups, Scene
from .reward import innovation, memory, speed
from .transition import Formula, Transition, writer

__all__ = [
    "COUNTS",
    "NUMBERS",
    "TOLD",
    "Info",
    "begun",
    "info_of",
    "infos_of_each",
    "place_of",
    "table_of_infos",
    "write_counts",
    "write_early_numbers",
    "write_numbers",
    "write_told",
]


class Info(NamedTuple):
    """A number that is told of a step, 0 at a reset."""

    name: str
    kind: type[float] | type[int]
    formula: Formula
    description: str
    # Whether a batch writes it as soon as the valve has turned: of an affine map a hold, one column more at the hold's
    # end costs a tenth.
    early: bool = False


@formula
def _distance(step: Transition) -> float:
    return step.body.foot


@formula
def _valve(step: Transition) -> int:
    return step.valve


@formula
def _slips(step: Transition) -> int:
    return step.body.slips


_TABLE = (
    Info("speed", float, speed, "of the foot, its mean over the hold, z_c / t_c"),
    Info("memory", float, memory, "what the readout earned"),
    Info("distance", float, _distance, "of the foot from its start, z_c"),
    Info("innovation", float, innovation, "e_k", early=True),
    Info("valve", int, _valve, "u_k, after the flip"),
    Info("slips", int, _slips, "so far in the episode"),
)
_EPISODE = (
    ("groups", "dict of floats", "the episode's own, by name"),
    ("slope", "float", "the episode's own"),
)

_INFOS = sorted(_TABLE, key=lambda info: info.kind is int)  # stable: the whole numbers last
NUMBERS, COUNTS = (tuple(info.name for info in _INFOS if info.kind is kind) for kind in (float, int))
"""Names of what is told of a step: floats, and whole numbers."""

TOLD = (*NUMBERS, *COUNTS)
"""Both, in the order of what `write_told` writes."""

write_told = writer({place: info.formula for place, info in enumerate(_INFOS)})
"""Write what is told of a transition into an array, in compiled code."""


_FLOATS, _COUNTED = ([info for info in _INFOS if info.kind is kind] for kind in (float, int))
write_early_numbers, write_numbers = (
    writer({place: info.formula for place, info in enumerate(_FLOATS) if info.early == early})
    for early in (True, False)
)
"""Write those of `NUMBERS` that are early, and the others, each in its place."""

write_counts = writer({place: info.formula for place, info in enumerate(_COUNTED)})
"""Write `COUNTS`."""


def place_of(name: str) -> int:
    """Where in what `write_told` writes."""
    return TOLD.index(name)


def begun(groups: Groups, scene: Scene) -> dict[str, Any]:
    """What `reset` tells of an episode: that nothing has happened yet, and who crawls where."""
    return {**dict.fromkeys(NUMBERS, 0.0), **dict.fromkeys(COUNTS, 0), "groups": groups.to_dict(), "slope": scene.slope}


def _display(values: Mapping[str, str], rest: str = "") -> str:
    """Source of a dict: a display with its keys written out takes a third of the time of any other way to make one."""
    return "{" + ", ".join(f"{name!r}: {value}" for name, value in values.items()) + rest + "}"


def _info_of() -> Callable[[list[float], dict[str, float], float], dict[str, Any]]:
    values = {info.name: f"told[{k}]" if info.kind is float else f"int(told[{k}])" for k, info in enumerate(_INFOS)}
    made: Callable[..., dict[str, Any]]
    made = eval(f"lambda told, groups, slope: {_display({**values, 'groups': 'groups', 'slope': 'slope'})}")
    return made


info_of = _info_of()
"""Infos of one step, from the list of what `write_told` wrote, the groups by name and the slope."""


def infos_of_each(
    constants: Mapping[str, object],
) -> Callable[[Mapping[str, NDArray[Any]], Sequence[tuple[dict[str, float], float]]], list[dict[str, Any]]]:
    """Make a function of a batch's infos, and of groups and slope of each, that returns the infos of each.

    Parameters
    ----------
    constants : mapping
        What all of them hold besides.
    """
    names = [f"told_{k}" for k in range(len(TOLD))]
    values = dict(zip(TOLD, names, strict=True)) | {"groups": "groups.copy()", "slope": "slope"}
    values |= {name: f"constants[{name!r}]" for name in constants}
    rows = "zip(*(infos[name].tolist() for name in names), crawlers, strict=True)"
    source = f"lambda infos, crawlers: [{_display(values)} for {', '.join(names)}, (groups, slope) in {rows}]"
    made: Callable[..., list[dict[str, Any]]] = eval(source, {"constants": constants, "names": TOLD})
    return made


def table_of_infos() -> str:
    """What is told, as a table of the documentation."""
    rows: list[tuple[str, ...]] = [("Key", "Type", "Description", "At reset")]
    rows += [(f"`{info.name}`", info.kind.__name__, info.description, "0") for info in _TABLE]
    rows += [(f"`{name}`", kind, description, "the same") for name, kind, description in _EPISODE]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    rows.insert(1, tuple("-" * width for width in widths))
    return "\n".join(f"| {' | '.join(map(str.ljust, row, widths))} |" for row in rows)
