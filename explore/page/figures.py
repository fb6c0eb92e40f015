"""The plots of the page, and the sources from which they draw."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from ...common.extras import optional_import
from ..front import edge_of
from ..motion import WHAT
from ..units import Units

with optional_import():
    from bokeh.models import ColumnDataSource, HoverTool, Range1d
    from bokeh.plotting import figure
    from bokeh.transform import factor_cmap, factor_mark

__all__ = ["Plots", "draw_front", "make_plots"]

# Of M. Okabe and K. Ito, as in `stickslip.common.figures`, which imports matplotlib.
STICK, SLIP, PAYLOAD, FOUND, LIGHT = "#0072B2", "#D55E00", "#6b6b6b", "#009E73", "#56B4E9"
_INK, _GRID = "#33383d", "#e6e4df"
KINDS = ["open loop", "policies", "conditioned"]
_FONT = "Inter, system-ui, -apple-system, 'Segoe UI', 'Liberation Sans', sans-serif"
_HEIGHT = {"trace": 220, "phase": 260, "memory": 260, "plane": 260}


class Plots(NamedTuple):
    """Sources by name, and figures by name."""

    sources: Mapping[str, Any]
    figures: Mapping[str, Any]


def make_plots() -> Plots:
    """Draw empty plots.

    Returns
    -------
    Plots
        Sources ``trace``, ``events``, ``profile``, ``you``, ``edge``, ``points`` and ``cursor``, the last of which only
        the browser moves; figures ``trace``, ``phase``, ``memory`` and ``plane``.
    """
    sources = {
        "trace": _source(
            "time", "deformation", "velocity", "pressure", "foot", "payload", "sliding", "valve", "flipped",
            "foot_sliding", "velocity_sliding",
        ),
        "events": _source("time", "deformation", "velocity", "foot", "what"),
        "profile": _source("delay", "capacity", "cutoff", "found"),
        "you": _source("speed", "memory"),
        "edge": _source("speed", "memory"),
        "points": _source("speed", "memory", "what", "kind"),
        "cursor": _source("time", "foot", "deformation", "velocity"),
    }  # fmt: skip
    for name, source in sources.items():
        source.name = name
    sources["cursor"].syncable = False
    figures = {
        "trace": _trace(sources),
        "phase": _phase(sources),
        "memory": _memory(sources),
        "plane": _plane(sources),
    }
    return Plots(sources, figures)


def draw_front(plots: Plots, front: Mapping[str, Any], units: Units) -> None:
    """Draw a front that is shipped, see `stickslip.explore.front.front_at`."""
    scale = units.length / units.time
    speeds, memories = edge_of(front)
    plots.sources["edge"].data = {"speed": scale * speeds, "memory": memories}
    rows = [(scale * each["speed"], each["memory"], each["name"], kind) for kind in KINDS for each in front[kind]]
    columns = [list(column) for column in zip(*rows, strict=True)]
    plots.sources["points"].data = dict(zip(("speed", "memory", "what", "kind"), columns, strict=True))


def _source(*columns: str) -> Any:
    return ColumnDataSource({column: [] for column in columns})


def _blank(name: str, **options: Any) -> Any:
    plot = figure(
        name=name,
        height=_HEIGHT[name],
        sizing_mode="stretch_width",
        tools="",
        toolbar_location=None,
        background_fill_color=None,
        border_fill_color=None,
        outline_line_color=None,
        min_border_right=12,
        min_border_top=6,
        **options,
    )
    for axis in (*plot.xaxis, *plot.yaxis):
        axis.axis_line_color = axis.major_tick_line_color = "#b9b5ac"
        axis.minor_tick_line_color = None
        axis.major_label_text_color = _INK
        axis.major_label_text_font = _FONT
        axis.major_label_text_font_size = "12px"
    for grid in (*plot.xgrid, *plot.ygrid):
        grid.grid_line_color = _GRID
    return plot


def _hover(plot: Any, renderers: list[Any], rows: list[tuple[str, str]], **options: Any) -> None:
    plot.add_tools(HoverTool(renderers=renderers, tooltips=rows, **options))


def _trace(sources: Mapping[str, Any]) -> Any:
    plot = _blank("trace")
    plot.x_range.range_padding = 0.0
    trace, cursor = sources["trace"], sources["cursor"]
    plot.line("time", "payload", source=trace, color=PAYLOAD, line_width=1.6, line_dash=[5, 3])
    foot = plot.line("time", "foot", source=trace, color=STICK, line_width=2.4)
    plot.line("time", "foot_sliding", source=trace, color=SLIP, line_width=3.6)
    plot.scatter(
        "time", "foot", source=cursor, size=12, color="white", line_color=_INK, line_width=2.2, level="overlay"
    )
    _hover(
        plot, [foot], [("time", "@time{0.00}"), ("foot", "@foot{0.00}"), ("payload", "@payload{0.00}")], mode="vline"
    )
    return plot


def _phase(sources: Mapping[str, Any]) -> Any:
    plot = _blank("phase")
    trace, events, cursor = sources["trace"], sources["events"], sources["cursor"]
    plot.line("deformation", "velocity", source=trace, color=STICK, line_width=1.4, alpha=0.8)
    plot.line("deformation", "velocity_sliding", source=trace, color=SLIP, line_width=2.2)
    dots = plot.scatter(
        "deformation", "velocity", source=events, size=8, line_color="white", line_width=1.2,
        fill_color=factor_cmap("what", [SLIP, STICK], WHAT), marker=factor_mark("what", ["circle", "square"], WHAT),
    )  # fmt: skip
    plot.scatter(
        "deformation", "velocity", source=cursor, size=13, color="white", line_color=_INK, line_width=2.2,
        level="overlay",
    )  # fmt: skip
    _hover(plot, [dots], [("", "@what"), ("time", "@time{0.00}"), ("z, v", "@deformation{0.00}, @velocity{0.00}")])
    return plot


def _memory(sources: Mapping[str, Any]) -> Any:
    plot = _blank("memory", y_range=Range1d(start=0.0, end=1.04), x_range=Range1d(start=-0.7, end=19.7))
    profile = sources["profile"]
    bars = plot.vbar("delay", top="capacity", width=0.72, source=profile, color=FOUND, line_color=None)
    plot.line("delay", "cutoff", source=profile, color=_INK, line_width=1.2, line_dash=[4, 3])
    _hover(plot, [bars], [("delay", "@delay"), ("capacity", "@capacity{0.000}"), ("chance", "@cutoff{0.000}")])
    return plot


def _plane(sources: Mapping[str, Any]) -> Any:
    plot = _blank("plane")
    plot.x_range.start = plot.y_range.start = 0.0
    edge = sources["edge"]
    plot.varea(x="speed", y1=0.0, y2="memory", source=edge, color="#e3e0d8")
    plot.line("speed", "memory", source=edge, color="#a49f94", line_width=1.2)
    dots = plot.scatter(
        "speed", "memory", source=sources["points"], size=8, line_color="white", line_width=1.0,
        fill_color=factor_cmap("kind", [PAYLOAD, STICK, LIGHT], KINDS),
        marker=factor_mark("kind", ["square", "circle", "triangle"], KINDS),
    )  # fmt: skip
    plot.scatter(
        "speed", "memory", source=sources["you"], size=22, marker="star", color=SLIP, line_color="white",
        line_width=1.6, level="overlay",
    )  # fmt: skip
    _hover(plot, [dots], [("", "@what"), ("speed", "@speed{0.000}"), ("memory", "@memory{0.00}")])
    return plot
