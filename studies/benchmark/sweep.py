"""One number of the crawler swept: a body for each of its values."""

from collections.abc import Sequence

from ...common.validation import known_names
from ...crawler.model.variations import VARIED, with_amplitude
from ...tasks.reservoirs import BodyReservoir

__all__ = ["SWEPT", "parse_sweep", "with_amplitude", "with_value"]

SWEPT = tuple(VARIED)
"""What can be swept: the hold, the amplitude of the pressure, every dimensionless group, and the slope."""


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


def parse_sweep(text: str) -> tuple[str, Sequence[float]]:
    """Name and values of a sweep written as ``hold=0.25,0.5,1``.

    Raises
    ------
    ValueError
        If the text is not so written, the name unknown, or the values are fewer than two or repeat.
    """
    name, equals, values = text.partition("=")
    try:
        numbers = [float(value) for value in values.split(",")]
    except ValueError:
        numbers = []
    if not equals or len(numbers) < 2 or len(set(numbers)) < len(numbers):
        raise ValueError(f"sweep must be a name and two or more distinct values such as 'hold=0.25,0.5', got {text!r}")
    known_names("sweep", [name], SWEPT)
    return name, sorted(numbers)
