"""``stickslip map``."""

from pathlib import Path
from typing import Annotated, TYPE_CHECKING

from ..common.extras import optional_import
from ..common.sharing import processors
from ..common.validation import known_names, whole_number
from .options import groups_of, GroupsOption, hold_of, HoldOption, InputsOption, json_object, SceneOption
from .printing import print_table, progress, say

with optional_import():
    import typer

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["map_numbers"]


def map_numbers(
    x: Annotated[
        str,
        typer.Option(
            "--x", help="A number of the crawler along the columns, such as 'duffing=0:200:64' or 'hold=0.25,0.5,1'."
        ),
    ],
    y: Annotated[
        str | None, typer.Option("--y", help="Another along the rows, such as 'deborah=0.05:8:64:log'.")
    ] = None,
    output: Annotated[
        Path, typer.Option(help="Folder of the map and its figure; what is finished in it already is not done again.")
    ] = Path("runs/map"),
    measure: Annotated[str, typer.Option(help="Names with commas between; `stickslip list` tells them.")] = "memory",
    groups: GroupsOption = None,
    scene: SceneOption = "{}",
    hold: HoldOption = "0.5",
    inputs: InputsOption = "bits",
    nodes: Annotated[int, typer.Option(help="Readings a hold; 1 for the raw states.")] = 4,
    holds: Annotated[int, typer.Option(help="Of each run, from rest.")] = 4000,
    washout: Annotated[int, typer.Option(help="Holds at its start that are not scored.")] = 200,
    delays: Annotated[int, typer.Option(help="Of memory.")] = 20,
    seeds: Annotated[int, typer.Option(help="Runs a cell, each with its own input.")] = 1,
    tolerance: Annotated[float, typer.Option(help="As in `simulate`.")] = 1e-6,
    processes: Annotated[int | None, typer.Option(help="To share the work among; one a processor by default.")] = None,
    dask: Annotated[
        str | None, typer.Option(help="Address of a Dask scheduler, whose workers do the work instead.")
    ] = None,
) -> None:
    """Map memory, exponents, speed, work or slips over any two numbers of the crawler, with seeds and intervals."""
    from ..common.figures import save_figure
    from ..studies.maps import MEASURES, parameter_map
    from ..studies.maps.figures import plot_map

    measures = measure.split(",")
    known_names("--measure", measures, MEASURES)
    body = None if groups is None else groups_of(groups)
    workers = processors() if processes is None else whole_number("--processes", processes, 1)
    with progress("cells") as show:
        found = parameter_map(
            x,
            y,
            measures=measures,
            groups=body,
            scene=json_object("--scene", scene),
            hold=hold_of(hold, body),
            inputs=inputs,
            virtual_nodes=nodes,
            holds=holds,
            washout=washout,
            delays=delays,
            seeds=seeds,
            tolerance=tolerance,
            store=output / "map.zarr",
            processes=workers,
            dask=dask,
            on_progress=show,
        )
    save_figure(plot_map(found), *(output / f"map.{form}" for form in ("png", "svg")))
    print_table(f"{found['status'].size} cells, {found.sizes['seed']} seeds", _extremes(found))
    for place, meaning in enumerate(found["status"].attrs["flag_meanings"].split()):
        count = int((found["status"] == place).sum())
        if meaning != "finished" and count:
            say(f"{count} cells: {meaning.replace('_', ' ')}")
    say(f"Map: {output / 'map.zarr'}, figure: {output / 'map.png'}")


def _extremes(found: "xr.Dataset") -> list[list[str]]:
    """Least and greatest mean of each variable, and where."""
    from ..studies.maps import over_seeds
    from ..studies.maps.figures import drawn_names

    means = over_seeds(found)
    rows = [["", "least", "at", "greatest", "at"]]
    for name in drawn_names(found):
        if not means[name].notnull().any():
            continue
        row = [name]
        for place in (means[name].argmin(...), means[name].argmax(...)):
            cell = means.isel(place)
            interval = f" [{float(cell[f'{name}_low']):.3g}, {float(cell[f'{name}_high']):.3g}]"
            where = ", ".join(f"{axis}={float(cell[axis]):.4g}" for axis in place)
            row += [f"{float(cell[name]):.3g}{interval if found.sizes['seed'] > 1 else ''}", where]
        rows.append(row)
    return rows
