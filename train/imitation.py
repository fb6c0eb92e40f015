"""A network fitted to what a teacher commands."""

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..common.extras import optional_import

with optional_import():
    import torch
    from torch import nn

if TYPE_CHECKING:
    from torch.optim import Optimizer

__all__ = ["CRAWLERS", "fit", "optimizer_of"]

CRAWLERS = 64
"""Bodies that a teacher is seen to crawl with."""

_BATCH = 1024
_LEARNING_RATE = 3e-3


def optimizer_of(parameters: "Iterable[nn.Parameter]") -> "Optimizer":
    """What changes the weights of a pupil."""
    return torch.optim.Adam(parameters, _LEARNING_RATE)


def fit(
    logits: "Callable[[torch.Tensor], torch.Tensor]",
    optimizer: "Optimizer",
    seen: NDArray[np.float32],
    wanted: NDArray[np.int64],
    updates: int,
    generator: np.random.Generator,
    *,
    smoothing: float = 0.0,
) -> None:
    """Teach a pupil to command in the states that were seen what was wanted there.

    Parameters
    ----------
    logits : callable
        The pupil's, from states (n, d) to (n, 2).
    optimizer : Optimizer
        Of its weights.
    seen : (m, d) array
    wanted : (m,) array of 0 and 1
    updates : int
        Gradient steps, of a batch each.
    generator : Generator
        Which draws the batches.
    smoothing : float, in [0, 1]
        Share of the wanted chances that is spread over both commands.
    """
    for _ in range(updates):
        chosen = generator.integers(len(seen), size=_BATCH)
        loss = nn.functional.cross_entropy(
            logits(torch.from_numpy(seen[chosen])), torch.from_numpy(wanted[chosen]), label_smoothing=smoothing
        )
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
