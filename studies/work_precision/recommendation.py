"""Which solver and tolerance to use for the error that is wanted."""

from dataclasses import dataclass

from ...common.validation import number_within
from .measurement import Row, WorkPrecision

__all__ = ["Recommendation", "recommend"]


@dataclass(frozen=True)
class Recommendation:
    """What to ask for, and what its neighbours come to.

    Attributes
    ----------
    wanted : float
    row : Row or None
        None where nothing measured meets `wanted`.
    looser, tighter : Row or None
        The same solver at the neighbouring tolerances, where they were measured.
    sentence : str
        The recommendation in words, with its numbers.
    """

    wanted: float
    row: Row | None
    looser: Row | None
    tighter: Row | None
    sentence: str


def recommend(study: WorkPrecision, wanted: float = 1e-6) -> Recommendation:
    """Choose the cheapest solver and tolerance whose error is at most `wanted` and whose slip count is right.

    Every tighter tolerance of that solver must do as well: one that is right by luck is not recommended. Where
    statistics are compared, an error that cannot be told from none is small enough.

    Parameters
    ----------
    study : WorkPrecision
    wanted : float, in (0, inf)
        Natural units, for every quantity compared.

    Returns
    -------
    Recommendation

    Raises
    ------
    ValueError, TypeError
        If `wanted` is no such number.
    """
    wanted = number_within("error", wanted, "(0, inf)")
    good = [row for row in study.rows if _reliable(study, row, wanted)]
    if not good:
        return Recommendation(wanted, None, None, None, _refusal(study, wanted))
    row = min(good, key=lambda each: each.timing.median)
    mine = [each for each in study.rows if each.solver == row.solver]
    place = mine.index(row)
    looser = mine[place - 1] if place > 0 else None
    tighter = mine[place + 1] if place + 1 < len(mine) else None
    return Recommendation(wanted, row, looser, tighter, _sentence(study, wanted, row, looser, tighter))


def _meets(study: WorkPrecision, row: Row, wanted: float) -> bool:
    """Whether a row's errors and slips are as wanted."""
    floors = study.reference.floors
    largest = {name: wanted if study.reference.comparable else max(wanted, floors[name]) for name in floors}
    return row.slips_agree and all(study.error(row, name) <= limit for name, limit in largest.items())


def _reliable(study: WorkPrecision, row: Row, wanted: float) -> bool:
    """Whether a row is as wanted, and not by luck."""
    mine = [each for each in study.rows if each.solver == row.solver]
    return all(_meets(study, each, wanted) for each in mine[mine.index(row) :])


def _sentence(study: WorkPrecision, wanted: float, row: Row, looser: Row | None, tighter: Row | None) -> str:
    """The recommendation in words."""
    kept = ", ".join(f"{name} to {study.error(row, name):.1e}" for name in row.errors)
    if study.reference.comparable:
        aim = f"For an error of {wanted:g}"
        kept += f" and all {row.slips} slips" if row.slips else ""
    else:
        aim = "For statistics that cannot be told from the reference's"
    words = [f"{aim} use {row.name}: {kept}, at {row.timing.median:.2f} µs per time unit."]
    neighbours = []
    for name, other in (("looser", looser), ("tighter", tighter)):
        if other is not None:
            ratio = other.timing.median / row.timing.median
            cost = f"takes {ratio:.2f} times the time"
            neighbours.append(f"{name} ({other.tolerance:.0e}) {_errs(study, other)} and {cost}")
    if neighbours:
        words.append("One step " + "; one step ".join(neighbours) + ".")
    return " ".join(words)


def _refusal(study: WorkPrecision, wanted: float) -> str:
    """Why nothing is recommended, in words."""
    floor = max(study.reference.floors.values())
    if study.reference.comparable and floor > wanted:
        return f"No error of {wanted:g} can be told here: the reference itself is known to {floor:.1e} only."
    failing = [row for row in study.rows if not _meets(study, row, wanted)]
    best = min(failing, key=lambda row: (not row.slips_agree, study.largest_error(row)))
    return f"Nothing measured keeps to an error of {wanted:g}: the best, {best.name}, {_errs(study, best)}."


def _errs(study: WorkPrecision, row: Row) -> str:
    """What a row errs by."""
    wrong = "" if row.slips_agree else f", has {row.slips} slips instead of {study.reference.trajectory.slips}"
    return f"errs by {study.largest_error(row):.1e}{wrong}"
