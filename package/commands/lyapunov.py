"""``stickslip lyapunov``."""

from pathlib import Path
from typing import Annotated, TYPE_CHECKING

from ..common.extras import optional_import
from ..common.validation import whole_number
from .options import groups_of, GroupsOption, hold_of, HoldOption, InputsOption, json_object, SceneOption
from .printing import print_table, progress, say

with optional_import():
    import typer

if TYPE_CHECKING:
    from ..crawler import LyapunovSpectrum

__all__ = ["lyapunov"]

# Rows that a terminal shows of a diagram.
_SHOWN = 12


def lyapunov(
    groups: GroupsOption = None,
    scene: SceneOption = "{}",
    hold: HoldOption = "0.5",
    inputs: InputsOption = "bits",
    holds: Annotated[int, typer.Option(help="Of each run, from rest.")] = 4200,
    washout: Annotated[int, typer.Option(help="Holds at its start that are not measured.")] = 200,
    seeds: Annotated[int, typer.Option(help="Runs, each with its own input.")] = 1,
    tolerance: Annotated[float, typer.Option(help="As in `simulate`.")] = 1e-9,
    over: Annotated[
        str | None,
        typer.Option(help="A number to draw a diagram over, such as 'duffing=0:200:64' or 'deborah=0.05:8:64:log'."),
    ] = None,
    output: Annotated[Path, typer.Option(help="Folder of the diagram.")] = Path("runs/lyapunov"),
) -> None:
    """Lyapunov exponents of a driven crawler, through its slips and stops; over one of its numbers with a diagram."""
    body = None if groups is None else groups_of(groups)
    ground = json_object("--scene", scene)
    length = hold_of(hold, body)
    heading = ["", "exponents", "", "foot", "stops", "verdict"]
    if over is None:
        import numpy as np

        from ..crawler import Groups, lyapunov_spectrum
        from ..studies.maps import Inputs

        seeds = whole_number("--seeds", seeds, 1)
        ensemble = Inputs.of(inputs)
        valve = np.array([ensemble.drawn(holds, seed).valve for seed in range(seeds)])
        found = lyapunov_spectrum(Groups.of(body), valve, length, scene=ground, tolerance=tolerance, washout=washout)
        print_table(
            f"{found.time:g} natural times; the pressure forgets at {found.lag_exponent:.4g}",
            [heading, _row("body", found)],
        )
        return

    from ..common.figures import save_figure
    from ..studies.bifurcation import bifurcation_diagram

    with progress("values") as show:

        def begun(done: int, of: int) -> None:
            output.mkdir(parents=True, exist_ok=True)
            show(done, of)

        diagram = bifurcation_diagram(
            over,
            groups=body,
            scene=ground,
            hold=length,
            inputs=inputs,
            holds=holds,
            washout=washout,
            seeds=seeds,
            tolerance=tolerance,
            on_progress=begun,
        )
    save_figure(diagram.plot(), *(output / f"diagram.{form}" for form in ("png", "svg")))
    every = -(-len(diagram.values) // _SHOWN)
    rows = [_row(f"{value:.4g}", one) for value, one in zip(diagram.values, diagram.spectra, strict=True)]
    print_table(diagram.name, [heading, *rows[::every]])
    say(f"Diagram: {output / 'diagram.png'}")


def _row(name: str, found: "LyapunovSpectrum") -> list[str]:
    told = [f"{value:.4f} ± {error:.4f}" for value, error in zip(found.exponents, found.standard_error, strict=True)]
    return [name, *told, f"{found.foot_exponent:g}", str(found.stops), found.verdict]
