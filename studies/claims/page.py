"""The claims as a page of Markdown."""

from collections.abc import Mapping, Sequence

from .claim import Claim, CLAIMS, Number
from .real_body import portrait

__all__ = ["NOT_DRAWN", "as_markdown"]

NOT_DRAWN = (
    "Figures figS1 to figS5 are not drawn: no claim is known to rest on them, and the supplement's own table of "
    "figures does not match its numbers."
)


def as_markdown(decided: Sequence[Claim], pictures: Mapping[str, Sequence[str]], command: str) -> str:
    """The claims, each with its verdict, its numbers and its pictures.

    Parameters
    ----------
    decided : sequence of Claim
    pictures : mapping of str to sequence of str
        Files by the name of the claim.
    command : str
        That wrote the page.

    Returns
    -------
    str
    """
    lines = ["# What of the paper stands", "", f"`{command}` wrote this page.", ""]
    lines += ["| claim | the paper | verdict |", "|---|---|---|"]
    lines += [
        f"| [{claim.name}](#{claim.name.lower()}) | {CLAIMS[claim.name]} | **{claim.verdict}** |" for claim in decided
    ]
    lines += ["", f"The real body of the tables is {portrait()}.", "", NOT_DRAWN]
    shown: set[str] = set()
    for claim in decided:
        lines += ["", f"## {claim.name}", "", f"{CLAIMS[claim.name]} **{claim.verdict.capitalize()}.**", ""]
        lines += [claim.sentence, "", *_table("number", claim.numbers)]
        if claim.body:
            lines += ["", *_table("the real body", claim.body)]
        lines += ["", f"Checked by `{claim.check}`."]
        for picture in pictures[claim.name]:
            if picture not in shown:
                shown.add(picture)
                lines += ["", f"![{_caption(picture)}]({picture})"]
    return "\n".join(lines) + "\n"


def _table(heading: str, numbers: Mapping[str, Number]) -> list[str]:
    return [
        f"| {heading} | value [95%] |",
        "|---|---:|",
        *(f"| {name} | {number} |" for name, number in numbers.items()),
    ]


def _caption(picture: str) -> str:
    stem = picture.rsplit("/", 1)[-1].rsplit(".", 1)[0].removeprefix("claims_")
    return f"{stem} of the paper, redone" if stem.startswith("fig") else f"{stem}, which the paper has no figure of"
