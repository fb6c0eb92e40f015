"""Maps over numbers of the crawler: what a body comes to, cell by cell and seed by seed."""

from .inputs import Inputs
from .mapping import parameter_map
from .measures import MEASURES
from .statistics import in_si, over_seeds

__all__ = ["MEASURES", "Inputs", "in_si", "over_seeds", "parameter_map"]
