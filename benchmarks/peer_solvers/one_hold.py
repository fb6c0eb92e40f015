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
from stickslip.envs.observation import seen_at_rest
from stickslip.envs.settings import Settings
from stickslip.envs.single_kernel import ANSWERS, NO_MEMORY, rest, samples_of, Stepper, stepper_for

__all__ = ["measure_calls"]

# Hold and tolerance: the trajectory's hold, and the environment's defaults.
CASES = ((1.0, 1e-3), (1.0, 1e-6), (0.5, 1e-6))


def measure_calls(rounds: int) -> list[dict[str, Any]]:
    """Quartiles in microseconds a hold, a dictionary a case."""
    results = []
    for hold, tolerance in CASES:
        settings = Settings.of(groups=GROUPS, hold=hold, tolerance=tolerance, dither=0.0, memory_weight=0.0)
        stepper = stepper_for(settings, GROUPS, Scene())
        works = {
            "call": partial(_from_python, stepper.step, stepper),
            "dispatch": partial(_from_python, _nothing, stepper),
            "physics": partial(_from_compiled, _all_holds(stepper.step), stepper),
        }
        for work in works.values():
            work()  # compiles
        times = take_turns(works, rounds)
        call, dispatch, coefficients = (np.array(list(times[name].values())) * 1e6 / len(WORD) for name in works)
        columns = {
            "call": call,
            "dispatch": dispatch,
            "physics": coefficients,
            "call less dispatch": call - dispatch,
            "call less dispatch and physics": call - dispatch - coefficients,
        }
        named = {name: quartiles(column) for name, column in columns.items()}
        results.append({"hold": hold, "tolerance": tolerance, **named})
    return results


def _from_python(kernel, stepper: Stepper) -> None:
    body, *rest_of = _arrays(stepper)
    for command in WORD.tolist():
        kernel(body, stepper.fixed, command, 0, 0, *rest_of, 0)


def _from_compiled(all_holds, stepper: Stepper) -> None:
    body, *rest_of = _arrays(stepper)
    all_holds(body, stepper.fixed, WORD, *rest_of)


def _arrays(stepper: Stepper):
    return rest(), samples_of(1), stepper.workspace, seen_at_rest(1), np.empty(ANSWERS), *NO_MEMORY


# Neither is cached on disk: numba would go on using the kernel that it saw first.
@njit(nogil=True, error_model="numpy")
def _nothing(body, fixed, valve, _, __, samples, workspace, observation, told, w, c, h, r, seen):
    return 0


@cache
def _all_holds(step):
    @njit(nogil=True, error_model="numpy")
    def all_holds(body, fixed, word, samples, workspace, observation, told, w, c, h, r):
        for command in word:
            step(body, fixed, int(command), 0, 0, samples, workspace, observation, told, w, c, h, r, 0)

    return all_holds
