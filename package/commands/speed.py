"""``stickslip speed``."""

from pathlib import Path
from typing import Annotated, TYPE_CHECKING

from ..common.extras import optional_import
from ..common.validation import number_within, whole_number
from .options import groups_of, GroupsOption, hold_of, HoldOption, json_object, SceneOption
from .printing import print_whole, progress, say, write_json

with optional_import():
    import typer
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

if TYPE_CHECKING:
    from ..studies.work_precision import WorkPrecision

__all__ = ["speed"]


def speed(
    output: Annotated[Path, typer.Option(help="Folder of the table and the figure.")] = Path("runs/speed"),
    groups: GroupsOption = None,
    scene: SceneOption = "{}",
    hold: HoldOption = "0.5",
    holds: Annotated[int, typer.Option(help="Random valve states in the run.")] = 400,
    error: Annotated[float, typer.Option(help="Largest error wanted, natural units.")] = 1e-6,
    rounds: Annotated[int, typer.Option(help="How often everything is timed.")] = 31,
    seed: Annotated[int, typer.Option(help="Of the valve states.")] = 0,
) -> None:
    """See what each solver and tolerance errs by and takes on your crawler, and which to use."""
    from ..common.figures import save_figure
    from ..crawler import Groups, Scene
    from ..studies.work_precision import Case, measure, plot_work_precision, recommend

    number_within("--error", error, "(0, inf)")
    whole_number("--rounds", rounds, 1)
    body = None if groups is None else groups_of(groups)
    case = Case(
        groups=Groups.of(body),
        scene=Scene.of(json_object("--scene", scene)),
        hold=hold_of(hold, body),
        holds=whole_number("--holds", holds, 1),
        seed=whole_number("--seed", seed, 0),
    )
    output.mkdir(parents=True, exist_ok=True)
    with progress("measuring") as show:
        study = measure(case, rounds=rounds, on_progress=show)
    recommendation = recommend(study, error)
    found = {**study.to_dict(), "wanted": error, "recommendation": recommendation.sentence}
    write_json(output / "work_precision.json", found, indent=2)
    figure = plot_work_precision(study, recommendation)
    save_figure(figure, *(output / f"work_precision.{form}" for form in ("png", "svg")))
    print_whole(_table(study))
    say(*study.notes, recommendation.sentence, f"Figure and table: {output}")


def _table(study: "WorkPrecision") -> Table:
    """The rows of a study, ready to print."""
    table = Table(title=study.title, title_justify="left", box=SIMPLE_HEAD, padding=0, pad_edge=False)
    table.caption, table.caption_justify = (
        "≤: at the floor of what can be told; ✗: not the reference's slip count",
        "left",
    )
    table.add_column("solver")
    for name in ("tolerance", *study.reference.floors, "slips", "µs per unit", "quartiles", "ratio"):
        table.add_column(name, justify="right")
    cheapest = min(row.timing.median for row in study.rows)
    for row in study.rows:
        errors = [
            ("≤" if row.errors[name] <= floor else "") + f"{study.error(row, name):.1e}"
            for name, floor in study.reference.floors.items()
        ]
        table.add_row(
            row.solver,
            "any" if row.tolerance is None else f"{row.tolerance:.0e}",
            *errors,
            f"{row.slips}" if row.slips_agree else f"{row.slips} ✗",
            f"{row.timing.median:.2f}",
            f"{row.timing.low:.2f}–{row.timing.high:.2f}",
            f"{row.timing.median / cheapest:.2f}",
        )
    return table
