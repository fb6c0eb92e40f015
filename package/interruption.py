"""A command that is interrupted says in one line how to go on."""

import shlex
import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .common.extras import optional_import

with optional_import():
    from typer.core import TyperCommand

__all__ = ["INTERRUPTED", "Interruptible", "way_on"]

# The status that shells give to what an interrupt ended: 128 and the number of the signal.
INTERRUPTED = 128 + signal.SIGINT
# What the output folder of a command that takes --resume holds, once there is anything to resume.
_RESUMABLE = {"train": "configuration.yml", "bench": "finished"}
# Commands that go on by themselves when they are called again.
_CONTINUED = {"search", "demo"}


class Interruptible(TyperCommand):
    """A command that ends on an interrupt with status 130, and with the command that goes on where it can."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            on = way_on(str(ctx.info_name), ctx.params.get("output"), ctx.find_root().obj or sys.argv[1:])
            print("interrupted" + (f"; go on with: {on}" if on else ""), file=sys.stderr)
            raise SystemExit(INTERRUPTED) from None


def way_on(command: str, output: Path | None, arguments: Sequence[str]) -> str | None:
    """The line that goes on with a command that was interrupted; None where nothing of it is kept.

    Parameters
    ----------
    command : str
        Its name.
    output : Path or None
        Its folder.
    arguments : sequence of str
        What followed the program's name.
    """
    again = shlex.join(["stickslip", *arguments])
    if command in _CONTINUED:
        return again
    if command not in _RESUMABLE or output is None:
        return None
    if (output / _RESUMABLE[command]).exists() and "--resume" not in arguments:
        return again + " --resume"
    return again
