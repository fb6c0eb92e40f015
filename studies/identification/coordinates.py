"""The points among which a body is sought, and the bodies that they are."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from ...crawler import Actuator
from .prediction import Body

__all__ = ["Coordinates"]

# Typical sizes, for groups whose guess is 0 or nearly so.
_SIZES = {
    "duffing": 0.1,
    "damping_ratio": 0.02,
    "deborah": 0.05,
    "radial_coupling": 0.1,
    "foot_mass_fraction": 0.1,
    "static_friction": 0.05,
    "kinetic_friction": 0.05,
}
_SPREAD = 4.0  # starts lie within this factor of the guess, either way
_FARTHEST = 50.0  # and the search within this
_FRACTIONS = (1e-3, 0.999)  # of the mass that the foot may have


class Coordinates:
    """Free parameters in units of a guess.

    Where both frictions are free, the kinetic one is a share of the static.

    Parameters
    ----------
    guess : Groups or Actuator
    names : tuple of str
        Of the parameters that are free.

    Raises
    ------
    ValueError
        If the guess has a parameter of 0 whose size it should tell.
    """

    def __init__(self, guess: Body, names: tuple[str, ...]) -> None:
        self.guess, self.names = guess, names
        self.units = np.array([max(abs(getattr(guess, name)), _SIZES.get(name, 0.0)) for name in names])
        self.kinetic = names.index("kinetic_friction") if {"static_friction", "kinetic_friction"} <= {*names} else None
        if self.kinetic is not None:
            self.units[self.kinetic] = 1.0
        if np.any(self.units == 0.0):
            name = names[int(np.argmin(self.units))]
            raise ValueError(f"guess must have a {name} other than 0, which tells its size, got 0")

    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Least and greatest points."""
        low = np.array([1.0 / _FARTHEST if name == "deborah" else 0.0 for name in self.names])
        high = np.full(len(self.names), _FARTHEST)
        if "foot_mass_fraction" in self.names:
            i = self.names.index("foot_mass_fraction")
            low[i], high[i] = (share / self.units[i] for share in _FRACTIONS)
        if isinstance(self.guess, Actuator):
            low[:] = 1.0 / _FARTHEST
        if self.kinetic is not None:
            low[self.kinetic], high[self.kinetic] = 0.0, 1.0
        elif "kinetic_friction" in self.names:
            i = self.names.index("kinetic_friction")
            high[i] = self.guess.static_friction / self.units[i]
        elif "static_friction" in self.names:
            i = self.names.index("static_friction")
            low[i] = self.guess.kinetic_friction / self.units[i]
        return low, high

    def body(self, point: NDArray[np.float64]) -> Body:
        """The body at a point."""
        values = dict(zip(self.names, (point * self.units).tolist(), strict=True))
        if self.kinetic is not None:
            values["kinetic_friction"] *= values["static_friction"]
        return replace(self.guess, **values)

    def jacobian(self, point: NDArray[np.float64]) -> NDArray[np.float64]:
        """Derivatives of the body's parameters by the point's coordinates, (free, free)."""
        slopes = np.diag(self.units)
        if self.kinetic is not None:
            static = self.names.index("static_friction")
            slopes[self.kinetic, self.kinetic] = point[static] * self.units[static]
            slopes[self.kinetic, static] = point[self.kinetic] * self.units[static]
        return slopes

    def about_the_guess(self, starts: int, seed: int) -> NDArray[np.float64]:
        """Points spread evenly on a logarithmic scale, the guess among them."""
        low, high = self.bounds()
        spread = qmc.Sobol(len(self.names), rng=np.random.default_rng(seed)).random(starts)
        points = _SPREAD ** (2.0 * spread - 1.0)
        points[0] = [getattr(self.guess, name) for name in self.names] / self.units
        if self.kinetic is not None:
            points[:, self.kinetic] = spread[:, self.kinetic]
            points[0, self.kinetic] = self.guess.kinetic_friction / max(self.guess.static_friction, 1e-300)
        return np.clip(points, low, high)

    def along_the_static_friction(self, point: NDArray[np.float64], ratios: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points of bodies whose static friction is by some ratios that of another."""
        points = np.tile(point, (ratios.size, 1))
        points[:, self.names.index("static_friction")] *= ratios
        if self.kinetic is not None:  # the kinetic one stays
            points[:, self.kinetic] = np.minimum(points[:, self.kinetic] / ratios, 1.0)
        low, high = self.bounds()
        return np.clip(points, low, high)
