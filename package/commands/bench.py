"""``stickslip bench``."""

from pathlib import Path
from typing import Annotated, Any

from ..common.extras import optional_import
from ..common.validation import whole_number
from .options import groups_of, GroupsOption, hold_of, json_object, SceneOption
from .printing import print_table, progress, say

with optional_import():
    import typer

__all__ = ["bench"]


def bench(
    output: Annotated[Path, typer.Option(help="Folder of tables, figures and all that is finished.")] = Path(
        "runs/bench"
    ),
    tasks: Annotated[
        str | None,
        typer.Option(help="Names that `stickslip list` tells, with commas between; all by default."),
    ] = None,
    reservoirs: Annotated[str | None, typer.Option(help="Likewise of reservoirs.")] = None,
    sweep: Annotated[
        str | None, typer.Option(help="Instead of reservoirs: a number of the crawler, such as 'hold=0.25,0.5,1'.")
    ] = None,
    seeds: Annotated[int, typer.Option(help="Repetitions, each with its own inputs and random weights.")] = 15,
    features: Annotated[int, typer.Option(help="Of every reservoir, a multiple of 3.")] = 12,
    length: Annotated[int, typer.Option(help="Samples of a repetition.")] = 4000,
    washout: Annotated[int, typer.Option(help="Samples at its start that are not scored.")] = 200,
    hold: Annotated[
        str | None,
        typer.Option(
            help="Length of a hold: natural time, or '20 ms' where --groups is a body in SI units; 0.5 where it is not "
            "swept."
        ),
    ] = None,
    groups: GroupsOption = None,
    scene: SceneOption = "{}",
    against: Annotated[
        str | None,
        typer.Option(help="Reservoir that the others are compared with, draw by draw; the first by default."),
    ] = None,
    processes: Annotated[int, typer.Option(help="To share the work among.")] = 1,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with what the folder holds.")] = False,
) -> None:
    """Score reservoirs on tasks over seeds, beside fair baselines, or sweep a number of the crawler."""
    from ..studies.benchmark.bench import Bench

    whole_number("--processes", processes, 1)
    body: dict[str, Any] = {
        "groups": None if groups is None else groups_of(groups),
        "scene": json_object("--scene", scene),
    }
    if hold is not None:
        body["hold"] = hold_of(hold, body["groups"])
    benchmark = Bench(
        output,
        tasks=tasks,
        reservoirs=reservoirs,
        sweep=sweep,
        seeds=seeds,
        features=features,
        length=length,
        washout=washout,
        body=body,
        against=against,
        resume=resume,
    )
    with progress("scoring") as show:
        for finished in benchmark.run(processes):
            show(finished, benchmark.total)
    scores, differences = benchmark.report()
    interval = "" if seeds == 1 else f", mean [95% interval of the mean] over {seeds} seeds"
    print_table(f"{features} features{interval}", scores)
    if differences:
        print_table(f"differences from {benchmark.against} on the same draws{interval}", differences)
    say(f"Tables, figures and scores: {output}")
