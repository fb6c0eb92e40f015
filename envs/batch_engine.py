"""Many crawlers, each with its own world, flips and memory: what a batched environment steps."""

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import deepcopy
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from gymnasium.utils import seeding
from numpy.typing import NDArray

from ..compiling.generators import whereabouts
from ..compiling.vectors import aligned_zeros, LANES
from ..crawler import Groups, Scene
from ..crawler.batch.advance import lane_workspace
from ..crawler.closed_form.parts import is_linear
from ..crawler.cost import cheapest_of_each, PREDICTED
from ..crawler.model.state import SLIPS
from ..crawler.refusals import solver_error, SolverError
from ..crawler.solvers import SOLVERS
from ..crawler.steps.options import MAX_STEPS
from ..crawler.steps.propagator import table_shape, tabulate_each
from ..crawler.steps.workspace import ROWS, WIDTH
from ..reservoir.prequential_lanes import blank_readouts, forget, packed, Readouts, readouts_of, unpack
from .batch_kernel import batch_of, draw_shares, Episode, STEP_BATCH
from .calibration import calibrated_memory, calibration_valves
from .infos import COUNTS, NUMBERS
from .observation import valves_seen
from .rendering.film import Film, recalled_of
from .settings import columns_of_numbers, CrawlerChoice, drawn_numbers, numbers_of, Settings
from .state import CrawlerState

__all__ = ["BatchEngine"]

# Fewer crawlers than this are stepped before another thread has woken; an affine map a hold is soon done.
_LEAST_A_THREAD = 128
_LEAST_OF_MAPS = 16_384
# Natural time times crawlers that one call of compiled code steps: some tens of milliseconds, unless they are stiff.
_TIME_OF_A_CALL = 20_000.0


class _Slice(NamedTuple):
    """What one thread steps, and what it works on."""

    begin: int
    end: int
    workspaces: dict[str, NDArray[np.float64]]  # by solver
    scratch: NDArray[np.float64]


