"""Logs as instruments write them: read as they are meant, and refused in a sentence where they are none."""

import numpy as np
import pytest

from stickslip import Actuator, identify, simulate
from stickslip.studies.identification import read_log
from stickslip.tasks import random_bits

HOLDS, HOLD, SAMPLES = 30, 0.06, 10
BITS = random_bits(HOLDS, 3)
NATURAL = "time,valve,foot\n0.5,1,0.1\n1.0,1,0.2\n1.5,0,\n2.0,0,0.4\n"


def written(folder, text, encoding="utf-8"):
    file = folder / "log.csv"
    file.write_text(text, encoding)
    return file


def log_of(motion, valve_at, separator=","):
    """Deformation and foot in mm, pressure in kPa, with some gaps, as text; the valve of a row is `valve_at` it."""
    rows = [["time_s", "valve", "deformation_mm", "note", "foot_mm", "pressure_kPa"]]
    for i, t in enumerate(motion.time.tolist()):
        foot = "" if 60 <= i < 75 else f"{1e3 * motion.foot[i]:.17g}"
        deformation, pressure = f"{1e3 * motion.deformation[i]:.17g}", f"{1e-3 * motion.pressure[i]:.17g}"
        rows.append([f"{t:.6f}", str(BITS[valve_at(i)]), deformation, "cold", foot, pressure])
    return "".join(separator.join(row) + "\n" for row in rows)


def last_valve(i):
    """The valve before an instant: a row at an edge tells of the hold that ends."""
    return i // SAMPLES


