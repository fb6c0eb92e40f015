"""``stickslip run``: the simulator or somebody's file as the plant, a log that identification reads, and refusals."""

import json
import re
from dataclasses import asdict, replace

import numpy as np
import pytest

import stickslip
from stickslip.commands import run
from stickslip.envs import StickSlipCrawlerEnv
from stickslip.studies.identification.log import read_log

PLANT = """
from pathlib import Path
turns = Path(__file__).with_suffix(".turns")

def read():
    return {"deformation_mm": 0.5, "foot_mm": 1.0, "pressure_kPa": 2.0}

def write(valve):
    with turns.open("a", encoding="utf-8") as file:
        print(valve, file=file)
"""


def test_a_dry_run_is_logged_as_identification_reads_it(tmp_path, capsys):
    log, report = tmp_path / "run.csv", tmp_path / "report.json"
    command = ["run", "knee", "--dry-run", "--pace", "inf", "--holds", "40", "--seed", "7"]
    assert run([*command, "--log", str(log), "--report", str(report)]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "40 holds of 0.5 t_c = 31.25 ms" in printed
    assert "0 deadlines missed by more than 3.125 ms, 0 holds skipped" in printed
    policy = stickslip.pretrained("knee")
    env = StickSlipCrawlerEnv(**policy.env_kwargs)
    observation, _ = env.reset(seed=7)
    valves, feet = [], []
    for _ in range(40):
        observation, *_, info = env.step(policy.predict(observation))
        valves.append(info["valve"])
        feet.append(info["distance"])
    body = stickslip.Actuator.ecoflex()
    went = float(re.search(r"the foot went (\S+) mm in 1.25 s", printed)[1])
    assert went == pytest.approx(1e3 * feet[-1] * body.scales.length, rel=1e-3)
    read = read_log(log, 0.03125)
    assert read.si
    assert read.ignored == ("command",)
    np.testing.assert_array_equal(read.run.valve, valves)
    assert read.run.samples_per_hold == 8
    np.testing.assert_allclose(read.run.foot[7::8], np.array(feet) * body.scales.length, rtol=1e-8, atol=1e-12)
    told = json.loads(report.read_text(encoding="utf-8"))
    assert (told["holds"], told["missed"], told["hold"]) == (40, 0, 0.03125)


def test_another_body_than_that_of_the_training_is_told(capsys):
    body = json.dumps(asdict(replace(stickslip.Actuator.ecoflex(), lag=0.04, damping=0.41)))
    assert run(["run", "speed", "--dry-run", "--pace", "inf", "--holds", "2", "--actuator", body]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert printed.count("another body than that of the training") == 1
    assert "training: deborah 0.64 instead of 0.5 2 holds" in printed


def test_a_file_is_the_plant(tmp_path, capsys):
    file = tmp_path / "robot.py"
    file.write_text(PLANT, encoding="utf-8")
    command = ["run", "conditioned", "--weight", "0.3", "--plant", str(file), "--hold", "2 ms", "--dither", "0"]
    assert run([*command, "--holds", "6", "--readings", "2", "--volts", "0", "12"]) == 0
    turns = [float(line) for line in file.with_suffix(".turns").read_text(encoding="utf-8").split()]
    assert turns[0] == turns[-1] == 0.0
    assert set(turns) <= {0.0, 12.0}
    assert 2 < len(turns) <= 8
    assert "0.032 t_c, trained at 0.5 t_c" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "--dry-run or --plant must be given, and one of them alone, got neither"),
        (["--dry-run", "--plant", "x.py"], "one of them alone, got both"),
        (["--plant", "nowhere.py"], "--plant must be a Python file, nowhere.py is no file"),
        (["--plant", "empty.py"], "--plant must define read() and write(valve), empty.py lacks read and write"),
        (["--plant", "empty.py", "--pace", "2"], "--pace must be left out with --plant"),
        (["--dry-run", "--volts", "0", "24"], "--volts must be left out with --dry-run"),
        (["--dry-run", "--holds", "0"], "--holds must be a whole number >= 1, got 0"),
        (["--dry-run", "--pace", "0"], "--pace must be in (0, inf], got 0"),
        (["--dry-run", "--hold", "20 apples"], "hold must be a number in (0, inf), or a text of one and its unit"),
        (["--dry-run", "--actuator", '{"lag": 1}'], "--actuator must set"),
        (["--dry-run", "--readings", "1"], "readings must be a whole number in [2, 1000], got 1"),
    ],
)
def test_what_cannot_be_run_is_refused_in_one_sentence(arguments, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty.py").write_text("", encoding="utf-8")
    assert run(["run", "knee", *arguments]) == 1
    told = capsys.readouterr().err
    assert message in told
    assert told.count("\n") == 1
