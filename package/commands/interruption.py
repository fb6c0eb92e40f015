"""A command that is interrupted says in one line how to go on."""

import shlex
import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..common.extras import optional_import

with optional_import():
    from typer.core import TyperCommand

__all__ = ["INTERRUPTED", "Interruptible", "continued", "resumed"]

# The status that shells give to what an interrupt ended: 128 and the number of the signal.
INTERRUPTED = 128 + signal.SIGINT


class Interruptible(TyperCommand):
    """A command that ends on an interrupt with status 130. Nothing of what it did is kept."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            on = self.way_on(ctx.params.get("output"), ctx.find_root().obj or sys.argv[1:])
            print("interrupted" + (f"; go on with: {on}" if on else ""), file=sys.stderr)
            raise SystemExit(INTERRUPTED) from None

    def way_on(self, output: Path | None, arguments: Sequence[str]) -> str | None:
        """The line that goes on with the command once it was interrupted; None where nothing of it is kept.

        Parameters
        ----------
        output : Path or None
            Its folder.
        arguments : sequence of str
            What followed the program's name.
        """
        return None


def continued() -> type[Interruptible]:
    """A command that goes on by itself when it is called again."""

    class Continued(Interruptible):
        def way_on(self, output: Path | None, arguments: Sequence[str]) -> str | None:
            return _again(arguments)

    return Continued


def resumed(kept: str) -> type[Interruptible]:
    """A command that goes on by ``--resume`` once its output folder holds what is `kept`, and else is begun again."""

    class Resumed(Interruptible):
        def way_on(self, output: Path | None, arguments: Sequence[str]) -> str | None:
            if output is None:
                return None
            resume = (output / kept).exists() and "--resume" not in arguments
            return _again(arguments) + (" --resume" if resume else "")

    return Resumed


def _again(arguments: Sequence[str]) -> str:
    return shlex.join(["stickslip", *arguments])
