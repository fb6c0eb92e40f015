"""StickSlipCrawler-v0: one crawler, one valve decision a step."""

import operator
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from ..crawler import GroupsLike, Scene
from ..crawler.body import STUCK
from ..crawler.control import FINISHED, MAX_STEPS
from ..crawler.simulation import solver_error
from ..reservoir.prequential import PrequentialMemory
from .calibration import calibrated_memory
from .rendering import Frame, Renderer
from .settings import begun, FLIPS, Settings
from .stepping import calibration_states, rest, stepper_for

__all__ = ["StickSlipCrawlerEnv"]

_FOOT = 3  # in the body's array


class StickSlipCrawlerEnv(gym.Env[NDArray[np.float32], np.int64]):
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

    `Box` of shape `(5,)` and dtype `float32`, the state at the end of the hold. Bounds are infinite where the physics
    sets none.

    | Num | Observation                           | Min    | Max     | Unit      |
    |-----|---------------------------------------|--------|---------|-----------|
    | 0   | deformation z of the body             | -Inf   | Inf     | z_c       |
    | 1   | rate v of the deformation             | -Inf   | Inf     | z_c / t_c |
    | 2   | pressure p                            | 0      | 1       | P_max     |
    | 3   | velocity w of the foot                | 0, or -Inf without ratchet | Inf | z_c / t_c |
    | 4   | valve state u, after the flip         | 0      | 1       |           |

    The foot's position is not observed: nothing depends on it.

    ## Rewards

    `(1 - memory_weight) * speed + memory_weight * memory`, with both terms in `info`.

    - *speed*: distance that the foot travelled in the hold, over the hold's length, z_c / t_c.
    - *memory*: $\sum_d (e_{k-d}^2 - (e_{k-d} - \hat e_{k-d})^2) / \mathrm{Var}\,e$ over `delays` delays from 0, where
      $\hat e_{k-d}$ is read from the deformation, rate and pressure at `virtual_nodes` instants of the hold by a
      recursive least-squares readout that has not yet learned $e_{k-d}$. Its mean tends to the memory capacity. Every
      episode starts from the same calibrated readout. Without dither there is no message, and this term is 0.

    ## Starting State

    At rest, with the valve shut and the foot at 0. What `randomize` names is drawn uniformly from its range at every
    reset.

    ## Episode End

    The episode never terminates. `gym.make` truncates it after `max_episode_steps` = 1000 steps.

    ## Information

    The same keys from `reset`, where nothing has happened yet, and from `step`.

    | Key          | Type             | Description                                             | At reset |
    |--------------|------------------|---------------------------------------------------------|----------|
    | `speed`      | float            | of the foot, its mean over the hold, z_c / t_c          | 0        |
    | `memory`     | float            | what the readout earned                                 | 0        |
    | `distance`   | float            | of the foot from its start, z_c                         | 0        |
    | `innovation` | float            | e_k                                                     | 0        |
    | `valve`      | int              | u_k, after the flip                                     | 0        |
    | `slips`      | int              | so far in the episode                                   | 0        |
    | `groups`     | dict of floats   | the episode's own, by name                              | the same |
    | `slope`      | float            | the episode's own                                       | the same |

    ## Arguments

    All can be written as JSON; `groups` and `scene` may also be a `Groups`, an `Actuator` and a `Scene`.

    | Argument        | Type           | Default | Description                                                |
    |-----------------|----------------|---------|------------------------------------------------------------|
    | `groups`        | str or mapping | None    | a preset's name, or the groups that differ from the defaults |
    | `scene`         | mapping        | None    | what differs from the default scene, see `Scene`           |
    | `hold`          | float          | 0.5     | length of a step, t_c, in (0, 10000]                        |
    | `tolerance`     | float          | 1e-6    | of the solver, 1e-15 to 1e-2                                |
    | `dither`        | float          | 0.1     | probability of a flip, 0 to 1/2                             |
    | `memory_weight` | float          | 0.5     | share of memory in the reward, 0 to 1; above 0 needs dither |
    | `delays`        | int            | 20      | delays read out, 1 to 1000                                  |
    | `virtual_nodes` | int            | 4       | instants of a hold at which the body is read, 1 to 1000     |
    | `randomize`     | mapping        | None    | group or "slope" -> (low, high), drawn at each reset        |
    | `render_mode`   | str            | None    | `"human"` or `"rgb_array"`                                  |

    ## Version History

    * v0: first release.
    """

    metadata: dict[str, Any] = {"render_modes": ["human", "rgb_array"], "render_fps": 30}  # noqa: RUF012

    render_mode: Literal["human", "rgb_array"] | None

    def __init__(
        self,
        *,
        groups: GroupsLike | None = None,
        scene: Mapping[str, Any] | Scene | None = None,
        hold: float = 0.5,
        tolerance: float = 1e-6,
        dither: float = 0.1,
        memory_weight: float = 0.5,
        delays: int = 20,
        virtual_nodes: int = 4,
        randomize: Mapping[str, Sequence[float]] | None = None,
        render_mode: Literal["human", "rgb_array"] | None = None,
    ) -> None:
        self.settings = Settings.of(
            groups=groups,
            scene=scene,
            hold=hold,
            tolerance=tolerance,
            dither=dither,
            memory_weight=memory_weight,
            delays=delays,
            virtual_nodes=virtual_nodes,
            randomize=randomize,
        )
        if render_mode not in (None, "human", "rgb_array"):
            raise ValueError(f"render_mode must be one of {self.metadata['render_modes']} or None, got {render_mode!r}")
        self.render_mode = render_mode

        self.action_space = spaces.Discrete(2)
        self.observation_space = self.settings.observation_space()

        self._samples = np.empty((5, self.settings.samples))
        self._states = self._samples[:3].reshape(-1)
        self._memory: PrequentialMemory | None = None
        self._renderer: Renderer | None = None
        self._frame: Frame | None = None
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
            None is known.

        Returns
        -------
        observation : (5,) array of float32
        info : dict
        """
        super().reset(seed=seed)
        if seed is not None or self._body is None:
            self._flips: list[bool] = []
        settings = self.settings
        if settings.dither > 0.0:
            if self._memory is None:
                self._memory = calibrated_memory(settings, calibration_states(settings))
            self._memory.reset()
        self.episode_groups, self.episode_scene = settings.draw(self.np_random)
        self._stepper = stepper_for(
            self.episode_groups, self.episode_scene, settings.hold, settings.tolerance, settings.samples
        )
        self._body = rest()
        self._steps = 0
        self._frame = Frame(0.0, 0.0, 0.0, 0.0, STUCK, False, 0, 0.0, None)
        if self.render_mode == "human":
            self.render()
        info = begun(self.episode_groups, self.episode_scene)
        self._groups, self._slope = info["groups"].copy(), info["slope"]
        return np.zeros(5, np.float32), info

    def step(self, action: int | np.integer) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Hold the valve as commanded, or flipped, for one hold.

        Parameters
        ----------
        action : int
            0 or 1.

        Returns
        -------
        observation : (5,) array of float32
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
        body, settings = self._body, self.settings
        if body is None:
            raise ResetNeeded("step needs a call of reset first")
        command = self._command(action)
        valve = command ^ self._flip()
        start = float(body[_FOOT])
        observation = np.empty(5, np.float32)
        hold_valve, fixed, workspace, solver = self._stepper
        status, elapsed = hold_valve(body, fixed, valve, self._samples, workspace, observation)
        if status != FINISHED:
            self._body = None
            reached = self._steps * settings.hold + elapsed
            crawler = self.episode_groups, self.episode_scene, settings.tolerance
            raise solver_error(status, reached, float(body[0]), MAX_STEPS, *crawler, solver)
        self._steps += 1

        deformation, _, pressure, foot, _, motion, slips = body.tolist()
        speed = (foot - start) / settings.hold
        innovation = valve - abs(command - settings.dither)
        memory = 0.0 if self._memory is None else self._memory.score(self._states, innovation)
        reward = (1.0 - settings.memory_weight) * speed + settings.memory_weight * memory
        if self.render_mode is not None:
            self._frame = Frame(
                self._steps * settings.hold,
                deformation,
                pressure,
                foot,
                int(motion),
                foot != start,
                valve,
                speed,
                None if self._memory is None else memory,
            )
            if self.render_mode == "human":
                self.render()
        info = {
            "speed": speed,
            "memory": memory,
            "distance": foot,
            "innovation": innovation,
            "valve": valve,
            "slips": int(slips),
            "groups": self._groups.copy(),  # the caller keeps it
            "slope": self._slope,
        }
        return observation, reward, False, False, info

    def render(self) -> NDArray[np.uint8] | None:
        """Draw the crawler as it is now.

        Returns
        -------
        (height, width, 3) array of uint8, or None
            None for `render_mode="human"`, which shows a window.

        Raises
        ------
        gymnasium.error.ResetNeeded
            If called before `reset`.
        """
        if self.render_mode is None:
            gym.logger.warn(
                "render was called without a render_mode; "
                'make the environment with gym.make("StickSlipCrawler-v0", render_mode="rgb_array")'
            )
            return None
        if self._frame is None:
            raise ResetNeeded("render needs a call of reset first")
        if self._renderer is None:
            self._renderer = Renderer(self.render_mode, self.metadata["render_fps"])
        return self._renderer.draw(self._frame)

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def __getstate__(self) -> dict[str, Any]:
        # A window cannot be copied; the copy opens its own.
        return {**self.__dict__, "_renderer": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._states = self._samples[:3].reshape(-1)  # a view, of which the copy was made apart

    def _flip(self) -> bool:
        """Whether the next command is flipped."""
        if self.settings.dither == 0.0:
            return False
        if not self._flips:
            self._flips = (self.np_random.random(FLIPS) < self.settings.dither)[::-1].tolist()
        return self._flips.pop()

    @staticmethod
    def _command(action: int | np.integer) -> int:
        """`action` as an int; quicker than the space's own test, which costs as much as the physics."""
        try:
            command = operator.index(action)
        except TypeError:
            command = -1
        if command not in (0, 1):
            raise ValueError(f"action must be 0 or 1, got {action!r}")
        return command
