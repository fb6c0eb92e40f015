"""Laws and groups of a body from measurements of how it moved."""

from .identify import Identification, identify
from .measurements import CHANNELS, Measurements
from .regression import Law, regress

__all__ = ["CHANNELS", "Identification", "Law", "Measurements", "identify", "regress"]
