"""StickSlipCrawler-v0: one crawler, one valve decision a step."""

import operator
from collections.abc import Mapping, Sequence
from copy import deepcopy
from inspect import cleandoc
from typing import Any, Literal

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from ..compiling.generators import whereabouts
from ..crawler import Groups, GroupsLike, Scene
from ..crawler.drawing.film import FPS
from ..crawler.model.holds import hold_in_seconds
from ..crawler.model.state import SLIPS
from ..crawler.refusals import solver_error
from ..crawler.steps.options import FINISHED, MAX_STEPS
from ..reservoir.prequential import PrequentialMemory
from .calibration import calibrated_memory
from .infos import begun, info_of, place_of, table_of_infos, TOLD
from .observation import observation_space, seen_at_rest
from .rendering.film import Film, film_of, fps_of, Recalled, recalled_of
from .rendering.renderer import known_mode, RENDER_MODES, Renderer, RenderMode
from .settings import CRAWLER_OPTIONS, known_options, refuse_unread, Settings
from .single_kernel import ANSWERS, calibration_states, ELAPSED, NO_MEMORY, rest, REWARD, samples_of, stepper_for
from .specification import Specified
from .state import CrawlerState, refuse_foreign

__all__ = ["StickSlipCrawlerEnv"]


_TOLD, _SLIPS = len(TOLD), place_of("slips")


