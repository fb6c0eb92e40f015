"""What a map varies, in text and in values."""

import numpy as np
import pytest

from stickslip.studies.benchmark.sweep import parse_sweep
from stickslip.studies.maps.axes import Axis, axis_of


def test_an_axis_is_spread_evenly_or_in_logarithms_or_listed():
    assert axis_of("x", "duffing=0:200:5") == Axis("duffing", (0.0, 50.0, 100.0, 150.0, 200.0))
    name, values = axis_of("x", "deborah=0.05:8:64:log")
    assert (name, len(values), values[0], values[-1]) == ("deborah", 64, 0.05, 8.0)
    np.testing.assert_allclose(values, np.geomspace(0.05, 8.0, 64), rtol=1e-13)
    assert axis_of("x", "hold=1,0.5") == Axis("hold", (0.5, 1.0))
    assert axis_of("x", "dither=0.1:0.5:3") == Axis("dither", (0.1, 0.1 + 0.5 * (0.5 - 0.1), 0.5))
    assert axis_of("x", "slope=-0.2:0.2:2") == Axis("slope", (-0.2, 0.2))
    assert axis_of("x", ("hold", np.array([2]))) == Axis("hold", (2.0,))
    assert parse_sweep("hold=0.25:1:3:log") == ("hold", pytest.approx([0.25, 0.5, 1.0], rel=1e-15))


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("wheels=0:1:3", r"x has no 'wheels'; allowed are \['hold', 'amplitude', 'duffing'.*'dither'\]"),
        ("duffing=200:0:64", "x duffing must rise from low to high, got '200:0:64'"),
        ("duffing=0:0:64", "x duffing must rise from low to high, got '0:0:64'"),
        ("duffing=0:200:64:log", "x duffing must be above 0 to be spread in logarithms, got '0:200:64:log'"),
        ("duffing=-1:200:64", r"x duffing must be in \[0, inf\), got -1.0"),
        ("dither=0.1:0.7:3", r"x dither must be in \[0, 0.5\], got 0.7"),
        ("duffing=0:inf:3", r"x duffing must be in \[0, inf\), got inf"),
        ("duffing=0:200", "x duffing must be low:high:count or low:high:count:log with a count in .*, got '0:200'"),
        ("duffing=0:200:1", "with a count in .*, got '0:200:1'"),
        ("duffing=0:200:4:lin", "with a count in .*, got '0:200:4:lin'"),
        ("duffing=0:200:4:log:log", r"with a count in \[2, 100000\]"),
        ("duffing=0:200:100001", r"with a count in \[2, 100000\], got '0:200:100001'"),
        ("duffing=a:b:4", r"with a count in \[2, 100000\]"),
        ("duffing", "x must be a name and two or more distinct values"),
        ("duffing=3", "x must be a name and two or more distinct values"),
        (("duffing", [1.0, 0.5]), r"x duffing must ascend, got \[1.0, 0.5\]"),
        (("duffing", [1.0, 1.0]), "x duffing must ascend"),
        (("duffing", [1.0, np.nan]), "x duffing must be finite, got nan at index"),
        (("wheels", [1.0]), "x has no 'wheels'"),
    ],
)
def test_an_axis_that_is_none_is_refused(given, message):
    with pytest.raises(ValueError, match=message):
        axis_of("x", given)


def test_an_axis_of_another_type_is_refused():
    with pytest.raises(TypeError, match="x must be text such as 'duffing=0:200:64' or a name and values, got 3"):
        axis_of("x", 3)
