"""What an elastomer tube under axial stretch and pressure pushes with, and the lumped body that is nearest to it.

The wall between the radii A and B is incompressible: at the axial stretch w and the bore radius a, what was at R is at
r with r^2 = a^2 + (R^2 - A^2) / w (D. M. Haughton and R. W. Ogden, Journal of the Mechanics and Physics of Solids 27
(1979) 179 and 489). Threads are wound around it at one radius; they resist hoop tension and nothing else. The bore
takes the radius at which the energy of the wall less the work of the pressure is least, and the force is minus that
energy's slope along the length.
"""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq, nnls

from ...common.validation import finite_array, number_within
from .elastomer import Yeoh

__all__ = ["LumpedTube", "Tube"]

# Gauss nodes across the wall, in R^2. The integrands are analytic there: 24 leave only rounding.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)
# A tube whose bore radius has grown by this factor has ballooned.
_WIDEST = 10.0
_LONGEST = 3.0  # deformation in lengths of the tube
_LOOKS = 200  # for the least radius or deformation in balance
_GRID = (31, 11)  # deformations and pressures that the lumped body is fitted to
_HALVINGS = 14  # of the range on a logarithmic scale: to 0.05%


class LumpedTube(NamedTuple):
    """The body P A (1 + alpha z) - k_1 z - k_3 z^3 that is nearest to a tube, in SI."""

    stiffness: float  # k_1, N/m
    cubic_stiffness: float  # k_3, N/m^3
    pressure_area: float  # A, m^2
    radial_coupling: float  # alpha, 1/m
    error: float  # largest deviation of the force, over the largest force of the tube