class StickSlipCrawlerEnv(Specified, gym.Env[NDArray[np.float32], np.int64]):
    r"""
    ## Description

    A soft pneumatic crawler: an elastomer body between a payload in front and a foot behind, pumped through a binary
    valve. The foot sticks until the body pulls it with more than static friction, then slides until it comes to rest;
    it never slides back. The same body is a physical reservoir, in which past valve states can be read out of present
    ones. One policy decides both how fast it crawls and how much it remembers.

    The command chosen by the policy is flipped with probability `dither` before it reaches the valve. The flips are
    the message that the body is to remember: the innovation $e_k = u_k - E[u_k | a_k]$ of the valve state $u_k$ given
    the command $a_k$ is unpredictable to everyone, so a periodic gait earns nothing for its own regularity.

    One step is one hold of the valve. Lengths are in units of z_c = P_max A_0 / k_1, times in t_c = sqrt(M / k_1).

    ## Action Space

    The action is the valve command, `Discrete(2)`.

    | Num | Action                            |
    |-----|-----------------------------------|
    | 0   | close the valve: the body deflates |
    | 1   | open the valve: the body inflates  |

    ## Observation Space

    `Box` of dtype `float32`, a number for each row: the state at the end of the hold. Bounds are infinite where the
    physics sets none.

    | Num | Observation                           | Min    | Max     | Unit      |
    |-----|---------------------------------------|--------|---------|-----------|
    | 0   | deformation z of the body             | -Inf   | Inf     | z_c       |
    | 1   | rate v of the deformation             | -Inf   | Inf     | z_c / t_c |
    | 2   | pressure p                            | 0      | 1       | P_max     |
    | 3   | velocity w of the foot                | 0, or -Inf without ratchet | Inf | z_c / t_c |
    | 4   | valve state u, after the flip         | 0      | 1       |           |
    | 5.. | the `valve_history` - 1 before it, newest first | 0 | 1  |           |

    The foot's position is not observed: nothing depends on it. Valve states from before the episode are 0. Older ones
    tell nothing of the motion to come, but of the flips that the body is to remember: a policy that sees the last four
    can keep what its own gait would overwrite.

    ## Rewards

    `(1 - memory_weight) * speed + memory_weight * memory`, with both terms in `info`.

    - *speed*: distance that the foot travelled in the hold, over the hold's length, z_c / t_c.
    - *memory*: $\sum_d (e_{k-d}^2 - (e_{k-d} - \hat e_{k-d})^2 / (1 + h_d)) / \mathrm{Var}\,e$ over `delays` delays
      from 0, where $\hat e_{k-d}$ is read from the deformation, rate and pressure at `virtual_nodes` instants of the
      hold by a recursive least-squares readout that has not yet learned $e_{k-d}$. Its mean tends to the memory
      capacity. Every episode starts with a readout that knows nothing; the leverages $h_d$ make up for what it still
      lacks (`docs/reward.md`). Without dither there is no message, and this term is 0. With `target="parity"` the
      readout is to tell products of `target_order` successive innovations instead, with `target="narma"` a nonlinear
      series that they drive, of which the newest value alone is read out (`stickslip.reservoir.targets`).

    ## Starting State

    At rest, with the valve shut and the foot at 0. What `randomize` names is drawn uniformly from its range at every
    reset; `reset(options={"groups": ..., "slope": ...})` settles an episode's crawler. `get_state` and `set_state`
    save a crawler in the middle of an episode and go on from there, here or in a batch.

    Each step draws one number from `np_random`, whether the command is flipped, and nothing else does but `randomize`.

    ## Episode End

    The episode never terminates. `gym.make` truncates it after `max_episode_steps` = 1000 steps.

    ## Information

    The same keys from `reset`, where nothing has happened yet, and from `step`.

    {infos}

    ## Arguments

    All can be written as JSON; `groups` and `scene` may also be a `Groups`, an `Actuator` and a `Scene`. Of an
    `Actuator` the attribute `hold_seconds` tells the length of a step in seconds; else it is None.

    | Argument        | Type           | Default | Description                                                |
    |-----------------|----------------|---------|------------------------------------------------------------|
    | `groups`        | str or mapping | None    | a preset's name, or the groups that differ from the defaults |
    | `scene`         | mapping        | None    | what differs from the default scene, see `Scene`           |
    | `hold`          | float or str   | 0.5     | length of a step, t_c, in (0, 10000]; or "20 ms" of an `Actuator` |
    | `tolerance`     | float          | 1e-6    | of the solver, 1e-15 to 1e-2                                |
    | `dither`        | float          | 0.1     | probability of a flip, 0 to 1/2                             |
    | `memory_weight` | float          | 0.2     | share of memory in the reward, 0 to 1; above 0 needs dither |
    | `delays`        | int            | 20      | delays read out, 1 to 1000                                  |
    | `target`        | str            | "memory" | what is read out: "memory", "parity" or "narma" of the flips |
    | `target_order`  | int            | 2       | innovations in a product, or order of NARMA, 2 to 5         |
    | `virtual_nodes` | int            | 4       | instants of a hold at which the body is read, 1 to 1000     |
    | `valve_history` | int            | 1       | valve states in the observation, 1 to 64                    |
    | `randomize`     | mapping        | None    | group or "slope" -> (low, high), drawn at each reset        |
    | `render_mode`   | str            | None    | `"human"`, `"rgb_array"` or `"rgb_array_list"`              |
    | `slow_motion`   | float          | 1       | of the pictures, 0.01 to 1000: 2 makes them twice as slow   |

    ## Pictures

    Pictures are taken within the holds, from the solver's own trajectory, 30 a second, in which at most 2 t_c pass:
    eight of a hold of 0.5 t_c (240 of a hold at most). `"human"` shows them in a window, `"rgb_array_list"` returns
    those since the last call, and `"rgb_array"` the last one, of which `metadata["render_fps"]` says how many make up a
    second. `stickslip.envs.RecordVideo` films all of them in either mode; Gymnasium's own takes one picture a step.
    The lower half shows what has just happened, and, where there is dither, the flips, the message that is made of
    them, and what the readout recalls of it.

    ## Version History

    * v0: first release.
    """

    metadata: dict[str, Any] = {"render_modes": RENDER_MODES, "render_fps": FPS}  # noqa: RUF012

    render_mode: RenderMode | None

    def __init__(
        self,
        *,
        groups: GroupsLike | None = None,
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
        render_mode: RenderMode | None = None,
        slow_motion: float = 1.0,
    ) -> None:
        self.settings = Settings.of(
            groups=groups,
            scene=scene,
            hold=hold,
            tolerance=tolerance,
            dither=dither,
            memory_weight=memory_weight,
            delays=delays,
            target=target,
            target_order=target_order,
            virtual_nodes=virtual_nodes,
            valve_history=valve_history,
            randomize=randomize,
        )
        self.hold_seconds = hold_in_seconds(self.settings.hold, groups)
        self.render_mode = known_mode(render_mode, self.metadata["render_modes"])
        self._film = film_of(self.settings, self.render_mode, slow_motion)
        self.metadata = {**self.metadata, "render_fps": fps_of(self.settings, self.render_mode, slow_motion)}

        self.action_space = spaces.Discrete(2)
        self.observation_space = observation_space(self.settings.scene, self.settings.valve_history)

        self._samples = samples_of(self.settings.samples)
        self._observation = seen_at_rest(self.settings.valve_history)
        self._answers = np.empty(ANSWERS)
        self._memory: PrequentialMemory | None = None
        self._drawn_from: np.random.Generator | None = None
        self._whereabouts = 0, 0
        self._renderer: Renderer | None = None
        self._readout = NO_MEMORY
        self._body: NDArray[np.float64] | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Put the crawler at rest at the start of the ground.

        Parameters
        ----------
        seed : int, optional
            Of the flips and of the groups drawn.
        options : dict, optional
            Of this episode: ``"groups"``, a mapping of what differs from its groups as they are drawn, or all of them
            by a preset's name, `Groups` or an `Actuator`; and ``"slope"``.

        Returns
        -------
        observation : array of float32
        info : dict

        Raises
        ------
        ValueError, TypeError
            If an option is unknown or wrong; nothing is reset then.
        """
        choice = self.settings.choose(**known_options(options, CRAWLER_OPTIONS))
        super().reset(seed=seed)
        self._calibrate()
        if self._memory is not None:
            self._memory.reset()
            self._readout = self._memory.arrays
        self._settle(*self.settings.draw(self.np_random, choice))
        self._body = rest()
        self._observation = seen_at_rest(self.settings.valve_history)
        self._answers[:] = 0.0
        self._read()[:] = 0.0
        self._steps = 0
        if self.render_mode == "human":
            self.render()
        return self._observation.copy(), begun(self.episode_groups, self.episode_scene)

    def step(self, action: int | np.integer) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Hold the valve as commanded, or flipped, for one hold.

        Parameters
        ----------
        action : int
            0 or 1.

        Returns
        -------
        observation : array of float32
        reward : float
        terminated : bool
            Always False.
        truncated : bool
            Always False; `gym.make` limits the time.
        info : dict

        Raises
        ------
        ValueError
            If `action` is not 0 or 1; nothing is stepped then.
        gymnasium.error.ResetNeeded
            If called before `reset`.
        SolverError
            If the motion diverges.
        """
        body = self._body
        if body is None:
            raise ResetNeeded("step needs a call of reset first")
        command = self._command(action)
        if self._np_random is not self._drawn_from:
            self._draw_from(self.np_random)
        step, fixed, workspace, solver = self._stepper
        weights = self._readout[0]
        if self._film is not None:
            self._follow(self._film)
            weights = weights.copy()  # before they have learned of this step
        status = step(
            body,
            fixed,
            command,
            *self._whereabouts,
            self._samples,
            workspace,
            self._observation,
            self._answers,
            *self._readout,
            self._steps + 1,
        )
        answers = self._answers.tolist()
        if status != FINISHED:
            self._body = None
            began = self._steps * self.settings.hold
            crawler = self.episode_groups, self.episode_scene, self.settings.tolerance
            after, gained = float(body[0]), int(body[SLIPS] - answers[_SLIPS])  # those told are of the step before
            raise solver_error(status, began + answers[ELAPSED], after, MAX_STEPS, *crawler, solver, gained, began)
        self._steps += 1
        if self._film is not None:
            self._film.add(body, self._answers[:_TOLD], self._recalled(weights))
            if self.render_mode == "human":
                self.render()
        # The caller keeps the observation and the groups.
        info = info_of(answers, self._groups.copy(), self._slope)
        return self._observation.copy(), answers[REWARD], False, False, info

    @property
    def np_random(self) -> np.random.Generator:
        """Generator of one number a step, and of what `randomize` draws at a reset; the next step draws from it.

        Raises
        ------
        TypeError
            If it is set to anything but a generator.
        """
        return super().np_random

    @np_random.setter
    def np_random(self, value: np.random.Generator) -> None:
        if not isinstance(value, np.random.Generator):
            raise TypeError(f"np_random must be a numpy.random.Generator, got {value!r}")
        self._np_random, self._np_random_seed = value, -1

    @staticmethod
    def get_keys_to_action() -> dict[tuple[int, ...], int]:
        """Keys and actions for `gymnasium.utils.play`: the space bar opens the valve."""
        return {(ord(" "),): 1}

    def render(self) -> NDArray[np.uint8] | list[NDArray[np.uint8]] | None:  # type: ignore[override]
        """Draw the crawler as it is now, or as it was since the last call.

        Returns
        -------
        (height, width, 3) array of uint8, list of these, or None
            For `render_mode="rgb_array"` the crawler at the end of its hold, for `"rgb_array_list"` all pictures within
            the holds since the last call; None for `"human"`, which has shown them in a window.

        Raises
        ------
        gymnasium.error.ResetNeeded
            If called before `reset`.
        """
        if self.render_mode is None or self._film is None:
            gym.logger.warn(
                "render was called without a render_mode; "
                'make the environment with gym.make("StickSlipCrawler-v0", render_mode="rgb_array")'
            )
            return None
        film, renderer = self._drawing()
        if self.render_mode == "rgb_array":
            return renderer.draw(film.last()[-1], film.world)
        unseen = film.unseen()
        if self.render_mode == "human":
            renderer.show(unseen or film.last()[-1:], film.world)
            return None
        return [renderer.draw(frame, film.world) for frame in unseen]

    def frames(self) -> list[NDArray[np.uint8]]:
        """Draw the last step: every picture within its hold, or the one of a crawler that has been reset.

        Returns
        -------
        list of (height, width, 3) arrays of uint8

        Raises
        ------
        ValueError
            Without a `render_mode`.
        gymnasium.error.ResetNeeded
            If called before `reset`.
        """
        film, renderer = self._drawing()
        return [renderer.draw(frame, film.world) for frame in film.last()]

    def readout_states(self) -> NDArray[np.float64]:
        """What the memory readout has seen of the hold just ended.

        With the innovations, rows of many steps make the capacity that the reward estimates:
        ``stickslip.memory_capacity(states, innovations, delays)``.

        Returns
        -------
        (3 * virtual_nodes,) array of float64
            Deformations at the virtual nodes, then rates, then pressures; 0 of a crawler that was at rest.

        Raises
        ------
        ValueError
            Without dither: there is no message, and nobody reads the body within a hold.
        gymnasium.error.ResetNeeded
            If called before `reset`.
        """
        refuse_unread(self.settings)
        if self._body is None:
            raise ResetNeeded("readout_states needs a call of reset first")
        return self._read().copy()

    def get_state(self, *, generator: bool = True) -> CrawlerState:
        """State of the crawler in its episode, from which any environment of the same arguments can go on.

        A time limit that `gymnasium.make` has put around the environment counts on its own.

        Parameters
        ----------
        generator : bool
            Whether the generator of the flips to come is a part of it.

        Returns
        -------
        CrawlerState

        Raises
        ------
        gymnasium.error.ResetNeeded
            If there is no episode.
        """
        if self._body is None:
            raise ResetNeeded("get_state needs a call of reset first")
        return CrawlerState(
            self.settings,
            self.episode_groups,
            self.episode_scene,
            self._body.copy(),
            self._steps,
            self._observation.copy(),
            self._answers[:_TOLD].copy(),
            self._read().copy(),
            () if self._memory is None else self._memory.packed(),
            False,
            deepcopy(self.np_random) if generator else None,
            self.np_random_seed if generator else None,
        )

    def set_state(self, state: CrawlerState) -> None:
        """Go on from a state, to the last bit; its flips are the same too if it has a generator.

        Parameters
        ----------
        state : CrawlerState
            Of an environment, single or in a batch, of the same arguments.

        Raises
        ------
        TypeError, ValueError
            If it is none, or of an environment of other arguments, or of another version; nothing is set then.
        """
        refuse_foreign(state, self.settings)
        self._calibrate()
        self._settle(state.groups, state.scene)
        if self._memory is not None:
            self._memory.unpack(state.readout, state.steps)
            self._readout = self._memory.arrays
        self._body = state.body.copy()
        self._observation = state.observation.copy()
        self._answers[:_TOLD] = state.told
        self._read()[:] = state.read
        self._steps = state.steps
        if state.generator is not None:
            self._np_random, self._np_random_seed = deepcopy(state.generator), state.seed
        self._draw_from(self.np_random)  # which there is none of before the first reset

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def __getstate__(self) -> dict[str, Any]:
        # A window cannot be copied; the copy opens its own.
        # Its generator lies elsewhere.
        return {**self.__dict__, "_renderer": None, "_drawn_from": None}

    def _drawing(self) -> tuple[Film, Renderer]:
        """What is drawn, up to now, and what draws it."""
        if self._film is None:
            raise ValueError("frames needs a render_mode, got an environment without")
        if self._body is None:
            raise ResetNeeded("render needs a call of reset first")
        self._follow(self._film)
        if self._renderer is None:
            self._renderer = Renderer()
        return self._film, self._renderer

    def _follow(self, film: Film) -> None:
        """Have a film begin anew where the crawler does not go on from its end: after a reset, or set to a state."""
        body = self._body
        assert body is not None
        if not film.follows(body, self._steps):
            film.begin(self.episode_groups, self.episode_scene, body, self._steps, self._answers[:_TOLD])

    def _recalled(self, weights: NDArray[np.float64]) -> Recalled | None:
        """Message so far, and what a readout with these weights makes of the last hold."""
        if self._memory is None:
            return None
        scaling, past = self._readout[3][:2, :-1], self._readout[2][0]
        return recalled_of(self.settings, weights, scaling, self._read(), past, self._steps)

    def _calibrate(self) -> None:
        if self._memory is None and self.settings.dither > 0.0:
            self._memory = calibrated_memory(self.settings, calibration_states(self.settings))

    def _read(self) -> NDArray[np.float64]:
        """Deformations, rates and pressures at the nodes of the last hold; of one node, for nobody, without dither."""
        return self._samples[:3].reshape(-1)

    def _settle(self, groups: Groups, scene: Scene) -> None:
        """Who crawls where in the episode."""
        self.episode_groups, self.episode_scene = groups, scene
        self._groups, self._slope = groups.to_dict(), scene.slope
        self._stepper = stepper_for(self.settings, groups, scene)

    def _draw_from(self, generator: np.random.Generator) -> None:
        self._drawn_from = generator
        if self.settings.dither > 0.0:
            self._whereabouts = whereabouts(generator)

    @staticmethod
    def _command(action: int | np.integer) -> int:
        """`action` as an int; quicker than the space's own test, which costs as much as the physics."""
        try:
            command = operator.index(action)
        except TypeError:  # NumPy's bool is no index, though Python's is
            truth = isinstance(action, np.bool_ | np.ndarray) and action.dtype == np.bool_ and action.ndim == 0
            command = int(action) if truth else -1
        if command not in (0, 1):
            raise ValueError(f"action must be 0 or 1, got {action!r}")
        return command


if StickSlipCrawlerEnv.__doc__:  # which Python leaves out where it is told to
    # Newer Pythons take away the indentation themselves.
    StickSlipCrawlerEnv.__doc__ = cleandoc(StickSlipCrawlerEnv.__doc__).replace("{infos}", table_of_infos().strip())
