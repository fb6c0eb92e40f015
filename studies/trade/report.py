"""What a trade leaves in its folder: ``front.csv``, ``front.json``, a figure a dither, and ``index.md``."""

import csv
import io
import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ...common.figures import save_figure
from ...common.files import write_text
from ...reservoir.bootstrap import Estimate
from ..benchmark.report import as_markdown, cell
from .figure import plot_front
from .front import area, as_json, estimated, Front, gain, Point
from .learned import Learned, learned
from .plan import OPEN_LOOP, Trade
from .portrait_figure import plot_learned
from .running import TradeFolder

__all__ = ["COLUMNS", "areas", "figure_of", "rows", "table", "write_report"]

COLUMNS = (
    "dither", "kind", "weight", "floor", "training_seed", "name",
    "speed", "speed_low", "speed_high", "memory", "memory_low", "memory_high",
    "reward", "lead", "lead_low", "lead_high",
    "episode_speed", "episode_memory", "body_memory",
)  # fmt: skip
"""Of ``front.csv``: means over the seeds that judge, with 95% intervals. `reward` is that of long runs at the policy's
weight, `lead` what it is above the best open-loop word, held open or held shut; `episode_...` is what the environment
pays over one episode, `body_memory` the memory of a policy's commands on flips that it knows nothing of."""


def rows(front: Front) -> Iterator[dict[str, Any]]:
    """Rows of ``front.csv`` at one dither, by `COLUMNS`; what a point has not is None."""
    for point in front.points:
        row: dict[str, Any] = dict.fromkeys(COLUMNS)
        row |= {"dither": front.dither, "kind": point.kind, "name": point.name}
        row |= {"weight": point.weight, "floor": point.floor, "training_seed": point.seed}
        for name, values in (("speed", point.speeds), ("memory", point.memories)):
            row |= _ends(name, estimated(values))
        if point.weight is not None:
            row |= {"reward": float(point.rewards(point.weight).mean()), **_ends("lead", front.lead(point))}
        for name, told in (
            ("episode_speed", point.episode_speeds),
            ("episode_memory", point.episode_memories),
            ("body_memory", point.body_memories),
        ):
            if told is not None:
                row[name] = float(told.mean())
        yield row


def write_report(folder: TradeFolder, fronts: Sequence[Front], *, weight: float = 0.2) -> None:
    """Write all of it, each file whole or not at all.

    Parameters
    ----------
    folder : TradeFolder
        That holds what the fronts were made of.
    fronts : sequence of Front
    weight : float
        Of memory in the reward whose lines of equal reward the figures show.

    Raises
    ------
    OSError
        If the folder cannot be written.
    """
    trade, output = folder.trade, folder.folder
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for front in fronts:
        writer.writerows(rows(front))
    write_text(output / "front.csv", text.getvalue())
    told = {
        "settings": trade.settings,
        "weights": list(trade.weights),
        "seeds": trade.seeds,
        "dithers": {str(front.dither): front.summary() for front in fronts},
    }
    write_text(output / "front.json", json.dumps(told, indent=1) + "\n")
    looked_at = {front.dither: learned(folder, front) for front in fronts if front.dither > 0}
    for front in fronts:
        if front.dither > 0:
            save_figure(plot_front(front, weight=weight), output / figure_of(front))
        if (seen := looked_at.get(front.dither)) is not None:
            figure = plot_learned(seen.portraits, seen.responses, seen.imitations)
            save_figure(figure, output / figure_of(front, "learned"))
    write_text(output / "index.md", _page(trade, fronts, looked_at))


def figure_of(front: Front, name: str = "front") -> str:
    """Name of a figure of a front."""
    return f"{name}-{front.dither!r}.png"


def table(front: Front) -> list[list[str]]:
    """Speed, memory and reward of what matters at one dither, under a row of headings."""
    told = [
        [
            "",
            "weight or floor",
            "speed",
            "memory",
            "reward above the best schedule",
            "memory paid in an episode",
            "of the body",
        ]
    ]
    corners = _corners(front.open_loop)
    for point in front.shown:
        if point.kind == OPEN_LOOP and point not in corners:
            continue
        memory, paid = point.memories.mean(), point.episode_memories
        told.append(
            [
                " ".join(
                    [
                        point.kind,
                        *([point.name] if point.kind == OPEN_LOOP else []),
                        *([] if point.seed is None else [f"seed {point.seed}"]),
                    ]
                ),
                _objective(point),
                cell(estimated(point.speeds), 3),
                cell(estimated(point.memories)) if front.dither else "",
                "" if point.weight is None else cell(front.lead(point), 3, "+"),
                "" if paid is None or not memory else f"{paid.mean():.2f} ({paid.mean() / memory:.0%})",
                "" if point.body_memories is None else cell(estimated(point.body_memories)),
            ]
        )
    return told


