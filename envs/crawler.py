"""StickSlipCrawler-v0: one crawler, one valve decision a step."""

import operator
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from ..crawler import Groups, Scene
from ..crawler.body import STUCK
from ..crawler.control import FINISHED, MAX_STEPS
from ..crawler.groups import RANGES
from ..crawler.simulation import solver_error, TOLERANCES
from ..reservoir.prequential import PrequentialMemory
from ..validation import known_names, number_within, whole_number
from .rendering import Frame, Renderer
from .stepping import rest, stepper_for

__all__ = ["StickSlipCrawlerEnv"]

# Longer holds are for `simulate`: here a hold of 10^4 already takes as long as the 10^4 steps of a policy.
_HOLDS = "(0, 10000]"
# Of delays and of virtual nodes: the readout's covariance has the square of the latter.
_MOST = 1000
# Random commands that calibrate the memory readout, enough for the scale of each feature to a few percent; fewer
# where holds are long, but never fewer than this many.
_CALIBRATION = 2000
_CALIBRATION_TIME = 20_000.0
_LEAST_CALIBRATION = 100
_CALIBRATION_SEED = 0
# Flips are drawn from the generator this many at a time, which costs a tenth of drawing each alone.
_BLOCK = 256

_FOOT = 3  # in the body's array
_LARGEST = float(np.finfo(np.float32).max)


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

    `Box` of shape `(5,)` and dtype `float32`, the state at the end of the hold. Bounds of plus or minus the largest
    float32 mean that the physics sets none.

    | Num | Observation                           | Min    | Max     | Unit      |
    |-----|---------------------------------------|--------|---------|-----------|
    | 0   | deformation z of the body             | -3.4e38 | 3.4e38 | z_c       |
    | 1   | rate v of the deformation             | -3.4e38 | 3.4e38 | z_c / t_c |
    | 2   | pressure p                            | 0      | 1       | P_max     |
    | 3   | velocity w of the foot                | 0, or -3.4e38 without ratchet | 3.4e38 | z_c / t_c |
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

    At rest, with the valve shut and the foot at 0. With `randomize`, each named group is drawn uniformly from its
    range at every reset.

    ## Episode End

    The episode never terminates. `gym.make` truncates it after `max_episode_steps` = 1000 steps.

    ## Information

    `step` gives `speed`, `memory`, `distance` (of the foot from its start, z_c), `valve` (u_k), `innovation` (e_k) and
    `slips` (so far in the episode). `reset` gives `groups`, the episode's own.

    ## Arguments

    All can be written as JSON.

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
    | `randomize`     | mapping        | None    | group -> (low, high), drawn at each reset                   |
    | `render_mode`   | str            | None    | `"human"` or `"rgb_array"`                                  |

    ## Version History

    * v0: first release.
    """

    metadata: dict[str, Any] = {"render_modes": ["human", "rgb_array"], "render_fps": 30}  # noqa: RUF012

    render_mode: Literal["human", "rgb_array"] | None

    def __init__(
        self,
        *,
        groups: str | Mapping[str, float] | Groups | None = None,
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
        self.groups = Groups.of(groups)
        self.scene = Scene.of(scene)
        if self.scene.segments > 1 or self.scene.tube_mass > 0.0:
            raise ValueError(
                f"scene of the environment must have segments = 1 and tube_mass = 0, got segments = "
                f"{self.scene.segments} and tube_mass = {self.scene.tube_mass!r}: use simulate"
            )
        self.hold = number_within("hold", hold, _HOLDS)
        self.tolerance = number_within("tolerance", tolerance, TOLERANCES)
        self.dither = number_within("dither", dither, "[0, 0.5]")
        self.memory_weight = number_within("memory_weight", memory_weight, "[0, 1]")
        self.delays = whole_number("delays", delays, 1, _MOST)
        self.virtual_nodes = whole_number("virtual_nodes", virtual_nodes, 1, _MOST)
        self.randomize = _ranges(randomize, self.groups)
        if self.memory_weight > 0.0 and self.dither == 0.0:
            raise ValueError(
                f"dither must be in (0, 0.5] where memory_weight = {self.memory_weight!r} > 0, got {dither!r}: "
                "without flips there is no message to remember"
            )
        if render_mode not in (None, "human", "rgb_array"):
            raise ValueError(f"render_mode must be one of {self.metadata['render_modes']} or None, got {render_mode!r}")
        self.render_mode = render_mode

        self.action_space = spaces.Discrete(2)
        backward = 0.0 if self.scene.ratchet or self.scene.anchored else -_LARGEST
        self.observation_space = spaces.Box(
            np.array([-_LARGEST, -_LARGEST, 0.0, backward, 0.0], np.float32),
            np.array([_LARGEST, _LARGEST, 1.0, _LARGEST, 1.0], np.float32),
        )

        self._samples = np.empty((5, self.virtual_nodes))
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
        if self.dither > 0.0:
            if self._memory is None:
                self._memory = self._calibrate()
            self._memory.reset()
        drawn = {name: float(self.np_random.uniform(low, high)) for name, (low, high) in self.randomize.items()}
        self.episode_groups = Groups(**{**self.groups.to_dict(), **drawn})
        self._stepper = stepper_for(self.episode_groups, self.scene, self.hold, self.tolerance, self.virtual_nodes)
        self._body = rest()
        self._steps = 0
        self._frame = Frame(0.0, 0.0, 0.0, 0.0, STUCK, False, 0, 0.0, None)
        if self.render_mode == "human":
            self.render()
        return np.zeros(5, np.float32), {"groups": self.episode_groups.to_dict()}

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
        body = self._body
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
            reached = self._steps * self.hold + elapsed
            raise solver_error(
                status, reached, float(body[0]), MAX_STEPS, self.episode_groups, self.scene, self.tolerance, solver
            )
        self._steps += 1

        deformation, _, pressure, foot, _, motion, slips = body.tolist()
        speed = (foot - start) / self.hold
        innovation = valve - abs(command - self.dither)
        memory = 0.0 if self._memory is None else self._memory.score(self._states, innovation)
        reward = (1.0 - self.memory_weight) * speed + self.memory_weight * memory
        if self.render_mode is not None:
            self._frame = Frame(
                self._steps * self.hold,
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
            "valve": valve,
            "innovation": innovation,
            "slips": int(slips),
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
        if self.dither == 0.0:
            return False
        if not self._flips:
            self._flips = (self.np_random.random(_BLOCK) < self.dither)[::-1].tolist()
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

    def _calibrate(self) -> PrequentialMemory:
        """Memory readout that has seen this body under random commands, dithered as in the episodes."""
        affordable = int(min(_CALIBRATION_TIME / self.hold, _CALIBRATION))
        holds = self.delays + max(affordable, _LEAST_CALIBRATION)
        generator = np.random.default_rng(_CALIBRATION_SEED)
        commands = generator.integers(0, 2, holds)
        valves = commands ^ (generator.random(holds) < self.dither)
        states = np.empty((holds, self._states.size))
        hold_valve, fixed, workspace, solver = stepper_for(
            self.groups, self.scene, self.hold, self.tolerance, self.virtual_nodes
        )
        body, observation = rest(), np.empty(5, np.float32)
        for k, valve in enumerate(valves.tolist()):
            status, elapsed = hold_valve(body, fixed, valve, self._samples, workspace, observation)
            if status != FINISHED:
                reached = k * self.hold + elapsed
                raise solver_error(
                    status, reached, float(body[0]), MAX_STEPS, self.groups, self.scene, self.tolerance, solver
                )
            states[k] = self._states
        return PrequentialMemory(
            states,
            valves - np.abs(commands - self.dither),
            self.delays,
            variance=self.dither * (1.0 - self.dither),
        )


def _ranges(randomize: Mapping[str, Sequence[float]] | None, groups: Groups) -> dict[str, tuple[float, float]]:
    """Ranges to draw from, in the order of the groups' fields, after a look at both ends of each."""
    if randomize is None:
        return {}
    if not isinstance(randomize, Mapping):
        raise TypeError(f"randomize must be a mapping of group to (low, high), got {randomize!r}")
    known = groups.to_dict()
    known_names("randomize", randomize, known)
    for name, given in randomize.items():
        if isinstance(given, str) or not isinstance(given, Sequence) or len(given) != 2:
            raise ValueError(f"randomize {name} must be a pair (low, high), got {given!r}")
    ranges = {}
    for name in known:
        if name in randomize:
            low, high = (number_within(f"randomize {name}", end, RANGES[name]) for end in randomize[name])
            if low > high:
                raise ValueError(f"randomize {name} must be a pair with low <= high, got {randomize[name]!r}")
            ranges[name] = (low, high)
    # The one range that depends on another group: the worst draw of both is refused here, not in some later episode.
    Groups(
        **{
            **known,
            "static_friction": ranges.get("static_friction", (groups.static_friction,))[0],
            "kinetic_friction": ranges.get("kinetic_friction", (groups.kinetic_friction,))[-1],
        }
    )
    return ranges
