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
    by_chaos, by_lag = _by_chaos(spreads), _by_lag(spreads)
    if by_chaos and by_lag:
        return "reproduced"
    if by_chaos or by_lag or spreads["nearly undamped, stiff"].parts.low > _CHAOS:
        return "reproduced in part"
    return "overturned" if spreads["as it is"].parts.high < _LEAVES_NOTHING else "not reproduced"


def _by_chaos(spreads: Mapping[str, Spread]) -> bool:
    return spreads["as it is"].parts.low > _CHAOS


def _by_lag(spreads: Mapping[str, Spread]) -> bool:
    return compare(spreads["lag made fast"], spreads["as it is"])[2] < 1.0


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
        f"Chaos {'spreads the work' if _by_chaos(spreads) else 'does not'}, the lag "
        f"{'does' if _by_lag(spreads) else 'does not'}, and inputs do: under random bits work varies by "
        f"{usual.relative:.0%} of its mean, {fast.relative:.0%} with a fast lag, {slow.relative:.0%} with a slow one, "
        f"{free.relative:.0%} without friction, and under one input starts far apart leave {usual.parts.share:.1g} of "
        f"that variance on the ground, {wild.parts.share:.1g} at a damping ratio of 0.002 and Pi1 = 2000, and "
        f"{held.parts.share:.2f} anchored and chaotic, where nothing sticks or slips. The balance of energy "
        f"{'closes' if residual < _CLOSED else 'does not close'}. Jarzynski's average gives no free energy, since beta "
        f"is no temperature: {ends[0]:.2f} at beta = {BETAS[0]} and {ends[1]:.2f} at {BETAS[-1]:g}, while nothing is "
        f"stored.",
        {f"share of starts in the variance, {name}": _share(each) for name, each in spreads.items()}
        | {f"standard deviation over mean, {name}": Number(each.relative) for name, each in spreads.items()}
        | {
            f"the same, {name} over as it is": _compared(spreads[name], usual)
            for name in ("lag made fast", "lag made slow", "friction absent")
        }
        | {
            "residual of the balance": Number(residual),
            "least loss in a cycle from rest": Number(study.least_loss, unit="P_max A_0 z_c"),
            f"mean of exp(-beta W), beta = {_AT:g}, energy conserved": Number(conserving.mean, *conserving.interval),
            f"mean of exp(-beta W), beta = {_AT:g}, crawler": Number(crawler.mean, *crawler.interval),
            "least W_diss over all beta, crawler": Number(
                min(each.dissipated for each in study.crawler.values()), unit="P_max A_0 z_c"
            ),
        }
        | {
            f"runs that carry the average, of {study.cycles.size}, beta = {beta:g}, crawler": Number(
                study.crawler[beta].samples
            )
            for beta in (BETAS[0], _AT, BETAS[-1])
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
