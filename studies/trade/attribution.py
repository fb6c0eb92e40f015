"""How much of a policy's memory is the body's, and how much the controller's.

A policy that sees the valve may write past flips into the body by its commands, and the readout finds them there. That
is memory of body and controller together. Cut the feedback: let the same commands act on fresh flips. Of those the
commands know nothing, and what is read of them the body alone has kept, under the very commands of the policy. The
difference is what the controller has added.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...envs.settings import Settings
from ...reservoir.bootstrap import Estimate, mean_over_runs
from .conditions import refuse_silence
from .judgement import judge, Judgement, Runs

__all__ = ["Attribution", "attribute", "feedback_cut"]

# The stream of fresh flips beside that of a seed's own.
_FRESH = 1


@dataclass(frozen=True, eq=False)
class Attribution:
    """Memory of policies as they are, and with their feedback cut.

    Attributes
    ----------
    closed : Judgement
        Of the policies.
    cut : Judgement
        Of their commands on fresh flips.
    """

    closed: Judgement
    cut: Judgement

    def body(self, name: str) -> Estimate:
        """Memory that the body has under the commands of a policy, and its interval over the seeds."""
        return self.cut.memory(name)

    def controller(self, name: str) -> Estimate:
        """Memory that the feedback adds, and its interval; below 0 where it costs some."""
        i = self.closed.names.index(name)
        return mean_over_runs(self.closed.memories[i] - self.cut.memories[i], bounds=(-np.inf, np.inf))


def attribute(names: Sequence[str], runs: Runs, settings: Settings, *, seeds: Sequence[int]) -> Attribution:
    """Measure policies with their feedback and without.

    Parameters
    ----------
    names, runs, settings, seeds
        As for `judge`; with dither.

    Returns
    -------
    Attribution

    Raises
    ------
    ValueError
        If there is no dither.
    """
    refuse_silence(settings)
    return Attribution(
        judge(names, runs, settings, seeds=seeds),
        judge(names, feedback_cut(runs, settings.dither), settings, seeds=seeds),
    )


def feedback_cut(runs: Runs, dither: float) -> Runs:
    """Runs of the same commands on flips of which they know nothing.

    Parameters
    ----------
    runs : callable
        As for `judge`.
    dither : float

    Returns
    -------
    callable
        Likewise.
    """

    def cut(seed: int) -> tuple[np.ndarray, np.ndarray]:
        commands, _ = runs(seed)
        return commands, commands ^ (np.random.default_rng([seed, _FRESH]).random(commands.shape) < dither)

    return cut