@dataclass(frozen=True, slots=True, kw_only=True)
class Tube:
    """A tube of an elastomer, closed at both ends, with or without threads around it.

    Without threads pressure does not push at first order: under small pressure an incompressible closed tube gets
    wider and not longer, and the volume of its bore does not change when it is stretched.

    Parameters
    ----------
    material : Yeoh
    outer_radius, inner_radius : float
        B > A > 0, m.
    length : float
        L_0 at rest, m, > 0.
    thread_radius : float or None
        Of inextensible threads wound around the tube, m, from A to B. None: no threads.

    Raises
    ------
    ValueError
        If a length is not finite or out of range; the message names it.
    """

    material: Yeoh
    outer_radius: float
    inner_radius: float
    length: float
    thread_radius: float | None

    def __post_init__(self) -> None:
        if not isinstance(self.material, Yeoh):
            raise TypeError(f"material must be a Yeoh, got {self.material!r}")
        outer = number_within("outer_radius", self.outer_radius, "(0, inf)")
        number_within("length", self.length, "(0, inf)")
        inner = number_within("inner_radius", self.inner_radius, "(0, inf)")
        if inner >= outer:
            raise ValueError(f"inner_radius must be in (0, outer_radius = {outer!r}), got {self.inner_radius!r}")
        if self.thread_radius is not None and not inner <= self.thread_radius <= outer:
            raise ValueError(
                f"thread_radius must be in [inner_radius = {inner!r}, outer_radius = {outer!r}] or None, "
                f"got {self.thread_radius!r}"
            )

    def force(self, deformation: ArrayLike, pressure: ArrayLike) -> NDArray[np.float64]:
        """The force that pushes the ends apart, N, at rest.

        Parameters
        ----------
        deformation : array_like
            z, m, > -L_0.
        pressure : array_like
            In the bore above that outside, Pa, >= 0. Broadcast against `deformation`.

        Returns
        -------
        ndarray

        Raises
        ------
        ValueError
            If a number is not finite or out of range, or the tube balloons under the pressure.
        """
        stretch = 1.0 + finite_array("deformation", deformation, (0, 1, 2)) / self.length
        loads = finite_array("pressure", pressure, (0, 1, 2))
        if stretch.min() <= 0.0:
            raise ValueError(
                f"deformation must be more than -length = {-self.length!r}, got {float(np.min(deformation))!r}"
            )
        if loads.min() < 0.0:
            raise ValueError(f"pressure must be in [0, inf), got {float(loads.min())!r}")
        pairs = np.broadcast(stretch, loads)
        return np.array([self._force(w, load) for w, load in pairs]).reshape(pairs.shape)

    def deformation_at(self, pressure: float) -> float:
        """The least z, m, up to three times the length, at which nothing moves the ends under `pressure`, Pa, >= 0.

        Raises
        ------
        ValueError
            If the tube balloons under the pressure, or gets longer than that.
        """
        load = number_within("pressure", pressure, "[0, inf)")
        far = _LONGEST * self.length
        for before, after in pairwise(np.linspace(0.0, far, _LOOKS)):
            if self.force(after, load) < 0.0:
                return float(brentq(self.force, before, after, args=(load,), xtol=1e-15 * far, rtol=1e-14))
        raise ValueError(f"pressure must be one that holds the tube at a deformation below {far!r} m, got {pressure!r}")

    def lumped(self, deformation: tuple[float, float], peak_pressure: float) -> LumpedTube:
        """The lumped body nearest to the tube, in least squares of the force.

        Parameters
        ----------
        deformation : (low, high)
            The range of z, m, in which it is to be near.
        peak_pressure : float
            Of the range of pressures from 0, Pa, > 0.

        Returns
        -------
        LumpedTube
            None of its numbers is negative: a tube that softens has no cubic stiffness.
        """
        low, high = (
            number_within(f"deformation[{i}]", z, f"(-{self.length!r}, inf)") for i, z in enumerate(deformation)
        )
        if not low < high:
            raise ValueError(f"deformation must be (low, high) with low < high, got {deformation!r}")
        peak = number_within("peak_pressure", peak_pressure, "(0, inf)")
        z, load = np.meshgrid(np.linspace(low, high, _GRID[0]), np.linspace(0.0, peak, _GRID[1]))
        force = self.force(z, load)
        # Columns in units of the range, so that they are of one size.
        reach = max(abs(low), abs(high))
        w, p = z / reach, load / peak
        columns = np.stack([-w, -(w**3), p, p * w], axis=-1).reshape(-1, 4)
        fit, _ = nnls(columns, force.ravel())
        linear, cubic, push, coupling = (float(x) for x in fit)
        error = np.abs(columns @ fit - force.ravel()).max() / np.abs(force).max()
        return LumpedTube(
            stiffness=linear / reach,
            cubic_stiffness=cubic / reach**3,
            pressure_area=push / peak,
            radial_coupling=coupling / (push * reach) if push else 0.0,
            error=float(error),
        )

    def reach(self, peak_pressure: float, error: float = 0.05) -> float:
        """How far the tube may be stretched for a lumped body to have its force within `error` of the largest.

        Parameters
        ----------
        peak_pressure : float
            Pa, > 0.
        error : float
            In (0, 1).

        Returns
        -------
        float
            The largest z, m, up to three times the length, so that a body fitted from 0 to z is near enough.
        """
        allowed = number_within("error", error, "(0, 1)")
        low, high = 1e-3 * self.length, _LONGEST * self.length
        for _ in range(_HALVINGS):
            middle = math.sqrt(low * high)
            if self.lumped((0.0, middle), peak_pressure).error <= allowed:
                low = middle
            else:
                high = middle
        return low

    def _force(self, stretch: float, pressure: float) -> float:
        """The force at one stretch and pressure."""
        inner, thread = self.inner_radius**2, self.thread_radius
        work = math.pi * pressure * stretch
        free = inner / stretch  # a^2 of a bore without pressure and threads
        if thread is None:
            bore, tension, ring = self._bore(stretch, work, free, (_WIDEST * self.outer_radius) ** 2), 0.0, 0.0
        else:
            ring = thread**2 - inner
            held = thread**2 - ring / stretch
            tension = work - self._slopes(stretch, held)[1]
            bore = held
            if tension < 0.0:  # the threads are slack
                bore, tension = self._bore(stretch, work, free, held), 0.0
        along = self._slopes(stretch, bore)[0]
        return math.pi * pressure * bore - along + tension * ring / stretch**2

    def _slopes(self, stretch: float, bore: float) -> tuple[float, float]:
        """Slopes of the wall's energy for a unit of length, in the stretch and in a^2, at a^2 = `bore`."""
        inner, outer = self.inner_radius**2, self.outer_radius**2
        half = 0.5 * (outer - inner)
        squared = inner + half * (_NODES + 1.0)  # R^2
        hoop = (bore + (squared - inner) / stretch) / squared  # the hoop stretch, squared
        slope = math.pi * half * _WEIGHTS * self.material.slope(stretch**2 + hoop + 1.0 / (stretch**2 * hoop))
        by_hoop = 1.0 - 1.0 / (stretch * hoop) ** 2
        by_stretch = 2.0 * stretch - 2.0 / (stretch**3 * hoop)
        along = by_stretch - by_hoop * (squared - inner) / (stretch**2 * squared)
        return float(slope @ along), float(slope @ (by_hoop / squared))

    def _bore(self, stretch: float, work: float, least: float, most: float) -> float:
        """The least a^2 from `least` to `most` at which wall and pressure are in balance."""

        def excess(bore: float) -> float:
            return self._slopes(stretch, bore)[1] - work

        if work == 0.0:
            return least
        looks = np.geomspace(least, most, _LOOKS)
        for before, after in pairwise(looks):
            if excess(after) >= 0.0:
                return float(brentq(excess, before, after, xtol=1e-15 * most, rtol=1e-14))
        raise ValueError(
            f"pressure must be one at which the tube does not balloon, got {float(work / (math.pi * stretch))!r} "
            f"at the stretch {float(stretch)!r}"
        )
