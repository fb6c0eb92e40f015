"""What the numbers of the study say of the paper's claims, in sentences: pure functions of numbers."""

import re
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from .study import PLACES

__all__ = [
    "Finding",
    "memory_along_work",
    "memory_at_the_edge",
    "spread_by_chaos",
    "verdicts",
    "where_an_edge_is",
]

_WORTH = 0.05  # capacity from which a series counts
_CHAOTIC = 0.01  # exponent from which a body counts as chaotic beyond doubt
_FORGOTTEN = 0.1  # share of the spread over inputs below which starts do not spread the work


class Finding(NamedTuple):
    """What is found of a claim.

    Attributes
    ----------
    claim : str
        What is asked, with the paper's number.
    answer : str
        In a word or a few.
    sentence : str
        The numbers that say so.
    """

    claim: str
    answer: str
    sentence: str

    def __str__(self) -> str:
        return f"**{self.claim}: {self.answer}.** {self.sentence}"


def verdicts(told: Mapping[str, Any]) -> str:
    """All that the study says, a line each."""
    largest = told["largest memory"]
    each_claim = (
        where_an_edge_is(largest),
        memory_at_the_edge(largest),
        _why(told["modes"]),
        memory_along_work(told["work"]),
        _whether_products_peak(told["line"]),
        _whether_starts_are_forgotten(told["forgetting"]),
        _chaos_on_the_ground(told["ground"], told["words"]),
        spread_by_chaos(told["spread of work"]),
        _what_a_chain_does(told["chain"]),
    )
    return "\n".join(f"- {each}" for each in each_claim)


def where_an_edge_is(largest: Mapping[str, Any]) -> Finding:
    """C4, by the chaotic cells of the maps of raw states, whose exponents are those of the body."""
    raw = {name: each for name, each in largest.items() if name.endswith("raw")}
    chaos = {place: [each["chaotic"] for name, each in raw.items() if name.startswith(place)] for place in PLACES}
    cells = next(iter(raw.values()))["cells"]
    low, high = min(chaos["anchored"]), max(chaos["anchored"])
    ground = sum(chaos["ground"])
    if low and min(chaos["ground"]):
        answer = "yes"
    elif low and not ground:
        answer = "of the anchored body only"
    else:
        answer = "not as the paper has it"
    return Finding(
        "C4, a curve λ = 0 in Π₁ × Π₄",
        answer,
        f"Under fair bits {low} to {high} of {cells} cells are chaotic where the body is anchored, and {ground} of "
        f"{cells * len(chaos['ground'])} on the ground, at {_dampings(raw)}.",
    )


def _dampings(names: Iterable[str]) -> str:
    return "Π₂ " + " and ".join(sorted({found[1] for name in names if (found := re.search(r"Π₂ ([\d.]+)", name))}))


def memory_at_the_edge(largest: Mapping[str, Any]) -> Finding:
    """C5, by how much more the best cell of each map holds than the best at its edge.

    Memory is at the edge only where the exponent of the best cell cannot be told from 0: on a coarse map the cell that
    is nearest to the edge may be far from it.
    """
    with_edge = [each for each in largest.values() if "more" in each]
    margins = [each["more"][0] for each in with_edge]
    ahead = sum(each["more"][1] > 0.0 for each in with_edge)
    behind = sum(each["more"][2] < 0.0 for each in with_edge)
    exponents = [each["exponent"][0] for each in largest.values()]
    if ahead and not behind:
        answer = "no"
    elif not ahead and all(each["exponent"][1] <= 0.0 <= each["exponent"][2] for each in with_edge):
        answer = "yes"
    else:
        answer = "not told"
    return Finding(
        "C5, memory is largest at the edge",
        answer,
        f"Over {len(largest)} maps the cell of most memory has an exponent of {min(exponents):.3f} to "
        f"{max(exponents):.3f}. It holds {min(margins):.2f} to {max(margins):.2f} more than the best cell at the edge "
        f"in the {len(with_edge)} maps that have one: more by the 95% interval in {ahead}, less in {behind}.",
    )


def _why(modes: Mapping[str, Any]) -> str:
    off = max(abs(each["exact"] - 3.0) for each in modes.values())
    return (
        f"**Why: a linear body holds all that its states can.** Three states remember 3 at most, and {len(modes)} "
        f"linear bodies, at three dampings and lags, remember 3 exactly (to {off:.0e}), whatever their exponents: the "
        f"slower of λ and −1/Π₄ decides how far back memory reaches, by a half-life of ln 2 / (2 abs(rate) hold), "
        f"and not how much of it there is."
    )


