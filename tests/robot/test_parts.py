"""What a runner is made of, against closed forms."""

import math
import subprocess
import sys

import numpy as np
import pytest

import stickslip
from stickslip.crawler import Actuator
from stickslip.envs.observation import OBSERVATION
from stickslip.robot import RealClock, SensorError, SENSORS, SimulatedPlant, VirtualClock
from stickslip.robot.acting import other_groups
from stickslip.robot.observer import Observer, STATE
from stickslip.robot.sensors import Readings, readings_of, Sensors, unit_of
from stickslip.robot.slope import Slope
from stickslip.train.policies import Policy

ECOFLEX = Actuator.ecoflex()

LIGHT = """
import sys

class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {"scipy", "numba", "llvmlite", "gymnasium", "sklearn", "joblib", "torch"}:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name.partition(".")[0])

sys.meta_path.insert(0, Blocked())
import stickslip
from stickslip.robot import Runner, VirtualClock

turns = []
runner = Runner(
    stickslip.pretrained("knee"),
    lambda: {"deformation_mm": 0.0, "foot_mm": 0.0, "pressure_kPa": 0.0},
    turns.append,
    actuator=stickslip.Actuator.ecoflex(),
    clock=VirtualClock(),
    dither=0.0,
)
print(runner.run(5).holds, turns)
try:
    stickslip.simulate
except ImportError as error:
    print(error, file=sys.stderr)
"""


def test_a_policy_acts_with_numpy_and_safetensors_alone():
    done = subprocess.run([sys.executable, "-c", LIGHT], capture_output=True, text=True, encoding="utf-8", check=True)
    assert done.stdout.split()[0] == "5"
    assert done.stdout.strip().endswith("0]")
    assert "1" in done.stdout.partition("[")[2]
    needed = "stickslip.simulate needs numba, which is not installed: run `pip install stickslip` without --no-deps"
    assert done.stderr.strip() == needed


def test_the_observation_is_the_environments():
    assert tuple(each.name for each in OBSERVATION) == STATE
    observer = Observer(ECOFLEX, 3, ratchet=True, window=4)
    assert observer.observation.dtype == np.float32
    np.testing.assert_array_equal(observer.observation, np.zeros(7))
    observer.turned(1)
    observer.see(0.1, Readings(0.015625, 0.25, 5000.0, None, 1.0), 1)
    np.testing.assert_array_equal(observer.observation, np.float32([0.5, 0.5, 0.25, 2.0, 1, 0, 0]))
    observer.turned(0, 2)
    np.testing.assert_array_equal(observer.observation[4:], [0, 0, 1])


@pytest.mark.parametrize("window", [3, 4, 9])
def test_a_slope_is_exact_of_a_parabola_sampled_at_any_times(window):
    slope, times = Slope(window, 2), np.cumsum(np.random.default_rng(0).uniform(0.5, 2.0, 20)) * 1e-3
    for k, t in enumerate(times.tolist()):
        slope.add(t, 3.0 - 2.0 * t + 40.0 * t * t)
        if k >= 2:
            assert slope.now == pytest.approx(-2.0 + 80.0 * t, rel=1e-9)
    slope.add(times[-1], 1e9)  # of the same instant
    assert slope.now == pytest.approx(-2.0 + 80.0 * times[-1], rel=1e-9)


def test_a_slope_begins_with_what_there_is():
    slope = Slope(4, 2)
    assert slope.now == 0.0
    slope.add(0.0, 1.0)
    assert slope.now == 0.0
    slope.add(0.5, 2.0)
    assert slope.now == pytest.approx(2.0)


@pytest.mark.parametrize(("window", "degree", "name"), [(1, 1, "window"), (4, 0, "degree"), (4, 4, "degree")])
def test_a_slope_is_of_a_polynomial_that_its_samples_determine(window, degree, name):
    with pytest.raises(ValueError, match=f"^{name} must be"):
        Slope(window, degree)


def test_a_slope_averages_noise():
    rng, errors = np.random.default_rng(1), {}
    for window in (2, 16):
        found = []
        for _ in range(200):
            slope = Slope(window, 1)
            for k in range(window):
                slope.add(0.01 * k, 0.7 * 0.01 * k + 1e-3 * rng.standard_normal())
            found.append(slope.now - 0.7)
        errors[window] = np.std(found)
        # Var = sigma^2 / sum (t - mean)^2
        t = 0.01 * np.arange(window)
        assert errors[window] == pytest.approx(1e-3 / math.sqrt(((t - t.mean()) ** 2).sum()), rel=0.15)


def test_a_pressure_that_nobody_measures_follows_the_valve_with_the_lag():
    observer = Observer(ECOFLEX, 1, ratchet=True, window=2)
    seen = [0.0]
    for k, valve in enumerate([1, 1, 0, 1], start=1):
        observer.see(0.01 * k, Readings(0.0, None, None, 0.0, None), valve)
        seen.append(observer.observation[2])
    decay, p, expected = math.exp(-0.01 / ECOFLEX.lag), 0.0, [0.0]
    for valve in (1, 1, 0, 1):
        p = valve + (p - valve) * decay
        expected.append(p)
    np.testing.assert_allclose(seen, expected, rtol=1e-6)


