"""What a reservoir is to a task: a function from a series to states, one row a sample."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Reservoir", "Step"]

Reservoir = Callable[[NDArray[Any], int], NDArray[np.float64]]
"""Takes a series (length,) in [0, 1] and a seed for what in it is random; gives states (length, features).

One that has `candidates`, a sequence of reservoirs, is tuned by the benchmark, on training data alone. One that has
`on_grounds`, as :class:`BodyReservoir` has, can tell the ground it crawls on. One that has `stepper`, a function of a
series and a seed that gives a :data:`Step`, is stepped on from the end of that series and not driven anew.
"""

Step = Callable[[float], NDArray[np.float64]]
"""Takes the next sample of a series, in [0, 1], and gives the states (features,) that have absorbed it."""
