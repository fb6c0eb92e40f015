"""Policies and schedules for other programs act as Stable-Baselines3 does, at the times and volts asked for."""

import csv
import json
from dataclasses import asdict
from functools import partial

import numpy as np
import onnx
import pytest
import torch
from onnx.reference import ReferenceEvaluator
from stable_baselines3 import A2C, DQN, PPO

from stickslip.commands import run as command
from stickslip.crawler import Actuator, Groups
from stickslip.envs import StickSlipCrawlerEnv
from stickslip.train import StickSlipVecEnv
from stickslip.train.evaluation import roll_out
from stickslip.train.played import play_policy, play_word
from stickslip.train.policies import Policy, policy_of, read_policy, write_policy
from stickslip.train.policies.portable import check_onnx, onnx_actions, write_npz, write_onnx
from stickslip.train.run import Configuration
from stickslip.train.scores import score

ARGUMENTS = {"dither": 0.2, "memory_weight": 0.3, "hold": 0.25}
STIFF = {
    "payload_mass": 0.3,
    "foot_mass": 0.1,
    "stiffness": 100.0,
    "bore_area": 1e-4,
    "peak_pressure": 3e4,
    "lag": 0.02,
    "static_friction": 0.8,
    "kinetic_friction": 0.5,
}


def model_of(algorithm, **changes):
    model = algorithm("MlpPolicy", StickSlipVecEnv(1, **ARGUMENTS, **changes), seed=0, device="cpu")
    generator = torch.Generator().manual_seed(0)
    with torch.no_grad():
        for parameter in model.policy.parameters():
            parameter += torch.randn(parameter.shape, generator=generator)
    return model


def plain(model, name="ppo", **changes):
    return policy_of(model, Configuration(algorithm=name, env_kwargs=ARGUMENTS | changes))


@pytest.fixture(scope="module")
def model():
    return model_of(PPO)


@pytest.fixture(scope="module")
def policy(model):
    return plain(model)


@pytest.fixture(scope="module")
def weighed(policy):
    """The policy, as if its last number were the weight and it had seen the others."""
    description = policy.description
    description["observation_space"] |= {"shape": [4]}
    return Policy(policy.layers, {**description, "conditioned": True})


def observations(count, inputs=5):
    return np.random.default_rng(1).standard_normal((count, inputs)).astype(np.float32)


@pytest.mark.parametrize(("algorithm", "name"), [(PPO, "ppo"), (A2C, "a2c"), (DQN, "dqn")])
def test_onnx_acts_as_stable_baselines_does(algorithm, name, tmp_path):
    model = model_of(algorithm)
    write_onnx(plain(model, name), tmp_path / "policy.onnx")
    seen = observations(2000)
    expected, _ = model.predict(seen, deterministic=True)
    np.testing.assert_array_equal(onnx_actions(tmp_path / "policy.onnx", seen), expected)
    assert set(expected) == {0, 1}
    assert onnx_actions(tmp_path / "policy.onnx", seen[:1]).tolist() == expected[:1].tolist()


def test_a_graph_is_of_the_policy_and_says_whose(policy, tmp_path):
    write_onnx(policy, tmp_path / "policy.onnx")
    graph = onnx.load(tmp_path / "policy.onnx")
    assert json.loads({each.key: each.value for each in graph.metadata_props}["description"]) == policy.description
    seen = observations(50)
    action, outputs = ReferenceEvaluator(graph).run(["action", "outputs"], {"observation": seen})
    np.testing.assert_array_equal(action, policy.predict(seen))
    np.testing.assert_allclose(outputs, policy.outputs(seen), rtol=1e-4, atol=1e-4 * np.abs(outputs).max())


def test_onnx_takes_the_weight_beside_the_observation(weighed, tmp_path):
    write_onnx(weighed, tmp_path / "policy.onnx")
    seen, weights = observations(500, 4), np.random.default_rng(0).random(500).astype(np.float32)
    actions = onnx_actions(tmp_path / "policy.onnx", seen, weights)
    np.testing.assert_array_equal(actions, weighed.predict(seen, weights))
    assert check_onnx(weighed, tmp_path / "policy.onnx") > 990


