"""C10: what spreads the work over an ensemble, and what Jarzynski's average says of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..work.study import BETAS, Case, compare, FULL, HOLD, QUICK, Spread, spread_of, Study
from ..work.study import measure as measure_work
from .asked import Asked
from .claim import Claim, Number, Verdict
from .real_body import BODY

__all__ = ["Work", "claim", "measure", "verdict"]

_CHAOS = 0.1  # share of the variance from which starts count
_LEAVES_NOTHING = 0.01  # share of the variance with fixed input below which inputs make all of it
_CLOSED = 1e-6  # of all energy that is turned over: how well the balance must close
_AT = 1.0  # beta


@dataclass(frozen=True)
class Work:
    """The study of work, and the spread of the real body's."""

    study: Study
    body: Spread


def measure(asked: Asked) -> Work:
    """Everything, of the default bodies and of the real one."""
    size = QUICK if asked.quick else FULL
    return Work(measure_work(size), spread_of(Case(BODY.groups), size))


def verdict(spreads: Mapping[str, Spread]) -> Verdict:
    """Of C10, by the share that starts have in the variance, and by whether work varies less without the lag."""
    usual = spreads["as it is"].parts
    anywhere = spreads["nearly undamped, stiff"].parts
    by_lag = compare(spreads["lag made fast"], spreads["as it is"])[2] < 1.0
    by_chaos = usual.low > _CHAOS
    if by_chaos and by_lag:
        return "reproduced"
    if by_chaos or by_lag or anywhere.low > _CHAOS:
        return "reproduced in part"
    return "overturned" if usual.high < _LEAVES_NOTHING else "not reproduced"


def claim(work: Work) -> Claim:
    """C10, decided."""
    study, spreads = work.study, work.study.spreads
    usual, fast, slow, wild, held = (
        spreads[name]
        for name in ("as it is", "lag made fast", "lag made slow", "nearly undamped, stiff", "anchored, chaotic")
    )
    free = spreads["friction absent"]
    residual = max(study.residual, *(each.residual for each in spreads.values()))
    conserving, crawler = study.conserving[_AT], study.crawler[_AT]
    ends = [study.crawler[beta].free_energy for beta in (BETAS[0], BETAS[-1])]
    return Claim(
        "C10",
        verdict(spreads),
        f"It is the inputs that spread the work, by {usual.relative:.0%} of its mean: under one input, starts far "
        f"apart leave {usual.parts.share:.1g} of the variance on the ground, {wild.parts.share:.1g} at a damping "
        f"ratio of 0.002 and Pi1 = 2000, and {held.parts.share:.2f} where the body is anchored and chaotic and nothing "
        f"sticks or slips. The lag changes what inputs do: {fast.relative:.0%} of the mean with a fast one and "
        f"{slow.relative:.0%} with a slow one, of which there is less work; without friction it is "
        f"{free.relative:.0%}. The balance closes to {residual:.0e}"
        f"{'' if residual < _CLOSED else ', which is not enough'}, and every cycle from rest loses "
        f"{study.least_loss:.2g} at least; <W_diss> >= 0 alone says nothing, since it holds of any numbers. "
        f"Jarzynski's average gives no free energy here, where beta is no temperature: {ends[0]:.2f} at beta = "
        f"{BETAS[0]} and {ends[1]:.2f} at {BETAS[-1]:g}, while nothing is stored. Of a body that conserves energy, "
        f"started at exp(-beta H), it is 1 as it must be: {conserving.mean:.3f} at beta = {_AT:g}.",
        {f"share of starts in the variance, {name}": _share(each) for name, each in spreads.items()}
        | {f"standard deviation over mean, {name}": Number(each.relative) for name, each in spreads.items()}
        | {
            f"the same, {name} over as it is": _compared(spreads[name], usual)
            for name in ("lag made fast", "lag made slow", "friction absent")
        }
        | {
            "residual of the balance": Number(residual),
            "least loss in a cycle from rest": Number(study.least_loss, unit="P_max A_0 z_c"),
            f"<exp(-beta W)>, beta = {_AT:g}, energy conserved": Number(conserving.mean, *conserving.interval),
            f"<exp(-beta W)>, beta = {_AT:g}, crawler": Number(crawler.mean, *crawler.interval),
        },
        "stickslip reproduce work",
        {
            "work a hold": Number(work.body.mean * BODY.scales.energy * 1e3, unit="mJ"),
            "length of a hold": Number(HOLD * BODY.scales.time, unit="s"),
            "standard deviation over runs": Number(work.body.deviation * BODY.scales.energy * 1e3, unit="mJ"),
            "share of starts in the variance": _share(work.body),
        },
    )


def _share(spread: Spread) -> Number:
    return Number(spread.parts.share, spread.parts.low, spread.parts.high)


def _compared(one: Spread, other: Spread) -> Number:
    return Number(*compare(one, other))
