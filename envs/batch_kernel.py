"""One step of many crawlers: compiled, in structures of arrays, eight crawlers side by side."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compiling.compilation import compiled, inlined
from ..compiling.generators import next_uniform
from ..compiling.vectors import aligned_zeros, LANES
from ..crawler import Groups
from ..crawler.batch.advance import advance_lanes
from ..crawler.model.columns import body_of, coefficients_at, Crawlers, Share
from ..crawler.model.state import Body, Coefficients, FOOT
from ..crawler.steps.options import FINISHED, Method, METHODS, Options
from ..reservoir.prequential_lanes import Readouts, score_lanes
from ..reservoir.targets import aimed, LONGEST, Target
from .infos import COUNTS, NUMBERS, write_counts, write_early_numbers, write_numbers
from .observation import observe, seen_at_rest
from .reward import reward, surprise
from .transition import Transition

__all__ = ["STEP_BATCH", "Batch", "Episode", "Results", "batch_of", "draw_shares"]

Array = NDArray[np.float64]


class Batch(NamedTuple):
    """State of n crawlers; `width` is n rounded up to an odd number of blocks of LANES."""

    bodies: Array  # (7, width): the fields of `Body`
    coefficients: Array  # (11, width): the fields of `Coefficients`
    samples: Array  # (3, samples, width): z, v, p in the last hold
    generators: NDArray[np.uint64]  # (2, n): where the random numbers come from, see `stickslip.compiling.generators`
    valves: NDArray[np.int64]  # (width,): in the last hold
    # (n,): valves of the last 64 holds, each a bit, the newest lowest; of none where only the newest is seen
    histories: NDArray[np.int64]
    starts: Array  # (width,): where the foot was before it
    scores: Array  # (width,): messages, then what they earned; of no matter without readouts
    recent: Array  # (n, 2, LONGEST): what messages other than innovations are made of; of none where they are these
    steps: NDArray[np.int64]  # (n,): of the episode


class Results(NamedTuple):
    """What a step answers, each of n."""

    observations: NDArray[np.float32]  # (n, observation)
    rewards: Array
    truncations: NDArray[np.bool_]
    numbers: Array  # (NUMBERS, the groups and the slope, n)
    counts: NDArray[np.int64]  # (COUNTS, n)
    statuses: NDArray[np.int8]
    elapsed: Array


class Episode(NamedTuple):
    """What is the same for all."""

    hold: float
    dither: float
    memory_weight: float
    longest: int  # steps of an episode
    target: Target


def batch_of(count: int, samples: int, valve_history: int, target: Target) -> tuple[Batch, Results]:
    """A batch of crawlers, and a place for its results, all zero."""
    # Rows that are a power of two apart would fall on the same places of the processor's cache.
    width = LANES * (-(-count // LANES) | 1)
    batch = Batch(
        aligned_zeros(len(Body._fields), width),
        aligned_zeros(len(Coefficients._fields), width),
        aligned_zeros(3, samples, width),
        np.zeros((2, count), np.uint64),
        np.zeros(width, np.int64),
        np.zeros(count if valve_history > 1 else 0, np.int64),
        aligned_zeros(width),
        aligned_zeros(width),
        np.zeros((count if target.kind else 0, 2, LONGEST)),
        np.zeros(count, np.int64),
    )
    results = Results(
        seen_at_rest(valve_history, count),
        np.zeros(count),
        np.zeros(count, np.bool_),
        np.zeros((len(NUMBERS) + len(Groups.__slots__) + 1, width + LANES))[:, :count],
        np.zeros((len(COUNTS), width + LANES), np.int64)[:, :count],
        np.zeros(count, np.int8),
        np.zeros(count),
    )
    return batch, results


@compiled
def draw_shares(sources: NDArray[np.uint64], who: NDArray[np.int64], shares: Array) -> None:
    """Draw numbers in [0, 1) for some crawlers, each its own from its own generator.

    Parameters
    ----------
    sources : (2, n) array
        Where each crawler's random numbers come from, see `stickslip.compiling.generators`.
    who : (m,) array
    shares : (k, m) array
        Receives k numbers of each.
    """
    for j in range(len(who)):
        for k in range(len(shares)):
            shares[k, j] = next_uniform(sources[0, who[j]], sources[1, who[j]])


def _stepper(method: type[Method]) -> Callable[..., None]:
    # A tuple costs microseconds to carry across the border between Python and compiled code, and a method is one.
    @compiled
    def step_batch(
        begin: int,
        end: int,
        opens: bool,
        closes: bool,
        commands: NDArray[np.int64],
        idle: NDArray[np.bool_],
        skipped: NDArray[np.bool_],
        batch: Batch,
        readouts: Readouts | None,
        episode: Episode,
        tolerance: float,
        order: int,
        max_steps: int,
        workspaces: Array,
        scratch: Array,
        results: Results,
    ) -> None:
        """Hold the valves of a slice of the batch for one step, in place.

        Parameters
        ----------
        begin, end : int
            The slice, which begins a block of LANES.
        opens, closes : bool
            Whether this is the first, and the last, of the methods that the slice needs.
        commands : (n,) array
            0 or 1.
        idle : (n,) array
            Crawlers that sit the step out, whose results are those of a reset.
        skipped : (n,) array
            Crawlers that this method does not move: the idle ones, and those of other methods.
        batch : Batch
        readouts : Readouts or None
            None where the dither is 0: there is no message, and nothing to score.
        episode : Episode
        tolerance, order, max_steps
            As in `Options`.
        workspaces : array
            As `advance_lanes` wants them.
        scratch : (2, features + 1, LANES) array
        results : Results
            Where a status is not FINISHED the rest is of the step before, and does not count.
        """
        if opens:
            _open(begin, end, commands, idle, batch, readouts, episode, results)
        bodies, coefficients, valves, samples = batch.bodies, batch.coefficients, batch.valves, batch.samples
        crawlers = Crawlers(bodies, coefficients, valves, samples, results.statuses, results.elapsed)
        options = Options(tolerance, order, max_steps, False, False, False, method())
        advance_lanes(crawlers, Share(begin, end, skipped), episode.hold, options, workspaces)
        if not closes:
            return
        if readouts is not None:
            for block in range(begin // LANES, (end + LANES - 1) // LANES):
                score_lanes(readouts, block, samples, block * LANES, bodies.shape[1], batch.scores, scratch)
        _close(begin, end, commands, idle, batch, readouts, episode, results)

    return step_batch


STEP_BATCH = {method: _stepper(method) for method in METHODS}


@inlined
def _open(
    begin: int,
    end: int,
    commands: NDArray[np.int64],
    idle: NDArray[np.bool_],
    batch: Batch,
    readouts: Readouts | None,
    episode: Episode,
    results: Results,
) -> None:
    """Turn the valves, as commanded or flipped, and write down what is known then."""
    dither, target = episode.dither, episode.target
    for i in range(begin, end):
        results.statuses[i] = FINISHED
        if idle[i]:
            continue
        valve = commands[i]
        if readouts is not None:
            function, generator = batch.generators[0, i], batch.generators[1, i]
            if function != 0 and next_uniform(function, generator) < dither:
                valve = 1 - valve
            message = surprise(valve, commands[i], dither)
            if len(batch.recent) > 0:
                message = aimed(target.kind, target.order, target.mean, batch.recent[i], message)
            batch.scores[i] = message
        batch.valves[i] = valve
        if len(batch.histories) > 0:
            batch.histories[i] = batch.histories[i] << 1 | valve
        batch.starts[i] = batch.bodies[FOOT, i]
        write_early_numbers(results.numbers[:, i], _transition(i, commands, batch, episode, 0.0))


@inlined
def _close(
    begin: int,
    end: int,
    commands: NDArray[np.int64],
    idle: NDArray[np.bool_],
    batch: Batch,
    readouts: Readouts | None,
    episode: Episode,
    results: Results,
) -> None:
    """Write down what the step came to."""
    for i in range(begin, end):
        if idle[i]:
            results.observations[i] = 0.0
            results.rewards[i] = 0.0
            results.truncations[i] = False
            continue
        if results.statuses[i] != FINISHED:
            continue
        step = _transition(i, commands, batch, episode, batch.scores[i] if readouts is not None else 0.0)
        batch.steps[i] += 1
        observe(results.observations[i], step)
        write_numbers(results.numbers[:, i], step)
        write_counts(results.counts[:, i], step)
        results.rewards[i] = reward(step)
        results.truncations[i] = batch.steps[i] >= episode.longest


@inlined
def _transition(i: int, commands: NDArray[np.int64], batch: Batch, episode: Episode, memory: float) -> Transition:
    """The step of a crawler as far as it has come."""
    return Transition(
        batch.starts[i],
        body_of(batch.bodies, i),
        coefficients_at(batch.coefficients, i),
        commands[i],
        batch.valves[i],
        batch.histories[i] if len(batch.histories) > 0 else batch.valves[i],
        episode.hold,
        episode.dither,
        episode.memory_weight,
        memory,
    )
