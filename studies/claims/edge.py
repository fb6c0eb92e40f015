"""C3, C4 and C5: where memory is largest, against work and against the exponent."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, TYPE_CHECKING

from scipy.stats import binomtest

from ..edge import FULL, QUICK, Study
from ..edge.line import lines_through_the_edge
from ..edge.over_maps import maps_of_all, where_memory_is_largest, work_and_memory
from ..edge.verdicts import Finding, memory_along_work, memory_at_the_edge, where_an_edge_is
from .asked import Asked
from .claim import Claim, interval, Number, Verdict
from .real_body import BODY

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Edge", "claims", "measure"]

VERDICT_OF: Mapping[str, Verdict] = {
    "yes": "reproduced",
    "in part": "reproduced in part",
    "of the anchored body only": "reproduced in part",
    "not as the paper has it": "not reproduced",
    "not told": "not reproduced",
    "no": "overturned",
}
"""By the answer of a finding."""
_SLEEVES = (0.0, 1.0, 5.0, 20.0, 100.0)  # Pi1 that a sleeve around the real body gives it


@dataclass(frozen=True)
class Edge:
    """Maps and lines, what they tell, and the map of the real body.

    Attributes
    ----------
    maps, lines : dict of str to Dataset
    told : mapping
        "largest memory", "work" and "line", as `stickslip.studies.edge` tells them.
    body : dict of str to Dataset
        Of the real body along Pi1, by scene.
    """

    maps: dict[str, xr.Dataset]
    lines: dict[str, xr.Dataset]
    told: Mapping[str, Any]
    body: dict[str, xr.Dataset]


def measure(asked: Asked) -> Edge:
    """Make the maps, each kept in the folder; a quick run takes holds of 0.5 and one damping."""
    study = Study(
        replace(QUICK, columns=1) if asked.quick else FULL, asked.folder / "maps", asked.processes, asked.show
    )
    maps = maps_of_all(study, holds=(0.5,), dampings=(0.02,)) if asked.quick else maps_of_all(study)
    lines, _, line = lines_through_the_edge(study, measures=("memory", "parity"))
    told = {"largest memory": where_memory_is_largest(maps)[1], "work": work_and_memory(maps)[1], "line": line}
    body = {
        place: study.map(
            f"body {place}",
            ("duffing", _SLEEVES),
            measures=["memory", "lyapunov", "work"],
            groups=BODY.groups,
            scene=scene,
            virtual_nodes=1,
            seeds=4,
        )
        for place, scene in (("anchored", {"anchored": True}), ("ground", {}))
    }
    return Edge(maps, lines, told, body)


def claims(edge: Edge) -> list[Claim]:
    """C3, C4 and C5, decided."""
    of_body = _of_body(edge.body)
    return [
        along_work(edge.told["work"], of_body["C3"]),
        an_edge(edge.told["largest memory"], of_body["C4"]),
        at_the_edge(edge.told["largest memory"], edge.told["line"], of_body["C5"]),
    ]


def along_work(work: Mapping[str, Mapping[str, int]], body: Mapping[str, Number] | None = None) -> Claim:
    """C3, by the rows of Pi4 whose memory is largest at neither end of Pi1."""
    first, inside, last = (sum(each[key] for each in work.values()) for key in ("first", "inside", "last"))
    rows = first + inside + last
    shares = {
        "rows of Pi4 with most memory inside Pi1": _share(inside, rows),
        "rows with most memory at the least Pi1, where most work is done": _share(first, rows),
    }
    return _decided("C3", memory_along_work(work), shares, "stickslip reproduce fig2", body)


def an_edge(largest: Mapping[str, Any], body: Mapping[str, Number] | None = None) -> Claim:
    """C4, by the shares of cells whose exponent is above 0."""
    shares = {
        f"chaotic cells, {name.removesuffix(', raw')}": _share(each["chaotic"], each["cells"])
        for name, each in largest.items()
        if name.endswith("raw")
    }
    return _decided("C4", where_an_edge_is(largest), shares, "stickslip reproduce fig3", body)


def at_the_edge(
    largest: Mapping[str, Any], lines: Mapping[str, Any] | None = None, body: Mapping[str, Number] | None = None
) -> Claim:
    """C5, by how much more memory the best cell has than the best at the edge, on maps and along lines."""
    more = {
        f"most memory less most at the edge, {name}": Number(*each["more"])
        for name, each in largest.items()
        if "more" in each
    } | {
        f"along Pi1, {name.removesuffix(': memory')}": Number(*each["more"])
        for name, each in (lines or {}).items()
        if name.endswith(": memory") and each["more"]
    }
    return _decided("C5", memory_at_the_edge(largest), more, "stickslip reproduce fig3", body)


def _decided(
    name: str, finding: Finding, found: Mapping[str, Number], check: str, body: Mapping[str, Number] | None
) -> Claim:
    return Claim(name, VERDICT_OF[finding.answer], finding.sentence, dict(found), check, dict(body or {}))


def _share(part: int, whole: int) -> Number:
    """A share with Wilson's 95% interval."""
    interval = binomtest(part, whole).proportion_ci(method="wilson")
    return Number(part / whole, float(interval.low), float(interval.high))


def _of_body(maps: Mapping[str, xr.Dataset]) -> dict[str, dict[str, Number]]:
    """What the real body does as it is and in sleeves of cubic stiffness, in mJ, s and N/mm^3."""
    scales = BODY.scales
    sleeve = BODY.stiffness / scales.length**2 * 1e-9  # N/mm^3 for each unit of Pi1
    told: dict[str, dict[str, Number]] = {"C3": {}, "C4": {}, "C5": {}}
    for place, found in maps.items():
        for duffing in (_SLEEVES[0], _SLEEVES[-1]):
            cell = found.sel(duffing=duffing)
            name = f"{place}, k_3 = {duffing * sleeve:.2g} N/mm^3"
            told["C3"][f"work a hold, {name}"] = interval(cell.work.values * scales.energy * 1e3, "mJ")
            told["C4"][f"exponent, {name}"] = interval(cell.lyapunov.values / scales.time, "1/s")
        best = max(_SLEEVES, key=lambda duffing: float(found.memory.sel(duffing=duffing).mean()))
        told["C3"][f"most memory, {place}, at k_3 = {best * sleeve:.2g} N/mm^3"] = interval(
            found.memory.sel(duffing=best).values
        )
        told["C5"][f"exponent at most memory, {place}"] = interval(
            found.lyapunov.sel(duffing=best).values / scales.time, "1/s"
        )
    return told
