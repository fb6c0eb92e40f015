"""What a policy comes to: rolled out, measured, filmed and reported, each against the environment stepped by hand."""

import json
from dataclasses import asdict
from functools import partial
from inspect import signature

import numpy as np
import pytest
import torch
from pictures import film_in
from stable_baselines3 import PPO

from stickslip.common.figures import save_figure
from stickslip.crawler import simulate
from stickslip.envs import StickSlipCrawlerEnv
from stickslip.reservoir import mean_over_runs
from stickslip.train import report, StickSlipVecEnv, training, verdict
from stickslip.train.evaluation import film, measure, roll_out
from stickslip.train.evaluations import Evaluation, read_evaluations, write_evaluations
from stickslip.train.hyperparameters import read_hyperparameters
from stickslip.train.report import evaluate_run
from stickslip.train.run import Configuration, Run
from stickslip.train.schedules import performance
from stickslip.train.scores import HELD_OUT_SEEDS, roll_outs
from stickslip.train.training import load_policy, train

# Every argument of the environment but `randomize` is another than by default.
ODD = {
    "groups": {"deborah": 0.8},
    "scene": {"ratchet": False, "slope": 0.02},
    "hold": 0.7,
    "tolerance": 1e-4,
    "dither": 0.2,
    "memory_weight": 0.3,
    "delays": 3,
    "virtual_nodes": 2,
}
QUIET = {"dither": 0.0, "memory_weight": 0.0}
DRAWN = {"randomize": {"duffing": [0.0, 2.0], "slope": [0.0, 0.1]}, "dither": 0.2}


def perturbed(policy, seed=0):
    """A policy with weights so large that its answers depend on the state."""
    generator = torch.Generator().manual_seed(seed)
    with torch.no_grad():
        for weights in policy.policy.parameters():
            weights += torch.randn(weights.shape, generator=generator)
    return policy


@pytest.fixture(scope="module")
def policy():
    return perturbed(PPO("MlpPolicy", StickSlipVecEnv(1), seed=0, device="cpu"))


def stepped(policy, arguments, steps, seed):
    """Commands, valve states, and what the environment tells, step by step."""
    environment = StickSlipCrawlerEnv(**arguments)
    observation, _ = environment.reset(seed=seed)
    commands, infos = [], []
    for _ in range(steps):
        commands.append(int(policy.predict(observation, deterministic=True)[0]))
        observation, _, _, _, info = environment.step(commands[-1])
        infos.append(info)
    return np.array(commands), np.array([info["valve"] for info in infos]), infos, environment


def test_a_roll_out_is_the_policy_s_best_action_at_every_step(policy):
    for steps, seed in ((200, 3), (50, 4)):
        command, valve = roll_out(policy, StickSlipCrawlerEnv(**ODD), steps, seed)
        expected = stepped(policy, ODD, steps, seed)
        np.testing.assert_array_equal(command, expected[0])
        np.testing.assert_array_equal(valve, expected[1])
        assert command.dtype == valve.dtype == np.int64
        assert 0 < np.mean(command) < 1
        assert np.any(command != valve)


@pytest.mark.parametrize(
    "arguments", [ODD, DRAWN, {"dither": 0.0, "memory_weight": 0.0}], ids=["odd", "drawn", "quiet"]
)
def test_what_is_measured_is_the_crawler_of_the_episode(policy, arguments):
    environment = StickSlipCrawlerEnv(**arguments)
    result, command, valve = measure(policy, environment, steps=1500, seed=9)
    expected_command, expected_valve, infos, stepped_through = stepped(policy, arguments, 1500, 9)
    np.testing.assert_array_equal(command, expected_command)
    np.testing.assert_array_equal(valve, expected_valve)
    # The environment tells the speed of every hold.
    assert result.speed == pytest.approx(np.mean([info["speed"] for info in infos]), rel=1e-9)
    if environment.settings.dither == 0.0:
        assert result.memory is None
        return
    settings = environment.settings
    expected = performance(
        expected_command,
        expected_valve,
        dither=arguments["dither"],
        groups=stepped_through.episode_groups,
        scene=stepped_through.episode_scene,
        hold=arguments.get("hold", 0.5),
        delays=arguments.get("delays", 20),
        virtual_nodes=arguments.get("virtual_nodes", 4),
        tolerance=arguments.get("tolerance", 1e-6),
    )
    assert len(result.memory.profile) == settings.delays
    assert result.speed == expected.speed
    np.testing.assert_array_equal(result.memory.profile, expected.memory.profile)


