"""What it costs to advance one hold by a call from Python, over a call that does nothing.

Three times are taken over the same holds: `call`, the environment's kernel called from Python once a hold;
`dispatch`, a compiled function with the same arguments and result that does nothing, called as often; `physics`, the
same kernel called from a compiled loop. What the call adds over the bare dispatch is ``call - dispatch - physics``;
with the physics of the hold itself it is ``call - dispatch``.
"""

from functools import cache, partial
from typing import Any

import numpy as np
from measuring import quartiles, take_turns
from numba import njit

from peer_solvers.problem import GROUPS, WORD
from stickslip.crawler import Scene
from stickslip.envs.stepping import rest, Stepper, stepper_for

__all__ = ["measure_calls"]

# Hold and tolerance: the trajectory's hold, and the environment's defaults.
CASES = ((1.0, 1e-3), (1.0, 1e-6), (0.5, 1e-6))


def measure_calls(rounds: int) -> list[dict[str, Any]]:
    """Quartiles in microseconds a hold, a dictionary a case."""
    results = []
    for hold, tolerance in CASES:
        stepper = stepper_for(GROUPS, Scene(), hold, tolerance, 1)
        works = {
            "call": partial(_from_python, stepper.hold_valve, stepper),
            "dispatch": partial(_from_python, _nothing, stepper),
            "physics": partial(_from_compiled, _all_holds(stepper.hold_valve), stepper),
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


def _from_python(kernel, stepper: Stepper) -> None:
    body, samples, observation = _arrays()
    for command in WORD.tolist():
        kernel(body, stepper.fixed, command, samples, stepper.workspace, observation)


def _from_compiled(all_holds, stepper: Stepper) -> None:
    body, samples, observation = _arrays()
    all_holds(body, stepper.fixed, WORD, samples, stepper.workspace, observation)


def _arrays():
    return rest(), np.empty((5, 1)), np.empty(5, np.float32)


# Neither is cached on disk: numba would go on using the kernel that it saw first.
@njit(nogil=True, error_model="numpy")
def _nothing(body, fixed, valve, samples, workspace, observation):
    return 0, 0.0


@cache
def _all_holds(hold_valve):
    @njit(nogil=True, error_model="numpy")
    def all_holds(body, fixed, word, samples, workspace, observation):
        for command in word:
            hold_valve(body, fixed, int(command), samples, workspace, observation)

    return all_holds
