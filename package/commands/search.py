"""``stickslip search``."""

import math
from pathlib import Path
from typing import Annotated

from ..common.extras import optional_import
from ..common.validation import known_names, whole_number
from .options import json_object
from .printing import progress, write_json

with optional_import():
    import typer

__all__ = ["search"]


def search(
    task: Annotated[str, typer.Option(help="A task of `stickslip list`, such as 'NARMA-10 uniform NRMSE'.")],
    output: Annotated[Path, typer.Option(help="Folder of what is found; an unfinished search there goes on.")] = Path(
        "runs/search"
    ),
    reservoir: Annotated[str, typer.Option(help="body or echo-state.")] = "body",
    features: Annotated[int, typer.Option(help="Most features that a reservoir may have.")] = 60,
    fixed: Annotated[str, typer.Option(help="Dimensions not to search, as JSON such as '{\"segments\": 1}'.")] = "{}",
    evaluations: Annotated[int, typer.Option(help="Reservoirs to score.")] = 300,
    seconds: Annotated[float, typer.Option(help="Wall time after which no further one is scored.")] = math.inf,
    length: Annotated[int, typer.Option(help="Samples of a series, in the search and in the test.")] = 3000,
    tests: Annotated[int, typer.Option(help="Seeds to test on what was found; the search sees none of them.")] = 10,
    seed: Annotated[int, typer.Option(help="Of the reservoirs that are tried.")] = 0,
) -> None:
    """Look for the reservoir that does best at a task, and test it on series it was not chosen by."""
    from ..studies.search import body_space, echo_state_space, held_out_scores
    from ..studies.search import search as search_space
    from ..tasks import TASKS

    known_names("--task", [task], TASKS)
    spaces = {"body": body_space, "echo-state": echo_state_space}
    known_names("--reservoir", [reservoir], spaces)
    space = spaces[reservoir](features).where(**json_object("--fixed", fixed))
    whole_number("--tests", tests, 2)
    validation = range(tests, tests + 4)
    output.mkdir(parents=True, exist_ok=True)
    with progress(task) as show:
        found = search_space(
            TASKS[task],
            space,
            evaluations=evaluations,
            seconds=seconds,
            seed=seed,
            length=length,
            validation_seeds=validation,
            file=output / "evaluations.json",
            on_progress=show,
        )
    scores, test = held_out_scores(
        TASKS[task], found.reservoir, range(tests), validation_seeds=validation, length=length
    )
    result = {
        "task": task,
        "values": found.values,
        "reservoir": repr(found.reservoir),
        "evaluations": len(found.evaluations),
        "validation": found.validation,
        "test": scores,
    }
    write_json(output / "best.json", result, indent=1)
    typer.echo(repr(found.reservoir))
    interval = "" if math.isnan(test.low) else f", 95% interval {test.low:.4f} to {test.high:.4f}"
    typer.echo(f"{task}: {test.mean:.4f}{interval} over {test.runs} test seeds")