def next_valve(i):
    """The valve after it."""
    return min((i + 1) // SAMPLES, HOLDS - 1)


@pytest.fixture(scope="module")
def motion():
    body = Actuator.ecoflex()
    return simulate(body, BITS, HOLD / body.scales.time, samples_per_hold=SAMPLES).in_si(body)


@pytest.mark.parametrize("valve_at", [last_valve, next_valve])
@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_a_log_is_read_as_it_was_driven_and_measured(tmp_path, motion, valve_at, separator):
    read = read_log(written(tmp_path, log_of(motion, valve_at, separator), "utf-8-sig"))
    run = read.run
    assert read.si
    assert read.ignored == ("note",)
    assert run.hold == HOLD
    np.testing.assert_array_equal(run.valve, BITS)
    assert run.samples_per_hold == SAMPLES
    assert run.measured == ("deformation", "pressure", "foot")
    np.testing.assert_allclose(run.deformation, motion.deformation, rtol=1e-12)
    np.testing.assert_allclose(run.pressure, motion.pressure, rtol=1e-12)
    gap = np.arange(60, 75)
    assert np.flatnonzero(np.isnan(run.foot)).tolist() == gap.tolist()
    np.testing.assert_allclose(np.delete(run.foot, gap), np.delete(motion.foot, gap), rtol=1e-12)


def test_the_body_that_a_log_is_of_is_found_again(tmp_path, motion):
    run = read_log(written(tmp_path, log_of(motion, last_valve))).run
    free = ("stiffness", "lag", "kinetic_friction")
    found = identify(run, free=free, guess=Actuator.ecoflex(), starts=1)
    for name in free:
        assert getattr(found.body, name) == pytest.approx(getattr(Actuator.ecoflex(), name), rel=1e-5), name


def test_rows_at_times_of_their_own_and_the_row_at_rest(tmp_path):
    file = written(tmp_path, "time,foot,valve\n0,0,1\n0.4,0.1,1\n0.7,nan,1\n1.3,0.3,0\n1.9,0.4,0\n2.4,,1\n")
    run = read_log(file, 1.0).run
    np.testing.assert_array_equal(run.valve, [1, 0, 1])
    assert run.samples_per_hold is None
    np.testing.assert_array_equal(run.times, [0, 0.4, 0.7, 1.3, 1.9, 2.4])
    np.testing.assert_array_equal(run.foot, [0, 0.1, np.nan, 0.3, 0.4, np.nan])
    # Equally spaced samples are told as such, and the rest with which they begin is left away.
    even = read_log(written(tmp_path, "time,foot,valve\n0,0,1\n0.5,0.1,1\n1,0.2,1\n1.5,0.3,0\n2.0,0.4,0\n"), 1.0).run
    assert even.samples_per_hold == 2
    np.testing.assert_array_equal(even.foot, [0.1, 0.2, 0.3, 0.4])


@pytest.mark.parametrize("hold", [0.05, 0.125, 1.0 / 3.0])
@pytest.mark.parametrize("late", [0.0, 0.3, 0.9])
def test_the_hold_is_found_from_when_the_valve_turns(tmp_path, hold, late):
    word = [0, 0, 1, 1, 0, 1, 0, 0, 0, 1]
    times = (np.arange(200) + late) * hold / 20
    lines = [f"{t!r},{word[min(int(t / hold + 1e-9), 9)]},0.1" for t in times.tolist()]
    run = read_log(written(tmp_path, "time,valve,foot\n" + "\n".join(lines))).run
    assert run.hold == pytest.approx(hold, rel=1e-12)
    np.testing.assert_array_equal(run.valve, word)


def hold_of(folder, hold, times, holds=40, digits=None):
    """A log of random bits that was read back: the hold that is found, and its bounds."""
    word = random_bits(holds, 3)
    told = [word[min(int(t / hold + 1e-9), holds - 1)] for t in times]
    written_times = [repr(float(t)) if digits is None else f"{t:.{digits}f}" for t in times]
    lines = [f"{t},{valve},0.1" for t, valve in zip(written_times, told, strict=True)]
    return read_log(written(folder, "time,valve,foot\n" + "\n".join(lines)))


def test_a_hold_of_whole_rows_is_found_as_such(tmp_path):
    # Between 0.03117 and 0.03125, by the rows about the last turn, 0.0312 is no more likely than anything else.
    read = hold_of(tmp_path, 0.03125, np.arange(1, 321) / 256)
    low, high = read.hold_bounds
    assert low < 0.0312 < high
    assert (read.run.hold, read.run.samples_per_hold) == (0.03125, 8)


def test_a_hold_of_a_round_rate_is_found_as_such(tmp_path):
    read = hold_of(tmp_path, 1.0 / 32.0, np.arange(2083) * 0.003, holds=200)
    low, high = read.hold_bounds
    assert low < read.run.hold == 1.0 / 32.0 <= high


def test_times_that_were_rounded_are_read_as_the_equally_spaced_ones_that_they_were(tmp_path):
    read = hold_of(tmp_path, 0.0625, np.arange(1, 321) / 128, digits=3)
    assert read.run.hold == pytest.approx(0.0625, rel=1e-4)
    assert read.run.samples_per_hold == 8


def test_rows_that_are_missing_are_no_rounding(tmp_path):
    times = [1, 2, 3, 5, 6, 8, 9, 10, 12, 13]
    lines = [f"{t},1,0.1" for t in times]
    run = read_log(written(tmp_path, "time,valve,foot\n" + "\n".join(lines)), 13.0).run
    np.testing.assert_array_equal(run.times, times)


def test_of_a_hold_that_is_not_round_the_middle_of_its_bounds_is_taken(tmp_path):
    true = 0.0317459
    times = (np.arange(1, 400) + np.random.default_rng(0).uniform(-0.3, 0.3, 399)) * true / 10
    read = hold_of(tmp_path, true, times)
    low, high = read.hold_bounds
    assert low <= true <= high
    assert read.run.hold == pytest.approx(0.5 * (low + high), rel=1e-12)
    assert high - low < 0.01 * true
    # Nor is the only round number in wide bounds more than chance: 0.06 is among those of this hold.
    few = hold_of(tmp_path, 0.0613, times[:99] * 0.0613 / true, holds=10)
    low, high = few.hold_bounds
    assert few.run.hold == pytest.approx(0.5 * (low + high), rel=1e-12)


def test_a_hold_that_is_given_has_no_bounds(tmp_path):
    assert read_log(written(tmp_path, NATURAL), 1.0).hold_bounds is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "log.csv must have a line of column names, it is empty"),
        ("time,valve,foot\n", "log.csv must have a line a sample, it has none"),
        ("valve,foot\n1,0\n", "log.csv must have a column time, or time_s, got valve, foot"),
        ("time,foot\n1,0\n", "log.csv must have a column valve, got time, foot"),
        ("time,valve\n1,0\n", "log.csv must have a column of deformation, velocity, pressure, foot,"),
        (
            "time_s,valve,foot_inch\n",
            "log.csv: the unit of foot_inch must be one of m, cm, mm, um, or none, got 'inch'",
        ),
        ("time_s,valve_V,foot_m\n", "log.csv: the unit of valve_V must be none, got 'V'"),
        ("time_s,valve,foot\n1,0,1\n", "must be all in SI units or all in natural ones, got time_s and foot"),
        ("time,valve,foot_mm,pressure\n1,0,1,1\n", "must be all in SI units or all in natural ones, got foot_mm and"),
        ("time,valve,foot,foot\n1,0,1,1\n", "log.csv must have one column for the foot, got foot and foot"),
        (NATURAL.replace("0.2", "0.2m"), "log.csv, line 3: foot must be a number or empty, got '0.2m'"),
        (NATURAL.replace("0.2", "1_0"), "log.csv, line 3: foot must be a number or empty, got '1_0'"),
        (NATURAL.replace("0.2", '"0\n2"'), "log.csv, line 4: foot must be a number or empty, got '0\\n2'"),
        (
            NATURAL.replace("0.2", 200_000 * "1"),
            "log.csv, line 3: cells must be of a CSV file, got a field",
        ),
        (NATURAL.replace("0.2", "inf"), "log.csv, line 3: foot must be a number or empty, got 'inf'"),
        (NATURAL.replace("2.0,0", "2.0,0.5"), "log.csv, line 5: valve must be 0 or 1, got 0.5"),
        (NATURAL.replace("1.5,0,", "1.5,0"), "log.csv, line 4: 3 cells are expected, got 2"),
        (NATURAL.replace("1.5,0", "1.0,0"), "log.csv, line 4: time must ascend, got 1.0"),
        (NATURAL.replace("1.5,0", ",0"), "log.csv, line 4: time must be a number, got an empty cell"),
        (NATURAL.replace("0.5,1", "-0.5,1"), "log.csv, line 2: time must count from the first hold, got -0.5"),
        (
            NATURAL.replace("0.5,1", "0.5,0"),
            "line 3: the valve must stay as it is within a hold of 2, which began at 0",
        ),
        (
            "time,valve,foot\n1,1,0\n1.5,1,0\n5,0,0\n",
            "line 2 and on: a row must tell the valve of each hold of 2, none tells",
        ),
    ],
)
def test_refuses_what_is_no_log_and_says_where(tmp_path, text, message):
    with pytest.raises(ValueError, match=r".") as refused:
        read_log(written(tmp_path, text), 2.0)
    assert message in str(refused.value)


def test_refuses_a_hold_that_the_rows_do_not_tell(tmp_path):
    with pytest.raises(ValueError, match=r"hold must be given for .*, whose valve never turns"):
        read_log(written(tmp_path, "time,valve,foot\n1,1,0\n2,1,0\n"))
    with pytest.raises(ValueError, match="its valve turns at multiples of no one time that its rows tell"):
        read_log(written(tmp_path, "time,valve,foot\n1,1,0\n2,0,0\n3,1,0\n"))
    with pytest.raises(ValueError, match=r"a row tells the valve of each, got 1e-09 for the 4 rows of .*log.csv,"):
        read_log(written(tmp_path, NATURAL), 1e-9)
    assert read_log(written(tmp_path, "time,valve,foot\n1,1,0\n2,1,0\n"), 1e300).run.valve.tolist() == [1.0]
    with pytest.raises(ValueError, match=r"hold must be in \(0, inf\), got 0.0"):
        read_log(written(tmp_path, NATURAL), 0.0)
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ValueError, match="must be text in UTF-8"):
        read_log(tmp_path / "binary.csv")