class BatchEngine:
    """Crawlers that are stepped together.

    Parameters
    ----------
    kinds : sequence of Settings
        Alike but for the groups.
    kind : (crawlers,) array of int
        Which of them is whose.
    longest : int
        Steps of an episode.
    threads : int
        Most that share a step.

    Attributes
    ----------
    batch, results
        See `Batch` and `Results`.
    generators : list of numpy.random.Generator
        Of each crawler's draws; None where none was asked for yet. Set by `draw_from`.
    seeds : list of int
        -1 where a generator was given.
    """

    def __init__(self, kinds: Sequence[Settings], kind: NDArray[np.int64], longest: int, threads: int) -> None:
        self._kinds, self._kind = kinds, kind
        settings = self._settings = kinds[0]
        self._alike = len(kinds) == 1 and not settings.randomize
        count = len(kind)
        self._episode = Episode(settings.hold, settings.dither, settings.memory_weight, longest, settings.aim)
        self.batch, self.results = batch_of(count, settings.samples, settings.valve_history, settings.aim)
        self.generators: list[Any] = [None] * count
        self.seeds: list[int | None] = [None] * count
        self._sources = np.zeros((2, count), np.uint64)  # of the numbers drawn at a reset
        self._numbers = numbers_of([(each.groups, each.scene) for each in kinds])  # of each kind
        # Made when they are asked for.
        self._crawlers: list[tuple[Groups, Scene] | None] = [None] * count
        self._named: list[tuple[dict[str, float], float] | None] = [None] * count
        self._solvers = np.full(count, "", np.dtype("U11"))
        self._strange = np.zeros(count, np.bool_)  # whose episodes have crawlers that the kinds do not tell
        self._tables: NDArray[np.float64] | None = None
        self._readouts: Readouts | None = None

        blocks = -(-count // LANES)
        maps = settings.scene.anchored and all(is_linear(kind.groups) for kind in kinds) and settings.dither == 0.0
        parts = max(1, min(threads, count // (_LEAST_OF_MAPS if maps else _LEAST_A_THREAD)))
        ends = [min(count, LANES * (blocks * part // parts)) for part in range(parts + 1)]
        self._slices = [
            _Slice(
                begin,
                end,
                {"taylor": lane_workspace(), "radau": np.empty((1, ROWS, WIDTH))},
                aligned_zeros(2, settings.features + 1, LANES),
            )
            for begin, end in pairwise(ends)
        ]
        self._crawlers_of_a_call = LANES * max(1, int(_TIME_OF_A_CALL / settings.hold) // LANES)
        self._interrupted = False
        self._executor: ThreadPoolExecutor | None = None
        self._process = os.getpid()
        self._names: Sequence[int] | NDArray[np.int64] = range(count)  # in messages

    def begin(
        self, mask: NDArray[np.bool_], seeds: Sequence[int | None], choices: Sequence[CrawlerChoice] | None = None
    ) -> None:
        """Start the episodes of the crawlers in the mask.

        Parameters
        ----------
        mask : (crawlers,) array of bool
        seeds : (crawlers,) sequence
            None goes on with the random numbers as they come.
        choices : (crawlers,) sequence, optional
            What is settled of the crawlers of these episodes.

        Raises
        ------
        SolverError
            If a motion diverges while its memory readout is calibrated.
        """
        for i in np.flatnonzero(mask).tolist():
            if seeds[i] is not None:
                self.draw_from(i, *seeding.np_random(seeds[i]))
        self.want_generators()
        self._calibrate()
        self.begin_again(mask, choices)

    def want_generators(self) -> None:
        """Give a generator, seeded by chance, to each crawler that has none."""
        for i, generator in enumerate(self.generators):
            if generator is None:
                self.draw_from(i, *seeding.np_random())

    def draw_from(self, i: int, generator: np.random.Generator, seed: int | None) -> None:
        """Let the random numbers of a crawler come from a generator: one for what is drawn of it, one a step."""
        self.generators[i], self.seeds[i] = generator, seed
        if self._settings.dither > 0.0:
            self.batch.generators[:, i] = whereabouts(generator)
        if self._settings.randomize:
            self._sources[:, i] = whereabouts(generator)

    def begin_again(self, mask: NDArray[np.bool_], choices: Sequence[CrawlerChoice] | None = None) -> None:
        """Start further episodes of the crawlers in the mask."""
        unsettled = mask & (self._strange | (self._solvers == ""))
        if self._settings.randomize or choices is not None or np.count_nonzero(unsettled):
            self._draw(np.flatnonzero(mask), choices)
        self.batch.bodies[:, : len(mask)][:, mask] = 0.0
        self._read()[:, : len(mask)][:, mask] = 0.0
        self.batch.steps[mask] = 0
        self.results.observations[mask] = 0.0
        self.results.numbers[: len(NUMBERS), mask] = 0.0
        self.results.counts[:, mask] = 0
        if self._readouts is not None:
            forget(self._readouts, mask)
        for past in (self.batch.histories, self.batch.recent):
            if len(past):
                past[mask] = 0

    def step(self, commands: NDArray[np.int64], idle: NDArray[np.bool_]) -> None:
        """Step all but the idle, and write down the results.

        Parameters
        ----------
        commands : (crawlers,) array
            Each 0 or 1.
        idle : (crawlers,) array of bool

        Raises
        ------
        SolverError
            If a motion diverges.
        """
        self._interrupted = False
        first, *rest = self._slices
        try:
            others = [self._threads().submit(self._step_slice, commands, idle, each) for each in rest]
            self._step_slice(commands, idle, first)
            for other in others:
                other.result()
        except BaseException:
            # Nobody steps any more when this has ended, not even who was called while the interrupt came.
            self._interrupted = True
            self.close()
            raise
        if np.count_nonzero(self.results.statuses):
            failed = np.flatnonzero(self.results.statuses)
            raise self._error(int(failed[0]))

    def readout_states(self, which: int | slice = slice(None)) -> NDArray[np.float64]:
        """What the readouts have seen of the last hold, of one crawler or of some, shape (..., features)."""
        return self._read()[:, : len(self._kind)].T[which].copy()

    def follow(self, film: Film, i: int) -> None:
        """Have a film begin anew where crawler `i` does not go on from its end: after a reset, or set to a state."""
        body, steps = self.batch.bodies[:, i], int(self.batch.steps[i])
        if not film.follows(body, steps):
            film.begin(*self.crawler_of(i), body, steps, self._told(i))

    def weights(self, i: int) -> NDArray[np.float64] | None:
        """Copy of the weights of crawler `i`'s readout; None where there is none."""
        return None if self._readouts is None else packed(self._readouts, i)[0]

    def film(self, film: Film, i: int, weights: NDArray[np.float64] | None) -> None:
        """Have a film that follows crawler `i` go through its last step, before which its readout had these weights."""
        message = None
        if self._readouts is not None and weights is not None:
            block, lane = divmod(i, LANES)
            message = recalled_of(
                self._settings,
                weights,
                self._readouts.scaling[block, ..., lane],
                self.readout_states(i),
                self._readouts.past[block, :, lane],
                int(self.batch.steps[i]),
            )
        film.add(self.batch.bodies[:, i].copy(), self._told(i), message)

    def close(self) -> None:
        """End the threads."""
        if self._executor is not None and self._process == os.getpid():
            self._executor.shutdown()
        self._executor = None

    def __getstate__(self) -> dict[str, Any]:
        # Threads cannot be copied; the copy starts its own.
        return {**self.__dict__, "_executor": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        for i, generator in enumerate(self.generators):  # which lie elsewhere than those copied
            if generator is not None:
                self.draw_from(i, generator, self.seeds[i])

    def _read(self) -> NDArray[np.float64]:
        """States in the last hold, a crawler a column."""
        return self.batch.samples.reshape(-1, self.batch.samples.shape[-1])

    def _told(self, i: int) -> NDArray[np.float64]:
        """What the last step has told of a crawler: `stickslip.envs.infos.TOLD`."""
        return np.array([*self.results.numbers[: len(NUMBERS), i], *self.results.counts[:, i]])

    def _draw(self, who: NDArray[np.int64], choices: Sequence[CrawlerChoice] | None) -> None:
        """Settle who crawls where in the episodes to come."""
        self._strange[who] = choices is not None
        if choices is None:
            numbers = self._numbers[:, self._kind[who]]
            shares = np.empty((len(self._settings.randomize), len(who)))
            if len(shares):
                draw_shares(self._sources, who, shares)
            self._settle(who, drawn_numbers(self._settings, numbers, shares))
            return
        kinds = self._kinds_of(who.tolist())
        generators = [self.generators[i] for i in who.tolist()]
        chosen = [choices[i] for i in who.tolist()]
        crawlers = [kind.draw(*each) for kind, *each in zip(kinds, generators, chosen, strict=True)]
        self._settle(who, numbers_of(crawlers))

    def _settle(self, who: NDArray[np.int64], numbers: NDArray[np.float64]) -> None:
        """Let these crawlers be others, each solved by what solves it best; `numbers` as from `numbers_of`."""
        settings = self._settings
        if self._alike and self._strange.any():
            self._alike = False
            if self._tables is not None:
                self._tables = np.repeat(self._tables, len(self._kind), axis=0)
        for i in who.tolist():
            self._crawlers[i] = self._named[i] = None
        self.results.numbers[len(NUMBERS) :, who] = numbers
        columns = columns_of_numbers(settings.scene, numbers)
        self.batch.coefficients[:, who] = columns
        holds, units = np.full(len(who), settings.hold), np.ones(len(who))
        self._solvers[who] = np.array(PREDICTED)[cheapest_of_each(columns, holds, units, settings.tolerance)]
        linear = who[self._solvers[who] == "closed_form"]
        if len(linear):
            if self._tables is None:
                places = 1 if self._alike else len(self._kind)
                self._tables = np.zeros((places, *table_shape(settings.samples)))
            # One table serves crawlers that are all alike.
            some = linear[: len(self._tables)] if len(self._tables) == 1 else linear
            tabulate_each(self.batch.coefficients, some, settings.hold, settings.samples, self._tables)
        names = sorted(set(self._solvers.tolist()) - {""})  # which have none yet
        self._methods = [
            (name, None if len(names) == 1 else self._solvers != name, SOLVERS[name].options(settings.tolerance))
            for name in names
        ]

    def crawler_of(self, i: int) -> tuple[Groups, Scene]:
        """Who crawls where in the episode of crawler `i`; of its kind where no episode has begun."""
        if self._solvers[i] == "":
            kind = self._kinds[self._kind[i]]
            return kind.groups, kind.scene
        crawler = self._crawlers[i]
        if crawler is None:
            *groups, slope = self.results.numbers[len(NUMBERS) :, i].tolist()
            crawler = self._crawlers[i] = Groups(*groups), replace(self._settings.scene, slope=slope)
        return crawler

    @property
    def named(self) -> list[tuple[dict[str, float], float]]:
        """Groups by name, and slope, of each crawler's episode."""
        known: list[tuple[dict[str, float], float]] = []
        for i, each in enumerate(self._named):
            if each is None:
                *groups, slope = self.results.numbers[len(NUMBERS) :, i].tolist()
                each = self._named[i] = dict(zip(Groups.__slots__, groups, strict=True)), slope
            known.append(each)
        return known

    def save(self, i: int, over: bool, generator: bool) -> CrawlerState:
        """State of crawler `i`, as it is known from outside whether its episode is over."""
        groups, scene = self.crawler_of(i)
        return CrawlerState(
            self.settings_of_each[i],
            groups,
            scene,
            self.batch.bodies[:, i].copy(),
            int(self.batch.steps[i]),
            self.results.observations[i].copy(),
            self._told(i),
            self.readout_states(i),
            () if self._readouts is None else (*packed(self._readouts, i), *self.batch.recent[i : i + 1].copy()),
            over,
            deepcopy(self.generators[i]) if generator else None,
            self.seeds[i] if generator else None,
        )

    def restore(self, states: Sequence[CrawlerState | None]) -> None:
        """Let each crawler go on from its state, if it has one."""
        self._calibrate()
        self.want_generators()
        whose: dict[int, list[int]] = {}  # many may branch from one
        others: dict[int, tuple[Groups, Scene]] = {}  # who are to be others than they are
        for i, state in enumerate(states):
            if state is not None:
                whose.setdefault(id(state), []).append(i)
                crawler, kind = (state.groups, state.scene), self._kinds[self._kind[i]]
                self._strange[i] = crawler != (kind.groups, kind.scene)
                if self._solvers[i] == "" or self.crawler_of(i) != crawler:
                    others[i] = crawler
        self._settle(np.array(list(others), np.int64), numbers_of(list(others.values())))
        for indices in whose.values():
            state = states[indices[0]]
            assert state is not None
            self.batch.bodies[:, indices] = state.body[:, np.newaxis]
            self.batch.steps[indices] = state.steps
            self.results.observations[indices] = state.observation
            if len(self.batch.histories):
                self.batch.histories[indices] = valves_seen(state.observation)
            self.results.numbers[: len(NUMBERS), indices] = state.told[: len(NUMBERS), np.newaxis]
            self.results.counts[:, indices] = state.told[len(NUMBERS) :, np.newaxis]
            self._read()[:, indices] = state.read[:, np.newaxis]
            if self._readouts is not None:
                unpack(self._readouts, indices, state.readout[:3], state.steps)
                for recent in state.readout[3:]:
                    self.batch.recent[indices] = recent
            if state.generator is not None:
                for i in indices:
                    self.draw_from(i, deepcopy(state.generator), state.seed)

    @property
    def settings_of_each(self) -> list[Settings]:
        """Arguments of each crawler."""
        return self._kinds_of(range(len(self._kind)))

    def _kinds_of(self, indices: Sequence[int]) -> list[Settings]:
        return [self._kinds[k] for k in self._kind[list(indices)].tolist()]

    def _calibrate(self) -> None:
        if self._readouts is None and self._settings.dither > 0.0:
            states = _calibration_states(self._kinds, np.unique(self._kind, return_index=True)[1])
            memories = [calibrated_memory(kind, seen) for kind, seen in zip(self._kinds, states, strict=True)]
            self._readouts = readouts_of(memories, self._kind)

    def _threads(self) -> ThreadPoolExecutor:
        if self._executor is None or self._process != os.getpid():  # a forked process has none of its parent's threads
            self._executor = ThreadPoolExecutor(len(self._slices) - 1, "stickslip")
            self._process = os.getpid()
        return self._executor

    def _step_slice(self, commands: NDArray[np.int64], idle: NDArray[np.bool_], part: _Slice) -> None:
        # An interrupt is heard between two calls of compiled code.
        for begin in range(part.begin, part.end, self._crawlers_of_a_call):
            if self._interrupted:
                return
            end = min(begin + self._crawlers_of_a_call, part.end)
            for k, (name, others, options) in enumerate(self._methods):
                STEP_BATCH[type(options.method)](
                    begin,
                    end,
                    k == 0,
                    k == len(self._methods) - 1,
                    commands,
                    idle,
                    idle if others is None else idle | others,
                    self.batch,
                    self._readouts,
                    self._episode,
                    options.tolerance,
                    options.order,
                    options.max_steps,
                    self._tables if name == "closed_form" else part.workspaces[name],
                    part.scratch,
                    self.results,
                )

    def _error(self, i: int) -> SolverError:
        """Why the first crawler that failed did."""
        began = float(self.batch.steps[i] * self._settings.hold)
        reached = began + float(self.results.elapsed[i])
        # Those told are of the step before.
        gained = int(self.batch.bodies[SLIPS, i]) - int(self.results.counts[COUNTS.index("slips"), i])
        deformation = float(self.batch.bodies[0, i])
        status, tolerance, solver = int(self.results.statuses[i]), self._settings.tolerance, str(self._solvers[i])
        groups, scene = self.crawler_of(i)
        error = solver_error(status, reached, deformation, MAX_STEPS, groups, scene, tolerance, solver, gained, began)
        return SolverError(f"sub-environment {self._names[i]}: {error}")


def _calibration_states(kinds: Sequence[Settings], names: NDArray[np.int64]) -> NDArray[np.float64]:
    """States of the bodies under the calibration's valves, from rest, shape (kinds, holds, features).

    An error names a sub-environment of the kind.
    """
    settings, count = kinds[0], len(kinds)
    engine = BatchEngine([replace(kind, randomize={}) for kind in kinds], np.arange(count), 1, 1)
    engine._names = names
    # With readouts, though blank, the kernel is the one that is compiled for the episodes.
    engine._readouts = blank_readouts(count, settings.messages, settings.features + 1, 1.0)
    engine.begin(np.ones(count, np.bool_), [0] * count)
    engine.batch.generators[:] = 0  # which flip none
    valves = calibration_valves(settings)
    states = np.empty((count, len(valves), settings.features))
    idle = np.zeros(count, np.bool_)
    for k, valve in enumerate(valves.tolist()):
        engine.step(np.full(count, valve), idle)
        states[:, k] = engine.readout_states()
    return states
