import ast
import copy
import inspect
import itertools
import json
import pickle
import re
import subprocess
import sys
import warnings

import gymnasium as gym
import numpy as np
import pygame
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.utils.play import play
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers import DiscretizeObservation, RescaleObservation

import stickslip
from stickslip import Actuator, Groups, Scene, simulate
from stickslip.crawler import SolverError
from stickslip.envs import StickSlipCrawlerEnv

NAME = "StickSlipCrawler-v0"
SPEED_ONLY = {"dither": 0.0, "memory_weight": 0.0}
ARGUMENTS = [
    {},
    SPEED_ONLY,
    {"groups": "high-damping", "scene": {"ratchet": False}, "hold": 2.0, "tolerance": 1e-9},
    {"groups": {"deborah": 2.0}, "scene": {"anchored": True}, "dither": 0.5, "memory_weight": 1.0, "virtual_nodes": 1},
    {"randomize": {"duffing": [0.1, 2.0], "static_friction": [0.2, 0.5]}, "delays": 3, "valve_history": 4},
]


def rollout(env, actions):
    return [env.step(int(action)) for action in actions]


def assert_same_steps(one, other):
    for (observation, *rest), (expected, *others) in zip(one, other, strict=True):
        np.testing.assert_array_equal(observation, expected)
        assert rest == others


def commands(steps, seed=0):
    return np.random.default_rng(seed).integers(0, 2, steps)


@pytest.mark.parametrize("arguments", ARGUMENTS, ids=str)
def test_gymnasium_finds_no_fault_but_that_the_physics_sets_no_bound(arguments):
    # Its pictures, which take most of the time, are the same for all.
    mode = "rgb_array" if not arguments else None
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        warnings.simplefilter("ignore", EncodingWarning)  # of other packages, as they are imported
        check_env(gym.make(NAME, render_mode=mode, **arguments).unwrapped, skip_render_check=mode is None)
    assert len(caught) == 2
    for warning, bound in zip(caught, ("minimum value is -infinity", "maximum value is infinity"), strict=True):
        assert f"A Box observation space {bound}" in str(warning.message)


@pytest.mark.parametrize("arguments", ARGUMENTS, ids=str)
def test_what_knows_no_bound_says_so(arguments):
    space = gym.make(NAME, **arguments).observation_space
    scene = Scene.of(arguments.get("scene"))
    backward = 0.0 if scene.ratchet or scene.anchored else -np.inf
    history = arguments.get("valve_history", 1)
    np.testing.assert_array_equal(space.low, np.float32([-np.inf, -np.inf, 0, backward, *[0] * history]))
    np.testing.assert_array_equal(space.high, np.float32([np.inf, np.inf, 1, np.inf, *[1] * history]))
    table = inspect.getdoc(StickSlipCrawlerEnv).split("## Observation Space")[1].split("## Rewards")[0]
    rows = [
        [cell.strip() for cell in row.split("|")[3:5]] for row in table.splitlines() if row[:3].strip("| .").isdigit()
    ]
    foot, valve = ["0, or -Inf without ratchet", "Inf"], ["0", "1"]
    assert rows == [["-Inf", "Inf"], ["-Inf", "Inf"], ["0", "1"], foot, valve, valve]


@pytest.mark.parametrize("wrap", [RescaleObservation, DiscretizeObservation])
def test_wrappers_that_need_bounds_refuse_it(wrap):
    arguments = {"min_obs": -1.0, "max_obs": 1.0} if wrap is RescaleObservation else {"bins": 10}
    with pytest.raises((AssertionError, ValueError)):
        wrap(gym.make(NAME), **arguments)


def kinds_of(info):
    return {name: kinds_of(value) if isinstance(value, dict) else type(value) for name, value in info.items()}


@pytest.mark.parametrize("arguments", ARGUMENTS, ids=str)
def test_reset_tells_what_a_step_does(arguments):
    env = gym.make(NAME, **arguments)
    begun, stepped = env.reset(seed=0)[1], env.step(1)[4]
    assert kinds_of(begun) == kinds_of(stepped)
    assert list(begun) == list(stepped)
    assert kinds_of(begun) == {
        **dict.fromkeys(("speed", "memory", "distance", "innovation", "slope"), float),
        **dict.fromkeys(("valve", "slips"), int),
        "groups": dict.fromkeys(Groups().to_dict(), float),
    }
    assert not any(value for name, value in begun.items() if name not in ("groups", "slope"))
    assert begun["groups"] == stepped["groups"] == env.unwrapped.episode_groups.to_dict()


