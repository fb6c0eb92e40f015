"""What drives what: reservoirs as functions from a series in [0, 1] to states, one row a sample.

Each call starts at rest: nothing of one series is left in the next.
"""

from .baselines import DelayLine, EchoState
from .body import body_states, BodyReservoir, crawler_states, READINGS
from .known import known_reservoirs, RESERVOIRS
from .reservoir import Reservoir, Step

__all__ = [
    "READINGS",
    "RESERVOIRS",
    "BodyReservoir",
    "DelayLine",
    "EchoState",
    "Reservoir",
    "Step",
    "body_states",
    "crawler_states",
    "known_reservoirs",
]
