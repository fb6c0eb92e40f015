"""The paper's claims, decided, and its figures, drawn: a folder of ``claims.json``, ``index.md`` and pictures."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, TYPE_CHECKING

from ...common.figures import save_figure
from ...common.files import write_text
from ...common.kept import Kept
from ...common.validation import known_names
from ..work.figure import plot_work as plot_work_study
from . import crawl, edge, edge_figure, laws, laws_figure, sindy_figures, twin, twin_figure, work
from .asked import Asked
from .claim import Claim, CLAIMS, UNKNOWN, WHY_UNKNOWN
from .page import as_markdown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["STUDIES", "Study", "reproduce"]

_STUDIES = "studies"  # folder of what is decided


@dataclass(frozen=True)
class Study:
    """What decides some claims.

    Attributes
    ----------
    measure : callable
        Of what is asked, to whatever the others take.
    decide : callable
        To the claims.
    figures : mapping of str to callable
        To the paper's figures, by their names, such as "fig4". Those that it does not have go by other names.
    """

    measure: Callable[[Asked], Any]
    decide: Callable[[Any], list[Claim]]
    figures: Mapping[str, Callable[[Any], Figure]]


STUDIES = {
    "crawl": Study(
        crawl.measure, lambda found: [crawl.claim(*found)], {"fig1": lambda found: crawl.plot_crawl(found[0])}
    ),
    "work": Study(
        work.measure, lambda found: [work.claim(found)], {"work": lambda found: plot_work_study(found.study)}
    ),
    "twin": Study(twin.measure, lambda found: [twin.claim(found)], {"figS6": twin_figure.plot_twin}),
    "laws": Study(
        laws.measure,
        laws.claims,
        {
            "fig4": laws_figure.plot_laws,
            "fig5": sindy_figures.plot_ways,
            "figS8": sindy_figures.plot_polynomial,
            "figS9": sindy_figures.plot_offsets,
            "figS10": sindy_figures.plot_rates,
        },
    ),
    "edge": Study(
        edge.measure,
        edge.claims,
        {
            "fig2": edge_figure.plot_work,
            "fig3": edge_figure.plot_edge,
            "figS7": edge_figure.plot_through_the_edge,
        },
    ),
}
"""By name, the quickest first."""


def reproduce(
    folder: Path,
    figures: Sequence[str] = (),
    *,
    quick: bool = False,
    processes: int = 1,
    show: Callable[[str], object] = lambda _: None,
) -> list[Claim]:
    """Decide claims and draw figures.

    Parameters
    ----------
    folder : Path
        Where to write ``claims.json``, ``index.md`` and the pictures; each is whole or not there. A study whose claims
        and pictures it has already is not done again.
    figures : sequence of str
        Of the paper, such as "fig4", or "work"; all by default. Whatever rests on the same study is drawn with them.
    quick : bool
        Three seeds instead of eight, and less of all else.
    processes : int
        That share maps.
    show : callable
        Told what begins.

    Returns
    -------
    list of Claim
        All that the folder has, those of earlier runs too.

    Raises
    ------
    ValueError
        If a figure is none of those or nothing is known of it, or the folder is of something else or of another kind
        of run.
    """
    if unknown := [figure for figure in figures if figure in UNKNOWN]:
        raise ValueError(f"figures cannot have {unknown[0]!r}: {WHY_UNKNOWN}")
    known_names("figures", figures, [figure for study in STUDIES.values() for figure in study.figures])
    _refuse_other_folder(folder)
    kept = Kept(folder / _STUDIES, {"stickslip": version("stickslip"), "quick": quick}, resume=True)
    asked = Asked(folder, quick, processes, show)
    wanted = [name for name, study in STUDIES.items() if not figures or set(figures) & set(study.figures)]
    for place, name in enumerate(wanted, 1):
        study = STUDIES[name]
        drawn = ", ".join(study.figures)
        if name in kept.load() and all(_picture(folder, figure).exists() for figure in study.figures):
            show(f"{place} of {len(wanted)}, {name}: {drawn}, done before")
            continue
        show(f"{place} of {len(wanted)}, {name}: {drawn}")
        found = study.measure(asked)
        for figure, draw in study.figures.items():
            save_figure(draw(found), _picture(folder, figure))
        kept.keep(name, [claim.as_json() for claim in study.decide(found)])
        _write(folder, kept, quick)
    return _write(folder, kept, quick)


def _write(folder: Path, kept: Kept, quick: bool) -> list[Claim]:
    """Write all that is decided so far, in the order of the paper."""
    try:
        claims = {name: [Claim.from_json(claim) for claim in found] for name, found in kept.load().items()}
    except (KeyError, TypeError) as error:
        raise ValueError(f"{folder / _STUDIES} holds claims of another form: choose another folder") from error
    decided = sorted((claim for found in claims.values() for claim in found), key=lambda each: _ORDER.index(each.name))
    command = f"stickslip reproduce{' --quick' if quick else ''}"
    write_text(folder / "claims.json", json.dumps([claim.as_json() for claim in decided], indent=1) + "\n")
    write_text(folder / "index.md", as_markdown(decided, command))
    return decided


_ORDER = list(CLAIMS)


def _picture(folder: Path, figure: str) -> Path:
    return folder / f"{figure}.png"


def _refuse_other_folder(folder: Path) -> None:
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"output must be a folder, got the file {folder}")
    if folder.exists() and any(folder.iterdir()) and not (folder / _STUDIES / "settings.json").exists():
        raise ValueError(
            f"output must be a new folder or one of an earlier reproduction, got {folder}, which holds other files"
        )
