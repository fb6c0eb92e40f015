"""The edge of chaos: whether it is there, whether memory lives at it, and what that says of the paper's claims."""

from .study import FULL, QUICK, Size, Study

__all__ = ["FULL", "QUICK", "Size", "Study"]
