"""The policies that the package ships: they are what they say, score what they say, and need nothing that trains."""

import json
import subprocess
import sys
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest

import stickslip
from stickslip.commands import run as command
from stickslip.train.policies import Policy, read_policy
from stickslip.train.policies.pretrained import PRETRAINED
from stickslip.train.schedules import performance
from stickslip.train.scores import HELD_OUT_SEEDS, score
from stickslip.train.shipping import ship, WEIGHTS_OF_A_FRONT

ROOT = Path(__file__).parents[2]


def plain(name):
    policy = stickslip.pretrained(name)
    return policy.at(0.2) if policy.conditioned else policy


def by_hand(policy, steps, seed):
    """Speed and memory of a policy that is called once a step."""
    environment = gym.make("StickSlipCrawler-v0", **policy.env_kwargs, max_episode_steps=-1).unwrapped
    observation, _ = environment.reset(seed=seed)
    commands, valves = [], []
    for _ in range(steps):
        commands.append(policy.predict(observation))
        observation, _, _, _, info = environment.step(commands[-1])
        valves.append(info["valve"])
    settings = environment.settings
    return performance(
        np.array(commands),
        np.array(valves),
        dither=settings.dither,
        groups=settings.groups,
        hold=settings.hold,
        scene=settings.scene,
    )


@pytest.mark.parametrize("name", PRETRAINED)
def test_a_shipped_policy_scores_what_its_file_says(name):
    policy = plain(name)
    told = policy.scores
    assert told["seeds"] == list(HELD_OUT_SEEDS)
    assert told["steps"] >= 6000
    found = by_hand(policy, 3000, 77)
    for quantity, value in (("speed", found.speed), ("memory", found.memory.corrected)):
        estimate = told[quantity]
        # One seed, over fewer steps, spreads as the ten did, and somewhat more.
        spread = (estimate["high"] - estimate["low"]) * np.sqrt(len(told["seeds"]))
        assert abs(value - estimate["mean"]) < 2 * spread + 0.1 * estimate["mean"]
    for end in (".json", ".safetensors"):
        assert (ROOT / "train" / "pretrained" / (name + end)).stat().st_size < 32_000


def test_the_knee_has_most_of_both():
    scores = stickslip.pretrained("knee").scores
    assert scores["speed"]["low"] > 0.72
    assert scores["memory"]["low"] > 3.0


def test_a_shipped_policy_is_evaluated_by_its_name(capsys, monkeypatch, tmp_path):
    monkeypatch.setattr("stickslip.train.report.save_figure", lambda *_: None)
    monkeypatch.chdir(tmp_path)
    options = ["--no-video", "--steps", "2000", "--seeds", "3", "--dither", "0.2"]
    assert command(["evaluate", "knee", *options]) == 0
    told = (line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    printed = {name: value for name, *value in told}
    policy = stickslip.pretrained("knee")
    expected = score(policy, policy.env_kwargs | {"dither": 0.2}, steps=2000, seeds=HELD_OUT_SEEDS[:3])["speed"]
    assert printed["speed"] == [f"{expected['mean']:.4f} [{expected['low']:.4f}, {expected['high']:.4f}]"]
    assert printed["seeds"] == ["2000000 to 2000002"]
    assert (tmp_path / "runs" / "knee" / "results.json").exists()
    for wrong, message in (
        (["--checkpoint", "c.zip"], "error: --checkpoint must be left out with the pretrained policy knee, got c.zip"),
        (["--weight", "0.5"], "error: weight must not be set: Policy(StickSlipCrawler-v0, ppo, 8-64-64-2) was not"),
    ):
        assert command(["evaluate", "knee", *wrong]) == 1
        assert capsys.readouterr().err.startswith(message)


def test_the_policy_of_every_weight_is_as_good_as_those_it_was_distilled_from():
    for each in stickslip.pretrained("conditioned").scores["weights"]:
        w = each["weight"]
        rewards = [
            (1 - w) * scores["speed"]["mean"] + w * scores["memory"]["mean"]
            for scores in (each, *(stickslip.pretrained(name).scores for name in ("speed", "knee", "memory")))
        ]
        assert rewards[0] > 0.97 * max(rewards[1:]), w


def test_what_is_not_shipped_is_refused():
    with pytest.raises(ValueError, match=r"name has no 'octopus'; allowed are \['"):
        stickslip.pretrained("octopus")


def test_a_shipped_policy_runs_where_nothing_is_installed_that_trains_one():
    blocked = "import sys; sys.modules.update(dict.fromkeys(['torch', 'stable_baselines3', 'sb3_contrib', 'yaml']))\n"
    code = "import stickslip; print(stickslip.pretrained('knee').predict([0.0] * 8), 'numba' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", blocked + code], capture_output=True, text=True, encoding="utf-8")
    assert done.stdout.split()[1:] == ["False"], done.stderr
    assert done.stdout.split()[0] in ("0", "1")


def test_shipping_measures_on_held_out_seeds_and_writes(tmp_path):
    policy = plain("knee").scored({})
    shipped = ship(policy, "mine", tmp_path / "deep", steps=1600, seeds=(5, 6))
    assert shipped.scores == score(policy, policy.env_kwargs, steps=1600, seeds=(5, 6))
    again = read_policy(tmp_path / "deep" / "mine")
    assert again.description == shipped.description
    assert json.loads((tmp_path / "deep" / "mine.json").read_text(encoding="utf-8"))["scores"]["seeds"] == [5, 6]
    # Of a run's folder its best policy is taken.
    (tmp_path / "run").mkdir()
    ship(policy, "best", tmp_path / "run", steps=1600, seeds=(5, 6))
    assert ship(tmp_path / "run", "other", tmp_path, steps=1600, seeds=(5, 6)).scores == shipped.scores


def test_a_policy_for_every_weight_is_measured_at_each(tmp_path, monkeypatch):
    assert tuple(k / 10 for k in range(11)) == WEIGHTS_OF_A_FRONT
    monkeypatch.setattr("stickslip.train.shipping.WEIGHTS_OF_A_FRONT", (0.0, 0.3, 1.0))
    knee = stickslip.pretrained("knee")
    (first, bias), *others = knee.layers
    column = np.random.default_rng(0).normal(size=(len(bias), 1)).astype(np.float32)
    description = knee.description
    sizes = description["network"]["sizes"]
    description["network"]["sizes"] = [sizes[0] + 1, *sizes[1:]]
    any_weight = Policy([(np.hstack([first, column]), bias), *others], {**description, "conditioned": True})
    scores = ship(any_weight, "any", tmp_path, steps=1600, seeds=(5, 6)).scores["weights"]
    assert [each["weight"] for each in scores] == [0.0, 0.3, 1.0]
    at = any_weight.at(0.3)
    assert scores[1] == {"weight": 0.3, **score(at, at.env_kwargs, steps=1600, seeds=(5, 6))}
    assert scores[1]["speed"] != scores[2]["speed"]
