"""What a training came to beside what needs none: runs, search, words of the verdict."""

import json

import gymnasium as gym
import numpy as np
import pytest
import torch

from stickslip.train import verdict
from stickslip.train.algorithms import algorithm_class, ALGORITHMS
from stickslip.train.hyperparameters import read_hyperparameters
from stickslip.train.long_runs import LongRuns, of_policy, of_words
from stickslip.train.run import Configuration, Run
from stickslip.train.still import hold_still
from stickslip.train.training import load_policy, train
from stickslip.train.vec_env import StickSlipVecEnv
from stickslip.train.verdict import Baseline, Judging, Mean, Verdict

TRADE = {"memory_weight": 0.3, "dither": 0.1, "groups": {"duffing": 0.25}}
BRIEF = Judging(seeds=3, steps=12, burn_in=5, longest_word=4)


class Alternating:
    """A policy with a memory: it does what it did not do the step before."""

    def predict(self, observations, state=None, episode_start=None, deterministic=False):
        assert deterministic
        commands = np.ones(len(observations), int) if episode_start.all() else 1 - state
        return commands, commands


def one_by_one(word, seed):
    """Means over the last 12 steps of 17, in the single environment."""
    environment = gym.make("StickSlipCrawler-v0", **TRADE).unwrapped
    environment.reset(seed=seed)
    told = []
    for step in range(17):
        _, reward, _, _, info = environment.step(int(word[step % len(word)]))
        told.append((info["speed"], info["memory"], reward))
    return np.mean(told[5:], axis=0)


def test_runs_of_words_and_policies_are_those_of_the_single_environment():
    length = {"seeds": [4, 9], "steps": 12, "burn_in": 5}
    words = of_words(["10", "1", "11100"], TRADE, **length)
    for word, runs in zip(["10", "1", "11100"], words, strict=True):
        expected = np.array([one_by_one(word, seed) for seed in (4, 9)])
        np.testing.assert_allclose(np.array(runs).T, expected, rtol=1e-12, atol=1e-14)
    np.testing.assert_array_equal(of_policy(Alternating(), TRADE, **length), words[0])


def test_the_best_word_has_most_reward_of_all():
    found = {each.name: each for each in verdict.baselines(TRADE | {"memory_weight": 0.0}, BRIEF)}
    assert list(found) == ["held open", "held shut", "best word"]
    assert [found[name].word for name in ("held open", "held shut")] == ["1", "0"]
    words = ["10", "110", "100", "1110", "1100", "1000"]
    of_each = of_words(words, TRADE | {"memory_weight": 0.0}, seeds=range(50), steps=100, burn_in=50)
    assert found["best word"].word == words[np.argmax([runs.reward.mean() for runs in of_each])]


def test_a_policy_of_plain_numbers_is_judged_by_them(tmp_path, monkeypatch):
    def unpickled(*arguments, **options):
        raise AssertionError("a zip was read")

    monkeypatch.setattr("stickslip.train.training.read_pickle", unpickled)
    hyperparameters = {"policy": "MlpPolicy", "n_envs": 2, "n_steps": 8, "batch_size": 16, "n_timesteps": 16}
    configuration = Configuration("ppo", env_kwargs=TRADE, hyperparameters=hyperparameters)
    train(configuration, tmp_path / "run", judging=BRIEF, or_still=False)
    assert (tmp_path / "run" / verdict.REPORT).exists()


def verdict_of(*rewards):
    """Of a policy with these rewards, where held open earns 2, 3 and 4."""
    terms = np.array([0.25, 0.5, 0.75]), np.array([1.0, 2.0, 3.0])
    rewards_of = {"1": [2.0, 3.0, 4.0], "0": [1.0, 1.0, 1.0], "110": [0.5, 1.5, 2.5]}
    runs = [LongRuns(*terms, np.array(each)) for each in rewards_of.values()]
    others = list(map(Baseline, ("held open", "held shut", "best word"), rewards_of, runs))
    return Verdict(runs[0]._replace(reward=np.array(rewards)), others, BRIEF)


def test_a_verdict_is_in_words():
    lost = verdict_of(1.0, 2.5, 3.5)  # 1, 0.5, 0.5 less: 2/3, standard error 1/6
    assert lost.loses
    assert lost.sentence == (
        "The training FAILED: its policy loses to the valve held open, which needs no training: "
        "2.3333 of reward per step against 3.0000, 0.6667 ± 0.1667 less."
    )
    won = verdict_of(2.5, 3.5, 4.5)
    assert not won.loses
    assert won.sentence == (
        "The policy beats the valve held open, the best that needs no training: "
        "3.5000 of reward per step against 3.0000, 0.5000 ± 0.0000 more."
    )
    equal = verdict_of(2.0001, 2.9999, 3.9998)
    assert not equal.loses
    assert equal.sentence == "The policy is as good as the valve held open, the best that needs no training."
    assert verdict_of(2.0, 2.999, 3.999).loses


def test_the_best_word_is_called_by_its_name():
    one = verdict_of(0.0, 0.0, 0.0)
    better = one.baselines[2]._replace(runs=one.policy._replace(reward=np.array([9.0, 9.0, 9.0])))
    assert (
        "loses to 110 repeated, the best word, which"
        in Verdict(one.policy, [*one.baselines[:2], better], BRIEF).sentence
    )


