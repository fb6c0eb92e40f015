"""The commands behind ``stickslip``, a file each, and each a few lines over the package's own functions."""

import os
import sys
from typing import Annotated

from .. import __version__
from ..common.extras import optional_import
from ..common.terminal import say_what_can_be_said

with optional_import():
    import typer

from . import (
    bench,
    compilation,
    demo,
    evaluate,
    explore,
    export,
    identify,
    lyapunov,
    mapping,
    names,
    reproduce,
    running,
    search,
    speed,
    trade,
    train,
)
from .interruption import continued, INTERRUPTED, Interruptible, resumed

__all__ = ["app", "run"]

app = typer.Typer(
    help="A soft crawler that computes: crawl, remember, learn.",
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
app.command("list", cls=Interruptible)(names.list_names)
app.command("demo", cls=continued())(demo.demo)
app.command("train", cls=resumed("configuration.yml"))(train.train)
app.command("evaluate", cls=Interruptible)(evaluate.evaluate)
app.command("explore", cls=Interruptible)(explore.explore)
app.command("trade", cls=continued())(trade.trade)
app.command("export", cls=Interruptible)(export.export)
app.command("run", cls=Interruptible)(running.run_policy)
app.command("speed", cls=Interruptible)(speed.speed)
app.command("bench", cls=resumed("finished"))(bench.bench)
app.command("search", cls=continued())(search.search)
app.command("map", cls=continued())(mapping.map_numbers)
app.command("lyapunov", cls=Interruptible)(lyapunov.lyapunov)
app.command("identify", cls=Interruptible)(identify.identify)
app.command("reproduce", cls=continued())(reproduce.reproduce)
app.command("compile", cls=Interruptible)(compilation.compile_kernels)


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
