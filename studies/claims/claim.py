"""A claim of the paper, and what comes of it."""

from dataclasses import asdict, dataclass, field
from typing import Any, Literal

__all__ = ["CLAIMS", "VERDICTS", "Claim", "Number", "Verdict"]

Verdict = Literal["reproduced", "reproduced in part", "not reproduced", "overturned"]
VERDICTS: tuple[Verdict, ...] = ("reproduced", "reproduced in part", "not reproduced", "overturned")

CLAIMS = {
    "C1": "The model crawls forward: payload and foot advance from cycle to cycle (Fig. 1).",
    "C2": "A body of one degree of freedom tracks a multibody twin: NMSE 0.0028, < 0.01 in three regimes (4.1, S6).",
    "C6": "Polynomial SINDy fails on stick-slip accelerations, NMSE 0.452 (Fig. 4, S8).",
    "C7": "A static offset makes SINDy invent a quadratic term, and removing it does not help (S9).",
    "C8": "max(0, p') and sign(p') in the library fail as well (Fig. 5, S10).",
    "C9": "So regression cannot recover the law: a kinetic stiffness limit (5.2, G).",
}
"""What the paper says, by the name of the claim."""


@dataclass(frozen=True)
class Number:
    """A number that decides, with a 95% interval where it has one."""

    value: float
    low: float | None = None
    high: float | None = None
    unit: str = "1"

    def __str__(self) -> str:
        interval = "" if self.low is None else f" [{self.low:.3g}, {self.high:.3g}]"
        return f"{self.value:.3g}{interval}" + ("" if self.unit == "1" else f" {self.unit}")


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
    """

    name: str
    verdict: Verdict
    sentence: str
    numbers: dict[str, Number] = field(default_factory=dict)
    check: str = ""

    def __post_init__(self) -> None:
        if self.name not in CLAIMS:
            raise ValueError(f"name must be one of {', '.join(CLAIMS)}, got {self.name!r}")
        if self.verdict not in VERDICTS:
            raise ValueError(f"verdict must be one of {', '.join(VERDICTS)}, got {self.verdict!r}")

    def as_json(self) -> dict[str, Any]:
        """The claim as it stands in ``claims.json``."""
        return {"claim": CLAIMS[self.name], **asdict(self)}
