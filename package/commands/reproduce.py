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
        list[str] | None, typer.Argument(help="Of the paper, such as fig4; claims or all for all of them.")
    ] = None,
    output: Annotated[Path, typer.Option(help="Folder of claims.json, the page and the pictures.")] = Path(
        "runs/claims"
    ),
    quick: Annotated[bool, typer.Option("--quick", help="Three seeds instead of eight.")] = False,
) -> None:
    """Test the paper's claims: verdicts with numbers and intervals, and its figures."""
    from ..studies.claims.reproduce import reproduce as decide

    asked = [figure for figure in figures or () if figure not in ("claims", "all")]
    for claim in decide(output, asked, quick=quick, show=say):
        say(f"{claim.name}  {claim.verdict}: {claim.sentence}")
    say(f"claims.json, index.md and figures in {output}")