@pytest.mark.parametrize("arguments", [ODD, DRAWN, QUIET], ids=["odd", "drawn", "quiet"])
def test_episodes_side_by_side_are_each_as_alone(policy, arguments):
    runs = roll_outs(policy, arguments, steps=1000, seeds=[9, 4])
    for seed, each in zip([9, 4], runs, strict=True):
        environment = StickSlipCrawlerEnv(**arguments)
        result, command, valve = measure(policy, environment, steps=1000, seed=seed)
        np.testing.assert_array_equal(each.command, command)
        np.testing.assert_array_equal(each.valve, valve)
        assert each.performance.speed == result.speed
        assert (each.groups, each.scene) == (environment.episode_groups, environment.episode_scene)
        if result.memory is not None:
            assert each.performance.memory.corrected == result.memory.corrected


@pytest.mark.parametrize(
    ("function", "defaults"),
    [
        (measure, {"steps": 6000, "seed": 0}),
        (film, {"steps": 40, "seed": 0, "slow_motion": 1.0, "washout": 0}),
        (
            evaluate_run,
            {
                "checkpoint": None,
                "output": None,
                "steps": 6000,
                "seeds": HELD_OUT_SEEDS,
                "dither": None,
                "weight": None,
                "video": True,
                "trust": False,
                "judge": None,
            },
        ),
    ],
)
def test_what_is_not_said_is_as_the_pages_say(function, defaults):
    parameters = signature(function).parameters.values()
    assert {each.name: each.default for each in parameters if each.default is not each.empty} == defaults


def frames_by_hand(policy, arguments, steps, seed):
    environment = StickSlipCrawlerEnv(**arguments, render_mode="rgb_array_list")
    observation, _ = environment.reset(seed=seed)
    for _ in range(steps):
        observation, *_ = environment.step(int(policy.predict(observation, deterministic=True)[0]))
    return environment.render()


def test_a_film_shows_the_policy_at_work_and_leaves_nothing_else(policy, tmp_path):
    arguments = {**ODD, "hold": 0.25}
    film(policy, tmp_path / "clip.mp4", env_kwargs=arguments, steps=4, seed=5, washout=3)
    assert [path.name for path in tmp_path.iterdir()] == ["clip.mp4"]
    shown, _ = film_in(tmp_path / "clip.mp4")
    frames = frames_by_hand(policy, arguments, 7, 5)[-16:]
    assert len(shown) == 16
    for picture, drawn in zip(shown, frames, strict=True):
        # The codec blurs edges; another seed or policy moves the body.
        assert np.mean(np.abs(picture.astype(float) - drawn)) < 3.0
    film(policy, tmp_path / "clip.mp4", env_kwargs=arguments, steps=1, seed=6, slow_motion=2.0)
    assert [path.name for path in tmp_path.iterdir()] == ["clip.mp4"]
    assert len(film_in(tmp_path / "clip.mp4")[0]) == 8


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """A run whose policy changes its gait from checkpoint to checkpoint."""
    entry = read_hyperparameters("ppo", "StickSlipCrawler-v0")
    del entry["env_kwargs"]  # the environment is the test's own
    entry |= {"n_envs": 4, "n_steps": 32, "batch_size": 64, "n_timesteps": 384, "learning_rate": 0.01}
    entry |= {"n_epochs": 10, "ent_coef": 0.003}
    short = partial(StickSlipVecEnv, max_episode_steps=20)
    folder = tmp_path_factory.mktemp("runs") / "run"
    return train(Configuration(env_kwargs=ODD, hyperparameters=entry, seed=1), folder, vec_env=short, or_still=False)


@pytest.fixture
def drawn(monkeypatch):
    """What a report draws and films, by the names of its files; all of it is written too."""
    made = {}

    def save(figure, *files):
        made.update(dict.fromkeys((file.name for file in files), figure))
        save_figure(figure, *files)

    def keep(policy, file, **arguments):
        made[file.name] = policy, arguments

    monkeypatch.setattr(report, "save_figure", save)
    monkeypatch.setattr(report, "film", keep)
    return made


def lines(figure):
    return {line.get_label(): line.get_xydata() for ax in figure.axes for line in ax.lines}


