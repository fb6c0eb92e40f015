"""The claims as a page of Markdown."""

from collections.abc import Mapping, Sequence

from .claim import Claim, CLAIMS, FIGURES, Number, WHY_UNKNOWN
from .real_body import portrait

__all__ = ["as_markdown", "sections"]


def as_markdown(decided: Sequence[Claim], command: str) -> str:
    """The claims as a page of their own: what wrote it, and `sections`."""
    return f"# What of the paper stands\n\n`{command}` wrote this page.\n\n{sections(decided)}\n"


def sections(decided: Sequence[Claim], picture: str = "{}.png") -> str:
    """The claims, each with its verdict, its numbers and its pictures.

    Parameters
    ----------
    decided : sequence of Claim
    picture : str
        Files of the pictures, "{}" being the name of a figure.

    Returns
    -------
    str
    """
    lines = ["| claim | the paper | verdict |", "|---|---|---|"]
    lines += [
        f"| [{claim.name}](#{claim.name.lower()}) | {CLAIMS[claim.name]} | **{claim.verdict}** |" for claim in decided
    ]
    lines += [
        "",
        f"The real body of the tables is {portrait()}.",
        "",
        f"Not drawn: {WHY_UNKNOWN}.",
    ]
    shown: set[str] = set()
    for claim in decided:
        lines += ["", f"## {claim.name}", "", f"{CLAIMS[claim.name]} **{claim.verdict.capitalize()}.**", ""]
        lines += [claim.sentence, "", *([claim.remark, ""] if claim.remark else []), *_table("number", claim.numbers)]
        if claim.body:
            lines += ["", *_table("the real body", claim.body)]
        lines += ["", f"Checked by `{claim.check}`."]
        for figure in FIGURES[claim.name]:
            if figure not in shown:
                shown.add(figure)
                lines += ["", f"![{_caption(figure)}]({picture.format(figure)})"]
    return "\n".join(lines)


def _table(heading: str, numbers: Mapping[str, Number]) -> list[str]:
    return [
        f"| {heading} | value [95%] |",
        "|---|---:|",
        *(f"| {name} | {number} |" for name, number in numbers.items()),
    ]


def _caption(figure: str) -> str:
    return f"{figure} of the paper, redone" if figure.startswith("fig") else f"{figure}: the paper has no figure of it"
