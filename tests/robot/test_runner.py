"""A runner keeps its instants, leaves the valve shut, and does in a simulated body what the environment does."""

import os
import re
import signal
import threading
from dataclasses import replace

import numpy as np
import pytest
from robots import Body, ScriptedClock

import stickslip
from stickslip.crawler import Actuator, simulate
from stickslip.envs import StickSlipCrawlerEnv
from stickslip.robot import Runner, SensorError, SimulatedPlant, VirtualClock

ECOFLEX = Actuator.ecoflex()
HOLD = 0.03125  # s, 1/2 t_c
# Groups that no group of the defaults is equal to, in scales that are no powers of two.
OTHER = replace(ECOFLEX, payload_mass=0.21, stiffness=71.3, bore_area=1.1e-4, damping=0.31, lag=0.027)


def opened(observation):
    return 1


def runner(clock, body, policy=opened, **arguments):
    arguments = {"actuator": ECOFLEX, "hold": 0.5, "readings": 2, "clock": clock} | arguments
    return Runner(policy, body.read, body.write, **arguments)


@pytest.mark.parametrize("actuator", [ECOFLEX, OTHER], ids=["default groups", "others"])
def test_a_dry_run_is_an_episode_of_the_environment(actuator):
    policy = stickslip.pretrained("knee")
    env = StickSlipCrawlerEnv(**policy.env_kwargs | {"groups": actuator})
    observation, _ = env.reset(seed=5)
    wanted, shown, valves = [], [], []
    for _ in range(60):
        shown.append(observation)
        wanted.append(int(policy.predict(observation)))
        observation, *_, info = env.step(wanted[-1])
        valves.append(info["valve"])
    shown.append(observation)

    clock, seen = VirtualClock(), []

    def watched(observation, deterministic):
        seen.append(observation)
        return policy.predict(observation, deterministic=deterministic)

    watching = type("Watching", (), {"predict": staticmethod(watched), "env_kwargs": policy.env_kwargs})()
    plant = SimulatedPlant(actuator, clock)
    done = Runner(watching, plant.read, plant.write, actuator=actuator, clock=clock, seed=5)
    report = done.run(60)
    np.testing.assert_allclose(seen, shown[:-1], rtol=1e-6, atol=1e-9)
    decisions = done.log.rows[::8]
    assert decisions[:-1, 2].tolist() == wanted
    assert decisions[:-1, 1].tolist() == valves
    foot = decisions[-1, list(done.log.names).index("foot_mm")]
    assert foot == pytest.approx(1e3 * info["distance"] * actuator.scales.length, rel=1e-12)
    assert foot > 100
    assert (report.holds, report.missed, report.skipped) == (60, 0, 0)
    assert report.hold == pytest.approx(0.5 * actuator.scales.time, rel=1e-15)


def test_what_is_logged_between_decisions_is_the_motion_and_begins_at_rest():
    clock = VirtualClock()
    plant = SimulatedPlant(ECOFLEX, clock, tolerance=1e-12)
    word = iter([1, 1, 0, 1, 0, 0] * 5)
    done = Runner(lambda observation: next(word), plant.read, plant.write, actuator=ECOFLEX, hold=0.5, clock=clock)
    done.run(30)
    rows = done.log.rows
    motion = simulate(ECOFLEX, [1, 1, 0, 1, 0, 0] * 5, 0.5, samples_per_hold=8, tolerance=1e-12).in_si(ECOFLEX)
    names = {"time_s": motion.time, "deformation_mm": 1e3 * motion.deformation, "pressure_kPa": 1e-3 * motion.pressure}
    names |= {"foot_mm": 1e3 * motion.foot, "payload_mm": 1e3 * motion.payload, "velocity_mm_s": 1e3 * motion.velocity}
    names["foot_velocity_mm_s"] = 1e3 * motion.foot_velocity
    assert set(names) | {"valve", "command"} == set(done.log.names)
    for name, values in names.items():
        column = rows[:, done.log.names.index(name)]
        assert column[0] == 0.0
        np.testing.assert_allclose(column[1:], values, rtol=1e-9, atol=1e-8)
    # The valve is what it is from the row on.
    assert rows[:-1, 1].tolist() == np.repeat([1, 1, 0, 1, 0, 0] * 5, 8).tolist()
    assert rows[-1, 1] == 0


