"""Hyperparameter files: what is read, what is refused."""

import pytest

from stickslip.train.algorithms import ALGORITHMS
from stickslip.train.hyperparameters import entropy_schedule, linear_schedule, read_hyperparameters, resolve
from stickslip.train.run import Configuration

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


def test_every_schedule_is_understood_and_a_mapping_is_taken_as_it_is():
    names = ("learning_rate", "clip_range", "clip_range_vf")
    resolved = resolve(dict.fromkeys(names, "lin_4e-1") | {"policy_kwargs": {"net_arch": [3]}, "other": "lin_1"})
    assert [resolved[name](0.25) for name in names] == [0.1] * 3
    assert resolved["policy_kwargs"] == {"net_arch": [3]}
    assert resolved["other"] == "lin_1"
    assert linear_schedule(2.0)(0.75) == 1.5


def test_the_weight_of_entropy_may_fall_though_the_algorithms_take_a_number():
    assert resolve({"ent_coef": "lin_0.02"}) == {"ent_coef": 0.02}
    falling = entropy_schedule({"ent_coef": "lin_0.02"})
    assert [falling(progress) for progress in (1.0, 0.5, 0.0)] == [0.02, 0.01, 0.0]
    for fixed in ({}, {"ent_coef": 0.01}, {"ent_coef": "1e-2"}):
        assert entropy_schedule(fixed) is None
    with pytest.raises(ValueError, match=r"ent_coef must be a number or lin_<number>, got 'auto'"):
        entropy_schedule({"ent_coef": "auto"})


def test_a_file_of_one_s_own_is_read_instead_of_the_packaged_one(tmp_path):
    file = tmp_path / "mine.yml"
    file.write_text(f"{ID}: {{n_envs: 3, n_timesteps: !!float 2e3, policy: p, gamma: 0.5}}\nOther-v1: {{}}\n", "utf-8")
    assert read_hyperparameters("ppo", ID, file) == {"n_envs": 3, "n_timesteps": 2000, "policy": "p", "gamma": 0.5}
    assert isinstance(read_hyperparameters("ppo", ID, file)["n_timesteps"], int)
    file.write_text(f"{ID}: {{n_envs: 1, n_timesteps: 1, policy: p}}", "utf-8")
    assert read_hyperparameters("ppo", ID, file)["n_envs"] == 1


def test_a_file_may_choose_the_environment(tmp_path):
    file = tmp_path / "mine.yml"
    for written in ("{valve_history: 3, hold: 0.7}", "'dict(valve_history=3, hold=0.7)'"):
        file.write_text(f"{ID}: {{n_envs: 3, n_timesteps: 9, policy: p, env_kwargs: {written}}}", "utf-8")
        entry = read_hyperparameters("ppo", ID, file)
        assert entry["env_kwargs"] == {"valve_history": 3, "hold": 0.7}
    asked = Configuration(env_kwargs={"hold": 0.25}, hyperparameters=entry)
    assert asked.env_kwargs == {"valve_history": 3, "hold": 0.25}  # what is said wins
    assert asked.hyperparameters == {"n_envs": 3, "n_timesteps": 9, "policy": "p"}
    assert "env_kwargs" in entry  # what was read is left as it was
    with pytest.raises(ValueError, match="env_kwargs has no 'wheels'"):
        Configuration(hyperparameters={"env_kwargs": {"wheels": 4}})


def test_what_is_no_text_is_refused(tmp_path):
    file = tmp_path / "mine.yml"
    file.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ValueError, match=r"hyperparameters file .*mine\.yml must be YAML, it is not text"):
        read_hyperparameters("ppo", ID, file)


@pytest.mark.parametrize("name", ["env", "seed", "device", "tensorboard_log", "verbose"])
def test_what_a_run_sets_itself_is_refused(name):
    with pytest.raises(ValueError, match=f"hyperparameters must not set {name}: the run sets it"):
        resolve({name: 1})


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
        ({"learning_rate": "lin_0"}, "learning_rate must be a number or lin_<number>, got 'lin_0'"),
        ({"clip_range_vf": "lin_x"}, "clip_range_vf must be a number or lin_<number>, got 'lin_x'"),
        ({"policy_kwargs": "dict([1])"}, "policy_kwargs must be a mapping or dict"),
        ({"policy_kwargs": "list(a=1)"}, "policy_kwargs must be a mapping or dict"),
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
        (f"{ID}: {{n_timesteps: 10, policy: p}}", "must set n_envs for StickSlipCrawler-v0, it sets"),
        (f"{ID}: {{n_envs: 1, policy: p}}", "must set n_timesteps"),
        (f"{ID}: {{n_envs: 1, n_timesteps: 2.5, policy: p}}", "n_timesteps must be a whole number >= 1, got 2.5"),
        (f"{ID}: {{n_envs: 1, n_timesteps: '9', policy: p}}", "n_timesteps must be a whole number >= 1, got '9'"),
        (
            f"{ID}: {{n_envs: 1, n_timesteps: 1.0e+15, policy: p}}",
            "n_timesteps must be a whole number >= 1, got 1000000000000000.0",
        ),
        (f"{ID}: {{n_envs: 0, n_timesteps: 10, policy: p}}", "n_envs must be a whole number >= 1, got 0"),
        (f"{ID}: {{n_envs: 1, n_timesteps: .nan, policy: p}}", "n_timesteps must be a whole number >= 1, got nan"),
        (f"{ID}: {{n_envs: .inf, n_timesteps: 1, policy: p}}", "n_envs must be a whole number >= 1, got inf"),
        (
            f"{ID}: {{n_envs: 1, n_timesteps: 1, policy: p, env_kwargs: [4]}}",
            "env_kwargs must be a mapping or dict",
        ),
        (f"{ID}: {{n_envs: true, n_timesteps: 1, policy: p}}", "n_envs must be a whole number >= 1, got True"),
    ],
)
def test_files_that_do_not_say_what_is_needed_are_refused(tmp_path, text, message):
    file = tmp_path / "ppo.yml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=message):
        read_hyperparameters("ppo", ID, file)