def test_a_foot_without_a_ratchet_may_go_back():
    for ratchet, expected in ((True, 0.0), (False, -2.0)):
        observer = Observer(ECOFLEX, 1, ratchet=ratchet, window=2)
        for k in range(3):
            observer.see(0.1 * k, Readings(0.0, None, None, -0.1 * k, None), 0)
        assert observer.observation[3] == pytest.approx(expected)


@pytest.mark.parametrize(
    ("name", "channel", "si"),
    [
        ("deformation_mm", "deformation", 1e-3),
        ("deformation_um", "deformation", 1e-6),
        ("foot_m", "foot", 1.0),
        ("payload_cm", "payload", 1e-2),
        ("foot_velocity_mm_s", "foot_velocity", 1e-3),
        ("velocity_m_s", "velocity", 1.0),
        ("pressure_Pa", "pressure", 1.0),
        ("pressure_mbar", "pressure", 100.0),
        ("pressure_kPa", "pressure", 1e3),
        ("pressure_bar", "pressure", 1e5),
        ("pressure_MPa", "pressure", 1e6),
    ],
)
def test_units_are_in_the_names(name, channel, si):
    found, parts = unit_of(name)
    assert found == channel
    assert 3.0 / parts == pytest.approx(3.0 * si, rel=1e-15)


def test_two_positions_tell_the_third():
    for given in ({"payload_mm": 5, "foot_mm": 3}, {"payload_m": 0.005, "deformation_m": 0.002}):
        found = readings_of(Sensors().measured(given))
        assert found.deformation == pytest.approx(0.002)
        assert found.foot == pytest.approx(0.003)
        assert found.velocity is found.pressure is found.foot_velocity is None
    alone = readings_of(Sensors().measured({"deformation_mm": 2, "foot_velocity_mm_s": 7}))
    assert (alone.foot, alone.foot_velocity) == (None, 0.007)


def test_limits_are_in_the_unit_of_their_name():
    sensors = Sensors({"pressure_kPa": (0, 30)})
    told = {"deformation_mm": 1, "foot_mm": 1, "pressure_bar": 0.29}
    assert sensors.measured(told)["pressure"] == pytest.approx(29e3)
    with pytest.raises(SensorError, match=r"sensor pressure must be within its limits \[0, 30000\], got 31000 in SI"):
        sensors.measured(told | {"pressure_bar": 0.31})
    with pytest.raises(SensorError, match="limits must be of sensors that are read"):
        Sensors({"pressure_kPa": (0, 30)}).measured({"deformation_mm": 1, "foot_mm": 1})


def test_groups_that_were_drawn_in_the_training_may_differ():
    policy = stickslip.pretrained("knee")
    groups = ECOFLEX.groups.to_dict()
    assert other_groups(policy, groups) == {}
    assert other_groups(policy, groups | {"duffing": 0.52, "deborah": 0.6}) == {"deborah": (0.5, 0.6)}
    description = policy.description
    description["env_kwargs"]["randomize"] = {"deborah": [0.3, 0.7]}
    drawn = Policy(policy.layers, description)
    assert other_groups(drawn, groups | {"duffing": 0.0, "deborah": 0.6}) == {"duffing": (0.5, 0.0)}


def test_clocks_never_wake_early():
    for clock in (RealClock(), RealClock(1000.0), VirtualClock()):
        for instant in (clock.now() + 1e-3, clock.now() + 2e-3, clock.now() - 1.0):
            before = clock.now()
            clock.sleep_until(instant)
            assert clock.now() >= max(before, instant)
    with pytest.raises(ValueError, match="pace must be in"):
        RealClock(0)


def test_a_clock_of_another_pace_sleeps_for_as_much_less(monkeypatch):
    real, slept = [100.0], []

    def sleep(seconds):
        slept.append(seconds)
        real[0] += seconds

    monkeypatch.setattr("stickslip.robot.clock.time.monotonic", lambda: real[0])
    monkeypatch.setattr("stickslip.robot.clock.time.sleep", sleep)
    clock = RealClock(4.0)
    clock.sleep_until(2.0)
    assert slept == [0.5]
    assert clock.now() == 2.0


def test_a_plant_tells_what_it_has_sensors_for():
    plant = SimulatedPlant(ECOFLEX, VirtualClock(), sensors=["payload", "foot"])
    assert plant.read() == {"payload_m": 0.0, "foot_m": 0.0}
    assert set(SimulatedPlant(ECOFLEX, VirtualClock()).read()) == {
        f"{name}_{next(unit for unit, parts in SENSORS[name].items() if parts == 1)}" for name in SENSORS
    }
    with pytest.raises(ValueError, match="valve must be 0 or 1, got 24"):
        plant.write(24)
    with pytest.raises(ValueError, match="sensors has no 'smell'"):
        SimulatedPlant(ECOFLEX, VirtualClock(), sensors=["smell"])