def test_what_the_caller_does_to_an_info_does_not_matter():
    env = gym.make(NAME)
    env.reset(seed=0)[1]["groups"].clear()
    env.step(1)[4]["groups"].clear()
    assert env.step(1)[4]["groups"] == Groups().to_dict()


def test_gymnasium_finds_it_by_name_without_import():
    code = (
        "import sys, gymnasium; env = gymnasium.make('stickslip:StickSlipCrawler-v0'); env.reset(); env.step(1);"
        "assert type(env.unwrapped).__module__ == 'stickslip.envs.single'"
    )
    subprocess.run([sys.executable, "-W", "error", "-c", code], check=True)


def test_importing_the_package_is_light():
    heavy = "numba", "sklearn", "scipy", "torch", "matplotlib", "pygame", "moviepy", "typer", "rich"
    code = f"import sys, stickslip; loaded = set({heavy}) & set(sys.modules); assert not loaded, loaded"
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize(
    "arguments",
    [
        {},
        {"scene": {"anchored": True}, "virtual_nodes": 3},
        {"scene": {"ratchet": False}, "groups": {"static_friction": 0.1, "kinetic_friction": 0.05}},
        {"groups": "aggressive-forcing", "hold": 2.0, "tolerance": 1e-12, "dither": 0.3},
    ],
    ids=str,
)
def test_it_moves_as_simulated_bit_for_bit(arguments):
    env = gym.make(NAME, **arguments).unwrapped
    env.reset(seed=5)
    observations, _, _, _, infos = zip(*rollout(env, commands(400)), strict=True)
    valve = [info["valve"] for info in infos]
    motion = simulate(
        env.settings.groups,
        valve,
        env.settings.hold,
        scene=env.settings.scene,
        tolerance=env.settings.tolerance,
        samples_per_hold=env.settings.virtual_nodes,
    )
    ends = slice(env.settings.virtual_nodes - 1, None, env.settings.virtual_nodes)
    expected = np.column_stack([motion.deformation, motion.velocity, motion.pressure, motion.foot_velocity])[ends]
    np.testing.assert_array_equal(observations, np.column_stack([expected, valve]).astype(np.float32))
    np.testing.assert_array_equal([info["distance"] for info in infos], motion.foot[ends])
    assert infos[-1]["slips"] == motion.slips
    assert infos[-1]["slips"] > 0 or env.settings.scene.anchored


def test_a_seed_fixes_the_episode_whatever_came_before():
    fresh, used = gym.make(NAME), gym.make(NAME)
    used.reset(seed=1)
    rollout(used, commands(300, seed=9))
    for env in (fresh, used):
        env.reset(seed=2)
    assert_same_steps(rollout(fresh, commands(600)), rollout(used, commands(600)))
    used.reset(seed=3)
    assert [s[4]["valve"] for s in rollout(used, commands(100))] != list(commands(100))


def test_reset_without_a_seed_goes_on_and_with_one_begins_anew():
    env = gym.make(NAME)
    episodes = []
    for seed in (4, None, 4, None):
        env.reset(seed=seed)
        episodes.append(rollout(env, commands(200)))
    assert_same_steps(episodes[0], episodes[2])
    assert_same_steps(episodes[1], episodes[3])
    flips = [[info["valve"] for *_, info in episode] for episode in episodes]
    assert flips[0] != flips[1]


def test_the_action_space_can_be_seeded():
    env = gym.make(NAME)
    draws = []
    for _ in range(2):
        env.action_space.seed(3)
        draws.append([env.action_space.sample() for _ in range(50)])
    assert draws[0] == draws[1]
    assert set(draws[0]) == {0, 1}


@pytest.mark.parametrize(
    "twin_of", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))], ids=["copy", "pickle"]
)
@pytest.mark.parametrize("arguments", [{}, SPEED_ONLY], ids=["default", "speed"])
def test_a_copy_goes_on_as_the_original_would(twin_of, arguments):
    env = gym.make(NAME, **arguments)
    env.reset(seed=1)
    rollout(env, commands(70))
    twin = twin_of(env)
    ensemble = rollout(twin, commands(300, seed=1))
    assert_same_steps(ensemble, rollout(env, commands(300, seed=1)))


