"""``stickslip trade``."""

from pathlib import Path
from typing import Annotated, Any

from ..common.extras import optional_import
from ..common.sharing import processors
from ..common.validation import whole_number
from .options import groups_of, GroupsOption, HoldOption, json_object, number_or_text
from .printing import print_table, progress, say

with optional_import():
    import typer

__all__ = ["trade"]


def trade(
    output: Annotated[
        Path, typer.Option(help="Folder of the front; what is finished in it already is not done again.")
    ] = Path("runs/trade"),
    quick: Annotated[bool, typer.Option("--quick", help="Fewer of everything that is not said: a glance.")] = False,
    weights: Annotated[str | None, typer.Option(help="Of memory in the reward, such as '0,0.2,1'.")] = None,
    dithers: Annotated[
        str | None, typer.Option(help="Probabilities that a command is flipped, such as '0.05,0.1'.")
    ] = None,
    seeds: Annotated[int | None, typer.Option(help="Trainings at each weight and dither.")] = None,
    floors: Annotated[
        str | None, typer.Option(help="On speed, such as '0.2,0.3': policies for memory above each; '' for none.")
    ] = None,
    hold: HoldOption = "0.5",
    groups: GroupsOption = None,
    env_kwargs: Annotated[str, typer.Option(help="Further arguments of the environment, as JSON.")] = "{}",
    algorithm: Annotated[str, typer.Option(help="Whose policies have no memory of their own, such as ppo.")] = "ppo",
    hyperparameters: Annotated[Path | None, typer.Option(help="YAML file in rl-baselines3-zoo's form.")] = None,
    steps: Annotated[int | None, typer.Option(help="Environment steps of each training, not the file's.")] = None,
    conditioned: Annotated[bool, typer.Option(help="Also distil one policy for all weights.")] = True,
    longest: Annotated[int | None, typer.Option(help="Bits of the longest open-loop words.")] = None,
    resolution: Annotated[int | None, typer.Option(help="Of the grid that the speed limit is found on.")] = None,
    judges: Annotated[int | None, typer.Option(help="Seeds that everything is judged on.")] = None,
    holds: Annotated[int | None, typer.Option(help="Of each run that judges, 1000 at least.")] = None,
    processes: Annotated[int | None, typer.Option(help="To share the work among; one a processor by default.")] = None,
    dask: Annotated[
        str | None, typer.Option(help="Address of a Dask scheduler, whose workers do the work instead.")
    ] = None,
) -> None:
    """Make the front of speed against memory: open loop, the limit, and policies over weights, on fresh seeds."""
    from ..crawler.model.holds import natural_hold
    from ..envs.settings import HOLDS
    from ..studies.trade.front import fronts
    from ..studies.trade.plan import FULL, QUICK, Trade
    from ..studies.trade.report import areas, table, write_report
    from ..studies.trade.running import TradeFolder
    from ..train.hyperparameters import read_hyperparameters
    from ..train.run import Configuration

    body = None if groups is None else groups_of(groups)
    arguments: dict[str, Any] = {"hold": natural_hold(number_or_text(hold), body, HOLDS)}
    if body is not None:
        arguments["groups"] = body
    further = json_object("--env-kwargs", env_kwargs)
    for name in ("hold", "groups"):
        if name in further:
            raise ValueError(f"--env-kwargs must not set {name}: it has an option of its own")
    said: dict[str, Any] = {
        "weights": None if weights is None else _numbers("--weights", weights),
        "dithers": None if dithers is None else _numbers("--dithers", dithers),
        "seeds": seeds,
        "floors": None if floors is None else _numbers("--floors", floors) if floors else (),
        "longest": longest,
        "resolution": resolution,
        "judges": judges,
        "holds": holds,
        "steps": steps,
    }
    asked = Trade(
        **{**(QUICK if quick else FULL), **{name: value for name, value in said.items() if value is not None}},
        env_kwargs=arguments | further,
        algorithm=algorithm,
        hyperparameters=None
        if hyperparameters is None
        else read_hyperparameters(algorithm, Configuration.environment, hyperparameters),
        conditioned=conditioned,
    )
    workers = processors() if processes is None else whole_number("--processes", processes, 1)
    folder = TradeFolder(output, asked)
    with progress("cells") as show:
        for finished in folder.run(processes=workers, dask=dask):
            show(finished.done, finished.of)
    found = fronts(asked, folder.results())
    write_report(folder, found)
    for front in found:
        if front.dither:
            print_table(f"dither {front.dither:g}, mean [95% interval] over {asked.judges} seeds", areas(front))
        print_table(f"dither {front.dither:g}", table(front))
    say(f"Front, figures and page: {output / 'index.md'}")


def _numbers(option: str, text: str) -> tuple[float, ...]:
    try:
        return tuple(float(number) for number in text.split(","))
    except ValueError:
        raise ValueError(f"{option} must be numbers with commas between them, got {text!r}") from None
