from dataclasses import replace

import numpy as np
import pytest

from stickslip.crawler import Actuator, Groups
from stickslip.studies.benchmark.sweep import parse_sweep, SWEPT, with_amplitude, with_value
from stickslip.tasks import BodyReservoir


def test_an_amplitude_is_that_of_the_pump():
    """The judge is the actuator in SI, whose pressure is raised and which is made dimensionless again."""
    actuator = Actuator.ecoflex()
    stronger = replace(actuator, peak_pressure=2.5 * actuator.peak_pressure)
    found = with_amplitude(actuator.groups, 2.5).to_dict()
    assert found == pytest.approx(stronger.groups.to_dict(), rel=1e-12)


def test_every_number_that_is_named_is_swept():
    bits = np.random.default_rng(0).integers(0, 2, 40).astype(float)
    still = BodyReservoir()(bits)
    for name in SWEPT:
        value = 0.25 if name != "static_friction" else 0.4
        if name in ("foot_mass_fraction", "kinetic_friction"):
            value = 0.1
        assert not np.array_equal(with_value(BodyReservoir(), name, value)(bits), still), name
    assert ("hold", "amplitude", *Groups().to_dict(), "slope") == SWEPT
    assert with_value(BodyReservoir(), "hold", 2.0) == BodyReservoir(hold=2.0)
    assert with_value(BodyReservoir(scene={"anchored": True}), "slope", 0.1) == BodyReservoir(
        scene={"anchored": True, "slope": 0.1}
    )
    assert with_value(BodyReservoir(), "duffing", 2.0).groups == Groups(duffing=2.0)


def test_a_sweep_is_read_in_ascending_order():
    assert parse_sweep("hold=1,0.25,2") == ("hold", [0.25, 1.0, 2.0])


@pytest.mark.parametrize("text", ["hold", "hold=", "hold=1", "hold=1,1", "hold=1,x", "=1,2,"])
def test_a_sweep_that_is_none_is_refused(text):
    with pytest.raises(ValueError, match=r"sweep must be a name and two or more distinct values .* got"):
        parse_sweep(text)


def test_bad_input():
    with pytest.raises(ValueError, match=r"sweep has no 'wheels'; allowed are \['hold', 'amplitude', 'duffing'"):
        parse_sweep("wheels=1,2")
    with pytest.raises(ValueError, match=r"amplitude must be in \(0, inf\), got 0"):
        with_amplitude(Groups(), 0)
    with pytest.raises(ValueError, match=r"sweep has no 'wheels'"):
        with_value(BodyReservoir(), "wheels", 1.0)