def test_observations_are_float32_within_bounds_and_independent():
    env = gym.make(NAME, dither=0.5)
    first, _ = env.reset(seed=0)
    observations = [first, *(step[0] for step in rollout(env, commands(999)))]
    kept = copy.deepcopy(observations)
    rollout(env, [1])
    for observation, before in zip(observations, kept, strict=True):
        assert observation.dtype == np.float32
        assert observation in env.observation_space
        np.testing.assert_array_equal(observation, before)
    assert not any(np.shares_memory(a, b) for a, b in itertools.pairwise(observations))


def test_without_ratchet_the_foot_goes_backward_within_bounds():
    arguments = {"scene": {"ratchet": False}, "groups": {"static_friction": 0.02, "kinetic_friction": 0.01}}
    env = gym.make(NAME, hold=1.0, **arguments)
    env.reset(seed=0)
    observations = [step[0] for step in rollout(env, commands(300))]
    assert min(observation[3] for observation in observations) < 0
    assert all(observation in env.observation_space for observation in observations)


def test_the_arguments_survive_json():
    arguments = {
        "groups": Groups(deborah=1.0).to_dict(),
        "scene": Scene(ratchet=False).to_dict(),
        "hold": 0.7,
        "randomize": {"duffing": [0.1, 2.0]},
        "dither": 0.2,
        "valve_history": 3,
    }
    env = gym.make(NAME, **arguments)
    kwargs = json.loads(json.dumps(env.spec.kwargs))
    assert kwargs == arguments
    again, loaded = gym.make(env.spec), gym.make(gym.envs.registration.EnvSpec.from_json(env.spec.to_json()))
    for twin in (env, again, loaded, gym.make(NAME, **kwargs)):
        assert twin.unwrapped.settings.groups == Groups(deborah=1.0)
        twin.reset(seed=3)
    steps = rollout(env, commands(50))
    for twin in (again, loaded):
        assert_same_steps(steps, rollout(twin, commands(50)))


@pytest.mark.parametrize("make", [gym.make, lambda name, **arguments: gym.make_vec(name, 2, **arguments)])
def test_numbers_of_numpy_and_what_stands_for_groups_survive_json(make):
    arguments = {
        "groups": {"duffing": np.float32(0.75)},
        "scene": {"ratchet": np.bool_(False), "slope": np.float64(0.1)},
        "hold": np.float32(0.7),
        "delays": np.int64(3),
        "virtual_nodes": np.uint8(2),
        "randomize": {"deborah": np.array([0.5, 1.0], np.float32), "damping_ratio": (np.float32(0.0), 1)},
    }
    env = make(NAME, **arguments)
    for spec in (env.spec, env.unwrapped.spec):
        kwargs = gym.envs.registration.EnvSpec.from_json(spec.to_json()).kwargs
        assert kwargs["hold"] == float(np.float32(0.7))
        again = make(NAME, **{name: kwargs[name] for name in arguments})
        assert again.unwrapped.settings == env.unwrapped.settings
    for groups in (Groups(duffing=2.0), Actuator.ecoflex(), {"duffing": 1}, "linear"):
        env = make(NAME, groups=groups, scene=Scene(slope=0.1))
        kwargs = json.loads(env.spec.to_json())["kwargs"]
        assert Groups.of(kwargs["groups"]) == Groups.of(groups)
        assert Scene.of(kwargs["scene"]) == Scene(slope=0.1)


def test_a_batch_of_several_groups_survives_json():
    env = gym.make_vec(NAME, 2, groups=["linear", Groups(deborah=2.0)], autoreset_mode=AutoresetMode.SAME_STEP)
    spec = gym.envs.registration.EnvSpec.from_json(env.spec.to_json())
    twin = gym.make_vec(spec)
    assert twin.get_attr("settings") == env.get_attr("settings")
    assert twin.autoreset_mode is AutoresetMode.SAME_STEP


