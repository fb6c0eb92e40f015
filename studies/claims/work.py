"""C10: what spreads the work over an ensemble, and what Jarzynski's average says of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..work.study import BETAS, Case, compare, COMPARED, COUNTS, FULL, HOLD, QUICK, Spread, spread_of, Study
from ..work.study import measure as measure_work
from .asked import Asked
from .claim import Claim, Number, Verdict
from .real_body import BODY

__all__ = ["Work", "claim", "measure", "verdict"]

_CHAOS = 0.1  # share of the variance from which starts count
_LEAVES_NOTHING = 0.01  # share of the variance with fixed input below which inputs make all of it
_SAME = 0.95  # of the spread with the lag: what is left without it from which the lag counts for nothing
_NOTHING = 0.005  # share that is not worth a word
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
    if by_chaos or by_lag or spreads["nearly undamped and stiff"].parts.low > _CHAOS:
        return "reproduced in part"
    neither = by_lag is False and spreads["as it is"].parts.high < _LEAVES_NOTHING
    return "overturned" if neither else "not reproduced"


def _by_chaos(spreads: Mapping[str, Spread]) -> bool:
    return spreads["as it is"].parts.low > _CHAOS


def _by_lag(spreads: Mapping[str, Spread]) -> bool | None:
    """Whether the lag spreads the work; None where the interval does not tell."""
    _, low, high = compare(spreads["lag made fast"], spreads["as it is"])
    if high < 1.0:
        return True
    return False if low > _SAME else None


def claim(work: Work) -> Claim:
    """C10, decided."""
    study, spreads = work.study, work.study.spreads
    ratios = {name: Number(*compare(spreads[name], spreads[other])) for name, other in COMPARED.items()}
    conserving, crawler = study.conserving[_AT], study.crawler[_AT]
    return Claim(
        "C10",
        verdict(spreads),
        _sentence(spreads, ratios),
        {f"work a hold (P_max A_0 z_c), {name}": Number(*each.mean_work) for name, each in spreads.items()}
        | {f"spread (standard deviation over mean), {name}": Number(*each.relative) for name, each in spreads.items()}
        | {f"taken by the elastomer, {name}": Number(each.viscous) for name, each in spreads.items()}
        | {f"taken by the ground, {name}": Number(each.friction) for name, each in spreads.items()}
        | {f"spread of {name} over that of {COMPARED[name]}": ratio for name, ratio in ratios.items()}
        | {"inputs under which each spread is measured": Number(spreads["as it is"].by_input.size)}
        | {f"share of starts in the variance, {name}": _share(each) for name, each in spreads.items()}
        | {
            "residual of the balance": Number(_residual(study)),
            "least loss in a cycle from rest": Number(study.least_loss, unit="P_max A_0 z_c"),
            f"mean of exp(-beta W), beta = {_AT:g}, energy conserved": Number(conserving.mean, *conserving.interval),
            f"mean of exp(-beta W), beta = {_AT:g}, crawler": Number(crawler.mean, *crawler.interval),
            "least W_diss over all beta, crawler": Number(
                min(each.dissipated for each in study.crawler.values()), unit="P_max A_0 z_c"
            ),
        }
        | {
            f"free energy by the average, beta = {beta:g}, {count} runs": Number(
                *study.by_count[beta, count].free_energies, unit="P_max A_0 z_c"
            )
            for beta in (_AT, BETAS[-1])
            for count in (*COUNTS[::2], COUNTS[-1])
            if (beta, count) in study.by_count
        }
        | {
            f"runs that carry the average, of {study.cycles.size}, beta = {beta:g}, crawler": Number(
                study.crawler[beta].samples
            )
            for beta in (BETAS[0], _AT, BETAS[-1])
        },
        "stickslip reproduce work",
        {
            "work a hold": Number(work.body.mean_work[0] * BODY.scales.energy * 1e3, unit="mJ"),
            "length of a hold": Number(HOLD * BODY.scales.time, unit="s"),
            "standard deviation over runs": Number(work.body.deviation * BODY.scales.energy * 1e3, unit="mJ"),
            "share of starts in the variance": _share(work.body),
        },
        _remark(study),
    )


def _sentence(spreads: Mapping[str, Spread], ratios: Mapping[str, Number]) -> str:
    usual = spreads["as it is"]
    lag = {True: "adds to it", False: "does not", None: "cannot be told to"}[_by_lag(spreads)]
    return (
        f"Under random bits the work varies by {usual.relative[0]:.1%} of its mean: a lag made fast leaves "
        f"{ratios['lag made fast']} of that, friction absent {ratios['friction absent']} and friction made smooth "
        f"{ratios['slides back on smooth friction']}, while starts make {_of_starts(usual)} of the variance; so "
        f"the lag {lag}, and stick-slip chaos {'does' if _by_chaos(spreads) else 'does not'}."
    )


def _remark(study: Study) -> str:
    wild, held = (study.spreads[name] for name in ("nearly undamped and stiff", "anchored and chaotic"))
    free = {beta: Number(*study.crawler[beta].free_energies) for beta in (BETAS[0], BETAS[-1])}
    return (
        f"Starts make {_of_starts(wild)} of the variance at a damping ratio of 0.002 and Pi1 = 2000, and "
        f"{_of_starts(held)} anchored and chaotic, where nothing sticks or slips. The balance of energy "
        f"{'closes' if _residual(study) < _CLOSED else 'does not close'}. Jarzynski's average gives no free energy, "
        f"since beta is no temperature here: it comes to {free[BETAS[0]]} at beta = {BETAS[0]} and to "
        f"{free[BETAS[-1]]} at {BETAS[-1]:g}, where {study.crawler[BETAS[-1]].samples:.0f} of {study.cycles.size} runs "
        f"carry it, while nothing is stored."
    )


def _of_starts(spread: Spread) -> str:
    return f"{spread.parts.share:.2f}" if spread.parts.share > _NOTHING else "nothing"


def _residual(study: Study) -> float:
    return max(study.residual, *(each.residual for each in study.spreads.values()))


def _share(spread: Spread) -> Number:
    return Number(spread.parts.share, spread.parts.low, spread.parts.high)
