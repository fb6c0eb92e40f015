"""How well a run kept its time."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["PERCENTILES", "Report"]

PERCENTILES = {"median": 50.0, "95%": 95.0, "99%": 99.0, "most": 100.0}
"""What is told of times, by the names of the columns."""

_TIMES = {
    "woke": "woke after the instant",
    "reading": "reading the sensors",
    "deciding": "deciding",
    "writing": "writing to the valve",
    "latency": "valve turned after the instant",
}


@dataclass(frozen=True, eq=False)
class Report:
    """Times of a run, s.

    Attributes
    ----------
    holds : int
        Decisions that were taken.
    skipped : int
        Holds in which none was: the valve stayed as it was, since all of the hold had passed before it could be
        turned.
    hold : float
        Length of one.
    natural_hold : float
        The same in t_c.
    trained_hold : float or None
        At which the policy was trained, t_c, where it says so.
    allowed : float
        Latency above which a deadline is missed.
    woke, reading, deciding, writing, latency : (holds,) arrays
        From the instant of a decision until the runner was awake; what it took to read, decide and write; and from the
        instant until the valve was turned.
    """

    holds: int
    skipped: int
    hold: float
    natural_hold: float
    trained_hold: float | None
    allowed: float
    woke: NDArray[np.float64]
    reading: NDArray[np.float64]
    deciding: NDArray[np.float64]
    writing: NDArray[np.float64]
    latency: NDArray[np.float64]

    @property
    def missed(self) -> int:
        """Deadlines that were missed: the valve was turned later than allowed."""
        return int(np.count_nonzero(self.latency > self.allowed))

    def percentiles(self, name: str) -> dict[str, float]:
        """Of one of the times, by the names of :data:`PERCENTILES`; s. Not a number where there was no decision."""
        times = getattr(self, name)
        found = np.percentile(times, list(PERCENTILES.values())) if len(times) else np.full(len(PERCENTILES), np.nan)
        return dict(zip(PERCENTILES, found.tolist(), strict=True))

    def to_dict(self) -> dict[str, Any]:
        """Numbers and percentiles, ready for JSON."""
        plain = {name: value for name, value in asdict(self).items() if name not in _TIMES}
        return {**plain, "missed": self.missed, **{name: self.percentiles(name) for name in _TIMES}}

    def __str__(self) -> str:
        trained = ""
        if self.trained_hold is not None and abs(self.trained_hold / self.natural_hold - 1.0) > 1e-6:
            trained = f", trained at {self.trained_hold:.4g} t_c"
        lines = [
            f"{self.holds} holds of {1e3 * self.hold:.6g} ms ({self.natural_hold:.4g} t_c{trained}): "
            f"{self.missed} deadlines missed by more than {1e3 * self.allowed:.4g} ms, {self.skipped} holds skipped",
            f"{'ms':32}" + "".join(f"{name:>10}" for name in PERCENTILES),
        ]
        for name, words in _TIMES.items():
            told = self.percentiles(name).values()
            lines.append(f"{words:32}" + "".join(f"{1e3 * value:10.3f}" for value in told))
        return "\n".join(lines)
