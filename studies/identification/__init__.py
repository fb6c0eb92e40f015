"""Laws and groups of a body from measurements of how it moved."""

from .design import best_word, Design
from .identification import Identification
from .identify import identify
from .log import Log, read_log
from .measurements import CHANNELS, Measurements
from .regression import Law, regress

__all__ = [
    "CHANNELS",
    "Design",
    "Identification",
    "Law",
    "Log",
    "Measurements",
    "best_word",
    "identify",
    "read_log",
    "regress",
]