def test_positions_alone_show_a_policy_nearly_what_it_would_see():
    shown = {}
    for sensors in (("deformation", "velocity", "pressure", "foot_velocity"), ("payload", "foot")):
        clock, seen = VirtualClock(), []
        plant = SimulatedPlant(ECOFLEX, clock, sensors=sensors)
        word = iter([1, 1, 1, 0, 0] * 5)

        def by_word(observation, seen=seen, word=word):
            seen.append(observation)
            return next(word)

        Runner(by_word, plant.read, plant.write, actuator=ECOFLEX, hold=0.5, readings=16, clock=clock).run(25)
        shown[sensors] = np.array(seen)
    exact, reckoned = shown.values()
    # The pressure follows the valve by the model's own law.
    np.testing.assert_allclose(reckoned[:, [0, 2, 4]], exact[:, [0, 2, 4]], rtol=1e-5, atol=1e-7)
    spread = exact.std(axis=0)
    errors = np.sqrt(np.mean((reckoned - exact) ** 2, axis=0))
    assert errors[1] < 0.02 * spread[1]
    assert errors[3] < 0.2 * spread[3]  # it has corners
    assert (reckoned[:, 3] >= 0).all()


def test_instants_do_not_drift_however_long_a_decision_takes():
    clock = ScriptedClock()
    spent = iter(np.resize([0.001, 0.011, 0.004], 1000).tolist())
    body = Body(clock, reading=0.0005, writing=spent)
    done = runner(clock, body, readings=2, allowed=0.2)
    report = done.run(90)
    np.testing.assert_allclose(body.looks[:-1:2], 100.0 + 0.001 + HOLD * np.arange(90), rtol=0, atol=1e-9)
    # The valve shut before the start took the first of the times.
    latencies = 0.0005 + np.resize([0.011, 0.004, 0.001], 90)
    np.testing.assert_allclose(report.latency, latencies, rtol=0, atol=1e-9)
    np.testing.assert_allclose(report.reading, 0.0005, atol=1e-9)
    np.testing.assert_allclose(report.writing, latencies - 0.0005, atol=1e-9)
    np.testing.assert_allclose(report.woke, 0.0, atol=1e-9)
    assert (report.holds, report.missed, report.skipped) == (90, 30, 0)
    percentiles = report.percentiles("latency")
    assert percentiles["most"] == pytest.approx(0.0115)
    assert percentiles["median"] == pytest.approx(0.0045)


def test_what_was_missed_altogether_is_skipped_and_the_valve_remembered():
    clock, seen = ScriptedClock(), []
    # The fourth write hangs for 2.6 holds: of the holds after it one has passed unseen.
    body = Body(clock, writing=iter([0.0] * 4 + [2.6 * HOLD] + [0.0] * 100))

    def alternately(observation):
        seen.append(observation[4:].tolist())
        return len(seen) % 2

    policy = type("Policy", (), {"predict": None, "env_kwargs": {"hold": 0.5, "valve_history": 3}})
    policy.predict = lambda self, observation, deterministic: alternately(observation)
    report = runner(clock, body, policy(), hold=None).run(8)
    assert (report.holds, report.skipped, report.missed) == (7, 1, 2)
    assert len(seen) == 7
    # Decisions were 1 0 1 0 | 1 0 1; the fourth valve state was kept for two holds.
    assert seen[3] == [1, 0, 1]
    assert seen[4] == [0, 0, 1]
    assert seen[5] == [1, 0, 0]
    assert report.woke[4] == pytest.approx(0.6 * HOLD)
    assert report.woke[5] == pytest.approx(0.0, abs=1e-9)
    assert body.turns[-1][1] == 0


def test_readings_whose_time_is_over_are_left_out():
    clock = ScriptedClock()
    body = Body(clock, writing=iter([0.0, 0.3 * HOLD] + [0.0] * 100))
    done = runner(clock, body, readings=8)
    done.run(2)
    times = done.log.rows[:, 0] / HOLD
    np.testing.assert_allclose(times, [0, 0.3, *np.arange(3, 8) / 8, *(1 + np.arange(8) / 8), 2], atol=1e-9)