def test_the_space_bar_opens_the_valve(monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    env = gym.make(NAME, render_mode="rgb_array", dither=0.0, memory_weight=0.0)
    valves = []

    def watch(*step):
        valves.append(step[-1]["valve"])
        kinds = {3: pygame.KEYDOWN, 6: pygame.KEYUP}
        if len(valves) in kinds:
            pygame.event.post(pygame.event.Event(kinds[len(valves)], key=pygame.K_SPACE))
        elif len(valves) == 8:
            pygame.event.post(pygame.event.Event(pygame.QUIT))

    play(env, fps=1000, callback=watch)
    assert valves == [0, 0, 0, 1, 1, 1, 0, 0]


def test_an_episode_is_a_thousand_steps_and_never_terminates():
    env = gym.make(NAME)
    env.reset(seed=0)
    steps = rollout(env, commands(1000))
    assert not any(terminated for _, _, terminated, _, _ in steps)
    assert [truncated for _, _, _, truncated, _ in steps] == [False] * 999 + [True]


def test_groups_are_drawn_anew_for_every_episode():
    ranges = {"duffing": [0.1, 2.0], "kinetic_friction": [0.0, 0.2], "deborah": [0.7, 0.7]}
    env, twin = gym.make(NAME, randomize=ranges), gym.make(NAME, randomize=ranges)
    drawn = [env.reset(seed=11 if episode == 0 else None)[1]["groups"] for episode in range(40)]
    assert [twin.reset(seed=11 if episode == 0 else None)[1]["groups"] for episode in range(40)] == drawn
    for name, (low, high) in ranges.items():
        values = np.array([groups[name] for groups in drawn])
        assert ((low <= values) & (values <= high)).all()
        # The mean of 40 uniform draws has standard deviation (high - low) / sqrt(480).
        assert abs(values.mean() - (low + high) / 2) <= 4 * (high - low) / np.sqrt(480)
        assert len(set(values)) == (40 if high > low else 1)
    fixed = Groups().to_dict().keys() - ranges
    assert all(groups[name] == getattr(Groups(), name) for groups in drawn for name in fixed)


def test_the_drawn_groups_are_those_that_move():
    env = gym.make(NAME, randomize={"duffing": [1.0, 3.0]}, **SPEED_ONLY)
    _, info = env.reset(seed=0)
    assert info["groups"] == env.unwrapped.episode_groups.to_dict()
    steps = rollout(env, commands(100))
    motion = simulate(Groups(**info["groups"]), commands(100), 0.5, tolerance=1e-6)
    # Virtual nodes move the solver's steps, so that one sample a hold agrees only to the tolerance.
    assert steps[-1][4]["distance"] == pytest.approx(motion.foot[-1], abs=1e-3)


def test_a_diverged_motion_has_to_be_reset():
    env = gym.make(NAME, groups={"radial_coupling": 3.0, "duffing": 0.0}, **SPEED_ONLY)
    env.reset(seed=0)
    with pytest.raises(SolverError, match=r"diverged at time .*radial_coupling > 1 needs duffing > 0"):
        rollout(env, np.ones(1000, int))
    with pytest.raises(gym.error.ResetNeeded, match="reset"):
        env.step(1)
    env.reset()
    assert env.step(1)[0][2] > 0


def test_the_description_has_the_headings_of_gymnasium_in_their_order():
    headings = re.findall(r"^## (.*)$", inspect.getdoc(StickSlipCrawlerEnv), re.MULTILINE)
    wanted = ["Description", "Action Space", "Observation Space", "Rewards", "Starting State", "Episode End"]
    wanted += ["Arguments", "Version History"]
    assert [heading for heading in headings if heading in wanted] == wanted


def test_the_table_of_arguments_is_the_constructor():
    section = inspect.getdoc(StickSlipCrawlerEnv).split("## Arguments")[1].split("## Version History")[0]
    table = dict(re.findall(r"^\| `(\w+)` *\|[^|]*\| *(\S+) *\|", section, re.MULTILINE))
    signature = inspect.signature(StickSlipCrawlerEnv)
    table = {name: ast.literal_eval(default) for name, default in table.items()}
    assert table == {name: parameter.default for name, parameter in signature.parameters.items()}
    assert list(table) == list(signature.parameters)


def test_the_package_lists_what_it_offers():
    assert set(stickslip.__all__) <= set(dir(stickslip))
    assert all(getattr(stickslip, name) is not None for name in stickslip.__all__)
