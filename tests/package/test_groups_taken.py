"""Wherever groups are taken, a preset, a mapping, an actuator and groups themselves mean the same."""

import json
from dataclasses import asdict, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import gymnasium as gym
import numpy as np
import pytest
import yaml

from stickslip.crawler import Actuator, Groups, simulate
from stickslip.envs import StickSlipCrawlerVectorEnv
from stickslip.studies.benchmark.bench import Bench
from stickslip.studies.benchmark.sweep import with_amplitude, with_value
from stickslip.studies.work_precision import Case
from stickslip.tasks import BodyReservoir, crawler_states, known_reservoirs
from stickslip.tasks.transformer import CrawlerReservoir
from stickslip.train.run import Configuration
from stickslip.train.schedules import performance

SOFT = replace(Actuator.ecoflex(), stiffness=70.0, damping=0.3)
CHOICES = {
    "preset": ("aggressive-forcing", Groups(duffing=5.0, radial_coupling=0.5)),
    "mapping": ({"duffing": 2}, Groups(duffing=2.0)),
    "actuator": (SOFT, SOFT.groups),
    "groups": (Groups(deborah=0.4), Groups(deborah=0.4)),
}
WORD = [1, 1, 0, 1, 0, 0, 1, 0]


def of_gym(groups):
    env = gym.make("StickSlipCrawler-v0", groups=groups)
    env.reset(seed=0)
    return env.unwrapped.episode_groups.to_dict()


def of_a_batch(groups):
    env = StickSlipCrawlerVectorEnv(2, groups=[groups, "linear"])
    told = env.reset(seed=0)[1]["groups"]
    env.close()
    return {name: values[0] for name, values in told.items() if not name.startswith("_")}


def of_a_schedule(groups):
    word = np.array(WORD)
    return performance(word, word, dither=0.0, groups=groups, hold=1.0, scene=None).speed


def of_a_configuration(groups):
    configuration = Configuration(env_kwargs={"groups": groups, "hold": np.float32(0.5)})
    Groups.of(configuration.env_kwargs["groups"])
    kept = yaml.safe_load(yaml.safe_dump(asdict(configuration)))
    return Groups.of(kept["env_kwargs"]["groups"])


def of_a_bench(groups):
    with TemporaryDirectory() as folder:
        chosen = {"tasks": "NARMA-2 NRMSE", "reservoirs": "crawler", "features": 3, "length": 300, "seeds": 1}
        bench = Bench(Path(folder) / "bench", body={"groups": groups}, **chosen)
        list(bench.run(1))
        bench.report()
        kept = json.loads((Path(folder) / "bench" / "benchmark.json").read_text(encoding="utf-8"))
    return [score["score"] for score in kept["scores"]]


TAKERS = {
    "Groups.of": Groups.of,
    "simulate": lambda groups: simulate(groups, WORD, 1.0).foot,
    "simulate a batch": lambda groups: simulate([groups, "linear", groups], WORD, 1.0).foot,
    "simulate schedules": lambda groups: simulate(groups, [WORD, WORD[::-1]], 1.0, scene={"ratchet": False}).foot,
    "gym.make": of_gym,
    "vector": of_a_batch,
    "crawler_states": lambda groups: crawler_states(WORD, groups=groups),
    "BodyReservoir": lambda groups: BodyReservoir(groups=groups).groups,
    "known_reservoirs": lambda groups: known_reservoirs(groups=groups)["linear"].groups,
    "CrawlerReservoir": lambda groups: CrawlerReservoir(groups).fit_transform(np.array(WORD)[:, None]),
    "with_amplitude": lambda groups: with_amplitude(groups, 2.0),
    "with_value": lambda groups: with_value(BodyReservoir(groups=groups), "amplitude", 2.0).groups,
    "performance": of_a_schedule,
    "Configuration": of_a_configuration,
    "Bench": of_a_bench,
    "Case": lambda groups: Case(groups=groups).groups,
}


@pytest.mark.parametrize("taker", TAKERS)
@pytest.mark.parametrize("choice", CHOICES)
def test_one_choice_means_one_crawler_everywhere(taker, choice):
    given, groups = CHOICES[choice]
    found, expected = TAKERS[taker](given), TAKERS[taker](groups)
    if isinstance(expected, np.ndarray):
        np.testing.assert_array_equal(found, expected)
    else:
        assert found == expected


@pytest.mark.parametrize("taker", TAKERS)
@pytest.mark.parametrize(
    ("bad", "error", "says"),
    [
        ("octopus", ValueError, "groups must be one of the presets .*, got 'octopus'"),
        ({"dufing": 1}, ValueError, "groups has no 'dufing'; allowed are"),
        ({"duffing": -1}, ValueError, r"duffing must be in \[0, inf\), got -1"),
        (3.0, TypeError, "groups must be Groups, a preset's name, a mapping of fields or an Actuator, got 3.0"),
        (Actuator, TypeError, "groups must be Groups, a preset's name"),
    ],
)
def test_what_is_no_choice_is_refused_everywhere_in_the_same_words(taker, bad, error, says):
    with pytest.raises(error, match=says):
        TAKERS[taker](bad)


def test_groups_of_their_own_kind_may_be_swept(tmp_path):
    """A number named beside its sweep is refused; of a whole crawler one number may be swept."""
    chosen = {"sweep": "duffing=1,2", "features": 3, "length": 300}
    for groups in (Groups(duffing=1.0), Actuator.ecoflex(), "aggressive-forcing", {"deborah": 1.0}):
        assert Bench(tmp_path / "bench", body={"groups": groups}, **chosen).total > 0
    with pytest.raises(ValueError, match="duffing must be left out where --sweep sets it, got 3"):
        Bench(tmp_path / "bench", body={"groups": {"duffing": 3}}, **chosen)


@pytest.mark.parametrize("several", [(SOFT, "linear"), iter([SOFT, "linear"]), np.array([SOFT, "linear"], object)])
def test_several_may_come_in_any_sequence(several):
    np.testing.assert_array_equal(
        simulate(several, WORD, 1.0).foot, simulate([SOFT.groups, Groups.of("linear")], WORD, 1.0).foot
    )
