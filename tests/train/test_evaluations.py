"""The table of evaluations: what stands in it, and older tables."""

import math
import shutil
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import torch
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from stickslip.envs import StickSlipCrawlerEnv
from stickslip.train import StickSlipVecEnv
from stickslip.train.evaluations import best_of, Evaluation, read_evaluations, write_evaluations
from stickslip.train.figures import plot_learning
from stickslip.train.hyperparameters import read_hyperparameters
from stickslip.train.policies import read_policy
from stickslip.train.run import Configuration
from stickslip.train.training import load_policy, train

TRADE = {"memory_weight": 0.3, "dither": 0.1}
SMALL = {"n_envs": 4, "n_steps": 32, "batch_size": 64, "n_timesteps": 128, "n_epochs": 10, "ent_coef": 0.003}


def configuration(**changes):
    entry = read_hyperparameters("ppo", "StickSlipCrawler-v0") | SMALL | changes
    del entry["env_kwargs"]  # the environment is the test's own
    return Configuration(env_kwargs=TRADE, hyperparameters=entry)


STEPS = 150


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Three updates, so large that every policy is another, with an evaluation after each."""
    asked = configuration(n_timesteps=384, learning_rate=0.01)
    folder = tmp_path_factory.mktemp("runs") / "run"
    short = partial(StickSlipVecEnv, max_episode_steps=STEPS)
    return train(replace(asked, seed=1), folder, vec_env=short, or_still=False)


def by_hand(policy, episodes, steps, arguments):
    """Mean speed and memory over episodes that no training sees."""
    terms = []
    for i in range(episodes):
        environment = StickSlipCrawlerEnv(**arguments)
        observation, _ = environment.reset(seed=1_000_000 + i)
        for _ in range(steps):
            action = policy.predict(observation, deterministic=True)[0]
            observation, _, _, _, info = environment.step(int(action))
            terms.append((info["speed"], info["memory"]))
    return np.mean(terms, axis=0)


def test_speed_and_memory_stand_beside_the_reward_they_make(run):
    evaluations = read_evaluations(run.folder / "evaluations.csv")
    assert [each.steps for each in evaluations] == [128, 256, 384]
    for each in evaluations:
        speed, memory = by_hand(load_policy(run, run.checkpoint(each.steps), trust=True), 32, STEPS, TRADE)
        assert each.speed == pytest.approx(speed, rel=1e-12)
        assert each.memory == pytest.approx(memory, rel=1e-12)
        assert each.reward == pytest.approx(0.7 * speed + 0.3 * memory, rel=1e-5)  # SB3 adds up in single precision
    assert len({each.speed for each in evaluations}) == 3


def test_an_evaluation_is_of_whole_episodes_unless_it_is_said(tmp_path):
    quiet = {"memory_weight": 0.0, "dither": 0.0}
    made = train(replace(configuration(n_timesteps=64, n_steps=16), env_kwargs=quiet), tmp_path / "run")
    (only,) = read_evaluations(made.folder / "evaluations.csv")
    speed, _ = by_hand(load_policy(made, made.final, trust=True), 1, 1000, quiet)
    assert only.speed == pytest.approx(speed, rel=1e-12)
    assert only.reward == pytest.approx(speed, rel=1e-5)


def weights(model):
    return torch.cat([value.flatten() for value in model.policy.state_dict().values()])


def test_the_best_policy_is_that_of_the_best_evaluation(run):
    evaluations = read_evaluations(run.folder / "evaluations.csv")
    rewards = [each.reward for each in evaluations]
    best = int(np.argmax(rewards))
    assert best_of(evaluations) == evaluations[best]
    assert 0 < best < 2  # else the first or the last policy could stand for the best
    assert torch.equal(
        weights(load_policy(run, trust=True)),
        weights(load_policy(run, run.checkpoint(evaluations[best].steps), trust=True)),
    )
    assert not torch.equal(weights(load_policy(run, trust=True)), weights(load_policy(run, run.final, trust=True)))


def test_the_best_policy_is_kept_as_plain_numbers_too(run):
    policy, best = read_policy(run.best_policy), best_of(read_evaluations(run.folder / "evaluations.csv"))
    seen = np.random.default_rng(0).normal(size=(500, 5)).astype(np.float32)
    np.testing.assert_array_equal(
        policy.predict(seen), load_policy(run, trust=True).predict(seen, deterministic=True)[0]
    )
    assert policy.env_kwargs == TRADE
    assert policy.description["algorithm"]["steps"] == best.steps
    assert policy.description["algorithm"]["hyperparameters"] == run.configuration.hyperparameters
    assert policy.scores == {
        "measured": "per step, in one episode a seed",
        "seeds": list(range(1_000_000, 1_000_032)),
        "reward": {"mean": best.reward},
        "speed": {"mean": best.speed},
        "memory": {"mean": best.memory},
    }


def test_the_first_of_equals_is_the_best():
    rows = [Evaluation(1, 0.5, 9.0, 9.0), Evaluation(2, 0.75, 0.0, 0.0), Evaluation(3, 0.75, 9.0, 9.0)]
    assert best_of(rows) is rows[1]


def test_a_best_score_is_remembered_by_a_run_that_goes_on(run, tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(run.folder, folder)
    evaluations = read_evaluations(folder / "evaluations.csv")
    evaluations[1] = evaluations[1]._replace(reward=100.0)
    write_evaluations(folder / "evaluations.csv", evaluations)
    entry = {**run.configuration.hyperparameters, "n_timesteps": 512}
    before = (folder / "best.zip").read_bytes()
    short = partial(StickSlipVecEnv, max_episode_steps=STEPS)
    train(replace(run.configuration, hyperparameters=entry), folder, resume=True, vec_env=short, or_still=False)
    assert (folder / "best.zip").read_bytes() == before
    kept = read_evaluations(folder / "evaluations.csv")
    assert kept[:3] == evaluations
    assert [each.steps for each in kept] == [128, 256, 384, 512]


def test_a_run_is_evaluated_twelve_times_on_its_way(tmp_path):
    entry = read_hyperparameters("a2c", "StickSlipCrawler-v0") | {"n_envs": 2, "n_steps": 5, "n_timesteps": 600}
    asked = Configuration(algorithm="a2c", env_kwargs=TRADE, hyperparameters=entry)
    steps = []
    made = train(
        asked, tmp_path / "run", on_progress=steps.append, vec_env=partial(StickSlipVecEnv, max_episode_steps=5)
    )
    assert [each.steps for each in read_evaluations(made.folder / "evaluations.csv")] == list(range(50, 601, 50))
    assert {path.name for path in (made.folder / "checkpoints").iterdir()} == {
        f"{steps}_steps.zip" for steps in range(50, 601, 50)
    }
    assert steps == list(range(2, 601, 2))


def test_evaluations_see_seeds_that_no_training_does(tmp_path):
    seeds = []

    class Noting(StickSlipVecEnv):
        def seed(self, seed=None):
            seeds.append((self.num_envs, seed))
            return super().seed(seed)

    made = train(
        replace(configuration(n_timesteps=256), seed=77),
        tmp_path / "run",
        vec_env=lambda count, **arguments: Noting(count, max_episode_steps=5, **arguments),
    )
    assert len(read_evaluations(made.folder / "evaluations.csv")) == 2
    training = {(count, seed) for count, seed in seeds if count == 4}
    assert training == {(4, 77)}
    # Every evaluation is of the same episodes.
    evaluated = [(count, seed) for count, seed in seeds if count == 32]
    assert len(evaluated) >= 2
    assert set(evaluated) == {(32, 1_000_000)}


def test_tensorboard_has_what_the_table_has(run):
    (events,) = (run.folder / "tensorboard").glob("ppo_*")
    logged = EventAccumulator(str(events)).Reload()
    evaluations = read_evaluations(run.folder / "evaluations.csv")
    for place, tag in enumerate(("mean_reward_per_step", "mean_speed", "mean_memory"), 1):
        assert [(each.step, each.value) for each in logged.Scalars(f"eval/{tag}")] == [
            (row.steps, np.float32(row[place])) for row in evaluations
        ]


def test_what_environments_do_not_tell_is_not_made_up(tmp_path):
    made = train(
        configuration(n_timesteps=64, n_steps=16), tmp_path / "run", vec_env=partial(StickSlipVecEnv, sparse_infos=True)
    )
    last = read_evaluations(made.folder / "evaluations.csv")[-1]
    assert math.isfinite(last.reward)
    assert math.isnan(last.speed)
    assert math.isnan(last.memory)


def test_a_table_from_before_it_had_them_is_read_drawn_and_gone_on_with(tmp_path):
    old = tmp_path / "evaluations.csv"
    old.write_text("steps,mean_reward_per_step\n64,0.25\n128,0.5\n", encoding="utf-8")
    rows = read_evaluations(old)
    assert [row[:2] for row in rows] == [(64, 0.25), (128, 0.5)]
    assert all(isinstance(row.steps, int) for row in rows)
    assert all(math.isnan(value) for row in rows for value in row[2:])
    assert best_of(rows) == rows[1]
    plot_learning(old)
    write_evaluations(old, [*rows, Evaluation(256, 0.75, 1.0, 2.0)])
    assert read_evaluations(old)[2] == Evaluation(256, 0.75, 1.0, 2.0)
    assert [row[:2] for row in read_evaluations(old)[:2]] == [(64, 0.25), (128, 0.5)]


@pytest.mark.parametrize("text", ["time,reward\n1,2\n", "steps,mean_reward_per_step\nmany,0.5\n", "steps\n1.5\n"])
def test_another_table_is_refused(tmp_path, text):
    file = tmp_path / "evaluations.csv"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=r"evaluations must be a table of steps, .*, got .*evaluations\.csv"):
        read_evaluations(file)
