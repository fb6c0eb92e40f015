"""A schedule for a real valve: seconds and volts instead of natural time and bits."""

import csv
import io
import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.files import write_text
from ..common.validation import number_within
from ..crawler import Actuator
from ..envs import StickSlipCrawlerEnv
from .evaluation import roll_out
from .policies.policy import Policy
from .schedules import repeat
from .scores import judging

__all__ = ["FORMAT", "Played", "play_policy", "play_word", "played", "write_csv", "write_json"]

FORMAT = "stickslip schedule 1"


class Played(NamedTuple):
    """When a valve turns, and to which voltage: each row holds until the next one, and the last one shuts the valve."""

    time: NDArray[np.float64]
    """Of shape (holds + 1,), s."""
    volts: NDArray[np.float64]
    """Of shape (holds + 1,)."""
    valve: NDArray[np.int64]
    """Of shape (holds + 1,), 0 or 1."""
    command: NDArray[np.int64]
    """Of shape (holds + 1,), 0 or 1: what `valve` would be without flips."""


def played(
    command: NDArray[np.int64],
    valve: NDArray[np.int64],
    hold: float,
    actuator: Actuator,
    *,
    open_volts: float = 24.0,
    shut_volts: float = 0.0,
) -> Played:
    """Give a schedule the units of a body and its valve.

    Parameters
    ----------
    command, valve : (holds,) arrays of 0 and 1
        What was asked for, and what came of it.
    hold : float, > 0
        Length of a hold, natural time.
    actuator : Actuator
        Whose natural time is sqrt(M / k_1) seconds.
    open_volts, shut_volts : float
        Of the valve's coil.

    Returns
    -------
    Played

    Raises
    ------
    ValueError, TypeError
        If a number is not finite, or the hold not positive.
    """
    voltages = [
        number_within(name, value, "(-inf, inf)")
        for name, value in (("shut_volts", shut_volts), ("open_volts", open_volts))
    ]
    seconds = number_within("hold", hold, "(0, inf)") * actuator.scales.time
    came, asked = (np.append(np.asarray(bits, np.int64), 0) for bits in (valve, command))
    return Played(np.arange(len(came), dtype=np.float64) * np.float64(seconds), np.array(voltages)[came], came, asked)


def play_word(
    word: str,
    *,
    holds: int,
    hold: float = 0.5,
    dither: float = 0.0,
    seed: int = 0,
    actuator: Actuator | None = None,
    **volts: float,
) -> Played:
    """A word repeated for a number of holds, in the units of a body: see `played`.

    Parameters
    ----------
    word : str
        Such as "11100".
    holds : int, >= 1
    hold : float, > 0
        Natural time.
    dither : float, in [0, 1/2]
        Probability of a flip.
    seed : int
        Of the flips.
    actuator : Actuator, optional
        `Actuator.ecoflex` by default.
    **volts
        As for `played`.

    Returns
    -------
    Played
    """
    command, valve = repeat(word, holds, dither=dither, seed=seed)
    return played(command, valve, hold, Actuator.ecoflex() if actuator is None else actuator, **volts)


def play_policy(
    policy: Policy,
    *,
    holds: int,
    hold: float | None = None,
    dither: float | None = None,
    seed: int = 0,
    actuator: Actuator | None = None,
    **volts: float,
) -> Played:
    """What a policy does to a valve from rest on, as it sees a simulated body, in the units of that body.

    Parameters
    ----------
    policy : Policy
        That takes no weight; `Policy.at` makes one.
    holds : int, >= 1
    hold, dither : float, optional
        Those that it was trained with by default.
    seed : int
        Of the flips.
    actuator : Actuator, optional
        The body, whose groups are simulated; `Actuator.ecoflex` by default, if its groups are those of the training.
    **volts
        As for `played`.

    Returns
    -------
    Played

    Raises
    ------
    ValueError
        If an argument is out of range, or no actuator is given for groups other than the default ones.
    """
    given = {name: value for name, value in {"hold": hold, "dither": dither}.items() if value is not None}
    arguments = {**judging(policy.env_kwargs), **given}
    arguments.pop("randomize", None)
    trained = StickSlipCrawlerEnv(**arguments).settings.groups
    body = Actuator.ecoflex() if actuator is None else actuator
    if actuator is None and trained != body.groups:
        raise ValueError(f"actuator must be given for a policy of other groups than ecoflex's, it is of {trained}")
    environment = StickSlipCrawlerEnv(**{**arguments, "groups": body.groups})
    command, valve = roll_out(policy, environment, holds, seed)
    return played(command, valve, environment.settings.hold, body, **volts)


def write_csv(schedule: Played, file: Path) -> None:
    """Write a row for every hold, and one for the end: ``time_s``, ``volts``, ``valve``, ``command``.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(_COLUMNS)
    rows.writerows(zip(*(column.tolist() for column in schedule), strict=True))
    write_text(file, text.getvalue())


def write_json(schedule: Played, file: Path, actuator: Actuator, told: Mapping[str, Any]) -> None:
    """Write the same columns as arrays, with the actuator and what else there is to tell.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    columns = {name: column.tolist() for name, column in zip(_COLUMNS, schedule, strict=True)}
    text = json.dumps({"format": FORMAT, **told, "actuator": asdict(actuator), **columns}) + "\n"
    write_text(file, text)


_COLUMNS = ("time_s", "volts", "valve", "command")
