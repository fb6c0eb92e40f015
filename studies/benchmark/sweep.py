"""One number of the crawler swept: a body for each of its values."""

from collections.abc import Mapping, Sequence

from ...common.validation import known_names, number_within
from ...crawler.model.variations import Range, VARIED, with_amplitude
from ...tasks.reservoirs import BodyReservoir

__all__ = ["SWEPT", "parse_sweep", "with_amplitude", "with_value"]

SWEPT = tuple(VARIED)
"""What can be swept: the hold, the amplitude of the pressure, every dimensionless group, and the slope."""

_MOST = 100_000  # values of a range


def with_value(body: BodyReservoir, name: str, value: float) -> BodyReservoir:
    """A body with one number changed.

    Parameters
    ----------
    body : BodyReservoir
    name : str
        One of `SWEPT`.
    value : float

    Returns
    -------
    BodyReservoir

    Raises
    ------
    ValueError
        If the name is unknown or the value out of range.
    """
    known_names("sweep", [name], SWEPT)
    return body.varied({name: value})


def parse_sweep(text: str, argument: str = "sweep", allowed: Mapping[str, str] = VARIED) -> tuple[str, Sequence[float]]:
    """Name and values of a sweep written as ``hold=0.25,0.5,1`` or ``deborah=0.05:8:64:log``.

    Parameters
    ----------
    text : str
        Values with commas between them; or the lowest, the highest and how many, evenly spread or, with ``:log``,
        evenly in their logarithms.
    argument : str
        What the caller calls it.
    allowed : mapping of str to str
        Names, and the interval that values of each must be in.

    Raises
    ------
    ValueError
        If the text is not so written, the name unknown, a range is upside down or leaves what is allowed, or the
        values are fewer than two or repeat.
    """
    name, equals, told = text.partition("=")
    if ":" in told:
        known_names(argument, [name], allowed)
        return name, _spread(told, f"{argument} {name}", allowed[name])
    try:
        numbers = [float(value) for value in told.split(",")]
    except ValueError:
        numbers = []
    if not equals or len(numbers) < 2 or len(set(numbers)) < len(numbers):
        raise ValueError(
            f"{argument} must be a name and two or more distinct values such as 'hold=0.25,0.5', got {text!r}"
        )
    known_names(argument, [name], allowed)
    return name, sorted(numbers)


def _spread(text: str, named: str, interval: str) -> list[float]:
    ends, log = text.split(":"), text.endswith(":log")
    try:
        low, high, count = float(ends[0]), float(ends[1]), int(ends[2])
    except (ValueError, IndexError):
        low, high, count = 0.0, 0.0, 0
    if len(ends) != 3 + log or not 2 <= count <= _MOST:
        raise ValueError(
            f"{named} must be low:high:count or low:high:count:log with a count in [2, {_MOST}], got {text!r}"
        )
    for end in (low, high):
        number_within(named, end, interval)
    if not low < high:
        raise ValueError(f"{named} must rise from low to high, got {text!r}")
    if log and low <= 0.0:
        raise ValueError(f"{named} must be above 0 to be spread in logarithms, got {text!r}")
    spread = Range(low, high, log)
    return [spread.at(k / (count - 1)) for k in range(count - 1)] + [high]
