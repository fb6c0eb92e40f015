"""The claims as a page of Markdown."""

from collections.abc import Mapping, Sequence

from .claim import CAPTIONS, Claim, CLAIMS, FIGURES, INDEPENDENT, Number, WHY_UNKNOWN
from .real_body import portrait

__all__ = ["as_markdown", "sections"]

_CELLS = 6  # of a table of two directions, at least


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
        lines += [claim.sentence, "", *([claim.remark, ""] if claim.remark else []), *_tables("number", claim.numbers)]
        if claim.body:
            lines += ["", *_tables("the real body", claim.body)]
        truth, test = INDEPENDENT[claim.name]
        lines += ["", f"Found again by `{claim.check}`; judged independently by {truth} (`{test}`)."]
        for figure in FIGURES[claim.name]:
            if figure not in shown:
                shown.add(figure)
                lines += ["", f"![{_caption(figure)}]({picture.format(figure)})"]
                lines += ["", f"*{CAPTIONS[figure]}*"]
    return "\n".join(lines)


def _tables(heading: str, numbers: Mapping[str, Number]) -> list[str]:
    """Numbers a line each, and those whose names differ in their last words alone as tables of both parts."""
    wide = _wide(numbers)
    long = {name: number for name, number in numbers.items() if not any(name in each for each in wide)}
    lines = [
        f"| {heading} | value [95%] |",
        "|---|---:|",
        *(f"| {name} | {number} |" for name, number in long.items()),
    ]
    for names in wide:
        rows, columns = (list(dict.fromkeys(part)) for part in zip(*names.values(), strict=True))
        cells = {parts: str(numbers[name]) for name, parts in names.items()}
        if len(columns) > len(rows):
            rows, columns = columns, rows
            cells = {(last, first): cell for (first, last), cell in cells.items()}
        lines += ["", "| " + " | ".join(["", *columns]) + " |", "|---|" + "---:|" * len(columns)]
        lines += ["| " + " | ".join([row, *(cells[row, column] for column in columns)]) + " |" for row in rows]
    return lines


def _wide(numbers: Mapping[str, Number]) -> list[dict[str, tuple[str, str]]]:
    """Names that fill a table, each with its first and last words: two rows and columns at least, and six cells."""
    parts = {name: (first, last) for name in numbers for first, _, last in [name.rpartition(", ")] if first}
    last_words: dict[str, tuple[str, ...]] = {}
    for first, last in parts.values():
        last_words[first] = (*last_words.get(first, ()), last)
    together: dict[tuple[str, ...], dict[str, tuple[str, str]]] = {}
    for name, (first, last) in parts.items():
        together.setdefault(last_words[first], {})[name] = first, last
    return [names for columns, names in together.items() if 1 < len(columns) < len(names) and len(names) >= _CELLS]


def _caption(figure: str) -> str:
    return f"{figure} of the paper, redone" if figure.startswith("fig") else f"{figure}: the paper has no figure of it"