def _floors(trade: Trade) -> str:
    return " and above each floor on speed" if trade.floors else ""


def _objective(point: Point) -> str:
    """What a policy was trained for."""
    if point.floor is not None:
        return f"floor {point.floor:g}"
    return "" if point.weight is None else f"{point.weight:g}"


def _corners(words: Sequence[Point]) -> list[Point]:
    """The fastest word, and the one of which speed times memory is largest."""
    return [
        max(words, key=lambda point: point.mean[0]),
        max(words, key=lambda point: point.mean[0] * point.mean[1]),
    ]


def _page(trade: Trade, fronts: Sequence[Front], looked_at: Mapping[float, Learned | None]) -> str:
    hold = trade.world(fronts[0].dither).hold
    parts = [
        "# Distance against memory",
        f"Hold {hold:g}. Everything is judged on {trade.judges} seeds that no training saw, over runs of {trade.holds}"
        f" holds: means [95% intervals]. Open-loop words have up to {trade.longest} bits. Policies are trained by"
        f" {trade.algorithm}, {trade.seeds} at each weight of memory in the reward{_floors(trade)}; of these the one is"
        " shown that was best in the evaluations of its own training.",
    ]
    for front in fronts:
        parts.append(f"## Dither {front.dither:g}")
        if front.dither:
            parts += [f"![Speed against memory capacity]({figure_of(front)})", as_markdown(areas(front))]
        parts.append(f"The speed limit, by dynamic programming, is {cell(front.speed_limit, 3)}.")
        if (knee := front.knee) is not None:
            parts.append(
                f"The knee: speed {cell(estimated(knee.speeds), 3)} and memory {cell(estimated(knee.memories))}, by the"
                f" {knee.kind} of {_objective(knee)}."
            )
        losses, trained = front.losses(), len(front.policies) + len(front.conditioned)
        parts.append(
            f"Of {trained} policies {len(losses)} earn less at their weight than the best of these: held open, held"
            f" shut, an open-loop word{': ' if losses else '.'}{', '.join(point.name for point in losses)}"
        )
        parts.append(as_markdown(table(front)))
        if (seen := looked_at.get(front.dither)) is not None:
            parts.append(f"![What the policies have learned]({figure_of(front, 'learned')})")
            parts += [
                f"A register of the last {bits} valve states, table {register.name}, commands as the {name} policy does"
                f" in {seen.imitations[name][bits].agreement:.1%} of the holds. By itself it comes to speed"
                f" {cell(estimated(register.speeds), 3)} and memory {cell(estimated(register.memories))}."
                for name, (bits, register) in seen.registers.items()
            ]
    return "\n\n".join(parts) + "\n"


def areas(front: Front) -> list[list[str]]:
    """Hypervolumes at one dither, under a row of headings."""
    told = [["", "hypervolume from (0, 0)", "% above open loop"], [OPEN_LOOP, cell(area(front.open_loop)), ""]]
    weighed = [point for point in front.chosen if point.floor is None]
    every = [("policies", front.chosen), ("conditioned policy", front.conditioned)]
    if len(weighed) < len(front.chosen):
        every.insert(1, ("policies for a weight", weighed))
    for name, points in every:
        if points:
            more = gain(points, front.open_loop)
            percent = Estimate(100 * more.mean, 100 * more.low, 100 * more.high, more.runs)
            told.append([name, cell(area(points)), cell(percent, 0, "+")])
    each = front.areas_by_seed()
    if len(each) > 1:
        shares = [100 * (one / area(front.open_loop).mean - 1) for one in each]
        ends = f"{min(shares):+.0f} to {max(shares):+.0f}"
        told.append(
            [f"policies of one seed, least and most of {len(each)}", f"{min(each):.2f} to {max(each):.2f}", ends]
        )
    return told


def _ends(name: str, estimate: Estimate) -> dict[str, float | None]:
    told = as_json(estimate)
    return {name: told["mean"], f"{name}_low": told["low"], f"{name}_high": told["high"]}
