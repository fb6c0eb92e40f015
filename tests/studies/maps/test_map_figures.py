"""Figures of maps: what is drawn where."""

import numpy as np
import pytest
import xarray as xr
from legible import assert_legible
from matplotlib.colors import CenteredNorm

from stickslip import Actuator
from stickslip.studies.maps import in_si
from stickslip.studies.maps.figures import plot_map

DUFFING, DEBORAH = np.linspace(0.0, 200.0, 5), np.geomspace(0.1, 10.0, 3)


def made(seeds=4):
    """An exponent that rises through zero at a duffing of 125, of a known scatter, and a memory."""
    scatter = np.linspace(-1.0, 1.0, seeds) if seeds > 1 else np.zeros(1)
    mean = (DUFFING - 125.0) / 100.0
    exponent = mean[None, :, None] * np.ones((3, 1, 1)) + scatter
    memory = 3.0 - np.abs(np.log(DEBORAH))[:, None, None] - DUFFING[None, :, None] / 100.0 + 0.0 * scatter
    dims = ("deborah", "duffing", "seed")
    return xr.Dataset(
        {
            "lyapunov": (dims, exponent, {"long_name": "largest exponent", "units": "1 / t_c"}),
            "lyapunov_standard_error": (dims, np.full_like(exponent, 0.3), {"units": "1 / t_c"}),
            "memory": (dims, memory, {"long_name": "memory capacity", "units": "1", "valid_min": 0.0}),
            "status": (dims[:2], np.ones((3, 5), np.int8)),
        },
        {"deborah": DEBORAH, "duffing": DUFFING, "seed": np.arange(seeds)},
    )


@pytest.mark.parametrize("seeds", [4, 1])
def test_a_map_shows_where_the_exponent_is_zero_what_is_uncertain_and_the_ridge(seeds):
    found = made(seeds)
    figure = plot_map(found, ["lyapunov", "memory"])
    exponent, memory, *_ = figure.axes
    assert (exponent.get_xscale(), exponent.get_yscale()) == ("linear", "log")
    assert exponent.get_xlabel() == r"duffing $\Pi_1$"
    for ax in (exponent, memory):
        [contour] = [each for each in ax.collections if hasattr(each, "levels")]
        line = np.concatenate([path.vertices for path in contour.get_paths()])
        np.testing.assert_allclose(line[:, 0], 125.0, rtol=1e-12)
        circles, star = ax.lines
        np.testing.assert_allclose(circles.get_ydata(), 1.0, rtol=1e-12)
        assert circles.get_xdata().tolist() == DUFFING.tolist()
        assert (star.get_xdata().tolist(), star.get_ydata().tolist()) == ([0.0], [pytest.approx(1.0)])
    error = found.lyapunov.std("seed", ddof=1) / np.sqrt(seeds) if seeds > 1 else found.lyapunov_standard_error[..., 0]
    near = np.abs(found.lyapunov.mean("seed")) < 2 * error
    assert 0 < near.sum() < near.size
    hatched = [patch for patch in exponent.patches if patch.get_hatch()]
    centres = sorted((patch.get_x() + patch.get_width() / 2, patch.get_y()) for patch in hatched)
    assert [x for x, _ in centres] == pytest.approx(sorted(DUFFING[np.nonzero(near.values)[1]]))
    rows = DEBORAH[
        np.unique(np.nonzero(near.values)[0])
    ]  # a factor of 10 apart, and so cells end a factor of sqrt(10) off
    np.testing.assert_allclose(sorted({patch.get_y() for patch in hatched}), rows / np.sqrt(10.0))
    tops = sorted({patch.get_y() + patch.get_height() for patch in hatched})
    np.testing.assert_allclose(tops, rows * np.sqrt(10.0))
    assert not [patch for patch in memory.patches if patch.get_hatch()]
    mesh = exponent.collections[0]
    assert isinstance(mesh.norm, CenteredNorm)
    assert (mesh.norm.vcenter, mesh.cmap.name, memory.collections[0].cmap.name) == (0, "RdBu_r", "cividis")
    assert figure.axes[2].get_ylabel() == "largest exponent ($1 / t_c$)"
    said = [text.get_text() for text in figure.legends[0].get_texts()]
    assert said == ["exponent 0", "within 2 standard errors of 0", "most memory of the column", "of all"]


def test_over_one_number_a_band_is_drawn_and_where_the_exponent_changes_its_sign():
    figure = plot_map(made().isel(deborah=1), ["lyapunov", "memory"])
    for ax in figure.axes:
        assert [line.get_xdata()[0] for line in ax.lines if len(set(line.get_xdata())) == 1] == [pytest.approx(125.0)]
    np.testing.assert_allclose(figure.axes[1].lines[0].get_ydata(), 3.0 - DUFFING / 100.0)
    assert len(figure.axes[0].collections) == 1
    assert not plot_map(made(1).isel(deborah=1), ["memory"]).axes[0].collections


def test_no_figure_is_wider_than_a_page_and_long_labels_are_folded():
    found = made()
    found.memory.attrs["long_name"] = "capacity for products of 2 inputs in a row"
    for dims, shape in ((found, (6.5, 2.9)), (found.isel(deborah=1), (4.4, 3.8))):
        figure = plot_map(dims, ["lyapunov", "memory"])
        assert figure.get_size_inches() == pytest.approx(shape)
        assert_legible(figure)
    lyapunov, memory = figure.axes
    assert memory.get_ylabel() == "capacity for products of 2\ninputs in a row"
    assert (lyapunov.get_xlabel(), memory.get_xlabel()) == ("", r"duffing $\Pi_1$")
    found.lyapunov.attrs["long_name"] = "largest Lyapunov exponent of it"
    [alone] = plot_map(found.isel(deborah=1), ["lyapunov"]).axes
    assert alone.get_ylabel() == "largest Lyapunov exponent\nof it\n($1 / t_c$)"


def test_what_is_not_in_a_map_is_not_drawn():
    with pytest.raises(ValueError, match=r"names must be of \['lyapunov', .*\], got 'wisdom'"):
        plot_map(made(), ["wisdom"])


def test_an_axis_in_si_says_so():
    found = made().isel(deborah=1).rename(duffing="hold")
    found.hold.attrs.update(units="t_c", long_name="hold")
    actuator = Actuator.ecoflex()
    [ax] = plot_map(found, ["lyapunov"]).axes
    assert ax.get_xlabel() == "hold ($t_c$)"
    [ax] = plot_map(in_si(found, actuator), ["lyapunov"]).axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("hold (s)", "largest exponent (1 / s)")
    np.testing.assert_allclose(ax.lines[0].get_xdata(), DUFFING * actuator.scales.time)