def test_a_late_reading_tells_no_valve_of_the_hold_that_it_fell_into(tmp_path):
    class Oversleeping(ScriptedClock):
        late = iter([0.0, 0.75 * HOLD] + [0.0] * 100)

        def sleep_until(self, instant):
            super().sleep_until(instant)
            self.time += next(self.late)

    clock, word = Oversleeping(), iter([1, 0, 1, 1])
    runner(clock, Body(clock), lambda observation: next(word)).run(4, log=tmp_path / "run.csv")
    rows = [line.split(",") for line in (tmp_path / "run.csv").read_text(encoding="utf-8").splitlines()[1:]]
    np.testing.assert_allclose(
        [float(row[0]) / HOLD for row in rows], [0, 1.25, 1.25, 1.5, 2, 2.5, 3, 3.5, 4], atol=1e-7
    )
    assert [row[1] for row in rows] == ["1", "", "0", "0", "1", "1", "1", "1", "0"]


def failing(error, after):
    calls = iter(range(10**6))

    def act(observation):
        if next(calls) >= after:
            raise error
        return 1

    return act


@pytest.mark.parametrize("error", [KeyboardInterrupt(), OSError("bus gone"), ValueError("no"), SystemExit(3)])
@pytest.mark.parametrize("where", ["policy", "read", "write", "sleep"])
def test_whatever_ends_a_run_the_valve_is_shut_first_and_the_log_written(tmp_path, error, where):
    clock = ScriptedClock()
    body = Body(clock)
    act = failing(error, 5) if where == "policy" else opened
    armed = {"read": body.read, "write": body.write, "sleep": clock.sleep_until}
    if where != "policy":
        count, kept = iter(range(10**6)), armed[where]

        def fail(*arguments):
            if next(count) == 9:
                raise error
            return kept(*arguments)

        setattr(*{"read": (body, "read"), "write": (body, "write"), "sleep": (clock, "sleep_until")}[where], fail)
    done = runner(clock, body, act)
    with pytest.raises(type(error)):
        done.run(100, log=tmp_path / "run.csv")
    states = [valve for _, valve in body.turns]
    assert states[-1] == 0
    assert 1 in states
    lines = (tmp_path / "run.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "time_s,valve,command,deformation_mm,pressure_kPa,foot_mm"
    assert len(lines) == 1 + len(done.log.rows) > 5
    assert done.report.holds == len(done.report.latency) > 3


@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP", "SIGQUIT"])
def test_a_request_to_terminate_and_a_lost_terminal_shut_the_valve_too(name):
    number = getattr(signal, name)
    clock = ScriptedClock()
    body = Body(clock)
    calls = iter(range(100))

    def act(observation):
        if next(calls) == 3:
            os.kill(os.getpid(), number)
        return 1

    before = signal.getsignal(number)
    with pytest.raises(SystemExit) as end:
        runner(clock, body, act).run()
    assert end.value.code == 128 + number
    assert [valve for _, valve in body.turns] == [0, 1, 1, 1, 0]
    assert signal.getsignal(number) is before


def test_a_lost_terminal_ends_nothing_that_ignores_it():
    clock = ScriptedClock()
    body = Body(clock)
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup has it
    try:
        runner(clock, body, lambda observation: os.kill(os.getpid(), signal.SIGHUP) or 1).run(3)
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)
    assert [valve for _, valve in body.turns] == [0, 1, 1, 1, 0]


@pytest.mark.parametrize("place", ["", "missing/run.csv"])
def test_a_log_that_cannot_be_written_is_refused_before_the_valve_turns(tmp_path, place):
    clock = ScriptedClock()
    body = Body(clock)
    with pytest.raises(OSError, match="log must be "):
        runner(clock, body).run(3, log=tmp_path / place)
    assert body.turns == []


def test_a_run_in_another_thread_leaves_signals_alone():
    clock = ScriptedClock()
    body, told = Body(clock), []
    thread = threading.Thread(target=lambda: told.append(runner(clock, body).run(3)))
    thread.start()
    thread.join(30)
    assert told[0].holds == 3


