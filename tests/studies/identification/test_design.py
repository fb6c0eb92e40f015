"""Words that tell most: as good as all that can be tried, and better than random ones where bodies are identified."""

from itertools import product

import numpy as np
import pytest

from stickslip import Actuator, Groups, identify, simulate
from stickslip.studies.identification import best_word, Measurements

BODY = Groups(static_friction=0.35, kinetic_friction=0.2)
NAMES = ("damping_ratio", "radial_coupling", "static_friction")
NOISE = {"deformation": 0.004, "foot": 0.004}


def design(length, **options):
    given = {"names": NAMES, "noise": NOISE, "hold": 1.0, "samples_per_hold": 4} | options
    return best_word(BODY, length, **given)


def errors_of(word, seeds=12):
    """Relative spread of what is identified from runs of a word, whose errors differ."""
    motion = simulate(BODY, [int(bit) for bit in word], 1.0, samples_per_hold=4)
    found = []
    for seed in range(seeds):
        generator = np.random.default_rng(seed)
        told = {name: getattr(motion, name) + NOISE[name] * generator.standard_normal(4 * len(word)) for name in NOISE}
        run = Measurements(motion.valve, 1.0, 4, **told)
        found.append(identify(run, free=NAMES, guess=BODY, starts=1).groups)
    return {name: np.std([getattr(each, name) for each in found]) / getattr(BODY, name) for name in NAMES}


def information_by_differences(word, names):
    columns = []
    for name in names:
        value = getattr(BODY, name)
        there, back = (
            simulate(BODY.to_dict() | {name: value * factor}, word, 1.0, samples_per_hold=4)
            for factor in (1.0 + 1e-5, 1.0 - 1e-5)
        )
        columns.append(np.concatenate([(getattr(there, c) - getattr(back, c)) / NOISE[c] for c in NOISE]) / 2e-5)
    relative = np.stack(columns, axis=1)
    return relative.T @ relative + np.eye(len(names))


def test_of_short_words_the_best_of_all_is_found():
    found = design(5, aim="radial_coupling")
    errors = {}
    for word in product((0, 1), repeat=5):
        covariance = np.linalg.inv(information_by_differences(word, NAMES))
        errors["".join(map(str, word))] = np.sqrt(covariance[1, 1])
    assert errors[found.word] == pytest.approx(min(errors.values()), rel=1e-3)
    assert found.errors["radial_coupling"] == pytest.approx(errors[found.word], rel=1e-3)
    assert found.random["radial_coupling"] > found.errors["radial_coupling"]


def test_a_designed_word_beats_random_ones_where_bodies_are_identified():
    found = design(12)
    assert found.aim == max(found.random, key=found.random.get)
    spread = errors_of(found.word)[found.aim]
    assert spread == pytest.approx(found.errors[found.aim], rel=0.6)
    generator = np.random.default_rng(5)
    others = [errors_of("".join(map(str, generator.integers(0, 2, 12))))[found.aim] for _ in range(3)]
    assert spread < 0.8 * np.median(others)


def test_the_aim_is_what_is_known_least_and_all_at_once_is_another():
    known = np.diag([0.001 * BODY.damping_ratio, 0.2 * BODY.radial_coupling, 0.001 * BODY.static_friction]) ** 2
    found = design(9, covariance=known)
    assert found.aim == "radial_coupling"
    assert found.known["damping_ratio"] == pytest.approx(0.001, rel=1e-3)
    assert found.errors["damping_ratio"] < 0.001
    both = design(9, aim="all")
    volume = [
        np.linalg.slogdet(information_by_differences([int(b) for b in w], NAMES))[1] for w in (both.word, found.word)
    ]
    assert volume[0] >= volume[1]


def test_an_identification_says_its_next_word():
    body = Actuator.ecoflex()
    motion = simulate(body, [1, 0, 1, 1, 0, 0, 1, 0], 0.06 / body.scales.time, samples_per_hold=6).in_si(body)
    run = Measurements.of(motion, "foot", noise=0.01)
    found = identify(run, free=("damping", "lag"), guess=body, starts=1)
    following = found.next_word(4)
    assert len(following.word) == 4
    least = max(following.known, key=following.known.get)
    assert following.aim == least
    errors = np.sqrt(np.diag(found.covariance)) / [found.body.damping, found.body.lag]
    assert list(following.known.values()) == pytest.approx(errors, rel=0.01)
    assert following.errors[least] < following.known[least]
    assert found.next_word(4, aim="lag").aim == "lag"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"length": 0}, r"length must be a whole number in \[1, 1000\], got 0"),
        ({"names": ("colour",)}, "names has no 'colour'"),
        ({"noise": {}}, "noise must have a positive number for each channel that is measured, got {}"),
        ({"names": ("duffing", "duffing")}, "names must be one or several of .*, each once"),
        ({"noise": {"foot": float("nan")}}, r"noise of foot must be in \(0, inf\), got nan"),
        ({"samples_per_hold": 0}, "samples_per_hold must be a whole number >= 1, got 0"),
        ({"covariance": [[1.0]]}, r"covariance must have shape \(.*\), a row and a column a name, got \(1, 1\)"),
        ({"covariance": [[float("nan")]]}, "covariance must be finite"),
        ({"noise": {"wheel": 1.0}}, "noise has no 'wheel'"),
        ({"aim": "duffing"}, "aim has no 'duffing'"),
    ],
)
def test_refuses_what_is_no_design(options, message):
    with pytest.raises(ValueError, match=message):
        design(**{"length": 3} | options)
