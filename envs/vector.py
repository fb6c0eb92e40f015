"""StickSlipCrawler-v0 in a batch: thousands of crawlers, one compiled call a step."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, Literal

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.error import ClosedEnvironmentError, ResetNeeded
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from ..common.sharing import processors
from ..common.validation import truth_value, whole_number
from ..crawler import Groups, GroupsLike, Scene
from ..crawler.model.holds import hold_in_seconds
from .batch_engine import BatchEngine
from .infos import begun, COUNTS, NUMBERS, TOLD
from .observation import observation_space
from .rendering.film import Film, film_of, fps_of
from .rendering.renderer import known_mode, RenderMode
from .rendering.tiling import Tiles
from .settings import CRAWLER_OPTIONS, CrawlerChoice, known_options, refuse_unread, Settings
from .single import StickSlipCrawlerEnv
from .specification import Specified
from .state import CrawlerState, refuse_foreign
from .sub_environment import SubEnvironment
from .vector_arguments import (
    autoreset_mode_of,
    commands_of,
    generators_of,
    groups_of,
    hold_of_all,
    mask_of,
    option_of_each,
    seeds_of,
    shown_of,
)

__all__ = ["StickSlipCrawlerVectorEnv"]

# Names of the masks beside the infos, those of the groups within theirs.
_GROUPS_HAVING = tuple(f"_{name}" for name in Groups.__slots__)
_HAVING = tuple(f"_{name}" for name in (*TOLD, "groups", "slope"))


class StickSlipCrawlerVectorEnv(Specified, VectorEnv[NDArray[np.float32], NDArray[np.int64], NDArray[Any]]):
    """A batch of `StickSlipCrawlerEnv`, stepped together.

    ``gymnasium.make_vec("StickSlipCrawler-v0", num_envs=n)`` makes it. Sub-environment i does what a single environment
    reset with ``seed + i`` does, to the last bit: observations, rewards, infos and flips, in any batch, on any number
    of threads, after any resets. Actions, observations, rewards and infos of one sub-environment are those that
    `StickSlipCrawlerEnv` documents; here they are arrays whose first axis is the sub-environment, and infos come in
    Gymnasium's vector form, each beside the mask of those that have it.

    Parameters
    ----------
    num_envs : int, >= 1
    groups : Groups, str, mapping or Actuator, or a sequence of num_envs of these
        As in `StickSlipCrawlerEnv`; a sequence gives each sub-environment its own.
    scene, hold, tolerance, dither, memory_weight, delays, target, target_order, virtual_nodes, valve_history,
    randomize
        As in `StickSlipCrawlerEnv`.
    max_episode_steps : int, optional
        Steps after which an episode is truncated; None or -1 for never. `make_vec` sets 1000.
    autoreset_mode : AutoresetMode or str
        What follows the end of an episode: "NextStep" ignores the next action and returns the first observation of the
        next episode instead, "SameStep" does so at once and tells the last one as ``infos["final_obs"]``, "Disabled"
        waits for ``reset(options={"reset_mask": mask})``.
    copy : bool
        Whether every call returns arrays of its own. Otherwise the next call overwrites them.
    threads : int, optional
        Most threads that share a step; as many as there are processors to run on by default.
    render_mode : {"human", "rgb_array", "rgb_array_list"}, optional
    slow_motion : float, in [0.01, 1000]
        As in `StickSlipCrawlerEnv`.
    rendered : sequence of int, optional
        Sub-environments that `render` draws; all by default.

    Attributes
    ----------
    hold_seconds : float or None
        Length of a step, s, where all groups are `Actuator` of one t_c.

    Raises
    ------
    ValueError, TypeError
        If an argument is out of range or of the wrong type; the message names it.
    """

    metadata: dict[str, Any] = {**StickSlipCrawlerEnv.metadata}  # noqa: RUF012
    _sub_environment = SubEnvironment

    render_mode: RenderMode | None

    def __init__(
        self,
        num_envs: int = 1,
        *,
        groups: GroupsLike | Sequence[GroupsLike] | None = None,
        scene: Mapping[str, Any] | Scene | None = None,
        hold: float | str = 0.5,
        tolerance: float = 1e-6,
        dither: float = 0.1,
        memory_weight: float = 0.2,
        delays: int = 20,
        target: Literal["memory", "parity", "narma"] = "memory",
        target_order: int = 2,
        virtual_nodes: int = 4,
        valve_history: int = 1,
        randomize: Mapping[str, Sequence[float]] | None = None,
        max_episode_steps: int | None = 1000,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        copy: bool = True,
        threads: int | None = None,
        render_mode: RenderMode | None = None,
        rendered: Sequence[int] | None = None,
        slow_motion: float = 1.0,
    ) -> None:
        self.num_envs = whole_number("num_envs", num_envs, 1)
        arguments: dict[str, Any] = {
            "scene": scene,
            "hold": hold_of_all(hold, groups),
            "tolerance": tolerance,
            "dither": dither,
            "memory_weight": memory_weight,
            "delays": delays,
            "target": target,
            "target_order": target_order,
            "virtual_nodes": virtual_nodes,
            "valve_history": valve_history,
            "randomize": randomize,
        }
        each = groups_of(groups, self.num_envs)
        kinds = {choice: Settings.of(groups=choice, **arguments) for choice in each}
        order = {choice: k for k, choice in enumerate(kinds)}
        kind = np.array([order[choice] for choice in each])
        self.settings = kinds[each[0]]
        self.hold_seconds = hold_in_seconds(self.settings.hold, groups)
        never = max_episode_steps is None or max_episode_steps == -1
        self.autoreset_mode = autoreset_mode_of(autoreset_mode)
        self._copy = truth_value("copy", copy)
        known_mode(render_mode, self.metadata["render_modes"])
        self.render_mode = render_mode
        self._rendered = shown_of(rendered, self.num_envs)
        films = {i: film_of(self.settings, render_mode, slow_motion) for i in self._rendered}
        self._films = {i: film for i, film in films.items() if film is not None}
        self._tiles: Tiles | None = None
        fps = fps_of(self.settings, render_mode, slow_motion)
        self.metadata = {**self.metadata, "render_fps": fps, "autoreset_mode": self.autoreset_mode}

        self.single_action_space = spaces.Discrete(2)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.single_observation_space = observation_space(self.settings.scene, self.settings.valve_history)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)

        longest = int(np.iinfo(np.int64).max)
        if not never:
            longest = min(longest, whole_number("max_episode_steps", max_episode_steps, 1))
        most = processors() if threads is None else whole_number("threads", threads, 1)
        self._engine = BatchEngine(list(kinds.values()), kind, longest, most)
        self._pending = np.zeros(self.num_envs, np.bool_)
        self._all = np.ones(self.num_envs, np.bool_)
        self._terminations = np.zeros(self.num_envs, np.bool_)
        self._begun = np.zeros(self.num_envs, np.bool_)  # who have an episode

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Put all crawlers, or those of a mask, at rest at the start of the ground.

        Parameters
        ----------
        seed : int or sequence of num_envs of int or None, optional
            Sub-environment i takes ``seed + i``, or its own; without a seed it goes on with its random numbers.
        options : dict, optional
            ``"reset_mask"``: a bool array of shape (num_envs,), the sub-environments to reset. ``"groups"`` and
            ``"slope"``, as in `StickSlipCrawlerEnv`, one for all or a sequence of num_envs, in which None settles
            nothing: of the episodes that begin now, not of those that follow them by autoreset.

        Returns
        -------
        observations : (num_envs, ...) array of float32
            Of all; those that are not reset show their last one again.
        infos : dict
            Of those that are reset.

        Raises
        ------
        ValueError, TypeError
            If an argument is wrong; nothing is reset then.
        gymnasium.error.ResetNeeded
            If the first reset, or the first after a SolverError, is not one of all; `call("reset")` is.
        gymnasium.error.ClosedEnvironmentError
            If called after `close`.
        """
        return self._reset(seed, options, some=self._running)

    def step(
        self, actions: ArrayLike
    ) -> tuple[NDArray[np.float32], NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """Hold every valve as commanded, or flipped, for one hold.

        Parameters
        ----------
        actions : (num_envs,) array of int
            Each 0 or 1.

        Returns
        -------
        observations : (num_envs, ...) array of float32
        rewards : (num_envs,) array of float64
        terminations : (num_envs,) array of bool
            All False.
        truncations : (num_envs,) array of bool
            Whether the episode has come to its last step.
        infos : dict

        Raises
        ------
        ValueError, TypeError
            If `actions` has another shape or type, or holds anything but 0 and 1; nothing is stepped then.
        gymnasium.error.ResetNeeded
            If called before `reset`, or on an episode that has ended where `autoreset_mode` is "Disabled".
        gymnasium.error.ClosedEnvironmentError
            If called after `close`.
        SolverError
            If a motion diverges; all sub-environments have to be reset then.
        """
        self._refuse_closed()
        commands = commands_of(actions, self.num_envs)
        if not self._running:
            raise ResetNeeded("step needs a call of reset first")
        idle = self._pending
        restarting = np.count_nonzero(idle) > 0
        if restarting and self.autoreset_mode is AutoresetMode.DISABLED:
            over = np.flatnonzero(idle).tolist()
            raise ResetNeeded(f"the episodes of sub-environments {over} are over; reset them with a reset_mask")
        self._begun[:] = False  # until the step has succeeded
        if self._films:
            self._step_filmed(commands, idle)
        else:
            self._engine.step(commands, idle)
        self._begun[:] = True

        results = self._engine.results
        self._terminations[:] = False  # without copies the caller has written to it perhaps
        ended = results.truncations.copy()
        last: dict[str, Any] = {}
        if self.autoreset_mode is not AutoresetMode.SAME_STEP:
            if restarting:
                self._engine.begin_again(idle)
            self._pending = ended
        elif np.count_nonzero(ended) > 0:
            last |= {"final_obs": _rows(results.observations, ended), "_final_obs": ended.copy()}
            # The next episodes are about to be told in the same places.
            last |= {"final_info": self._told(ended, copy=True), "_final_info": ended.copy()}
            self._engine.begin_again(ended)
        infos = self._told(self._all) | last
        if self.render_mode == "human":
            self.render()
        arrays = results.observations, results.rewards, self._terminations, results.truncations
        observations, rewards, terminations, truncations = (self._own(array) for array in arrays)
        return observations, rewards, terminations, truncations, infos

    def render(  # type: ignore[override]
        self,
    ) -> tuple[NDArray[np.uint8], ...] | tuple[list[NDArray[np.uint8]], ...] | None:
        """Draw the `rendered` crawlers as they are now, or as they were since the last call.

        Returns
        -------
        tuple of (height, width, 3) arrays of uint8, tuple of lists of these, or None
            For `render_mode="rgb_array"` a picture of each; `stickslip.envs.tile` makes one of them. For
            "rgb_array_list" all pictures of each within the holds since the last call, or since its episode began if
            that was later. None for "human", which has shown them in a window.

        Raises
        ------
        gymnasium.error.ResetNeeded
            If called before `reset`.
        gymnasium.error.ClosedEnvironmentError
            If called after `close`.
        """
        self._refuse_closed()
        if self.render_mode is None:
            gym.logger.warn(
                "render was called without a render_mode; "
                'make the environment with gym.make_vec("StickSlipCrawler-v0", n, render_mode="rgb_array")'
            )
            return None
        films, tiles = self._drawing()
        if self.render_mode == "rgb_array":
            return tiles.draw(films)
        if self.render_mode == "rgb_array_list":
            return tiles.unseen(films)
        tiles.show(films)
        return None

    def frames(self) -> list[tuple[NDArray[np.uint8], ...]]:
        """Draw the last step of the `rendered` crawlers: every picture within the hold.

        Returns
        -------
        list of tuples of (height, width, 3) arrays of uint8
            A picture of each crawler; who has begun an episode stands still.

        Raises
        ------
        ValueError
            Without a `render_mode`.
        gymnasium.error.ResetNeeded
            If called before `reset`.
        """
        films, tiles = self._drawing()
        return list(tiles.together(films, [film.last() for film in films]))

    def close_extras(self, **_: Any) -> None:
        """End the threads, and close the window if there is one."""
        self._engine.close()
        if self._tiles is not None:
            self._tiles.close()
            self._tiles = None

    @property  # type: ignore[override]
    def np_random(self) -> tuple[np.random.Generator, ...]:
        """Each sub-environment's generator: of one number a step, and of what `randomize` draws at a reset.

        A sequence of `num_envs` different generators sets them, and so does one generator, which spawns them. The next
        step draws from them.
        """
        self._engine.want_generators()
        return tuple(self._engine.generators)

    @np_random.setter
    def np_random(self, value: np.random.Generator | Sequence[np.random.Generator]) -> None:
        for i, generator in enumerate(generators_of(value, self.num_envs)):
            self._engine.draw_from(i, generator, -1)

    @property
    def np_random_seed(self) -> tuple[int | None, ...]:  # type: ignore[override]
        """Seed of each sub-environment's generator; -1 where a generator was given."""
        self._engine.want_generators()
        return tuple(self._engine.seeds)

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """Call a method of each sub-environment, or get an attribute, as `gymnasium.vector.SyncVectorEnv` does.

        Parameters
        ----------
        name : str
            Of a method or an attribute of `StickSlipCrawlerEnv`, or of what was set by `set_attr`.
        *args, **kwargs
            Of the method.

        Returns
        -------
        tuple of num_envs
        """
        found = [each.get_wrapper_attr(name) for each in self.sub_environments]
        return tuple(each(*args, **kwargs) if callable(each) else each for each in found)

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """Attribute of each sub-environment; a method of no arguments is called."""
        return self.call(name)

    def set_attr(self, name: str, values: Any) -> None:
        """Set an attribute of each sub-environment: to its own of a list or tuple of num_envs, or to one value."""
        each = values if isinstance(values, list | tuple) else [values] * self.num_envs
        if len(each) != self.num_envs:
            raise ValueError(f"values must be one value or num_envs = {self.num_envs} of them, got {len(each)}")
        for sub_environment, value in zip(self.sub_environments, each, strict=True):
            sub_environment.set_wrapper_attr(name, value)

    def readout_states(self) -> NDArray[np.float64]:
        """What the memory readout of each has seen of the hold just ended: see `StickSlipCrawlerEnv.readout_states`.

        Returns
        -------
        (num_envs, 3 * virtual_nodes) array of float64
            0 of those whose episode has just begun, by autoreset in the same step too.

        Raises
        ------
        ValueError
            Without dither.
        gymnasium.error.ResetNeeded
            If there are no episodes.
        """
        refuse_unread(self.settings)
        if not self._running:
            raise ResetNeeded("readout_states needs a call of reset first")
        return self._engine.readout_states()

    def get_state(self, *, generator: bool = True) -> tuple[CrawlerState, ...]:
        """State of each sub-environment, as `StickSlipCrawlerEnv.get_state` returns it.

        Raises
        ------
        gymnasium.error.ResetNeeded
            If there are no episodes.
        """
        if not self._running:
            raise ResetNeeded("get_state needs a call of reset first")
        return tuple(self._engine.save(i, over, generator) for i, over in enumerate(self._pending.tolist()))

    def set_state(self, state: CrawlerState | Sequence[CrawlerState | None]) -> None:
        """Go on from states, to the last bit.

        Parameters
        ----------
        state : CrawlerState or sequence of num_envs of CrawlerState or None
            Of one environment, single or in a batch, for all: branches of one state, each with its own flips to come
            if the state is without a generator, and all with the same if it has one. Or to each its own; None leaves
            one where it is.

        Raises
        ------
        TypeError, ValueError
            If one is none, or of an environment of other arguments, or of another version; nothing is set then.
        gymnasium.error.ResetNeeded
            If some are left where they are before the first reset.
        """
        self._refuse_closed()
        states = [state] * self.num_envs if isinstance(state, CrawlerState) else state
        if not isinstance(states, Sequence) or len(states) != self.num_envs:
            raise TypeError(f"state must be a CrawlerState or num_envs = {self.num_envs} of them, got {state!r}")
        for one, settings in zip(states, self.settings_of_each, strict=True):
            if one is not None:
                refuse_foreign(one, settings)
        if not all(begun or one is not None for begun, one in zip(self._begun.tolist(), states, strict=True)):
            raise ResetNeeded("set_state of some needs a call of reset first")
        self._engine.restore(states)
        for i, one in enumerate(states):
            if one is not None:
                self._pending[i] = one.over and self.autoreset_mode is not AutoresetMode.SAME_STEP
        self._begun[:] = True

    @property
    def settings_of_each(self) -> list[Settings]:
        """Arguments of each sub-environment."""
        return self._engine.settings_of_each

    @property
    def crawlers_by_name(self) -> list[tuple[dict[str, float], float]]:
        """Groups and slope of each sub-environment's episode, not to be changed."""
        return self._engine.named

    def crawler_of(self, index: int) -> tuple[Groups, Scene]:
        """Crawler and world of a sub-environment's episode."""
        if not self._begun[index]:
            raise AttributeError("no episode has begun, and no crawler been settled; call reset first")
        return self._engine.crawler_of(index)

    def reset_one(
        self, index: int, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Reset one sub-environment and answer as `StickSlipCrawlerEnv` does."""
        seeds: list[int | None] = [None] * self.num_envs
        seeds[index] = seed
        options = {"reset_mask": np.arange(self.num_envs) == index, **known_options(options, CRAWLER_OPTIONS)}
        observations, _ = self._reset(seeds, options, some=True)
        return observations[index].copy(), self.begun(index)

    def begun(self, index: int) -> dict[str, Any]:
        """What a reset of one sub-environment has told, or will have if it goes on from a state."""
        return begun(*self.crawler_of(index))

    def render_one(self, index: int) -> NDArray[np.uint8] | list[NDArray[np.uint8]] | None:
        """What `render` has of one sub-environment; None where it is not `rendered`, or a window shows all."""
        if self.render_mode == "rgb_array_list" and index in self._films:
            films, tiles = self._drawing()
            return tiles.unseen([films[self._rendered.index(index)]])[0]  # those of the others wait
        pictures = self.render()
        return None if pictures is None or index not in self._rendered else pictures[self._rendered.index(index)]

    @cached_property
    def sub_environments(self) -> list[SubEnvironment]:
        """Each as far as it can be asked for alone: all but stepped."""
        return [self._sub_environment(self, i) for i in range(self.num_envs)]

    def __getstate__(self) -> dict[str, Any]:
        # A window cannot be copied; the copy opens its own.
        return {**self.__dict__, "_tiles": None}

    def _drawing(self) -> tuple[list[Film], Tiles]:
        """What is drawn, up to now, and what draws it."""
        if not self._films:
            raise ValueError("frames needs a render_mode, got an environment without")
        if not self._running:
            raise ResetNeeded("render needs a call of reset first")
        for i, film in self._films.items():
            self._engine.follow(film, i)
        if self._tiles is None:
            self._tiles = Tiles(self._rendered)
        return [self._films[i] for i in self._rendered], self._tiles

    @property
    def _running(self) -> bool:
        return np.count_nonzero(self._begun) == self.num_envs

    def _reset(
        self, seed: int | Sequence[int | None] | None, options: dict[str, Any] | None, *, some: bool
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Reset all, or `some` where that is allowed."""
        self._refuse_closed()
        chosen = known_options(options, ("reset_mask", *CRAWLER_OPTIONS))
        mask = mask_of(chosen.pop("reset_mask", None), self.num_envs)
        choices = self._choices(**chosen) if chosen else None
        seeds = seeds_of(seed, self.num_envs)
        if not some and not mask.all():
            raise ResetNeeded("the first reset must be of all sub-environments, got a reset_mask of some")
        self._engine.begin(mask, seeds, choices)
        self._begun |= mask
        self._pending = self._pending & ~mask
        if self.render_mode == "human" and self._running:
            self.render()
        return self._own(self._engine.results.observations), self._told(mask)

    def _own(self, array: NDArray[Any]) -> NDArray[Any]:
        return array.copy() if self._copy else array

    def _step_filmed(self, commands: NDArray[np.int64], idle: NDArray[np.bool_]) -> None:
        """Step, and have the films go on."""
        filmed = {i: film for i, film in self._films.items() if not idle[i]}
        for i, film in filmed.items():
            self._engine.follow(film, i)
        weights = {i: self._engine.weights(i) for i in filmed}
        self._engine.step(commands, idle)
        for i, film in filmed.items():
            self._engine.film(film, i, weights[i])

    def _told(self, mask: NDArray[np.bool_], *, copy: bool = False) -> dict[str, Any]:
        """Infos in Gymnasium's form: zero, and not in the mask beside them, for those who do not have them."""
        results = self._engine.results
        if np.count_nonzero(mask) == len(mask):
            own = np.copy if copy else self._own
            numbers, counts = own(results.numbers), own(results.counts)
        else:
            numbers, counts = np.where(mask, results.numbers, 0.0), np.where(mask, results.counts, 0)
        # Rows of one array, which cost a third of an array each.
        having = np.full((len(_HAVING) + len(_GROUPS_HAVING), len(mask)), mask)
        infos: dict[str, Any] = dict(zip(_HAVING, having, strict=False))
        groups: dict[str, Any] = dict(zip(_GROUPS_HAVING, having[len(_HAVING) :], strict=True))
        groups |= zip(Groups.__slots__, numbers[len(NUMBERS) : -1], strict=True)
        infos |= zip(NUMBERS, numbers, strict=False)
        infos |= zip(COUNTS, counts, strict=True)
        infos["groups"], infos["slope"] = groups, numbers[-1]
        return infos

    def _refuse_closed(self) -> None:
        if self.closed:
            raise ClosedEnvironmentError("the vector environment is closed; make a new one")

    def _choices(self, groups: Any = None, slope: Any = None) -> list[CrawlerChoice]:
        """What the options of a reset settle of each crawler."""
        given = [option_of_each(name, value, self.num_envs) for name, value in (("groups", groups), ("slope", slope))]
        return [settings.choose(*one) for settings, *one in zip(self._engine.settings_of_each, *given, strict=True)]


def _rows(array: NDArray[Any], mask: NDArray[np.bool_]) -> NDArray[np.object_]:
    """Copies of an array's rows, None for those not in the mask."""
    rows = np.full(len(array), None, object)
    for i in np.flatnonzero(mask).tolist():
        rows[i] = array[i].copy()
    return rows
