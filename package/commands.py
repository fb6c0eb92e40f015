"""The commands behind ``stickslip``, each a few lines over the package's own functions."""

import json
import math
import os
import sys
from pathlib import Path
from typing import Annotated, Any, TYPE_CHECKING

from . import __version__
from .common.extras import optional_import
from .common.terminal import say_what_can_be_said
from .common.validation import known_names, number_within, whole_number
from .interruption import INTERRUPTED, Interruptible

with optional_import():
    import typer
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.measure import Measurement
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )
    from rich.table import Table

if TYPE_CHECKING:
    from .studies.work_precision import WorkPrecision

__all__ = ["app", "run"]

app = typer.Typer(
    help="A soft crawler that computes: crawl, remember, learn.",
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
_ENVIRONMENT = "StickSlipCrawler-v0"


def run(arguments: list[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    arguments : list of str, optional
        What follows the program's name; those of this process by default.

    Returns
    -------
    int
        Exit status: 0 done, 1 refused or failed, 2 not understood, 130 interrupted. What fails is told in one line;
        with ``STICKSLIP_DEBUG=1`` in the environment it is raised instead.
    """
    say_what_can_be_said()
    try:
        app(arguments, obj=arguments)
    except SystemExit as end:
        return int(end.code or 0)
    except KeyboardInterrupt:
        return INTERRUPTED
    except Exception as error:
        if os.environ.get("STICKSLIP_DEBUG"):
            raise
        print("error:", " ".join(str(error).split()) or type(error).__name__, file=sys.stderr)
        return 1
    return 0


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"stickslip {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", is_eager=True, callback=_print_version, help="Print the version and exit.")
    ] = False,
) -> None:
    """Options of the program itself."""


@app.command("list")
def list_names() -> None:
    """List the tasks, measures, reservoirs, presets, algorithms and more that are known by name."""
    from .listing import known_by_name

    for kind, names in known_by_name().items():
        typer.echo("\n  ".join([kind, *names]))


@app.command(cls=Interruptible)
def demo(
    output: Annotated[Path, typer.Option(help="Folder of the report.")] = Path("runs/demo"),
    seed: Annotated[int, typer.Option(help="Of everything random.")] = 0,
    steps: Annotated[int | None, typer.Option(help="Steps of each training, instead of the file's.")] = None,
) -> None:
    """See the crawler crawl, its memory measured, its tasks benchmarked and two policies trained."""
    from .demo import run_demo

    if steps is not None:
        whole_number("--steps", steps, 1)
    # The benchmark takes the four seeds that follow as well.
    run_demo(output, whole_number("--seed", seed, 0, 2**32 - 5), steps)


@app.command(cls=Interruptible)
def train(
    context: typer.Context,
    output: Annotated[Path, typer.Option(help="Folder of the run.")],
    memory_weight: Annotated[float, typer.Option(help="Share of memory in the reward, 0 to 1.")] = 0.5,
    dither: Annotated[float, typer.Option(help="Probability that a command is flipped, 0 to 0.5.")] = 0.1,
    hold: Annotated[float, typer.Option(help="Length of a step, natural time.")] = 0.5,
    groups: Annotated[str | None, typer.Option(help="A preset's name, or JSON such as '{\"duffing\": 2}'.")] = None,
    env_kwargs: Annotated[str, typer.Option(help="Further arguments of the environment, as JSON.")] = "{}",
    steps: Annotated[
        int | None,
        typer.Option(help="Environment steps in all, instead of the file's or the resumed run's; updates are whole."),
    ] = None,
    seed: Annotated[int, typer.Option(help="Of everything random.")] = 0,
    algorithm: Annotated[str, typer.Option(help="ppo, a2c, dqn, qrdqn or recurrent_ppo.")] = "ppo",
    hyperparameters: Annotated[Path | None, typer.Option(help="YAML file in rl-baselines3-zoo's form.")] = None,
    resume: Annotated[
        bool,
        typer.Option("--resume", help="Go on from the last checkpoint in the folder, which says all but the steps."),
    ] = False,
) -> None:
    """Train a policy, with evaluations, checkpoints and TensorBoard logs in the output folder."""
    from .train.evaluations import best_of, read_evaluations
    from .train.hyperparameters import read_hyperparameters
    from .train.run import Configuration, ENV_ARGUMENTS, Run
    from .train.training import train as train_policy

    arguments: dict[str, Any] = {"memory_weight": memory_weight, "dither": dither, "hold": hold}
    if groups is not None:
        arguments["groups"] = _groups(groups)
    further = _json_object("--env-kwargs", env_kwargs)
    for name in (*arguments, "groups", "render_mode"):
        if name in further:
            raise ValueError(f"--env-kwargs must not set {name}: it has an option of its own, or is not for training")
    known_names("--env-kwargs", further, [name for name in ENV_ARGUMENTS if name not in (*arguments, "groups")])
    arguments |= further
    if resume:
        # What is not said is as in the folder, and what is said is compared with it.
        kept = Run.open(output).configuration
        said = _said(context)
        arguments = kept.env_kwargs | {name: arguments[name] for name in arguments if name in said or name in further}
        algorithm = algorithm if "algorithm" in said else kept.algorithm
        seed = seed if "seed" in said else kept.seed
    # The algorithm is checked before a file of its name is looked for.
    configuration = Configuration(algorithm=algorithm, environment=_ENVIRONMENT, env_kwargs=arguments, seed=seed)
    if resume and hyperparameters is None:
        entry = dict(kept.hyperparameters)
    else:
        entry = read_hyperparameters(algorithm, _ENVIRONMENT, hyperparameters)
    if steps is not None:
        entry["n_timesteps"] = whole_number("--steps", steps, 1)
    configuration.hyperparameters.update(entry)

    bar = _progress_bar()
    task = bar.add_task("training", total=entry["n_timesteps"])

    def show(done: int) -> None:
        bar.start()  # only now: what is refused is refused without a bar above it
        bar.update(task, completed=min(done, entry["n_timesteps"]))

    try:
        finished = train_policy(configuration, output, resume=resume, on_progress=show)
    finally:
        if bar.live.is_started:
            bar.stop()
    best = best_of(read_evaluations(finished.folder / "evaluations.csv"))
    terms = "" if math.isnan(best.speed) else f" (speed {best.speed:.4f}, memory {best.memory:.4f})"
    typer.echo(
        f"best policy: {best.reward:.4f} reward per step{terms} after {best.steps} steps, kept in {finished.best}"
    )


@app.command(cls=Interruptible)
def evaluate(
    run: Annotated[Path, typer.Argument(help="Folder of a training run.")],
    checkpoint: Annotated[Path | None, typer.Option(help="One of its checkpoints; the best policy by default.")] = None,
    output: Annotated[Path | None, typer.Option(help="Folder for what is made; RUN/evaluation by default.")] = None,
    steps: Annotated[int, typer.Option(help="Steps to measure over, 1000 at least.")] = 6000,
    seed: Annotated[int, typer.Option(help="Of the flips.")] = 0,
    video: Annotated[bool, typer.Option(help="Also film the policy.")] = True,
) -> None:
    """Replay a policy: its speed and memory, figures and a clip."""
    from .train.report import evaluate_run

    whole_number("--steps", steps, 1000)
    whole_number("--seed", seed, 0, 2**32 - 1)
    result = evaluate_run(run, checkpoint=checkpoint, output=output, steps=steps, seed=seed, video=video)
    for name, value in result.items():
        typer.echo(f"{name:<24} {value}")


@app.command(cls=Interruptible)
def speed(
    output: Annotated[Path, typer.Option(help="Folder of the table and the figure.")] = Path("runs/speed"),
    groups: Annotated[str | None, typer.Option(help="A preset's name, or JSON such as '{\"duffing\": 2}'.")] = None,
    scene: Annotated[str, typer.Option(help="JSON such as '{\"ratchet\": false}'.")] = "{}",
    hold: Annotated[float, typer.Option(help="Time that the valve keeps each state, natural time.")] = 0.5,
    holds: Annotated[int, typer.Option(help="Random valve states in the run.")] = 400,
    error: Annotated[float, typer.Option(help="Largest error wanted, natural units.")] = 1e-6,
    rounds: Annotated[int, typer.Option(help="How often everything is timed.")] = 31,
    seed: Annotated[int, typer.Option(help="Of the valve states.")] = 0,
) -> None:
    """See what each solver and tolerance errs by and takes on your crawler, and which to use."""
    from .common.figures import save_figure
    from .common.files import atomically
    from .crawler import Groups, Scene
    from .studies.work_precision import Case, measure, plot_work_precision, recommend

    number_within("--error", error, "(0, inf)")
    whole_number("--rounds", rounds, 1)
    case = Case(
        groups=Groups.of(None if groups is None else _groups(groups)),
        scene=Scene.of(_json_object("--scene", scene)),
        hold=hold,
        holds=whole_number("--holds", holds, 1),
        seed=whole_number("--seed", seed, 0),
    )
    output.mkdir(parents=True, exist_ok=True)
    with _progress_bar() as bar:
        task = bar.add_task("measuring")
        study = measure(case, rounds=rounds, on_progress=lambda done, of: bar.update(task, completed=done, total=of))
    recommendation = recommend(study, error)
    found = {**study.to_dict(), "wanted": error, "recommendation": recommendation.sentence}
    text = json.dumps(found, indent=2) + "\n"
    atomically(output / "work_precision.json", lambda path: path.write_text(text, encoding="utf-8"))
    figure = plot_work_precision(study, recommendation)
    save_figure(figure, *(output / f"work_precision.{form}" for form in ("png", "svg")))
    console = Console()
    console.print(_work_precision_table(study))
    for line in (*study.notes, recommendation.sentence, f"Figure and table: {output}"):
        console.print(line, highlight=False)


@app.command(cls=Interruptible)
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
        float | None, typer.Option(help="Length of a hold, natural time; 0.5 where it is not swept.")
    ] = None,
    groups: Annotated[str | None, typer.Option(help="A preset's name, or JSON such as '{\"duffing\": 2}'.")] = None,
    scene: Annotated[str, typer.Option(help="JSON such as '{\"ratchet\": false}'.")] = "{}",
    against: Annotated[
        str | None,
        typer.Option(help="Reservoir that the others are compared with, draw by draw; the first by default."),
    ] = None,
    processes: Annotated[int, typer.Option(help="To share the work among.")] = 1,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with what the folder holds.")] = False,
) -> None:
    """Score reservoirs on tasks over seeds, beside fair baselines, or sweep a number of the crawler."""
    from .studies.benchmark.bench import Bench

    whole_number("--processes", processes, 1)
    body: dict[str, Any] = {
        "groups": None if groups is None else _groups(groups),
        "scene": _json_object("--scene", scene),
    }
    if hold is not None:
        body["hold"] = hold
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
    with _progress_bar() as bar:
        task = bar.add_task("scoring", total=benchmark.total)
        for finished in benchmark.run(processes):
            bar.update(task, completed=finished)
    scores, differences = benchmark.report()
    interval = "" if seeds == 1 else f", mean [95% interval of the mean] over {seeds} seeds"
    _print_table(f"{features} features{interval}", scores)
    if differences:
        _print_table(f"differences from {benchmark.against} on the same draws{interval}", differences)
    console = Console()
    console.print(f"Tables, figures and scores: {output}", highlight=False)


@app.command(cls=Interruptible)
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
    from .common.files import atomically
    from .common.validation import known_names
    from .studies.search import body_space, echo_state_space, held_out_scores
    from .studies.search import search as search_space
    from .tasks import TASKS

    known_names("--task", [task], TASKS)
    spaces = {"body": body_space, "echo-state": echo_state_space}
    known_names("--reservoir", [reservoir], spaces)
    space = spaces[reservoir](features).where(**_json_object("--fixed", fixed))
    whole_number("--tests", tests, 2)
    validation = range(tests, tests + 4)
    output.mkdir(parents=True, exist_ok=True)
    bar = _progress_bar()
    line = bar.add_task(task, total=evaluations)

    def show(done: int, of: int) -> None:
        bar.start()  # only now: what is refused is refused without a bar above it
        bar.update(line, completed=done, total=of)

    try:
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
    finally:
        if bar.live.is_started:
            bar.stop()
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
    text = json.dumps(result, indent=1) + "\n"
    atomically(output / "best.json", lambda path: path.write_text(text, encoding="utf-8"))
    typer.echo(repr(found.reservoir))
    interval = "" if math.isnan(test.low) else f", 95% interval {test.low:.4f} to {test.high:.4f}"
    typer.echo(f"{task}: {test.mean:.4f}{interval} over {test.runs} test seeds")


@app.command(cls=Interruptible, name="compile")
def compile_kernels() -> None:
    """Compile every kernel ahead of its first use, as for images and clusters, where none is compiled yet."""
    from .ahead import uses, where_kept

    folder = where_kept()
    wanted = list(uses())
    with _progress_bar() as bar:
        task = bar.add_task("compiling", total=len(wanted))
        for name, use in wanted:
            bar.update(task, description=name)
            use()
            bar.advance(task)
    typer.echo(f"every kernel is compiled; the solver's are kept in {folder}")


def _print_table(title: str, rows: list[list[str]]) -> None:
    table = Table(box=SIMPLE_HEAD, padding=(0, 1))
    for index, heading in enumerate(rows[0]):
        table.add_column(heading, justify="right" if index else "left", no_wrap=True)
    for row in rows[1:]:
        table.add_row(*row)
    console = Console()
    console.print(title, highlight=False, soft_wrap=True)
    # A table that is wider than the terminal is better scrolled or piped than cut.
    wide = Measurement.get(console, console.options.update(max_width=1000), table).maximum
    Console(width=max(console.width, wide)).print(table)


def _work_precision_table(study: "WorkPrecision") -> Table:
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


def _said(context: typer.Context) -> set[str]:
    """Names of the options that stand on the command line."""
    sources = {name: context.get_parameter_source(name) for name in context.params}
    return {name for name, source in sources.items() if source is not None and source.name == "COMMANDLINE"}


def _groups(text: str) -> str | dict[str, Any]:
    """A preset's name, or a mapping of fields from JSON."""
    return _json_object("--groups", text) if text.lstrip().startswith("{") else text


def _progress_bar() -> Progress:
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True),
    )


def _json_object(option: str, text: str) -> dict[str, Any]:
    try:
        value = json.loads(text, object_pairs_hook=lambda pairs: _distinct(option, pairs))
    except json.JSONDecodeError as error:
        raise ValueError(f"{option} must be a JSON object, got {text!r}: {error}") from None
    if not isinstance(value, dict):
        raise ValueError(f"{option} must be a JSON object, got {text!r}")
    return value


def _distinct(option: str, pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A JSON object's names and values, of which JSON would keep the last of a name silently."""
    names = [name for name, _ in pairs]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"{option} must name {name!r} once, got it {names.count(name)} times")
    return dict(pairs)