def test_a_report_is_a_table_and_can_be_read_again(tmp_path):
    assert verdict.read_report(tmp_path) is verdict.read_baselines(tmp_path, BRIEF) is None
    lost = verdict_of(1.0, 2.5, 3.5)
    verdict.write_verdict(lost, tmp_path)
    assert (tmp_path / "report.md").read_text(encoding="utf-8").splitlines() == [
        "# What the training came to",
        "",
        lost.sentence,
        "",
        "| | speed | memory | reward per step |",
        "| --- | ---: | ---: | ---: |",
        "| the policy | 0.5000 ± 0.1443 | 2.0000 ± 0.5774 | 2.3333 ± 0.7265 |",
        "| held open (1) | 0.5000 ± 0.1443 | 2.0000 ± 0.5774 | 3.0000 ± 0.5774 |",
        "| held shut (0) | 0.5000 ± 0.1443 | 2.0000 ± 0.5774 | 1.0000 ± 0.0000 |",
        "| best word (110) | 0.5000 ± 0.1443 | 2.0000 ± 0.5774 | 1.5000 ± 0.5774 |",
        "",
        "Means over 3 fresh seeds, with standard errors: 12 steps of each after 5 to get under way. "
        "The best word has most reward of all necklaces of up to 4 letters; it was found on other seeds.",
    ]
    written = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    assert written == verdict.read_report(tmp_path) == lost.to_dict()
    assert written["loses"] is True
    assert written["gain of reward"] == {"mean": -2 / 3, "standard error": pytest.approx(1 / 6)}
    again = verdict.read_baselines(tmp_path, BRIEF)
    assert [(each.name, each.word) for each in again] == [(each.name, each.word) for each in lost.baselines]
    np.testing.assert_array_equal([each.runs for each in again], [each.runs for each in lost.baselines])
    assert verdict.read_baselines(tmp_path, Judging(seeds=3, steps=12, burn_in=6, longest_word=4)) is None


def test_a_mean_has_its_standard_error():
    assert Mean.of([1.0, 2.0, 4.0]) == (pytest.approx(7 / 3), pytest.approx(np.sqrt(7 / 9)))


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("command", [0, 1])
def test_a_policy_that_holds_still_does_so_whatever_it_sees(algorithm, command):
    policy = read_hyperparameters(algorithm, "StickSlipCrawler-v0")["policy"]
    model = algorithm_class(algorithm)(policy, StickSlipVecEnv(2, **TRADE), device="cpu", seed=1)
    hold_still(model, command)
    seen = np.random.default_rng(2).normal(scale=3.0, size=(20, 5)).astype(np.float32)
    commands, _ = model.predict(seen, deterministic=True)
    assert commands.tolist() == [command] * 20


@pytest.mark.parametrize(("start", "command"), [("shut", 0), ("open", 1)])
def test_a_training_that_begins_still_commands_so_mostly(tmp_path, start, command):
    entry = read_hyperparameters("ppo", "StickSlipCrawler-v0")
    entry |= {"n_envs": 2, "n_steps": 4, "batch_size": 8, "n_timesteps": 8, "learning_rate": 1e-9}
    asked = Configuration(env_kwargs={"dither": 0.1}, hyperparameters=entry, start=start)
    run = train(asked, tmp_path, judging=BRIEF, or_still=False)
    policy = load_policy(run, trust=True).policy
    seen = torch.from_numpy(np.random.default_rng(2).normal(size=(500, 8)).astype(np.float32))
    with torch.no_grad():
        chances = policy.get_distribution(seen).distribution.probs[:, command]
    # As the logits differ by 2.5 but for what is seen, which an untrained network hardly heeds.
    assert chances.mean() == pytest.approx(1 / (1 + np.exp(-2.5)), abs=0.01)
    assert Run.open(run.folder).configuration.start == start


def test_a_training_that_fails_says_so_and_one_below_a_valve_held_still_keeps_that(tmp_path):
    entry = read_hyperparameters("ppo", "StickSlipCrawler-v0")
    entry |= {"n_envs": 2, "n_steps": 4, "batch_size": 8, "n_timesteps": 8}
    enough = Judging(seeds=8, steps=300, burn_in=200, longest_word=3)
    asked = {"memory_weight": 0.0, "dither": 0.0, "hold": 1.0}
    # Untrained, it crawls nowhere: any gait is better.
    run = train(Configuration(env_kwargs=asked, hyperparameters=entry), tmp_path / "speed", judging=enough)
    assert "FAILED: its policy loses to" in verdict.read_report(run.folder)["verdict"]
    # At high weights nothing is as good as the valve held open.
    asked = {"memory_weight": 1.0, "dither": 0.1}
    run = train(Configuration(env_kwargs=asked, hyperparameters=entry, seed=1), tmp_path / "memory", judging=enough)
    assert verdict.read_report(run.folder)["verdict"].startswith("The policy is as good as the valve held open")
    seen = np.random.default_rng(2).normal(size=(9, 8)).astype(np.float32)
    assert load_policy(run, trust=True).predict(seen, deterministic=True)[0].tolist() == [1] * 9
