"""What accuracy costs: work and precision of every solver, for the user's own crawler."""

from .case import Case
from .figures import plot_work_precision
from .measurement import measure, Omission, Row, Timing, TOLERANCES, WorkPrecision
from .recommendation import recommend, Recommendation
from .reference import Check, Reference, reference_for

__all__ = [
    "TOLERANCES",
    "Case",
    "Check",
    "Omission",
    "Recommendation",
    "Reference",
    "Row",
    "Timing",
    "WorkPrecision",
    "measure",
    "plot_work_precision",
    "recommend",
    "reference_for",
]
