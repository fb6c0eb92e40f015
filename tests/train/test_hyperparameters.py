"""Hyperparameter files: what is read, what is refused."""

import pytest

from stickslip.train.hyperparameters import read_hyperparameters, resolve
from stickslip.train.run import ALGORITHMS

ID = "StickSlipCrawler-v0"


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_the_packaged_files_have_an_entry_for_the_environment(algorithm):
    entry = read_hyperparameters(algorithm, ID)
    assert entry["policy"] == ("MlpLstmPolicy" if algorithm == "recurrent_ppo" else "MlpPolicy")
    assert isinstance(entry["n_timesteps"], int)
    assert entry["n_timesteps"] >= entry["n_envs"] >= 1


def test_schedules_and_dicts_are_understood():
    resolved = resolve({"learning_rate": "lin_0.002", "clip_range": 0.2, "policy_kwargs": "dict(net_arch=[8, 8])"})
    assert [resolved["learning_rate"](progress) for progress in (1.0, 0.5, 0.0)] == [0.002, 0.001, 0.0]
    assert resolved["clip_range"] == 0.2
    assert resolved["policy_kwargs"] == {"net_arch": [8, 8]}


def test_numbers_that_yaml_takes_for_text_are_numbers():
    assert resolve({"learning_rate": "3e-4", "ent_coef": "1e-4", "gamma": 0.9}) == {
        "learning_rate": 3e-4,
        "ent_coef": 1e-4,
        "gamma": 0.9,
    }


def test_what_was_read_is_left_as_it_was():
    entry = {"learning_rate": "lin_0.002"}
    resolve(entry)
    assert entry == {"learning_rate": "lin_0.002"}


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ({"learning_rate": "cos_0.1"}, "learning_rate must be a number or lin_<number>, got 'cos_0.1'"),
        ({"learning_rate": "lin_fast"}, "learning_rate must be a number or lin_<number>, got 'lin_fast'"),
        ({"learning_rate": "lin_inf"}, "learning_rate must be a number or lin_<number>, got 'lin_inf'"),
        ({"seed": 3}, "hyperparameters must not set seed"),
        ({"clip_range": "lin_-1"}, "clip_range must be a number or lin_<number>"),
        ({"policy_kwargs": "dict(x=__import__('os'))"}, "policy_kwargs must be a mapping or dict"),
        ({"policy_kwargs": "open('x')"}, "policy_kwargs must be a mapping or dict"),
        ({"policy_kwargs": "dict("}, "policy_kwargs must be a mapping or dict"),
    ],
)
def test_what_cannot_be_understood_is_refused(entry, message):
    with pytest.raises(ValueError, match=message):
        resolve(entry)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: [", "must be YAML"),
        ("- 1", "must have an entry StickSlipCrawler-v0"),
        ("CartPole-v1: {n_envs: 1}", r"must have an entry StickSlipCrawler-v0, it has \['CartPole-v1'\]"),
        (f"{ID}: {{n_envs: 1, n_timesteps: 10}}", "must set policy"),
        (f"{ID}: {{n_envs: 0, n_timesteps: 10, policy: p}}", "n_envs must be a whole number >= 1, got 0"),
        (f"{ID}: {{n_envs: 1, n_timesteps: .nan, policy: p}}", "n_timesteps must be a whole number >= 1, got nan"),
        (f"{ID}: {{n_envs: .inf, n_timesteps: 1, policy: p}}", "n_envs must be a whole number >= 1, got inf"),
        (f"{ID}: {{n_envs: true, n_timesteps: 1, policy: p}}", "n_envs must be a whole number >= 1, got True"),
    ],
)
def test_files_that_do_not_say_what_is_needed_are_refused(tmp_path, text, message):
    file = tmp_path / "ppo.yml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=message):
        read_hyperparameters("ppo", ID, file)
