"""``stickslip identify``: a body found again from logs, what is printed and written of it, and what is refused."""

import json
import re

import numpy as np
import pytest

from stickslip import Actuator, Groups, simulate
from stickslip.commands import run
from stickslip.tasks import random_bits

BITS = random_bits(25, 1)
TRUTH = {"duffing": 0.8, "deborah": 0.4}


def write_log(file, motion, names, factors, seed=0):
    """A log of some channels with errors of 1%."""
    generator = np.random.default_rng(seed)
    columns = []
    for name, factor in factors.items():
        values = getattr(motion, name) * factor
        columns.append(values + 0.01 * values.std() * generator.standard_normal(values.size))
    each = motion.time.size // len(BITS)
    lines = [
        ",".join([f"{t:.9g}", str(BITS[i // each]), *(f"{column[i]:.9g}" for column in columns)])
        for i, t in enumerate(motion.time.tolist())
    ]
    file.write_text("\n".join([names, *lines]), "utf-8")
    return str(file)


@pytest.fixture(scope="module")
def natural(tmp_path_factory):
    """Two runs of one body, in natural units."""
    folder = tmp_path_factory.mktemp("logs")
    motion = simulate(TRUTH, BITS, 1.0, samples_per_hold=10, scene={"slope": 0.02})
    channels = {"deformation": 1.0, "foot": 1.0}
    return [write_log(folder / f"{k}.csv", motion, "time,valve,deformation,foot", channels, k) for k in range(2)]


def test_groups_are_found_printed_and_written(capsys, tmp_path, natural):
    options = ["--free", "duffing, deborah", "--scene", '{"slope": 0.02}', "--level", "0.9", "--design", "6"]
    assert run(["identify", *natural, *options, "--output", str(tmp_path / "one")]) == 0
    told = capsys.readouterr().out
    assert told.count("25 holds of 1 natural units of time, 250 samples of deformation, foot") == 2
    assert told.count("; --hold says it exactly") == 2
    assert "From 1000 numbers" in told
    written = json.loads((tmp_path / "one" / "identification.json").read_text("utf-8"))
    assert written["units"] == "natural"
    assert (written["level"], written["samples"], written["holds"]) == (0.9, 1000, [1.0, 1.0])
    for low, high in written["hold_bounds"]:
        assert 0.9 < low <= 1.0 <= high < 1.1
    assert written["logs"] == natural
    assert list(written["free"]) == ["duffing", "deborah"]
    for name, value in TRUTH.items():
        found = written["free"][name]
        low, high = found["interval"]
        assert low < found["value"] < high
        assert (high - low) / 2.0 == pytest.approx(1.646 * found["standard_error"], rel=1e-2)
        assert found["value"] == pytest.approx(value, rel=5e-3)
        assert re.search(rf"{name} +{found['value']:.5g} +{low:.5g} to {high:.5g}", told)
    assert written["groups"] == pytest.approx(Groups(**TRUTH).to_dict(), rel=5e-3)
    following = written["design"]
    assert f"Least is known of {following['aim']}, to " in told
    assert re.search(rf"A run of\s{following['word']}\swould", told)
    assert len(following["word"]) == 6
    names = sorted(file.name for file in (tmp_path / "one").iterdir())
    assert names == ["fit-1.png", "fit-1.svg", "fit-2.png", "fit-2.svg", "identification.json"]


def test_an_actuator_is_found_from_a_log_in_si(capsys, tmp_path):
    true, hold = Actuator.ecoflex(), 0.06
    motion = simulate(true, BITS, hold / true.scales.time, samples_per_hold=10).in_si(true)
    log = write_log(tmp_path / "log.csv", motion, "time_s,valve,foot_mm,temperature_C", {"foot": 1e3, "pressure": 0.0})
    about = {name: getattr(true, name) for name in true.__dataclass_fields__} | {"stiffness": 70.0}
    options = ["--actuator", json.dumps(about), "--hold", "0.06", "--output", str(tmp_path / "found")]
    assert run(["identify", log, *options]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "25 holds of 0.06 s, 250 samples of foot" in told
    assert "no channel, and not used: temperature_C" in told
    assert "In groups: duffing" in told
    written = json.loads((tmp_path / "found" / "identification.json").read_text("utf-8"))
    assert written["units"] == "SI"
    assert list(written["free"])[:4] == ["stiffness", "cubic_stiffness", "damping", "lag"]
    assert written["free"]["stiffness"]["value"] == pytest.approx(64.0, rel=0.02)
    assert written["body"]["payload_mass"] == true.payload_mass


def test_what_a_log_cannot_tell_is_said(capsys, tmp_path):
    still = tmp_path / "still.csv"
    errors = 1e-3 * np.random.default_rng(0).standard_normal(40)
    rows = [f"{0.25 * (i + 1)},0,{error}" for i, error in enumerate(errors)]
    still.write_text("\n".join(["time,valve,pressure", *rows]), "utf-8")
    options = ["--free", "duffing", "--guess", '{"duffing": 2.0}', "--hold", "1", "--output", str(tmp_path / "one")]
    assert run(["identify", str(still), *options]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "warning: the data hardly tell a body from one up in duffing by 1 of the guess" in told


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--free", "colour"], "error: free has no 'colour'; allowed are"),
        (["--guess", "{}", "--actuator", "ecoflex"], "error: --guess is of groups and --actuator of a body in SI: one"),
        (["--actuator", "ecoflex"], "error: --actuator is for logs in SI units, and "),
        (["--design", "0"], "error: --design must be a whole number in [1, 1000], got 0"),
        (["--level", "1"], "error: --level must be in (0, 1), got 1.0"),
        (["--scene", "3"], "error: --scene must be a JSON object, got '3'"),
        (["--hold", "0.3"], "error: "),
    ],
)
def test_what_cannot_be_identified_is_refused_in_one_line(capsys, tmp_path, natural, options, message):
    assert run(["identify", natural[0], "--output", str(tmp_path / "one"), *options]) == 1
    assert capsys.readouterr().err.splitlines()[-1].startswith(message)
    assert not (tmp_path / "one").exists()


def test_a_log_in_si_needs_an_actuator(capsys, tmp_path):
    log = tmp_path / "log.csv"
    log.write_text("time_s,valve,foot_mm\n0.1,1,0.1\n0.2,0,0.1\n", "utf-8")
    assert run(["identify", str(log), "--hold", "0.1"]) == 1
    assert "error: --actuator must say about which body to look, since" in capsys.readouterr().err
