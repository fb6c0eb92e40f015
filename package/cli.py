"""The command line: ``stickslip`` and its commands."""

import atexit
import os
import signal
import sys

from .common.extras import MissingExtra

__all__ = ["main"]

_INTERRUPTED = 128 + signal.SIGINT


def main() -> None:
    """Run the command line; what it refuses, it refuses in one line."""
    try:
        from .commands import run

        status = run()
    except MissingExtra as error:
        sys.exit(f"error: {error}")
    except KeyboardInterrupt:  # before there was a command to say more
        status = _INTERRUPTED
    if status == _INTERRUPTED:
        # What has to be tidied is; taking torch and LLVM apart would keep the terminal for seconds.
        atexit._run_exitfuncs()
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)
    sys.exit(status)
