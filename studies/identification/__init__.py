"""Laws and groups of a body from measurements of how it moved."""

from .identify import Identification, identify
from .log import Log, read_log
from .measurements import CHANNELS, Measurements
from .regression import Law, regress

__all__ = ["CHANNELS", "Identification", "Law", "Log", "Measurements", "identify", "read_log", "regress"]