def memory_along_work(work: Mapping[str, Any]) -> Finding:
    """C3, by where along Π₁ memory is largest in each row of each map."""
    first, inside, last = (sum(each[key] for each in work.values()) for key in ("first", "inside", "last"))
    rows = first + inside + last
    if inside < 0.5 * rows:
        answer = "no"
    elif inside < 0.9 * rows:
        answer = "in part"
    else:
        answer = "yes"
    return Finding(
        "C3, along Π₁ memory peaks at moderate work",
        answer,
        f"Of {rows} rows of Π₄ memory is largest at the least Π₁, where most work is done, in {first}, inside in "
        f"{inside}, and at the largest Π₁ in {last}.",
    )


def _whether_products_peak(lines: Mapping[str, Any]) -> str:
    series = {name: each for name, each in lines.items() if ": " in name}
    found = {
        kind: [each for name, each in series.items() if name.endswith(ends) and each["most"][0] >= _WORTH]
        for kind, ends in {
            "linear": ("memory", "degree 1"),
            "products": ("parity_2", "parity_3", "degree 2", "degree 3"),
        }.items()
    }
    at_edge = {kind: sum(not each["more"] or each["more"][1] <= 0.0 for each in rows) for kind, rows in found.items()}
    exponents = [each["exponent"] for each in found["products"]]
    where = "on the contracting side of the edge" if max(exponents) < 0.0 else "on both sides of the edge"
    return (
        f"**Products of inputs** (parities and capacities of degrees 2 and 3) are largest {where}, at exponents of "
        f"{min(exponents):.3f} to {max(exponents):.3f} along two lines through λ = 0, and "
        f"{'not' if not at_edge['products'] else 'in part'} at it: of {len(exponents)} series that reach {_WORTH}, "
        f"{len(exponents) - at_edge['products']} are larger there than beside λ = 0 by the 95% interval, and of "
        f"{len(found['linear'])} of linear memory {len(found['linear']) - at_edge['linear']}."
    )


def _whether_starts_are_forgotten(forgetting: Mapping[str, Any]) -> str:
    counts = np.sum(list(forgetting.values()), axis=0).tolist()
    return (
        f"**Echo-state property:** of {sum(counts)} cells whose exponent is told from 0, {counts[0]} contract "
        f"and forget "
        f"their start, {counts[3]} are chaotic and keep it, {counts[1]} contract and have not forgotten it yet, and "
        f"{counts[2]} are chaotic and forget it."
    )


def _chaos_on_the_ground(low: Mapping[str, Any], words: Mapping[str, Any]) -> str:
    share = [f"{each:.1%}" for each in words["share"][1:]]
    return (
        f"**Chaos on the ground** exists at low damping (Π₂ 0.002, Π₁ 100 to 2000: {low['raw']['chaotic']} of "
        f"{low['raw']['cells']} cells under fair bits) and under short periodic words ({words['chaotic']} of "
        f"{words['tries']} random tries, 95% interval {share[0]} to {share[1]}); of these "
        f"{words['chaotic under flips']} have an exponent above 0 once a tenth of the bits are flipped."
    )


def spread_by_chaos(spread: Mapping[str, Any]) -> Finding:
    """C10, by what starts that hardly differ come to of the spread that inputs make."""
    calm = [each["share"] for name, each in spread.items() if name.startswith("ground")]
    wild = [
        each["share"] for name, each in spread.items() if name.startswith("anchored") and each["exponent"] > _CHAOTIC
    ]
    return Finding(
        "C10, chaos of stick-slip spreads the work",
        "no" if max(calm) < _FORGOTTEN else "in part",
        f"On the ground starts that differ by a thousandth come to at most {max(calm):.1g} of the spread that inputs "
        f"make; where the body is anchored and chaotic, and neither sticks nor slips, to {min(wild):.1f} to "
        f"{max(wild):.1f} of it.",
    )


def _what_a_chain_does(chain: Mapping[str, Any]) -> str:
    each_place = [
        f"{place} {each['kept']} of {each['cells']} cells keep their start, and the cell of most memory "
        f"{'is one of them' if each['best keeps'] else 'is none of them'}"
        for place, each in chain.items()
    ]
    return f"**A chain of three segments:** {'; '.join(each_place)}."
