"""What drives the valve: a word of commands repeated for ever, each flipped with a probability."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.validation import number_within
from ...tasks import innovation
from ...train.schedules import repeat

__all__ = ["Driving", "Inputs"]

_FORMS = "'bits', 'bernoulli:PROBABILITY', 'word:BITS' or 'word:BITS:DITHER'"


class Driving(NamedTuple):
    """One input from an ensemble."""

    valve: NDArray[np.int64]
    """(holds,) of 0 and 1."""
    message: NDArray[np.float64]
    """(holds,): what of the valve was news, see `stickslip.tasks.innovation`; all zeros without dither."""


@dataclass(frozen=True)
class Inputs:
    """An ensemble of inputs: the valve obeys a word but for flips.

    Fair bits are any word at dither 1/2, and bits of another probability a word of one letter at another dither.

    Attributes
    ----------
    word : str
        Of 0 and 1, repeated for ever.
    dither : float, in [0, 1/2]
        Probability of each flip.

    Raises
    ------
    ValueError, TypeError
        If an attribute is invalid.
    """

    word: str = "0"
    dither: float = 0.5

    def __post_init__(self) -> None:
        repeat(self.word, 1)
        object.__setattr__(self, "dither", number_within("dither", self.dither, "[0, 0.5]"))

    @classmethod
    def of(cls, choice: "Inputs | str") -> "Inputs":
        """Inputs from text, or themselves.

        Parameters
        ----------
        choice : Inputs or str
            "bits" for fair bits, "bernoulli:0.3" for bits of that probability, "word:0011:0.1" for a word and its
            dither, "word:0011" for a word without.

        Raises
        ------
        ValueError
            If the text is none of these.
        """
        if isinstance(choice, cls):
            return choice
        kind, *numbers = str(choice).split(":")
        try:
            if (kind, len(numbers)) == ("bits", 0):
                return cls()
            if (kind, len(numbers)) == ("bernoulli", 1):
                probability = number_within("probability", float(numbers[0]), "(0, 1)")
                return cls("0", probability) if probability <= 0.5 else cls("1", 1.0 - probability)
            if kind == "word" and len(numbers) in (1, 2):
                return cls(numbers[0], *map(float, numbers[1:] or "0"))
        except ValueError as error:
            raise ValueError(f"inputs must be {_FORMS}, got {choice!r}: {error}") from None
        raise ValueError(f"inputs must be {_FORMS}, got {choice!r}")

    def drawn(self, holds: int, seed: int) -> Driving:
        """The input of a seed."""
        command, valve = repeat(self.word, holds, dither=self.dither, seed=seed)
        message = innovation(valve, command, self.dither) if self.dither else np.zeros(holds)
        return Driving(valve, message)