def test_a_valve_that_does_not_shut_is_tried_again_and_told():
    clock = ScriptedClock()
    body, tries = Body(clock), []

    def write(valve):
        if len(body.turns) > 3 and valve == 0:
            tries.append(valve)
            if len(tries) < 3 or stubborn:
                raise OSError("bus gone")
        body.write(valve)

    stubborn = False
    Runner(opened, body.read, write, actuator=ECOFLEX, hold=0.5, clock=clock).run(5)
    assert (len(tries), body.turns[-1][1]) == (3, 0)
    stubborn = True
    tries.clear()
    body.turns.clear()
    with pytest.raises(RuntimeError, match="the valve could not be shut: OSError: bus gone"):
        Runner(opened, body.read, write, actuator=ECOFLEX, hold=0.5, clock=clock).run(5)
    assert len(tries) == 3


def test_volts_are_written_in_the_place_of_states():
    clock = ScriptedClock()
    body, word = Body(clock), iter([1, 0, 1])
    runner(clock, body, lambda observation: next(word), volts=(-1.5, 24)).run(3)
    assert [volts for _, volts in body.turns] == [-1.5, 24.0, -1.5, 24.0, -1.5]


def test_flips_are_those_of_the_seed():
    clock = ScriptedClock()
    done = runner(clock, Body(clock), dither=0.25, seed=11)
    done.run(200)
    flipped = done.log.rows[:-1:2, 1] != done.log.rows[:-1:2, 2]
    np.testing.assert_array_equal(flipped, np.random.default_rng(11).random(200) < 0.25)


def test_a_runner_can_run_again():
    clock = ScriptedClock()
    done = runner(clock, Body(clock), dither=0.25)
    first = done.run(5), done.log.rows
    second = done.run(5), done.log.rows
    np.testing.assert_allclose(first[1], second[1], atol=1e-9)
    assert second[0].holds == 5


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (None, "read must return a mapping of names such as deformation_mm to numbers, got None"),
        ({"deformation_mm": 1.0}, "sensors must tell deformation, foot and payload"),
        (
            {"deformation_mm": 1.0, "pressure_kPa": 3.0},
            r"got \['deformation_mm', 'pressure_kPa'\]",
        ),
        ({"foot_mm": 1.0, "payload_mm": float("nan")}, "sensor payload_mm must tell a number, got nan"),
        ({"foot_mm": 1.0, "payload_mm": None}, "sensor payload_mm must tell a number, got None"),
        ({"foot_mm": 1.0, "payload_mm": "near"}, "sensor payload_mm must tell a number, got 'near'"),
        ({"foot_mm": 1.0, "foot_cm": 1.0, "payload_mm": 2.0}, "sensor foot must be told once"),
        ({"foot": 1.0, "payload_mm": 2.0}, "sensors must be of .* such as deformation_mm.* got 'foot'"),
        ({"foot_mm": 1.0, "payload_inch": 2.0}, "got 'payload_inch'"),
        ({"foot_mm": 1.0, "payload_mm": 2.0, "pressure_kPa": 31.0}, "sensor pressure must be within its limits"),
    ],
)
def test_what_sensors_may_not_tell_ends_the_run_with_the_valve_shut(given, message):
    clock = ScriptedClock()
    body = Body(clock)
    done = Runner(
        opened, lambda: given, body.write, actuator=ECOFLEX, hold=0.5, clock=clock, limits=_of(given, "pressure_kPa")
    )
    with pytest.raises(SensorError, match=message):
        done.run(5)
    assert body.turns[-1][1] == 0


def _of(given, name):
    return {name: (-2, 30)} if given and name in given else None


