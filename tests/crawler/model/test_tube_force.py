"""The force of an elastomer tube: closed forms, and the least energy found by brute force."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

from stickslip.crawler import Actuator
from stickslip.crawler.model.elastomer import ECOFLEX_00_30, Yeoh
from stickslip.crawler.model.tube_force import Tube

MATERIAL = Yeoh(8e3, 90.0, -0.2)
INNER, OUTER, LENGTH = 0.005, 0.008, 0.12
WALL = math.pi * (OUTER**2 - INNER**2)


def tube(thread_radius, material=MATERIAL, inner=INNER, outer=OUTER):
    return Tube(material=material, outer_radius=outer, inner_radius=inner, length=LENGTH, thread_radius=thread_radius)


def energy(stretch, bore, pressure):
    """Energy of the wall less the work of the pressure, for a unit of length, at the bore radius `bore`."""

    def at(radius):
        hoop = math.sqrt(bore**2 + (radius**2 - INNER**2) / stretch) / radius
        above = hoop**2 + stretch**2 + (hoop * stretch) ** -2 - 3.0
        stored = MATERIAL.c1 * above + MATERIAL.c2 * above**2 + MATERIAL.c3 * above**3
        return stored * 2.0 * math.pi * radius

    return quad(at, INNER, OUTER, epsabs=0.0, epsrel=1e-12)[0] - pressure * math.pi * bore**2 * stretch


def least_energy(stretch, pressure, thread_radius):
    """The least of `energy` over the bores that the threads allow."""
    most = 3.0 * INNER
    if thread_radius is not None:
        most = math.sqrt(thread_radius**2 - (thread_radius**2 - INNER**2) / stretch)
    found = minimize_scalar(
        lambda bore: energy(stretch, bore, pressure),
        bounds=(0.3 * INNER, most),
        method="bounded",
        options={"xatol": 1e-9},
    )
    return min(found.fun, energy(stretch, most, pressure))


@pytest.mark.parametrize("thread_radius", [None, INNER, 0.006, OUTER])
@pytest.mark.parametrize(("stretch", "pressure"), [(1.3, 500.0), (1.3, 3e3), (0.8, 2e3), (1.05, 2.5e3)])
def test_the_force_is_the_slope_of_the_least_energy(thread_radius, stretch, pressure):
    step = 1e-4
    slope = (
        least_energy(stretch + step, pressure, thread_radius) - least_energy(stretch - step, pressure, thread_radius)
    ) / (2.0 * step)
    force = tube(thread_radius).force((stretch - 1.0) * LENGTH, pressure)
    assert force == pytest.approx(-slope, rel=1e-4, abs=1e-6)


@pytest.mark.parametrize("stretch", [0.9, 1.0, 1.5, 3.0])
def test_without_pressure_and_threads_the_wall_is_in_simple_tension(stretch):
    above = stretch**2 + 2.0 / stretch - 3.0
    nominal = 2.0 * (stretch - stretch**-2) * (8e3 + 2.0 * 90.0 * above - 3.0 * 0.2 * above**2)
    assert tube(None).force((stretch - 1.0) * LENGTH, 0.0) == pytest.approx(-WALL * nominal, rel=1e-12, abs=1e-12)


def test_a_thin_wall_held_by_taut_threads_is_in_pure_shear():
    modulus, outer = 60e3, INNER * 1.0001
    thin = tube(INNER, Yeoh.neo_hookean(modulus), outer=outer)
    wall = math.pi * (outer**2 - INNER**2)
    pressure, stretch = 1e3, 1.4
    expected = pressure * math.pi * INNER**2 - wall * modulus / 3.0 * (stretch - stretch**-3)
    assert thin.force(0.4 * LENGTH, pressure) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("thread_radius", [INNER, 0.006, OUTER])
def test_at_rest_pressure_pushes_on_the_area_inside_the_threads(thread_radius):
    assert tube(thread_radius).force(0.0, 123.0) == pytest.approx(123.0 * math.pi * thread_radius**2, rel=1e-12)


def test_pressure_does_not_push_a_tube_without_threads_at_first_order():
    force = tube(None).force(0.0, [1.0, 10.0])
    assert force[0] < 1e-4 * math.pi * INNER**2
    assert force[1] == pytest.approx(100.0 * force[0], rel=1e-2)  # it is of second order


def test_a_tube_without_threads_balloons():
    with pytest.raises(ValueError, match="pressure must be one at which the tube does not balloon, got 50000"):
        tube(None).force(0.0, 50e3)


def test_the_lumped_body_of_small_deformations_is_the_linear_tube():
    body = tube(INNER, Yeoh(8e3)).lumped((-1e-5, 1e-5), 20e3)
    assert body.pressure_area == pytest.approx(math.pi * INNER**2, rel=1e-3)
    assert body.error < 1e-3
    far = 1e-4 * LENGTH
    taut = tube(INNER, Yeoh(8e3)).force([-far, far], 20e3)
    assert body.stiffness == pytest.approx((taut[0] - taut[1]) / (2.0 * far), rel=1e-2)


def test_the_error_of_the_lumped_body_is_that_of_its_force():
    here, peak = tube(INNER), 20e3
    body = here.lumped((0.0, 0.05), peak)
    z, load = np.meshgrid(np.linspace(0.0, 0.05, 31), np.linspace(0.0, peak, 11))
    force = here.force(z, load)
    near = (
        load * body.pressure_area * (1.0 + body.radial_coupling * z) - body.stiffness * z - body.cubic_stiffness * z**3
    )
    assert body.error == pytest.approx(np.abs(near - force).max() / np.abs(force).max(), rel=1e-9)
    assert min(body[:4]) >= 0.0


def test_a_body_fitted_as_far_as_it_may_reach_is_as_near_as_asked():
    here = tube(INNER)
    reach = here.reach(20e3, 0.05)
    assert here.lumped((0.0, reach), 20e3).error <= 0.05 < here.lumped((0.0, 1.01 * reach), 20e3).error


def test_where_pressure_holds_the_tube_nothing_pushes():
    here = tube(OUTER)
    held = here.deformation_at(4e3)
    assert held > 0.0
    assert abs(here.force(held, 4e3)) < 1e-9
    with pytest.raises(ValueError, match="pressure must be one that holds the tube"):
        here.deformation_at(1e6)


COMMON = {
    "density": 1070.0,
    "payload_mass": 0.16,
    "foot_mass": 0.07,
    "peak_pressure": 20e3,
    "lag": 0.03,
    "static_friction": 0.8,
    "kinetic_friction": 0.5,
}


def test_an_actuator_has_the_numbers_of_its_tube():
    here = tube(INNER, ECOFLEX_00_30)
    body = here.lumped((0.0, here.deformation_at(20e3)), 20e3)
    actuator = Actuator.from_elastomer(here, **COMMON, damping=0.3, gravity=9.0, segments=3, tube_share=0.4)
    assert actuator == Actuator(
        payload_mass=0.16 + 0.4 * 1070.0 * WALL * LENGTH,
        foot_mass=0.07 + 0.4 * 1070.0 * WALL * LENGTH,
        stiffness=body.stiffness,
        cubic_stiffness=body.cubic_stiffness,
        damping=0.3,
        bore_area=body.pressure_area,
        peak_pressure=20e3,
        lag=0.03,
        radial_coupling=body.radial_coupling,
        static_friction=0.8,
        kinetic_friction=0.5,
        gravity=9.0,
        segments=3,
    )


def test_a_tube_that_pressure_does_not_push_makes_no_actuator():
    with pytest.raises(ValueError, match="tube must have a thread_radius, got None"):
        Actuator.from_elastomer(tube(None), **COMMON)
    with pytest.raises(ValueError, match="density must be in"):
        Actuator.from_elastomer(tube(INNER), **COMMON | {"density": -1.0})


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        ({"thread_radius": 0.009}, "thread_radius must be in .inner_radius = 0.005, outer_radius = 0.008. or None"),
        ({"inner_radius": 0.008}, r"inner_radius must be in \(0, outer_radius = 0.008\), got 0.008"),
        ({"length": 0.0}, "length must be in"),
        ({"outer_radius": math.nan}, "outer_radius must be in"),
    ],
)
def test_refuses_a_tube_that_cannot_be(bad, message):
    whole = {
        "material": MATERIAL,
        "outer_radius": OUTER,
        "inner_radius": INNER,
        "length": LENGTH,
        "thread_radius": INNER,
    }
    with pytest.raises(ValueError, match=message):
        Tube(**whole | bad)


def test_refuses_what_is_no_deformation_or_pressure():
    here = tube(INNER)
    with pytest.raises(ValueError, match=r"deformation must be more than -length = -0.12, got -0.2"):
        here.force(-0.2, 0.0)
    with pytest.raises(ValueError, match=r"pressure must be in \[0, inf\), got -1.0"):
        here.force(0.0, -1.0)
    with pytest.raises(ValueError, match=r"deformation must be \(low, high\) with low < high"):
        here.lumped((0.1, 0.0), 1e3)
    with pytest.raises(TypeError, match="material must be a Yeoh, got 7"):
        tube(INNER, material=7)
    with pytest.raises(ValueError, match="c1 must be in"):
        Yeoh(0.0)


def test_ecoflex_is_as_soft_as_its_data_sheet_says():
    # Smooth-On: 10 psi at 100% strain; samples differ by some tens of percent.
    at_two = 2.0 * (2.0 - 0.25) * ECOFLEX_00_30.slope(5.0)
    assert 0.4 < at_two / 68.9e3 < 1.0
    assert ECOFLEX_00_30.energy(5.0) == pytest.approx(2.0 * 7932.0 + 4.0 * 85.4)
    assert ECOFLEX_00_30.youngs_modulus == 6.0 * 7932.0
