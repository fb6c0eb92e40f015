"""Which word the valve should follow next, to tell most of a body: optimal design by sensitivities.

What a run would tell is its information matrix, the sum of the squares of the sensitivities over those of the noise
(V. V. Fedorov, Theory of Optimal Experiments, Academic Press 1972). The best word makes the variance of one parameter
least, given what is known already (c-optimality), or the volume of the ellipsoid of all (D-optimality). Short words are
all tried; of longer ones random words are improved a hold at a time (coordinate exchange: R. K. Meyer and C. J.
Nachtsheim, Technometrics 37 (1995) 60).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.validation import different_names, finite_array, known_names, number_within, whole_number
from ...crawler import Actuator, Groups, GroupsLike, Scene
from .measurements import CHANNELS, Measurements
from .prediction import slopes_of

__all__ = ["ALL", "Design", "best_word"]

ALL = "all"
"""The aim at all parameters at once."""
_TOLERANCE = 1e-9
_ALL_TRIED = 8  # holds up to which every word is
_LONGEST = 1000
_RANDOM = 31  # words that a word is compared with
_IMPROVED = 3  # of them
_ROUNDS = 5  # of exchanges through a word, at most


@dataclass(frozen=True, eq=False)
class Design:
    """A word, and what it would tell.

    Attributes
    ----------
    word : str
        Of 0 and 1, a hold each.
    aim : str
        The parameter that it tells most about, or "all".
    errors : dict of str to float
        Relative standard errors that would be left of the parameters, with what is known already.
    known : dict of str to float
        Those that are left now; 1 where nothing is known.
    random : dict of str to float
        Those that a random word would leave, in the median.
    """

    word: str
    aim: str
    errors: dict[str, float]
    known: dict[str, float]
    random: dict[str, float]


def best_word(
    body: GroupsLike,
    length: int,
    *,
    names: Sequence[str],
    noise: dict[str, float],
    hold: float,
    samples_per_hold: int = 8,
    covariance: NDArray[np.float64] | None = None,
    aim: str | None = None,
    scene: Scene | dict[str, Any] | None = None,
    seed: int = 0,
) -> Design:
    """The word that would tell most, run from rest, about a body that is roughly known.

    Parameters
    ----------
    body : Groups, preset, mapping or Actuator
        What is known of the body; SI goes with an `Actuator`.
    length : int, in [1, 1000]
        Holds of the word.
    names : sequence of str
        Parameters that are sought: fields of the body, none of which is 0 there.
    noise : dict of str to float
        Standard deviation of the errors of each channel that will be measured, see `CHANNELS`.
    hold : float
    samples_per_hold : int
    covariance : (names, names) array, optional
        Of what is known of the parameters, such as `Identification.covariance`; by default each is known to its size.
    aim : str, optional
        One of the names, or "all"; the one of which least is known by default: of which a random word would leave
        least known, where there is no covariance.
    scene : Scene or mapping, optional
        Any but a chain of heavy segments.
    seed : int
        Of the random words.

    Returns
    -------
    Design

    Raises
    ------
    ValueError, TypeError
        If an argument is out of its range or of the wrong type; the message names it.
    """
    length = whole_number("length", length, 1, _LONGEST)
    body = body if isinstance(body, Actuator) else Groups.of(body)
    each = whole_number("samples_per_hold", samples_per_hold, 1)
    hold = number_within("hold", hold, "(0, inf)")
    different_names("names", names, [name for name in body.__dataclass_fields__ if name != "segments"])
    known_names("noise", noise, CHANNELS)
    if not noise:
        raise ValueError(f"noise must have a positive number for each channel that is measured, got {noise}")
    for name, error in noise.items():
        number_within(f"noise of {name}", error, "(0, inf)")
    if aim is not None:
        known_names("aim", [aim], [*names, ALL])
    values = np.array([getattr(body, name) for name in names])
    if np.any(values == 0.0):
        raise ValueError(f"names must be of parameters other than 0, got {names[int(np.argmin(np.abs(values)))]}")
    # Relative to the parameters, of which each is known to its size at least.
    known = np.eye(len(names))
    if covariance is not None:
        given = finite_array("covariance", covariance, 2)
        if given.shape != known.shape:
            raise ValueError(f"covariance must have shape {known.shape}, a row and a column a name, got {given.shape}")
        known = known + np.linalg.pinv(given / np.outer(values, values), hermitian=True)
    ground = Scene.of(scene)

    def information(word: NDArray[np.int64]) -> NDArray[np.float64]:
        silent: dict[str, Any] = {name: np.zeros(length * each) for name in noise}
        run = Measurements(word.astype(np.float64), hold, each, **silent)
        told = known.copy()
        for name, slopes in slopes_of(body, run, ground, _TOLERANCE, names).items():
            relative = slopes * values / noise[name]
            told += relative.T @ relative
        return told

    def errors(told: NDArray[np.float64]) -> NDArray[np.float64]:
        found: NDArray[np.float64] = np.sqrt(np.diag(np.linalg.inv(told)))
        return found

    generator = np.random.default_rng(whole_number("seed", seed, 0))
    some = generator.integers(0, 2, (_RANDOM, length))
    told = [information(word) for word in some]
    random = np.median([errors(each) for each in told], axis=0)
    if aim is None:
        aim = names[int(np.argmax(random if covariance is None else errors(known)))]

    def cost(told: NDArray[np.float64]) -> float:
        """What is to be least."""
        return float(-np.linalg.slogdet(told)[1] if aim == ALL else errors(told)[list(names).index(aim)])

    if length <= _ALL_TRIED:
        every = np.array(list(product((0, 1), repeat=length)))
        costs = [cost(information(word)) for word in every]
        best = every[int(np.argmin(costs))]
    else:
        order = np.argsort([cost(each) for each in told])[:_IMPROVED]
        ends = [_exchanged(some[i], cost(told[i]), lambda word: cost(information(word))) for i in order]
        best = min(ends, key=lambda end: end[1])[0]
    return Design(
        word="".join(map(str, best.tolist())),
        aim=aim,
        errors=dict(zip(names, errors(information(best)).tolist(), strict=True)),
        known=dict(zip(names, errors(known).tolist(), strict=True)),
        random=dict(zip(names, random.tolist(), strict=True)),
    )


def _exchanged(word: NDArray[np.int64], cost: float, cost_of: Any) -> tuple[NDArray[np.int64], float]:
    """A word of which no single hold can be turned for the better, and its cost."""
    word, since = word.copy(), 0
    for k in range(_ROUNDS * len(word)):
        if since == len(word):
            break
        other = word.copy()
        other[k % len(word)] ^= 1
        here = cost_of(other)
        word, cost, since = (other, here, 0) if here < cost else (word, cost, since + 1)
    return word, cost
