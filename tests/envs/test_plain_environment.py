"""Single and batched environment judged by the plain one of `tests/judges`, argument by argument."""

import gymnasium as gym
import numpy as np
import pytest
from plain_environment import calibration_valves, crawled, episode

from stickslip import Actuator, Groups, simulate
from stickslip.envs import StickSlipCrawlerEnv, StickSlipCrawlerVectorEnv
from stickslip.envs.calibration import calibration_valves as valves_of
from stickslip.reservoir.targets import target_of

DEFAULTS = {"hold": 0.5, "tolerance": 1e-6, "dither": 0.1, "memory_weight": 0.2, "delays": 20, "virtual_nodes": 4}
DEFAULTS |= {"valve_history": 1, "target": "memory", "target_order": 2}
TARGET = "target", "target_order"
GAIT = np.resize([1, 1, 1, 0, 0], 30)
SEED = 7

# Of the gait by default arguments and this seed; `crawled` at 48 steps a hold gives the same to 3e-7.
REWARDS = [0.0, 0.0, 0.0, 0.17369989862, 1.00606120521, 0.93135904525, 0.07661815064, 0.0, 0.05064920961]
REWARDS += [1.03656971515, 1.14992882865, 0.12715340267, 0.29576638798, 0.64964314120, 1.19133207103, 0.97390593048]
REWARDS += [0.01054051074, -0.02492765479, 0.09628188003, 1.00747370373, 0.92304577183, 0.10810001020]
REWARDS += [-0.07525082485, 1.23981072632, 1.59197766958, 2.82372540758, 1.09845032746, -0.01290186780]
REWARDS += [0.70564233571, 1.60035711315]


def motion_of(valves, groups, scene, hold, tolerance, nodes):
    """States at the virtual nodes of each hold, as `simulate` knows them."""
    told = simulate(groups, valves, hold, scene=scene, tolerance=tolerance, samples_per_hold=nodes)
    readings = told.deformation, told.velocity, told.pressure, told.foot, told.foot_velocity
    return np.column_stack(readings).reshape(len(valves), nodes, 5), told


def expected_of(commands, seed, arguments, options=None, calibrated=None):
    """The episode that an environment of these arguments should play, its slips, its groups and its slope."""
    given = {**DEFAULTS, **arguments}
    nominal, scene = Groups.of(given.get("groups")), dict(given.get("scene") or {})
    generator = np.random.default_rng(seed)
    drawn = {name: generator.uniform(*given["randomize"][name]) for name in given.get("randomize", {})}
    slope = drawn.pop("slope", scene.get("slope", 0.0))
    groups = {**nominal.to_dict(), **drawn, **(options or {}).get("groups", {})}
    world = {**scene, "slope": (options or {}).get("slope", slope)}
    dither, nodes = given["dither"], given["virtual_nodes"] if given["dither"] else 1
    flips = generator.random(len(commands)) < dither if dither else np.zeros(len(commands), bool)
    body = given["hold"], given["tolerance"], nodes
    calibration = None
    if dither:
        calibration, _ = motion_of(calibration_valves(given["hold"]), nominal, scene, *body)
    slips = []

    def move(valves):
        motion, told = motion_of(valves, groups, world, *body)
        slips[:] = [told.slips]
        return motion

    weights = {name: given[name] for name in ("hold", "dither", "memory_weight", "delays", "valve_history", *TARGET)}
    aim = target_of(given["target"], given["target_order"], dither) if dither else None
    moments = aim and (aim.mean, aim.variance)
    return episode(commands, flips, move, calibration, **weights, moments=moments), slips[0], groups, world["slope"]


