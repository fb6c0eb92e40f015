"""Colours of the pictures: Okabe and Ito's, which all forms of colour vision tell apart, and greys for the rest."""

__all__ = [
    "AIR",
    "ELASTOMER",
    "GREY",
    "INK",
    "MESSAGE",
    "MIST",
    "PAPER",
    "SLIDING",
    "STICKING",
    "Colour",
    "mixed",
]

Colour = tuple[int, int, int]

PAPER: Colour = (255, 255, 255)
INK: Colour = (45, 52, 60)
GREY: Colour = (110, 117, 125)
MIST: Colour = (224, 228, 232)
ELASTOMER: Colour = (246, 243, 236)
AIR: Colour = (86, 180, 233)
STICKING: Colour = (0, 114, 178)
SLIDING: Colour = (213, 94, 0)
MESSAGE: Colour = (0, 158, 115)


def mixed(first: Colour, second: Colour, share: float) -> Colour:
    """Colour between two, `share` of the way from the first."""
    red, green, blue = (round(a + (b - a) * share) for a, b in zip(first, second, strict=True))
    return red, green, blue
