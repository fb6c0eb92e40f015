"""What is found of a body: its parameters, their intervals, and what the measurements cannot tell."""

from dataclasses import asdict, dataclass
from typing import Any, TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t

from ...common.validation import number_within, whole_number
from ...crawler import Groups, Scene
from .design import best_word, Design
from .measurements import Measurements
from .prediction import Body

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Identification"]


@dataclass(frozen=True, eq=False)
class Identification:
    """A body that fits measurements, and how well they tell it.

    Attributes
    ----------
    body : Groups or Actuator
        As the guess was.
    names : tuple of str
        Of the parameters that were free.
    covariance : (free, free) array
        Of the parameters, in their units, linearised about the fit, with the errors of each channel taken from what
        is left of it.
    noise : dict of str to float
        Root mean square of what is left of each channel.
    samples : int
        That were fitted.
    warnings : tuple of str
        What the data cannot tell.
    runs : tuple of Measurements
        That were fitted.
    scene : Scene
    profiles : dict of str to (values, rises)
        For each parameter, values of it beside the fit, the others following as the covariance has it, and by how much
        the sum of squares is larger there, in squares of the noise.
    """

    body: Body
    names: tuple[str, ...]
    covariance: NDArray[np.float64]
    noise: dict[str, float]
    samples: int
    warnings: tuple[str, ...]
    runs: tuple[Measurements, ...]
    scene: Scene
    profiles: dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]

    @property
    def groups(self) -> Groups:
        """The dimensionless groups of the body."""
        return self.body if isinstance(self.body, Groups) else self.body.groups

    def interval(self, level: float = 0.95) -> dict[str, tuple[float, float]]:
        """Intervals of the free parameters, one a name.

        They are those of the linearised fit by Student's t, and longer where `profiles` knows of bodies further away
        that fit as well: beyond a slip that is won or lost (D. M. Bates and D. G. Watts, Nonlinear Regression Analysis
        and Its Applications, Wiley 1988, section 6.1).

        Parameters
        ----------
        level : float
            Probability that an interval holds the true value, in (0, 1).
        """
        number_within("level", level, "(0, 1)")
        wide = float(t.ppf(0.5 + 0.5 * level, self.samples - len(self.names)))
        intervals = {}
        for name, error in zip(self.names, np.sqrt(np.diag(self.covariance)).tolist(), strict=True):
            values, rises = self.profiles[name]
            fitting = values[rises <= wide**2]
            around = [getattr(self.body, name) + sign * wide * error for sign in (-1.0, 1.0)]
            intervals[name] = min([around[0], *fitting.tolist()]), max([around[1], *fitting.tolist()])
        return intervals

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """What was found, ready for JSON.

        Parameters
        ----------
        level : float
            Of the intervals, in (0, 1).
        """
        errors = np.sqrt(np.diag(self.covariance)).tolist()
        return {
            "units": "natural" if isinstance(self.body, Groups) else "SI",
            "body": asdict(self.body),
            "groups": self.groups.to_dict(),
            "level": level,
            "free": {
                name: {"value": getattr(self.body, name), "standard_error": error, "interval": list(interval)}
                for (name, interval), error in zip(self.interval(level).items(), errors, strict=True)
            },
            "covariance": self.covariance.tolist(),
            "noise": self.noise,
            "samples": self.samples,
            "warnings": list(self.warnings),
            "scene": self.scene.to_dict(),
        }

    def next_word(self, length: int, aim: str | None = None) -> Design:
        """The word of the valve that would tell most about what is known least, or about another `aim`.

        Parameters
        ----------
        length : int
            Holds of the word, run from rest and measured as `runs[0]` was.
        aim : str, optional
            One of `names`, or "all" for all of them at once.

        Returns
        -------
        Design
        """
        run = self.runs[0]
        each = run.samples_per_hold or max(1, round(run.times.size / run.valve.size))
        return best_word(
            self.body,
            length,
            names=self.names,
            noise={name: self.noise[name] for name in run.measured},
            hold=run.hold,
            samples_per_hold=each,
            covariance=self.covariance,
            aim=aim,
            scene=self.scene,
        )

    def plot(self, run: int = 0) -> "Figure":
        """What was measured in one of the runs, the fit, and what is left of it, over time.

        Parameters
        ----------
        run : int
            Its place among `runs`.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from .figure import plot_fit

        return plot_fit(self, whole_number("run", run, 0, len(self.runs) - 1))
