"""One number of the crawler swept: a body for each of its values."""

from collections.abc import Sequence
from dataclasses import replace

from ...common.validation import known_names, number_within
from ...crawler import Groups, GroupsLike
from ...crawler.model.groups import RANGES
from ...tasks.reservoirs import BodyReservoir

__all__ = ["SWEPT", "parse_sweep", "with_amplitude", "with_value"]

SWEPT = ("hold", "amplitude", *RANGES)
"""What can be swept: the hold, the amplitude of the pressure, and every dimensionless group."""


def with_amplitude(groups: GroupsLike, amplitude: float) -> Groups:
    """The same body under so many times the peak pressure, in the units that go with it.

    Length, and with it force, is measured by the peak pressure: ``z_c = P_max A_0 / k_1``. So Pi1 = k_3 z_c^2 / k_1
    grows with its square, Pi5 = alpha z_c in proportion, and friction over P_max A_0 shrinks.

    Parameters
    ----------
    groups : Groups, str, mapping or Actuator
    amplitude : float, in (0, inf)
        Peak pressure, relative to that of `groups`.

    Returns
    -------
    Groups

    Raises
    ------
    ValueError
        If `amplitude` is out of range.
    """
    amplitude = number_within("amplitude", amplitude, "(0, inf)")
    groups = Groups.of(groups)
    return replace(
        groups,
        duffing=groups.duffing * amplitude**2,
        radial_coupling=groups.radial_coupling * amplitude,
        static_friction=groups.static_friction / amplitude,
        kinetic_friction=groups.kinetic_friction / amplitude,
    )


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
    if name == "hold":
        return replace(body, hold=value)
    if name == "amplitude":
        return replace(body, groups=with_amplitude(body.groups, value))
    return replace(body, groups=replace(body.groups, **{name: value}))


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
