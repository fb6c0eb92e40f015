"""``stickslip demo``: from body to policy in one command, with a page to open at the end."""

from .tour import run_demo

__all__ = ["run_demo"]
