"""A map over two numbers of a crawler: measures, cell by cell and seed by seed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TYPE_CHECKING

from ...common.jobs import as_done
from ...common.validation import whole_number
from ...crawler import GroupsLike, Scene
from ...tasks import BodyReservoir
from ...tasks.reservoirs.body import READINGS
from .axes import axis_of, AxisLike
from .cells import Job, measured
from .inputs import Inputs
from .plan import Plan, probe_of
from .store import MapStore

if TYPE_CHECKING:
    import xarray as xr
    from distributed import Client

__all__ = ["parameter_map"]


def parameter_map(
    x: AxisLike,
    y: AxisLike | None = None,
    *,
    measures: str | Sequence[str] = ("memory",),
    groups: GroupsLike | None = None,
    scene: Scene | dict[str, Any] | None = None,
    hold: float = 0.5,
    inputs: Inputs | str = "bits",
    virtual_nodes: int = 4,
    readings: Sequence[str] = READINGS,
    holds: int = 4000,
    washout: int = 200,
    delays: int = 20,
    seeds: int | Sequence[int] = 1,
    tolerance: float = 1e-6,
    store: str | Path | None = None,
    processes: int = 1,
    dask: str | Client | None = None,
    on_progress: Callable[[int, int], object] | None = None,
) -> xr.Dataset:
    """Measure crawlers over a grid of one number or two, each cell over seeds.

    All cells see the inputs of the same seeds, so that differences between cells are differences of bodies.

    Parameters
    ----------
    x, y : str, or (str, array_like)
        What varies along the columns and, if at all, the rows: the hold, the amplitude, a group, the slope or the
        dither, as ``duffing=0:200:64``, ``deborah=0.05:8:64:log``, ``hold=0.25,0.5,1`` or a name and ascending values.
    measures : str or sequence of str
        Of `stickslip.studies.maps.MEASURES`, such as "memory", "speed" and "work".
    groups, scene, hold, tolerance
        As in `simulate`: of the body that is varied.
    inputs : Inputs or str
        "bits" for fair bits, "bernoulli:0.3", "word:0011:0.1" for a word and the probability that a bit of it is
        flipped, or "word:0011" without flips, which tells nothing to remember.
    virtual_nodes : int
        Readings a hold. 1 gives the raw state at the end of each.
    readings : sequence of str
        As in `BodyReservoir`. Of a chain every segment is read.
    holds : int
        Of each run, from rest.
    washout : int
        Of these at the start, that memory and capacities leave out.
    delays : int
        Of memory, from 0 on.
    seeds : int or sequence of int
        Of the inputs: how many, from 0 on, or which.
    store : path, optional
        Zarr folder of the map, written block by block. What is finished in it is not done again, and the map equals
        one that was made in one go, to the bit. In memory by default.
    processes : int
        Of this computer, as in `stickslip.common.jobs.as_done`. With 1, threads share the motion.
    dask : str or distributed.Client, optional
        The cluster that does the work instead, or the address of its scheduler. Workers need not see the store.
    on_progress : callable, optional
        Told how many cells are done, of how many: at first, and after each block.

    Returns
    -------
    xarray.Dataset
        Variables of shape (y, x, seed), some with a further dimension "delay" or "degree", with their units and labels
        as attributes, not a number where there is no such body (kinetic friction above static friction) or the solver
        gave up; `status` says which. `over_seeds` makes means and intervals of it.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid, or the store is of another map; the message names what differs.
    ConnectionError
        If the cluster went away. What was finished is kept.
    MissingExtra
        If xarray or Zarr, of the extra `maps`, is not installed.
    """
    axes = [axis_of("x", x)] if y is None else [axis_of("y", y), axis_of("x", x)]
    plan = Plan(
        axes=tuple(axes),
        measures=(measures,) if isinstance(measures, str) else tuple(measures),
        body=BodyReservoir(
            groups, scene, hold=hold, virtual_nodes=virtual_nodes, readings=readings, tolerance=tolerance
        ),
        inputs=Inputs.of(inputs),
        holds=holds,
        washout=washout,
        delays=delays,
        seeds=tuple(seeds) if isinstance(seeds, Sequence) else tuple(range(whole_number("seeds", seeds, 1))),
    )
    processes = whole_number("processes", processes, 1)
    small = plan.small()
    kept = MapStore(None if store is None else Path(store), plan, probe_of(measured(Job(small, small.blocks[0], 1))))
    left = kept.unfinished()
    done = kept.cells
    if on_progress is not None:
        on_progress(done, plan.cells)
    threads = None if processes == 1 and dask is None else 1
    try:
        for k, found in as_done(
            measured, [Job(plan, block, threads) for block in left], processes=processes, dask=dask
        ):
            kept.keep(left[k], found)
            done += left[k].last - left[k].first
            if on_progress is not None:
                on_progress(done, plan.cells)
    except OSError as error:
        if dask is None:
            raise
        rest = f"they are kept in {store}: ask again to go on" if store is not None else "give a store to keep them"
        raise ConnectionError(
            f"dask must be a cluster that stays, got one that went away ({error or type(error).__name__}) after {done} "
            f"of {plan.cells} cells; {rest}"
        ) from error
    return kept.dataset()