def test_a_report_is_of_the_checkpoint_steps_and_seed_asked_for(kept, drawn, tmp_path):
    checkpoint, folder = kept.checkpoint(256), tmp_path / "deep" / "report"
    result = evaluate_run(kept.folder, checkpoint=checkpoint, output=folder, steps=1000, seeds=[4, 9], trust=True)
    policy, environment = load_policy(kept, checkpoint, trust=True), StickSlipCrawlerEnv(**ODD)
    other, _, _ = measure(policy, environment, steps=1000, seed=9)
    measured, command, valve = measure(policy, environment, steps=1000, seed=4)

    told = {name: result[name] for name in ("speed", "memory capacity", "memory capacity, raw")}
    for (name, estimate), values in zip(
        told.items(),
        [
            (measured.speed, other.speed),
            (measured.memory.corrected, other.memory.corrected),
            (measured.memory.total, other.memory.total),
        ],
        strict=True,
    ):
        assert estimate == asdict(mean_over_runs(values)), name
    assert result == {
        "steps": 1000,
        "seeds": [4, 9],
        **told,
        "commands": "".join(map(str, command[500:540].tolist())),
        "verdict": verdict.judge(policy, ODD, verdict.STANDARD).sentence,
    }
    assert json.loads((folder / "results.json").read_text(encoding="utf-8")) == result
    assert {path.name for path in folder.iterdir()} == {
        "results.json",
        "report.json",
        "report.md",
        "gait.png",
        "learning.png",
        "memory.png",
    }
    assert not (kept.folder / "evaluation").exists()

    # The gait is a stretch of the whole motion, from where the foot is at its begin.
    motion = simulate(
        environment.episode_groups,
        valve[:540],
        ODD["hold"],
        scene=environment.episode_scene,
        tolerance=ODD["tolerance"],
        samples_per_hold=20,
    )
    gait = lines(drawn["gait.png"])
    begin = motion.foot[10_000 - 1]
    np.testing.assert_allclose(gait["foot"][:, 1][-800:], motion.foot[10_000:] - begin, atol=1e-3)
    [(label, payload)] = [(name, values) for name, values in gait.items() if name.startswith("payload")]
    ahead = float(label.split()[2])
    np.testing.assert_allclose(payload[:, 1][-800:], motion.payload[10_000:] - begin + ahead, atol=1e-3)
    np.testing.assert_allclose(gait["pressure"][:, 1][-800:], motion.pressure[10_000:], atol=1e-6)
    np.testing.assert_allclose(gait["foot"][:, 0][-800:], motion.time[:800], atol=1e-9)

    evaluations = read_evaluations(kept.folder / "evaluations.csv")
    learning = lines(drawn["learning.png"])
    for name, label in {"reward": "reward", "speed": "its speed", "memory": "its memory"}.items():
        assert learning.pop(label).tolist() == [[each.steps, getattr(each, name)] for each in evaluations]
    baselines = json.loads((folder / "report.json").read_text(encoding="utf-8"))["baselines"]
    assert set(learning) == {f"reward of {name}: {np.mean(each['reward']):.3f}" for name, each in baselines.items()}
    (memory,) = (values for name, values in lines(drawn["memory.png"]).items() if name.startswith("policy: "))
    assert memory[:, 1].tolist() == measured.memory.profile.tolist()

    filmed, arguments = drawn["clip.mp4"]
    assert arguments == {"env_kwargs": {**kept.configuration.env_kwargs, "memory_weight": 0.0}, "seed": 4}
    assert torch.equal(filmed.policy.action_net.weight, policy.policy.action_net.weight)


def test_a_report_is_of_the_best_policy_beside_its_run_unless_it_is_said(kept, drawn):
    result = evaluate_run(kept.folder, steps=1000, seeds=[11], video=False)
    best, policies = stepped(load_policy(kept, trust=True), ODD, 1000, 11), (kept.folder / "checkpoints").iterdir()
    assert result["commands"] == "".join(map(str, best[0][500:540].tolist()))
    assert json.loads((kept.folder / "evaluation" / "results.json").read_text(encoding="utf-8")) == result
    assert "clip.mp4" not in drawn
    # Were all policies alike, another could stand for the best.
    assert (
        len(
            {
                measure(load_policy(kept, file, trust=True), StickSlipCrawlerEnv(**ODD), steps=1000)[0].speed
                for file in policies
            }
        )
        == 3
    )


@pytest.mark.parametrize(("arguments", "told"), [(DRAWN, True), (QUIET, False)], ids=["drawn", "quiet"])
def test_a_report_tells_what_was_drawn_and_no_memory_without_flips(
    tmp_path, drawn, policy, monkeypatch, arguments, told
):
    entry = read_hyperparameters("ppo", "StickSlipCrawler-v0")
    del entry["env_kwargs"]  # the environment is the test's own
    run = Run.create(tmp_path / "run", Configuration(env_kwargs=arguments, hyperparameters=entry))
    write_evaluations(run.folder / "evaluations.csv", [Evaluation(1, 2.0, 3.0, 4.0)])
    monkeypatch.setattr(training, "load_policy", lambda *_, **__: policy)
    result = evaluate_run(run.folder, steps=1000, seeds=[11], video=False)
    environment = StickSlipCrawlerEnv(**arguments)
    environment.reset(seed=11)
    assert ("memory capacity" in result) == ("memory.png" in drawn) == told
    if told:
        assert result["groups drawn"] == environment.episode_groups.to_dict()
        assert result["slope drawn"] == environment.episode_scene.slope
    else:
        assert set(result) == {"steps", "seeds", "speed", "commands", "verdict"}
