"""The table of evaluations: what stands in it, and older tables."""

import math
from functools import partial

import numpy as np
import pytest
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from stickslip.envs import StickSlipCrawlerEnv
from stickslip.train import StickSlipVecEnv
from stickslip.train.evaluations import best_of, Evaluation, read_evaluations, write_evaluations
from stickslip.train.figures import plot_learning
from stickslip.train.hyperparameters import read_hyperparameters
from stickslip.train.run import Configuration
from stickslip.train.training import load_policy, train

TRADE = {"memory_weight": 0.3, "dither": 0.1}
SMALL = {"n_envs": 4, "n_steps": 32, "batch_size": 64, "n_timesteps": 128}


def configuration(**changes):
    entry = read_hyperparameters("ppo", "StickSlipCrawler-v0") | SMALL | changes
    return Configuration(env_kwargs=TRADE, hyperparameters=entry)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return train(configuration(), tmp_path_factory.mktemp("runs") / "run")


def test_speed_and_memory_stand_beside_the_reward_they_make(run):
    last = read_evaluations(run.folder / "evaluations.csv")[-1]
    policy = load_policy(run, run.checkpoint(last.steps))
    terms = []
    for i in range(8):
        environment = StickSlipCrawlerEnv(**TRADE)
        observation, _ = environment.reset(seed=1_000_000 + i)
        for _ in range(1000):
            action = policy.predict(observation, deterministic=True)[0]
            observation, _, _, _, info = environment.step(int(action))
            terms.append((info["speed"], info["memory"]))
    speed, memory = np.mean(terms, axis=0)
    assert last.speed == pytest.approx(speed, rel=1e-12)
    assert last.memory == pytest.approx(memory, rel=1e-12)
    assert last.reward == pytest.approx(0.7 * speed + 0.3 * memory, rel=1e-5)  # SB3 adds up in single precision


def test_tensorboard_has_what_the_table_has(run):
    (events,) = (run.folder / "tensorboard").glob("ppo_*")
    logged = EventAccumulator(str(events)).Reload()
    last = read_evaluations(run.folder / "evaluations.csv")[-1]
    for tag, value in zip(("mean_reward_per_step", "mean_speed", "mean_memory"), last[1:], strict=True):
        assert logged.Scalars(f"eval/{tag}")[-1].value == np.float32(value)


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