def test_a_graph_that_acts_otherwise_is_found_out(policy, tmp_path):
    (first, bias), *others = policy.layers
    write_onnx(Policy([(first, bias + np.float32(1.0)), *others], policy.description), tmp_path / "policy.onnx")
    with pytest.raises(ValueError, match=r"policy\.onnx must act as its policy does, it does otherwise on \d+ of 1000"):
        check_onnx(policy, tmp_path / "policy.onnx")


def test_an_archive_holds_the_weights_and_whose_they_are(policy, tmp_path):
    write_npz(policy, tmp_path / "policy.npz")
    with np.load(tmp_path / "policy.npz", allow_pickle=False) as archive:
        assert json.loads(str(archive["description"])) == policy.description
        x = observations(100)
        for k in range(3):
            x = x @ archive[f"{k}.weight"].T + archive[f"{k}.bias"]
            x = np.tanh(x) if k < 2 else x
    np.testing.assert_array_equal(x.argmax(axis=1), policy.predict(observations(100)))


def test_one_weight_of_a_conditioned_policy_is_a_policy(weighed):
    at = weighed.at(0.25)
    seen = observations(2000, 4)
    np.testing.assert_allclose(at.outputs(seen), weighed.outputs(seen, 0.25), rtol=1e-6, atol=1e-5)
    assert (at.conditioned, at.env_kwargs) == (False, ARGUMENTS | {"memory_weight": 0.25})
    for call, message in (
        (partial(at.at, 0.5), "weight must not be set"),
        (partial(weighed.at, 1.5), r"weight must be in \[0, 1\], got 1.5"),
    ):
        with pytest.raises(ValueError, match=message):
            call()
    scores = {"weights": [{"weight": 0.25, "speed": {"mean": 0.5}}]}
    assert weighed.scored(scores).at(0.25).scores == scores["weights"][0]
    assert weighed.scored(scores).at(0.5).scores == {}


def test_a_word_is_played_in_seconds_and_volts():
    body = Actuator(**STIFF)
    schedule = play_word("110", holds=4, hold=0.5, actuator=body, open_volts=12.0, shut_volts=-1.5)
    # sqrt(M / k_1) = sqrt(0.4 / 100) s.
    np.testing.assert_allclose(schedule.time, 0.5 * np.sqrt(0.004) * np.arange(5), rtol=1e-12)
    assert schedule.volts.tolist() == [12.0, 12.0, -1.5, 12.0, -1.5]
    assert schedule.valve.tolist() == schedule.command.tolist() == [1, 1, 0, 1, 0]
    usual = play_word("110", holds=4)
    assert usual.time.tolist() == [0.0, 0.03125, 0.0625, 0.09375, 0.125]  # of half a sixteenth of a second
    assert usual.volts.tolist() == [24.0, 24.0, 0.0, 24.0, 0.0]
    for name, value in (("open_volts", np.inf), ("hold", 0.0)):
        with pytest.raises(ValueError, match=f"{name} must be in"):
            play_word("110", holds=4, **{name: value})


def test_a_policy_is_played_on_the_body_that_is_asked_for(policy):
    body = Actuator(**STIFF)
    schedule = play_policy(policy, holds=50, seed=3, actuator=body)
    expected = roll_out(policy, StickSlipCrawlerEnv(**ARGUMENTS | {"groups": body.groups}), 50, 3)
    np.testing.assert_array_equal(schedule.command[:-1], expected[0])
    np.testing.assert_array_equal(schedule.valve[:-1], expected[1])
    assert schedule.time[1] == pytest.approx(0.25 * np.sqrt(0.004), rel=1e-12)
    quiet = play_policy(policy, holds=50, dither=0.0, hold=0.5)
    assert quiet.command.tolist() == quiet.valve.tolist()
    assert quiet.time[1] == 0.03125
    assert Actuator.ecoflex().groups == Groups()
    with pytest.raises(ValueError, match="actuator must be given for a policy of other groups than ecoflex's"):
        play_policy(plain(model_of(PPO), groups={"duffing": 2.0}), holds=5)


