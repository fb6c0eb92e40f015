"""Every command takes a hold as a number, in natural time and in seconds, and means the same by all of them."""

import json
from dataclasses import asdict

import pytest
import typer

import stickslip.crawler
from stickslip import robot
from stickslip.commands import app, run
from stickslip.crawler import Actuator, Groups
from stickslip.studies import bifurcation, identification, maps, work_precision
from stickslip.studies.benchmark import bench
from stickslip.studies.trade import plan
from stickslip.train import played, training

ECOFLEX = Actuator.ecoflex()  # whose t_c is 1/16 s
SI = json.dumps(asdict(ECOFLEX))
SAME = ("0.5", "0.5 t_c", "31.25 ms", "0.03125 s")

# What a command calls with the hold, how that is told there, and the rest of the command.
TAKEN = {
    "bench": (bench, "Bench", lambda *_, body, **__: body["hold"], []),
    "export": (played, "play_word", lambda *_, hold, **__: hold, ["10", "--to", "csv"]),
    "lyapunov": (stickslip.crawler, "lyapunov_spectrum", lambda _, __, hold, **___: hold, ["--holds", "2"]),
    "lyapunov over": (bifurcation, "bifurcation_diagram", lambda *_, hold, **__: hold, ["--over", "duffing=0:1:2"]),
    "map": (maps, "parameter_map", lambda *_, hold, **__: hold, ["--x", "duffing=0:1:2"]),
    "run": (robot, "Runner", lambda *_, hold, actuator, **__: natural(hold, actuator), ["knee", "--dry-run"]),
    "speed": (work_precision, "Case", lambda *_, hold, **__: hold, []),
    "trade": (plan, "Trade", lambda *_, env_kwargs, **__: env_kwargs["hold"], []),
    "train": (training, "train", lambda asked, *_, **__: asked.env_kwargs["hold"], ["--output", "unused"]),
}
BODY = {name: ["--groups", "ecoflex"] for name in TAKEN} | {"export": ["--actuator", "ecoflex"], "run": []}


class TakenError(Exception):
    """Raised with the hold in place of the work."""


Runner = robot.Runner


def natural(hold, actuator):
    runner = Runner(stickslip.pretrained("knee"), dict, lambda _: None, actuator=actuator, hold=hold)
    return runner.hold / actuator.scales.time


@pytest.fixture
def taken(monkeypatch, tmp_path):
    """The natural time that a command takes a hold for."""
    monkeypatch.setenv("STICKSLIP_DEBUG", "1")
    monkeypatch.chdir(tmp_path)

    def ask(name, hold, body):
        module, function, told, others = TAKEN[name]

        def instead(*arguments, **named):
            raise TakenError(told(*arguments, **named))

        with monkeypatch.context() as patched:
            patched.setattr(module, function, instead)
            with pytest.raises(TakenError) as caught:
                run([name.split()[0], *others, *body, "--hold", hold])
        return caught.value.args[0]

    return ask


def test_all_commands_with_a_hold_are_here():
    commands = typer.main.get_command(app).commands
    having = {name for name, command in commands.items() if "hold" in {each.name for each in command.params}}
    assert having == {name.split()[0] for name in TAKEN} | {"identify"}


@pytest.mark.parametrize("name", TAKEN)
def test_a_hold_is_the_same_in_all_units(name, taken):
    assert {taken(name, hold, BODY[name]) for hold in SAME} == {0.5}
    assert taken(name, "1.25", BODY[name]) == 1.25


@pytest.mark.parametrize("name", [name for name, body in BODY.items() if "--groups" in body])
def test_seconds_are_of_a_body_in_si_alone(name, taken):
    assert taken(name, "31.25 ms", ["--groups", SI]) == 0.5
    assert taken(name, "0.5 t_c", []) == 0.5
    for body in ([], ["--groups", '{"duffing": 2}'], ["--groups", "linear"]):
        with pytest.raises(ValueError, match=r"^hold must be in units of t_c, .* such as ecoflex, .* got '20 ms'$"):
            run([name.split()[0], *TAKEN[name][3], *body, "--hold", "20 ms"])


@pytest.mark.parametrize(
    ("groups", "message"),
    [
        ('{"stiffness": 70}', "--groups must set ['payload_mass', 'foot_mass', "),
        ('{"stiffness": 70, "duffing": 2}', "--groups has no 'duffing'"),
        ('{"duffing": 2, "colour": 1}', "groups has no 'colour'; allowed are ['duffing'"),
    ],
)
def test_a_body_in_si_is_whole(groups, message, capsys):
    assert run(["speed", "--groups", groups]) == 1
    assert message in capsys.readouterr().err


def test_a_body_in_si_is_its_groups(taken, monkeypatch):
    noted = []
    monkeypatch.setattr(Groups, "of", classmethod(lambda _, choice: noted.append(choice)))
    assert taken("speed", "0.5", ["--groups", SI]) == 0.5
    assert noted == [ECOFLEX]


@pytest.fixture
def log(tmp_path):
    """A log of eight holds, in seconds or in natural time."""

    def write(si):
        time, foot, hold = ("time_s", "foot_mm", 0.03125) if si else ("time", "foot", 0.5)
        lines = [f"{time},valve,{foot}", *(f"{hold * (k + 0.5)},{k % 2},{k}" for k in range(8))]
        file = tmp_path / f"{time}.csv"
        file.write_text("\n".join(lines), encoding="utf-8")
        return str(file)

    return write


@pytest.mark.parametrize(
    ("si", "hold", "body", "length"),
    [
        (True, "0.03125", ["--actuator", "ecoflex"], 0.03125),
        (True, "31.25 ms", ["--actuator", "ecoflex"], 0.03125),
        (True, "0.5 t_c", ["--actuator", "ecoflex"], 0.03125),
        (True, "0.5 t_c", ["--guess", SI], 0.03125),
        (False, "0.5", [], 0.5),
        (False, "0.5 t_c", [], 0.5),
    ],
)
def test_a_log_s_hold_is_in_its_own_unit_or_in_the_one_that_is_said(si, hold, body, length, log, monkeypatch):
    monkeypatch.setenv("STICKSLIP_DEBUG", "1")

    def instead(runs, **_):
        raise TakenError(*(each.hold for each in runs))

    monkeypatch.setattr(identification, "identify", instead)
    with pytest.raises(TakenError) as caught:
        run(["identify", log(si), *body, "--hold", hold])
    assert caught.value.args == (length,)


@pytest.mark.parametrize(
    ("si", "hold", "message"),
    [
        (True, "0.5 t_c", "hold must be in seconds, such as '20 ms', where groups is no Actuator"),
        (False, "20 ms", "hold must be in units of t_c, such as 0.5, where groups is no Actuator"),
        (True, "-20 ms", "hold must be in (0, inf), got -0.02"),
        (True, "20 years", "hold must be a number in (0, inf), or a text of one and its unit (s, ms, us, µs, t_c)"),
    ],
)
def test_a_log_s_hold_without_a_meaning_is_refused(si, hold, message, log, capsys):
    assert run(["identify", log(si), "--hold", hold]) == 1
    assert message in capsys.readouterr().err
