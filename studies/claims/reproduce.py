"""The paper's claims, decided, and its figures, drawn: a folder of ``claims.json``, ``index.md`` and pictures."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TYPE_CHECKING

from ...common.figures import save_figure
from ...common.files import write_text
from ...common.validation import known_names
from . import crawl, laws, laws_figure, twin, twin_figure
from .claim import Claim, CLAIMS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["STUDIES", "Study", "as_markdown", "reproduce"]


@dataclass(frozen=True)
class Study:
    """What decides some claims.

    Attributes
    ----------
    figure : str
        The paper's figure that the picture stands for, such as "fig4".
    measure : callable
        Of seeds, to whatever the others take.
    decide : callable
        To the claims.
    draw : callable
        To the figure.
    """

    figure: str
    measure: Callable[[Sequence[int]], Any]
    decide: Callable[[Any], list[Claim]]
    draw: Callable[[Any], Figure]


STUDIES = {
    "crawl": Study("fig1", lambda _: crawl.crawl(), lambda found: [crawl.claim(found)], crawl.plot_crawl),
    "twin": Study("figS6", twin.measure, lambda found: [twin.claim(found)], twin_figure.plot_twin),
    "laws": Study("fig4", laws.measure, laws.claims, laws_figure.plot_laws),
}
"""By name. C3, C4, C5 and the chaos of C10 are decided by `stickslip.studies.maps` (docs/edge.md)."""
SEEDS, QUICK_SEEDS = range(8), range(3)


def reproduce(
    folder: Path, figures: Sequence[str] = (), *, quick: bool = False, show: Callable[[str], None] = lambda _: None
) -> list[Claim]:
    """Decide claims and draw figures.

    Parameters
    ----------
    folder : Path
        Where to write ``claims.json``, ``index.md`` and a picture a study; each is whole or not there.
    figures : sequence of str
        Of the paper, such as "fig4"; all by default.
    quick : bool
        Three seeds instead of eight.
    show : callable
        Told the name of each study as it begins.

    Returns
    -------
    list of Claim

    Raises
    ------
    ValueError
        If a figure is none of those.
    """
    known_names("figures", figures, [study.figure for study in STUDIES.values()])
    decided: list[Claim] = []
    pictures: dict[str, str] = {}
    folder.mkdir(parents=True, exist_ok=True)
    for name, study in STUDIES.items():
        if figures and study.figure not in figures:
            continue
        show(f"{name}: {study.figure}")
        found = study.measure(QUICK_SEEDS if quick else SEEDS)
        picture = folder / f"{study.figure}.png"
        save_figure(study.draw(found), picture)
        for claim in study.decide(found):
            decided.append(claim)
            pictures[claim.name] = picture.name
        decided.sort(key=lambda claim: list(CLAIMS).index(claim.name))
        write_text(folder / "claims.json", json.dumps([claim.as_json() for claim in decided], indent=1) + "\n")
        write_text(folder / "index.md", as_markdown(decided, pictures))
    return decided


def as_markdown(decided: Sequence[Claim], pictures: dict[str, str]) -> str:
    """The claims as a page, each with its verdict, its numbers and its picture."""
    lines = ["# What of the paper stands", "", "| claim | the paper | verdict |", "|---|---|---|"]
    lines += [
        f"| [{claim.name}](#{claim.name.lower()}) | {CLAIMS[claim.name]} | **{claim.verdict}** |" for claim in decided
    ]
    shown: set[str] = set()
    for claim in decided:
        lines += ["", f"## {claim.name}", "", claim.sentence, "", "| number | value [95%] |", "|---|---:|"]
        lines += [f"| {name} | {number} |" for name, number in claim.numbers.items()]
        lines += ["", f"Checked by `{claim.check}`."]
        picture = pictures[claim.name]
        if picture not in shown:
            shown.add(picture)
            lines += ["", f"![{Path(picture).stem} of the paper, redone]({picture})"]
    return "\n".join(lines) + "\n"