def test_the_command_measures_what_it_writes_as_a_policy(policy, tmp_path, capsys, monkeypatch):
    measure = partial(score, steps=1600, seeds=(5, 6))
    monkeypatch.setattr("stickslip.train.shipping.score", lambda *asked, **_: measure(*asked))
    write_policy(policy, tmp_path / "mine")
    options = ["--to", "safetensors", "--output", str(tmp_path / "deep" / "knee.safetensors")]
    assert command(["export", str(tmp_path / "mine.json"), *options]) == 0
    assert "with what it scored" in " ".join(capsys.readouterr().out.split())
    shipped = read_policy(tmp_path / "deep" / "knee")
    assert shipped.scores == measure(policy, policy.env_kwargs)
    assert {**shipped.description, "scores": {}} == policy.description


def test_the_command_writes_each_form(policy, weighed, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "run").mkdir()
    write_policy(policy, "run/best")
    write_policy(weighed, "weighed")
    for arguments in (
        "run --to onnx",
        "weighed.safetensors --to npz",
        "weighed.json --weight 0.5 --to onnx --output at.onnx",
        "run --to json --holds 5 --seed 3",
        "11100 --to csv --holds 3 --dither 0 --open-volts 12 --shut-volts 1",
    ):
        assert command(["export", *arguments.split()]) == 0, arguments
    printed = " ".join(capsys.readouterr().out.split())
    assert "run.onnx; onnxruntime acts on" in printed
    assert "3 holds of 0.03125 s: 11100.csv" in printed
    seen = observations(100)
    np.testing.assert_array_equal(onnx_actions("run.onnx", seen), policy.predict(seen))
    np.testing.assert_array_equal(onnx_actions("at.onnx", seen[:, :4]), weighed.predict(seen[:, :4], 0.5))
    with np.load("weighed.npz") as archive:
        np.testing.assert_array_equal(archive["0.weight"], weighed.layers[0].weight)
    told = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))
    schedule = play_policy(policy, holds=5, seed=3)
    assert told == {
        "format": "stickslip schedule 1",
        "source": "run",
        "weight": None,
        "seed": 3,
        "actuator": asdict(Actuator.ecoflex()),
        "time_s": schedule.time.tolist(),
        "volts": schedule.volts.tolist(),
        "valve": schedule.valve.tolist(),
        "command": schedule.command.tolist(),
    }
    with (tmp_path / "11100.csv").open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    assert header == ["time_s", "volts", "valve", "command"]
    assert [",".join(row) for row in rows] == ["0.0,12.0,1,1", "0.03125,12.0,1,1", "0.0625,12.0,1,1", "0.09375,1.0,0,0"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("11100 --to onnx", "error: 11100 must be a policy for --weight and --to safetensors, onnx, npz, it is"),
        ("11100 --to csv --weight 0.5", "error: 11100 must be a policy for --weight"),
        ("11100 --to wav", "error: --to has no 'wav'; allowed are ['safetensors', 'onnx', 'npz', 'csv', 'json']"),
        ("nowhere --to npz", "error: policy must be nowhere/best.safetensors with its .json beside it"),
        ("11100 --to csv --holds 0", "error: --holds must be a whole number >= 1, got 0"),
        ("11100 --to csv --dither 0.7", "error: dither must be in [0, 0.5], got 0.7"),
        ("11100 --to csv --actuator {}", "error: --actuator must set ['payload_mass', 'foot_mass', 'stiffness', "),
        ('11100 --to csv --actuator {"wheels":4}', "error: --actuator has no 'wheels'; allowed are ['payload_mass',"),
        ("11100 --to csv --actuator rubber", "error: --actuator must be a JSON object, got 'rubber'"),
    ],
)
def test_what_cannot_be_exported_is_refused(arguments, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert command(["export", *arguments.split()]) == 1
    assert capsys.readouterr().err.startswith(message)
    assert list(tmp_path.iterdir()) == []
