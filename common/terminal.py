"""Output that a terminal's encoding cannot say."""

import codecs
import sys

__all__ = ["STAND_INS", "say_what_can_be_said"]

STAND_INS = {
    "±": "+-", "≤": "<=", "≥": ">=", "✗": "x", "×": "x", "µ": "u", "–": "-", "−": "-", "…": "...", "↑": "^", "↓": "v",
    "Π": "Pi", "λ": "lambda", "₁": "1", "₂": "2", "₄": "4",
}  # fmt: skip
"""ASCII for the signs that commands print."""

_ERRORS = "stickslip.stand_ins"


def _stand_in(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(STAND_INS.get(sign, "?") for sign in error.object[error.start : error.end]), error.end


codecs.register_error(_ERRORS, _stand_in)


def say_what_can_be_said() -> None:
    """Have this process print ASCII stand-ins, or question marks, for what its output cannot encode."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors=_ERRORS)