def assert_is(expected, slips, groups, slope, observations, rewards, infos):
    """The motion to the bit, what is learned from it as well as the normal equations are conditioned."""
    np.testing.assert_array_equal(observations, expected.observations.astype(np.float32))
    for name in ("distance", "valve"):
        np.testing.assert_array_equal(infos[name], getattr(expected, name), err_msg=name)
    for name in ("speed", "innovation"):
        np.testing.assert_allclose(infos[name], getattr(expected, name), rtol=0, atol=1e-13, err_msg=name)
    np.testing.assert_allclose(infos["memory"], expected.memory, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(rewards, expected.rewards, rtol=1e-6, atol=1e-6)
    assert infos["slips"][-1] == slips
    assert infos["slope"] == [slope] * len(rewards)
    assert infos["groups"] == [groups] * len(rewards)


def played(env, commands, options=None, seed=SEED):
    env.reset(seed=seed, options=options)
    observations, rewards, _, _, infos = zip(*(env.step(int(command)) for command in commands), strict=True)
    return np.array(observations), np.array(rewards), {name: [info[name] for info in infos] for name in infos[0]}


def played_by_one(envs, i, commands, options=None, seed=SEED):
    envs.reset(seed=seed - i, options=options)
    answers = [envs.step(np.full(envs.num_envs, command)) for command in commands]
    infos = {name: [answer[4][name][i] for answer in answers] for name in ("speed", "memory", "distance", "innovation")}
    infos |= {name: [answer[4][name][i] for answer in answers] for name in ("valve", "slips", "slope")}
    names = Groups().to_dict()
    infos["groups"] = [{name: answer[4]["groups"][name][i] for name in names} for answer in answers]
    return np.array([answer[0][i] for answer in answers]), np.array([answer[1][i] for answer in answers]), infos


def test_the_rewards_of_an_episode_by_default():
    _, rewards, infos = played(StickSlipCrawlerEnv(), GAIT)
    np.testing.assert_allclose(rewards, REWARDS, rtol=0, atol=2e-8)
    assert infos["slips"][-1] == 6
    assert infos["distance"][-1] == pytest.approx(7.2055255, abs=1e-6)
    envs = gym.make_vec("StickSlipCrawler-v0", 9)
    np.testing.assert_allclose(played_by_one(envs, 6, GAIT)[1], REWARDS, rtol=0, atol=2e-8)


def test_the_defaults_are_those_of_equations_that_runge_kutta_integrates():
    calibration, _ = motion_of(calibration_valves(0.5), None, None, 0.5, 1e-6, 4)
    assert_runge_kutta_agrees(calibration)


@pytest.mark.slow
def test_so_does_the_calibration():
    assert_runge_kutta_agrees(crawled(calibration_valves(0.5), 0.5, 4))


def assert_runge_kutta_agrees(calibration):
    flips = np.random.default_rng(SEED).random(len(GAIT)) < 0.1
    weights = {"hold": 0.5, "dither": 0.1, "memory_weight": 0.2, "delays": 20}
    expected = episode(GAIT, flips, lambda valves: crawled(valves, 0.5, 4), calibration, **weights)
    observations, rewards, infos = played(StickSlipCrawlerEnv(), GAIT)
    np.testing.assert_allclose(observations, expected.observations, rtol=0, atol=2e-6)
    np.testing.assert_allclose(rewards, expected.rewards, rtol=0, atol=5e-6)
    np.testing.assert_allclose(rewards, REWARDS, rtol=0, atol=2e-8)
    for name in ("speed", "memory", "distance", "innovation", "valve"):
        np.testing.assert_allclose(infos[name], getattr(expected, name), rtol=0, atol=5e-6, err_msg=name)


ARGUMENTS = [
    {"groups": "high-damping"},
    {"groups": {"duffing": 2.0, "static_friction": 0.2}},
    {"groups": Actuator.ecoflex()},
    {"scene": {"slope": 0.08}},
    {"scene": {"anchored": True}},
    {"scene": {"ratchet": False}, "groups": {"static_friction": 0.1, "kinetic_friction": 0.05}},
    {"hold": 1.3},
    {"tolerance": 1e-4},
    {"dither": 0.4},
    {"dither": 0.0, "memory_weight": 0.0},
    {"memory_weight": 0.0},
    {"memory_weight": 1.0},
    {"delays": 3},
    {"delays": 50},
    {"target": "parity", "dither": 0.4},
    {"target": "parity", "target_order": 3, "dither": 0.3},
    {"target": "narma", "dither": 0.3},
    {"target": "narma", "target_order": 5, "dither": 0.3, "memory_weight": 1.0},
    {"virtual_nodes": 1},
    {"virtual_nodes": 6},
    {"valve_history": 4},
    {"valve_history": 64, "dither": 0.0, "memory_weight": 0.0},
    {"randomize": {"duffing": [0.1, 2.0], "static_friction": [0.2, 0.4], "slope": [-0.05, 0.1]}},
    {"hold": 30.0, "virtual_nodes": 2, "groups": "linear"},  # a calibration of fewer holds
    {"hold": 500.0, "virtual_nodes": 2, "groups": "linear"},  # and of the fewest
]
OPTIONS = [{"groups": {"deborah": 1.5}}, {"slope": 0.07}, {"groups": {"duffing": 0.0}, "slope": -0.02}]


@pytest.mark.parametrize("arguments", ARGUMENTS, ids=str)
def test_every_argument_has_the_effect_that_the_plain_environment_gives_it(arguments):
    commands = np.random.default_rng(1).integers(0, 2, 40)
    expected = expected_of(commands, SEED, arguments)
    assert_is(*expected, *played(StickSlipCrawlerEnv(**arguments), commands))
    envs = StickSlipCrawlerVectorEnv(3, **arguments)
    assert_is(*expected, *played_by_one(envs, 2, commands))


@pytest.mark.parametrize("options", OPTIONS, ids=str)
@pytest.mark.parametrize("arguments", [{}, {"randomize": {"duffing": [0.1, 2.0], "slope": [0.0, 0.1]}}], ids=str)
def test_so_has_every_option_of_a_reset_on_the_motion_and_none_on_the_calibration(arguments, options):
    expected = expected_of(GAIT, SEED, arguments, options)
    assert_is(*expected, *played(StickSlipCrawlerEnv(**arguments), GAIT, options))
    envs = StickSlipCrawlerVectorEnv(3, **arguments)
    assert_is(*expected, *played_by_one(envs, 1, GAIT, options))


def test_groups_of_each_sub_environment_have_a_calibration_of_their_own():
    groups = ["high-damping", {"duffing": 2.0}, None]
    envs = StickSlipCrawlerVectorEnv(3, groups=groups)
    for i, own in enumerate(groups):
        arguments = {} if own is None else {"groups": own}
        assert_is(*expected_of(GAIT, SEED, arguments), *played_by_one(envs, i, GAIT))


@pytest.mark.parametrize("hold", [0.5, 9.9, 10.1, 30.0, 199.0, 500.0])
def test_the_calibration_is_as_long_as_it_can_afford(hold):
    np.testing.assert_array_equal(valves_of(StickSlipCrawlerEnv(hold=hold).settings), calibration_valves(hold))


def test_an_episode_that_follows_forgets_what_was_learned():
    env, envs = StickSlipCrawlerEnv(), StickSlipCrawlerVectorEnv(3)
    played(env, GAIT, seed=1), played_by_one(envs, 2, GAIT, seed=3)
    expected = expected_of(GAIT, SEED, {})
    assert_is(*expected, *played(env, GAIT))
    assert_is(*expected, *played_by_one(envs, 2, GAIT))
