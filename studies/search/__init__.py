"""A search for the reservoir that does best at a task, on data that no test ever scores."""

from .evolution import Evaluation, Found, held_out_scores, search
from .space import body_space, Choice, crawler_space, echo_state_space, Range, Space

__all__ = [
    "Choice",
    "Evaluation",
    "Found",
    "Range",
    "Space",
    "body_space",
    "crawler_space",
    "echo_state_space",
    "held_out_scores",
    "search",
]
