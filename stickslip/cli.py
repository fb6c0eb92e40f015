"""The command line: ``stickslip`` with ``demo``, ``train``, ``evaluate``, ``speed``, ``bench`` or ``search``."""

import sys

__all__ = ["main"]


def main() -> None:
    """Run the command line; what it refuses, it refuses in one line."""
    try:
        from .commands import run
    except ModuleNotFoundError as error:
        sys.exit(f'error: the command line needs {error.name}: pip install "stickslip[demo]"')
    sys.exit(run())