def test_a_sensor_that_fails_later_ends_the_run():
    clock = ScriptedClock()
    body, left = Body(clock), iter(range(9, -1, -1))

    def read():
        told = body.read()
        if next(left) == 0:
            del told["foot_mm"]
        return told

    with pytest.raises(SensorError, match="sensor foot_mm must tell a number, got None"):
        Runner(opened, read, body.write, actuator=ECOFLEX, hold=0.5, clock=clock).run(50)
    assert [valve for _, valve in body.turns] == [0, 1, 1, 0]


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"actuator": ECOFLEX.groups}, TypeError, "actuator must be an Actuator, got Groups"),
        ({"hold": None}, ValueError, "hold must be given, such as '20 ms', for a policy"),
        ({"hold": "20 apples"}, TypeError, "hold must be a number in .* or a text"),
        ({"hold": 0}, ValueError, r"hold must be in \(0, inf\), got 0"),
        ({"readings": 1}, ValueError, r"readings must be a whole number in \[2, 1000\], got 1"),
        ({"window": 1}, ValueError, "window must be a whole number"),
        ({"dither": 0.6}, ValueError, r"dither must be in \[0, 0.5\]"),
        ({"seed": -1}, ValueError, "seed must be a whole number >= 0"),
        ({"volts": 24}, TypeError, r"volts must be those of the shut and of the open valve, such as \(0, 24\), got 24"),
        ({"volts": (5, 5)}, ValueError, "volts must differ"),
        ({"limits": {"pressure": (0, 1)}}, ValueError, "sensors must be of .* got 'pressure'"),
        (
            {"limits": {"pressure_kPa": (0, 1), "pressure_Pa": (0, 9)}},
            ValueError,
            "limits of pressure must be given on",
        ),
        ({"limits": 3}, TypeError, "limits must be a mapping such as .*, got 3"),
        ({"limits": {"pressure_kPa": (2, 1)}}, ValueError, r"limits of pressure_kPa must be in \[2.0, inf\), got 1"),
        (
            {"limits": {"pressure_kPa": 2}},
            TypeError,
            r"must be a pair \(least, greatest\), got 2",
        ),
        ({"allowed": 0}, ValueError, "allowed must be in"),
        ({"policy": 3}, TypeError, "policy must have a method predict, or be callable, got 3"),
        ({"policy": stickslip.pretrained("conditioned")}, ValueError, r"choose one by policy.at\(0.3\)"),
        ({"read": 3}, TypeError, "read must be callable"),
        ({"write": 3}, TypeError, "write must be callable"),
    ],
)
def test_bad_arguments_are_refused_by_name(arguments, error, message):
    body = Body(ScriptedClock())
    given = {"policy": opened, "read": body.read, "write": body.write, "actuator": ECOFLEX, "hold": 0.5} | arguments
    with pytest.raises(error, match=message):
        Runner(**given)


@pytest.mark.parametrize(
    ("policy", "message"),
    [
        (lambda observation: 2, "policy must act by 0 or 1, got 2"),
        (lambda observation: [0, 1], "policy must act by 0 or 1"),
        (lambda observation: (1, "state"), "policy must not be recurrent"),
    ],
)
def test_what_is_no_action_ends_the_run(policy, message):
    body = Body(clock := ScriptedClock())
    with pytest.raises(ValueError, match=message):
        runner(clock, body, policy).run(3)
    assert [valve for _, valve in body.turns] == [0, 0]


def test_a_model_of_stable_baselines_answers_with_a_state():
    body = Body(clock := ScriptedClock())
    runner(clock, body, lambda observation: (np.array(1), None)).run(2)
    assert [valve for _, valve in body.turns] == [0, 1, 1, 0]


def test_the_report_says_it_in_words_and_numbers():
    clock = ScriptedClock()
    policy = stickslip.pretrained("speed")
    done = runner(clock, Body(clock, writing=0.005), policy, hold="20 ms", dither=0)
    text = str(done.run(10))
    assert text.startswith("10 holds of 20 ms (0.32 t_c, trained at 0.5 t_c): 10 deadlines missed by more than 2 ms")
    assert re.search(r"valve turned after the instant +5\.000 +5\.000 +5\.000 +5\.000", text)
    told = done.report.to_dict()
    assert told["latency"]["95%"] == pytest.approx(0.005)
    assert (told["holds"], told["missed"], told["skipped"], told["trained_hold"]) == (10, 10, 0, 0.5)
    assert "trained" not in str(runner(clock, Body(clock), policy).run(3))
