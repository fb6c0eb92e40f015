"""``stickslip reproduce``."""

from pathlib import Path
from typing import Annotated

from ..common.extras import optional_import
from .printing import say

with optional_import():
    import typer

__all__ = ["reproduce"]


def reproduce(
    figures: Annotated[
        list[str] | None, typer.Argument(help="Of the paper, such as fig4, or work; claims or all for all of them.")
    ] = None,
    output: Annotated[Path, typer.Option(help="Folder of claims.json, the page and the pictures.")] = Path(
        "runs/claims"
    ),
    quick: Annotated[bool, typer.Option("--quick", help="Three seeds instead of eight, and less of all else.")] = False,
    processes: Annotated[int | None, typer.Option(help="That share maps; all processors by default.", min=1)] = None,
) -> None:
    """Test the paper's claims: verdicts with numbers and intervals, and its figures.

    What is finished in the output folder is not done again, so that an interrupted run goes on.
    """
    from ..common.sharing import processors
    from ..studies.claims.claim import WHY_UNKNOWN
    from ..studies.claims.real_body import portrait
    from ..studies.claims.reproduce import reproduce as decide

    asked = [] if {"claims", "all"} & set(figures or ()) else figures or []
    for claim in decide(output, asked, quick=quick, processes=processes or processors(), show=say):
        say(f"{claim.name}  {claim.verdict}: {' '.join([claim.sentence, claim.remark]).rstrip()}")
        if claim.body:
            say(f"    the real body: {'; '.join(f'{name} {number}' for name, number in claim.body.items())}")
    say(f"The real body is {portrait()}.")
    if not asked:
        say(f"Not drawn: {WHY_UNKNOWN}.")
    say(f"claims.json, index.md and figures in {output}")
