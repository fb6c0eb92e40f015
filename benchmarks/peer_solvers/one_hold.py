"""What it costs to advance one hold by a call from Python, over a call that does nothing.

Three times are taken over the same holds: `call`, the environment's kernel called from Python once a hold;
`dispatch`, a compiled function with the same arguments and result that does nothing, called as often; `physics`, the
same kernel called from a compiled loop. What the call adds over the bare dispatch is ``call - dispatch - physics``;
with the physics of the hold itself it is ``call - dispatch``.
"""

from functools import partial
from typing import Any

import numpy as np
from measuring import quartiles, take_turns
from numba import njit

from peer_solvers.problem import GROUPS, WORD
from stickslip.crawler import Scene
from stickslip.crawler.taylor import ROWS, WIDTH
from stickslip.envs.stepping import hold_valve, rest, settings

__all__ = ["measure_calls"]

# Hold and tolerance: the trajectory's hold, and the environment's defaults.
CASES = ((1.0, 1e-3), (1.0, 1e-6), (0.5, 1e-6))


def measure_calls(rounds: int) -> list[dict[str, Any]]:
    """Quartiles in microseconds a hold, a dictionary a case."""
    results = []
    for hold, tolerance in CASES:
        fixed = settings(GROUPS, Scene(), hold, tolerance)
        works = {
            "call": partial(_from_python, hold_valve, fixed),
            "dispatch": partial(_from_python, _nothing, fixed),
            "physics": partial(_from_compiled, fixed),
        }
        for work in works.values():
            work()  # compiles
        times = take_turns(works, rounds)
        call, dispatch, physics = (np.array(list(times[name].values())) * 1e6 / len(WORD) for name in works)
        columns = {
            "call": call,
            "dispatch": dispatch,
            "physics": physics,
            "call less dispatch": call - dispatch,
            "call less dispatch and physics": call - dispatch - physics,
        }
        named = {name: quartiles(column) for name, column in columns.items()}
        results.append({"hold": hold, "tolerance": tolerance, **named})
    return results


def _from_python(kernel, fixed) -> None:
    body, samples, series, observation = _arrays()
    for command in WORD.tolist():
        kernel(body, fixed, command, samples, series, observation)


def _from_compiled(fixed) -> None:
    body, samples, series, observation = _arrays()
    _all_holds(body, fixed, WORD, samples, series, observation)


def _arrays():
    return rest(), np.empty((5, 1)), np.empty((ROWS, WIDTH)), np.empty(5, np.float32)


# Neither is cached on disk: numba would go on using the kernel that it saw first.
@njit(nogil=True, error_model="numpy")
def _nothing(body, fixed, valve, samples, series, observation):
    return 0, 0.0


@njit(nogil=True, error_model="numpy")
def _all_holds(body, fixed, word, samples, series, observation):
    for command in word:
        hold_valve(body, fixed, int(command), samples, series, observation)
