"""The command line: ``stickslip`` and its commands."""

import sys

from .extras import MissingExtra

__all__ = ["main"]


def main() -> None:
    """Run the command line; what it refuses, it refuses in one line."""
    try:
        from .commands import run

        status = run()
    except MissingExtra as error:
        sys.exit(f"error: {error}")
    except KeyboardInterrupt:  # before there was a command to say more
        status = 130
    sys.exit(status)
