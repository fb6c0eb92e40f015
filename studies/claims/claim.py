"""A claim of the paper, and what comes of it."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import NDArray

from ...reservoir import mean_over_runs

__all__ = [
    "CAPTIONS",
    "CLAIMS",
    "FIGURES",
    "UNKNOWN",
    "VERDICTS",
    "WHY_UNKNOWN",
    "Claim",
    "Number",
    "Verdict",
    "interval",
]

Verdict = Literal["reproduced", "reproduced in part", "not reproduced", "overturned"]
VERDICTS: tuple[Verdict, ...] = ("reproduced", "reproduced in part", "not reproduced", "overturned")

CLAIMS = {
    "C1": "The model crawls forward: payload and foot advance from cycle to cycle (Fig. 1).",
    "C2": "A body of one degree of freedom tracks a multibody twin: NMSE 0.0028, < 0.01 in three regimes (4.1, S6).",
    "C3": "Memory capacity peaks at moderate mechanical work, along Pi1 (Fig. 2).",
    "C4": "lambda_max = 0 is a curve in Pi1 x Pi4: the edge of chaos (Fig. 3).",
    "C5": "Memory capacity is largest exactly at that edge (Fig. 3, S7).",
    "C6": "Polynomial SINDy fails on stick-slip accelerations, NMSE 0.452 (Fig. 4, S8).",
    "C7": "A static offset makes SINDy invent a quadratic term, and removing it does not help (S9).",
    "C8": "max(0, p') and sign(p') in the library fail as well (Fig. 5, S10).",
    "C9": "So regression cannot recover the law: a kinetic stiffness limit (5.2, G).",
    "C10": "The spread of work over an ensemble comes from stick-slip chaos and fluid lag (D, S28 to S30).",
}
"""What the paper says, by the name of the claim."""


FIGURES = {
    "C1": ("fig1",),
    "C2": ("figS6",),
    "C3": ("fig2",),
    "C4": ("fig3",),
    "C5": ("fig3", "figS7"),
    "C6": ("fig4", "figS8"),
    "C7": ("figS9",),
    "C8": ("fig5", "figS10"),
    "C9": ("fig4",),
    "C10": ("work",),
}
"""Where the paper shows each, and "work" for what it has no figure of."""
CAPTIONS = {
    "fig1": "The default crawler, the valve open for four holds of 1 and shut for four.",
    "fig2": "Memory of the three states against the work of a hold along Pi1, a line a lag of the fluid. Hold 0.5, "
    "Pi2 = 0.02, fair bits; mean over seeds.",
    "fig3": "The largest exponent and the memory of the three states over Pi1 and Pi4. Anchored, hold 0.5, Pi2 = 0.02, "
    "fair bits; mean over seeds.",
    "fig4": "Left: the one-step error of SINDy on accelerations, by friction; the axis is broken. Right: the error of "
    "whole runs by a regression that finds slips, by length and noise of its data; median over seeds.",
    "fig5": "The one-step error on the foot's acceleration, by what was tried, default groups; bars: mean over seeds.",
    "figS6": "Above: one spring against a chain of 8 segments, in four regimes. Below: one spring and chains by their "
    "number of segments. Hold 1, fair bits; mean over seeds.",
    "figS7": "Exponent, memory and the capacity for products of two inputs along Pi1. Anchored, hold 2, Pi2 = 0.05, "
    "Pi4 = 0.5, fair bits; bands: 95% over seeds; dashed: where the exponent is 0.",
    "figS8": "The foot's acceleration in an unseen run, default groups, and what a cubic by SINDy says of it.",
    "figS9": "The quadratic term that SINDy finds in the payload's acceleration where z is measured from an offset.",
    "figS10": "As figS8, with max(0, p') and sign(p') in the library.",
    "work": "Above: the spread of the work a hold over runs under fair bits, hold 0.5. Below: the average of "
    "exp(-beta W) and the free energy that it would give, from rest to rest through random bits; energy conserved and "
    "damped: anchored, from starts at exp(-beta H).",
}
"""What each figure shows, and of what."""
INDEPENDENT = {
    "C1": ("arithmetic of forty digits and SciPy's solvers", "tests/crawler/test_judges.py"),
    "C2": ("the exponential of a linear chain's matrix, on the ground too", "tests/crawler/motion/test_exact_chain.py"),
    "C3": ("delay lines and linear modes, whose memory is known", "tests/reservoir/test_memory.py"),
    "C4": ("exponents in closed form and by two runs that part", "tests/crawler/stability/test_lyapunov.py"),
    "C5": ("delay lines and linear modes, whose memory is known", "tests/reservoir/test_memory.py"),
    "C6": ("the law that made the data", "tests/studies/claims/test_laws.py"),
    "C7": ("the quadratic term of (z + c)^3", "tests/studies/claims/test_laws.py"),
    "C8": ("the law that made the data", "tests/studies/claims/test_laws.py"),
    "C9": ("the groups that made the data", "tests/studies/identification/test_regression.py"),
    "C10": ("the propagator of a linear body, and a method without events", "tests/studies/work/test_work.py"),
}
"""What the numbers behind each are compared with that is independent of them, and the test that does it."""
UNKNOWN = ("figS1", "figS2", "figS3", "figS4", "figS5")
"""Figures of the supplement of which only the names are known."""
WHY_UNKNOWN = (
    f"what {UNKNOWN[0]} to {UNKNOWN[-1]} show is not known: no claim names them, and the supplement's own table of "
    "figures does not match its numbers. What its equations say is drawn: segments of a tube (S14, S15) in figS6, work "
    "and Jarzynski's average (S28 to S30) in work; natural units (S18 to S22) are those of every axis"
)
"""Why these are not drawn."""


@dataclass(frozen=True)
class Number:
    """A number that decides, with a 95% interval where it has one."""

    value: float
    low: float | None = None
    high: float | None = None
    unit: str = "1"

    def __str__(self) -> str:
        interval = "" if self.low is None or self.high is None else f" [{_said(self.low)}, {_said(self.high)}]"
        return f"{_said(self.value)}{interval}" + ("" if self.unit == "1" else f" {self.unit}")


def _said(value: float) -> str:
    """To three digits; a thousand and more to the whole."""
    return f"{value:.0f}" if 999.5 <= abs(value) < 1e6 else f"{value:.3g}"


@dataclass(frozen=True)
class Claim:
    """What comes of a claim.

    Attributes
    ----------
    name : str
        Of `CLAIMS`.
    verdict : str
        Of `VERDICTS`.
    sentence : str
        What a reader may quote.
    numbers : dict of str to Number
    check : str
        The command that finds the numbers again.
    body : dict of str to Number
        What one real body does, in SI units (`stickslip.studies.claims.real_body`).
    remark : str
        What else was found.
    """

    name: str
    verdict: Verdict
    sentence: str
    numbers: dict[str, Number] = field(default_factory=dict)
    check: str = ""
    body: dict[str, Number] = field(default_factory=dict)
    remark: str = ""

    def __post_init__(self) -> None:
        if self.name not in CLAIMS:
            raise ValueError(f"name must be one of {', '.join(CLAIMS)}, got {self.name!r}")
        if self.verdict not in VERDICTS:
            raise ValueError(f"verdict must be one of {', '.join(VERDICTS)}, got {self.verdict!r}")

    def as_json(self) -> dict[str, Any]:
        """The claim as it stands in ``claims.json``."""
        return {
            "claim": CLAIMS[self.name],
            "figures": list(FIGURES[self.name]),
            **asdict(self),
            "independent": " ".join(INDEPENDENT[self.name]),
        }

    @classmethod
    def from_json(cls, kept: Mapping[str, Any]) -> Self:
        """A claim from `as_json`."""
        numbers, body = ({name: Number(**number) for name, number in kept[key].items()} for key in ("numbers", "body"))
        return cls(kept["name"], kept["verdict"], kept["sentence"], numbers, kept["check"], body, kept["remark"])


def interval(values: NDArray[np.float64], unit: str = "1", *, least: float = -np.inf) -> Number:
    """Mean over runs and its 95% interval by Student's t; the mean alone of one run or of runs that agree.

    Parameters
    ----------
    values : (runs,) array
    unit : str
    least : float
        Below which no value can be, and no interval reaches.
    """
    if values.size < 2:
        return Number(float(values[0]), unit=unit)
    found = mean_over_runs(values, bounds=(-np.inf, np.inf))
    mean = float(found.mean)
    return (
        Number(mean, unit=unit)
        if np.isnan(found.low)
        else Number(mean, max(float(found.low), least), float(found.high), unit)
    )
