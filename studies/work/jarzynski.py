"""Jarzynski's average of work, as the paper's supplement has it (S29, S30), and how far it can be trusted.

beta is a number that one chooses here, no temperature: nothing in the crawler's equations makes noise. What must hold
of them is the relation of Bochkov and Kuzovlev (Sov. Phys. JETP 45, 125, 1977; C. Jarzynski, C. R. Physique 8, 495,
2007): the work int P dV of a body that conserves energy, from starts at exp(-beta H), has <exp(-beta W)> = 1, whatever
the pressure did. With losses and no bath nothing of the kind holds.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

__all__ = ["Average", "average", "gaussian_average"]

_NORMAL = 1.959963984540054  # quantile of 97.5%


@dataclass(frozen=True)
class Average:
    """<exp(-beta W)> over an ensemble, and what it says.

    Attributes
    ----------
    beta : float
        Of the average, 1 / (P_max A_0 z_c).
    mean, error : float
        Of exp(-beta W), and its standard error.
    free_energy : float
        -ln <exp(-beta W)> / beta: what the paper takes for dF.
    bias : float
        By which a finite ensemble takes it too high, at least: Var(w) / (2 beta N <w>^2) with w = exp(-beta W)
        (J. Gore, F. Ritort and C. Bustamante, PNAS 100, 12564, 2003).
    dissipated : float
        <W> less the free energy (S30), >= 0 for any numbers whatever by Jensen's inequality.
    samples : float
        That carry the average, (sum w)^2 / sum w^2.
    """

    beta: float
    mean: float
    error: float
    free_energy: float
    bias: float
    dissipated: float
    samples: float

    @property
    def interval(self) -> tuple[float, float]:
        """95% interval of <exp(-beta W)>, by the normal law."""
        return self.mean - _NORMAL * self.error, self.mean + _NORMAL * self.error

    @property
    def free_energies(self) -> tuple[float, float, float]:
        """The free energy and the ends of its 95% interval, by the delta method; without the bias.

        Too narrow where few samples carry the average.
        """
        width = _NORMAL * self.error / (self.mean * self.beta)
        return self.free_energy, self.free_energy - width, self.free_energy + width


def average(works: NDArray[np.float64], beta: float) -> Average:
    """Jarzynski's average.

    Parameters
    ----------
    works : (runs,) array
        Two at least, natural units P_max A_0 z_c.
    beta : float, > 0
        Natural units 1 / (P_max A_0 z_c).

    Returns
    -------
    Average
    """
    count = len(works)
    logarithm = float(logsumexp(-beta * works)) - np.log(count)
    relative = np.exp(-beta * works - logarithm)  # of mean 1, whatever the size of the work
    spread = float(relative.std(ddof=1))
    mean = float(np.exp(logarithm))
    free_energy = -logarithm / beta
    return Average(
        beta=beta,
        mean=mean,
        error=mean * spread / count**0.5,
        free_energy=free_energy,
        bias=spread**2 / (2.0 * beta * count),
        dissipated=float(works.mean()) - free_energy,
        samples=float(relative.sum() ** 2 / (relative**2).sum()),
    )


def gaussian_average(mean: float, variance: float, beta: float) -> float:
    """<exp(-beta W)> of a normal work: exp(-beta mean + beta^2 variance / 2)."""
    return float(np.exp(-beta * mean + 0.5 * beta**2 * variance))
