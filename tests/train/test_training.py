"""Training runs: what they keep, how they resume, and that they learn to crawl."""

import shutil
import time
from contextlib import nullcontext
from dataclasses import asdict, replace
from functools import partial

import numpy as np
import pytest
import torch
from sb3_contrib import RecurrentPPO
from stable_baselines3 import PPO
from stable_baselines3.common.save_util import load_from_pkl
from stable_baselines3.common.vec_env import VecFrameStack, VecMonitor
from threadpoolctl import threadpool_info

from stickslip.crawler import SolverError
from stickslip.envs import StickSlipCrawlerEnv
from stickslip.train import library_threads, StickSlipVecEnv
from stickslip.train.algorithms import ALGORITHMS
from stickslip.train.evaluation import measure, roll_out
from stickslip.train.hyperparameters import entropy_schedule, read_hyperparameters, resolve
from stickslip.train.report import evaluate_run
from stickslip.train.run import Configuration, Run
from stickslip.train.training import load_policy, train

ID = "StickSlipCrawler-v0"
SPEED = {"memory_weight": 0.0, "dither": 0.0}
BEST_OPEN_LOOP = 1.0615


def configuration(steps, seed=0, algorithm="ppo", **changes):
    entry = {**read_hyperparameters(algorithm, ID), "n_timesteps": steps, **changes}
    return Configuration(algorithm=algorithm, env_kwargs=SPEED, hyperparameters=entry, seed=seed)


@pytest.fixture(scope="module")
def short_run(tmp_path_factory):
    """Two updates of PPO in small batches."""
    folder = tmp_path_factory.mktemp("runs") / "short"
    return train(configuration(512, n_envs=4, n_steps=64, batch_size=64), folder)


def test_a_run_keeps_its_configuration_checkpoints_evaluations_and_logs(short_run):
    names = {path.name for path in short_run.folder.iterdir()}
    assert names == {
        "configuration.yml",
        "checkpoints",
        "best.zip",
        "best.safetensors",
        "best.json",
        "final.zip",
        "evaluations.csv",
        "report.json",
        "report.md",
        "tensorboard",
    }
    assert Run.open(short_run.folder).configuration == short_run.configuration
    assert short_run.latest_checkpoint() == short_run.checkpoint(512)
    assert list((short_run.folder / "tensorboard").rglob("events.*"))
    header, *rows = (short_run.folder / "evaluations.csv").read_text(encoding="utf-8").splitlines()
    assert header == "steps,mean_reward_per_step,mean_speed,mean_memory"
    assert [int(row.split(",")[0]) for row in rows] == sorted(int(row.split(",")[0]) for row in rows)
    assert rows[-1].startswith("512,")


@pytest.mark.parametrize(
    ("arguments", "episodes"),
    [
        (SPEED, 1),
        (SPEED | {"randomize": {"slope": [0.0, 0.1]}}, 32),
        (SPEED | {"dither": 0.1}, 32),
        ({}, 32),  # flips are the environment's own choice
    ],
    ids=str,
)
def test_an_evaluation_has_one_episode_only_where_all_are_alike(arguments, episodes, tmp_path):
    counts = []

    def counted(count, **env_kwargs):
        counts.append(count)
        return StickSlipVecEnv(count, **env_kwargs)

    asked = configuration(8, n_envs=2, n_steps=4, batch_size=8)
    train(replace(asked, env_kwargs=arguments), tmp_path / "run", vec_env=counted)
    assert counts == [2, episodes]


def test_torch_and_blas_leave_the_cores_to_the_batch_and_get_them_back(tmp_path):
    before = torch.get_num_threads()
    torch.set_num_threads(2)
    during = []

    def count(_):
        during.append({torch.get_num_threads(), *(library["num_threads"] for library in threadpool_info())})

    try:
        train(configuration(8, n_envs=1, n_steps=8, batch_size=8), tmp_path / "run", on_progress=count)
        assert during == [{1}] * 8
        assert torch.get_num_threads() == 2
    finally:
        torch.set_num_threads(before)


def test_a_run_is_reproduced_by_its_seed(short_run, tmp_path):
    again = train(short_run.configuration, tmp_path / "again")
    other = train(replace(short_run.configuration, seed=1), tmp_path / "other")

    expected, repeated, different = (
        weights(load_policy(run, run.final, trust=True)) for run in (short_run, again, other)
    )
    assert torch.equal(repeated, expected)
    assert not torch.equal(different, expected)


def weights(model):
    return torch.cat([value.flatten() for value in model.policy.state_dict().values()])


TRADE = {"memory_weight": 0.3, "dither": 0.1}
SHORT = partial(StickSlipVecEnv, max_episode_steps=20)


@pytest.fixture(scope="module")
def flipped_run(tmp_path_factory):
    """Three updates of PPO where the seed of the flips matters."""
    asked = configuration(384, 5, n_envs=4, n_steps=32, batch_size=64, learning_rate="lin_0.01", ent_coef=0.01)
    return train(replace(asked, env_kwargs=TRADE), tmp_path_factory.mktemp("runs") / "flipped", vec_env=SHORT)


def by_hand(run, steps, checkpoint=None):
    """The same training in Stable-Baselines3's own words."""
    entry = resolve(run.configuration.hyperparameters)
    environments = VecMonitor(SHORT(entry.pop("n_envs"), **TRADE))
    environments.seed(run.configuration.seed)
    del entry["n_timesteps"]
    if checkpoint is None:
        model = PPO(entry.pop("policy"), environments, seed=run.configuration.seed, device="cpu", **entry)
        return model.learn(steps)
    model = PPO.load(checkpoint, environments, device="cpu")
    return model.learn(steps, reset_num_timesteps=False)


def test_a_run_is_what_stable_baselines_learns_by_itself(flipped_run):
    expected = by_hand(flipped_run, 384)
    assert torch.equal(weights(load_policy(flipped_run, flipped_run.final, trust=True)), weights(expected))


def test_a_run_that_goes_on_is_what_stable_baselines_learns_from_its_checkpoint(flipped_run, tmp_path):
    run = Run.create(tmp_path / "run", flipped_run.configuration)
    shutil.copy(flipped_run.checkpoint(128), run.checkpoint(128))
    train(run.configuration, run.folder, resume=True, vec_env=SHORT)
    expected = by_hand(flipped_run, 256, flipped_run.checkpoint(128))
    assert torch.equal(weights(load_policy(run, run.final, trust=True)), weights(expected))
    # It was gone on with, and not begun again.
    assert load_policy(run, run.final, trust=True).num_timesteps == expected.num_timesteps == 384
    assert not torch.equal(
        weights(load_policy(run, run.final, trust=True)), weights(load_policy(run, run.checkpoint(128), trust=True))
    )


def test_a_run_that_is_one_step_short_goes_on(tmp_path):
    small = {"n_envs": 2, "n_steps": 4, "batch_size": 8}
    train(configuration(8, **small), tmp_path / "run", vec_env=SHORT)
    run = train(configuration(9, **small), tmp_path / "run", resume=True, vec_env=SHORT)
    assert load_policy(run, run.final, trust=True).num_timesteps == 16  # updates are whole


def test_infos_are_sparse_where_only_the_algorithm_reads_them(tmp_path, monkeypatch):
    made = []

    class Noting(StickSlipVecEnv):
        def __init__(self, count, **arguments):
            made.append((count, arguments.get("sparse_infos", False)))
            super().__init__(count, max_episode_steps=5, **arguments)

    monkeypatch.setattr("stickslip.train.training.StickSlipVecEnv", Noting)
    asked = replace(configuration(8, n_envs=2, n_steps=4, batch_size=8), env_kwargs=TRADE)
    train(asked, tmp_path / "run")
    assert made == [(2, True), (32, False)]


def test_a_schedule_falls_over_all_the_steps_of_a_run(flipped_run, tmp_path):
    def rates(run):
        models = {
            int(file.name.split("_")[0]): load_policy(run, file, trust=True)
            for file in run.folder.glob("checkpoints/*")
        }
        return {steps: model.policy.optimizer.param_groups[0]["lr"] for steps, model in sorted(models.items())}

    assert rates(flipped_run) == pytest.approx({128: 0.01 * 2 / 3, 256: 0.01 / 3, 384: 0.0})
    folder = tmp_path / "longer"
    shutil.copytree(flipped_run.folder, folder)
    longer = {**flipped_run.configuration.hyperparameters, "n_timesteps": 768}
    run = train(replace(flipped_run.configuration, hyperparameters=longer), folder, resume=True, vec_env=SHORT)
    assert rates(run) == pytest.approx(rates(flipped_run) | {512: 0.01 / 3, 640: 0.01 / 6, 768: 0.0})


def test_the_weight_of_entropy_falls_before_each_update(tmp_path):
    asked = configuration(384, n_envs=4, n_steps=32, batch_size=64, ent_coef="lin_0.03")
    run = train(asked, tmp_path / "run", vec_env=SHORT)
    kept = [load_policy(run, run.checkpoint(steps), trust=True).ent_coef for steps in (128, 256, 384)]
    assert kept == pytest.approx([0.02, 0.01, 0.0])


def test_an_interrupted_run_goes_on_from_its_last_checkpoint(tmp_path):
    whole = configuration(512, n_envs=4, n_steps=64, batch_size=64)

    class Crash(Exception):
        pass

    def crash(done):
        if done >= 300:
            raise Crash

    with pytest.raises(Crash):
        train(whole, tmp_path / "run", on_progress=crash)
    run = Run.open(tmp_path / "run")
    kept = run.latest_checkpoint()
    rows = (run.folder / "evaluations.csv").read_text(encoding="utf-8").splitlines()
    assert kept is not None
    assert not run.final.exists()

    done = []
    train(whole, tmp_path / "run", resume=True, on_progress=done.append)
    assert done[0] > int(kept.name.split("_")[0])
    assert load_policy(run, run.final, trust=True).num_timesteps == 512
    assert (run.folder / "evaluations.csv").read_text(encoding="utf-8").splitlines()[: len(rows)] == rows


def test_a_policy_of_environments_of_one_s_own_is_kept_as_a_zip_alone(tmp_path):
    asked = configuration(8, n_envs=1, n_steps=8, batch_size=8)
    run = train(asked, tmp_path / "run", vec_env=lambda count, **each: VecFrameStack(SHORT(count, **each), 2))
    assert run.best.exists()
    assert not list(run.folder.glob("best.[js]*"))


def small(algorithm):
    """Changes to what an algorithm's file says that make it learn from few steps."""
    changes = {"n_envs": 4, "batch_size": 64, "learning_starts": 50, "n_steps": 32}
    entry = read_hyperparameters(algorithm, ID)
    return {name: min(value, entry[name]) for name, value in changes.items() if name in entry}


def assert_made_as_asked_for(model, asked):
    """Every hyperparameter is as in a model that Stable-Baselines3 makes of it; what falls has a test of its own."""
    entry = resolve(asked.hyperparameters)
    if entropy_schedule(asked.hyperparameters) is not None:
        del entry["ent_coef"]
    del entry["n_timesteps"]
    batch = StickSlipVecEnv(entry.pop("n_envs"), **SPEED)
    assert model.n_envs == batch.num_envs
    expected = type(model)(entry.pop("policy"), batch, seed=asked.seed, device="cpu", **entry)
    assert (type(model).__name__.lower(), model.seed) == (asked.algorithm.replace("_", ""), asked.seed)
    assert type(model.policy) is type(expected.policy)
    for name in entry:
        value, other = getattr(model, name), getattr(expected, name)
        if callable(value):  # a schedule
            value, other = ([each(progress) for progress in (1.0, 0.4)] for each in (value, other))
        assert value == other, name


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_every_algorithm_is_interrupted_resumed_and_evaluated(tmp_path, algorithm):
    whole = configuration(384, algorithm=algorithm, **small(algorithm))
    folder = tmp_path / "run"

    def crash(done):
        if done >= 200:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train(whole, folder, on_progress=crash, vec_env=SHORT)
    done = []
    run = train(whole, folder, resume=True, on_progress=done.append, vec_env=SHORT)
    assert done[0] > 100
    assert done[-1] == 384
    model = load_policy(run, run.final, trust=True)
    assert model.num_timesteps == 384
    assert_made_as_asked_for(model, whole)
    assert {path.name.rpartition("_")[0] for path in (folder / "tensorboard").iterdir()} == {algorithm}
    # A recurrent policy is kept as a zip alone.
    result = evaluate_run(folder, steps=1000, seeds=[0], video=False, trust=algorithm == "recurrent_ppo")
    assert set(result["commands"]) <= {"0", "1"}
    if run.replay_buffer.exists():
        # What was kept at the last checkpoint before the crash, and all since.
        assert load_from_pkl(run.replay_buffer).size() * 4 == 384
    assert run.replay_buffer.exists() == (algorithm in ("dqn", "qrdqn"))


def test_a_recurrent_policy_is_rolled_out_with_its_memory():
    batch = StickSlipVecEnv(1, max_episode_steps=None)
    policy = RecurrentPPO("MlpLstmPolicy", batch, seed=0, device="cpu")
    generator = torch.Generator().manual_seed(0)
    with torch.no_grad():
        for weights in policy.policy.parameters():
            weights += torch.randn(weights.shape, generator=generator)
    commands, _ = roll_out(policy, StickSlipCrawlerEnv(), 200, seed=7)

    def in_a_batch(remembering):
        batch.seed(7)
        observation, state, actions = batch.reset(), None, []
        for k in range(200):
            action, after = policy.predict(observation, state, np.array([k == 0]), deterministic=True)
            state = after if remembering else None
            observation, *_ = batch.step(action)
            actions.append(int(action[0]))
        return actions

    assert commands.tolist() == in_a_batch(remembering=True)
    assert commands.tolist() != in_a_batch(remembering=False)


def test_a_finished_run_has_nothing_to_resume(short_run):
    done = []
    train(short_run.configuration, short_run.folder, resume=True, on_progress=done.append)
    assert done == []


def test_a_run_is_not_overwritten_or_resumed_as_another(short_run, tmp_path):
    with pytest.raises(ValueError, match="holds a run already; resume it or name another folder"):
        train(short_run.configuration, short_run.folder)
    other = replace(short_run.configuration, env_kwargs={**short_run.configuration.env_kwargs, "hold": 1.0}, seed=7)
    with pytest.raises(ValueError, match=r"env_kwargs\.hold must be .* to go on with run .*, got 1\.0; seed must be 0"):
        train(other, short_run.folder, resume=True)
    with pytest.raises(ValueError, match=r"run must be a folder with a configuration\.yml in it"):
        train(short_run.configuration, tmp_path / "nowhere", resume=True)


def test_a_run_is_not_gone_on_with_under_another_reward(short_run, monkeypatch):
    step = StickSlipCrawlerEnv.step

    def better_paid(self, action):
        observation, reward, *rest = step(self, action)
        return observation, reward + 0.01, *rest

    monkeypatch.setattr(StickSlipCrawlerEnv, "step", better_paid)
    with pytest.raises(ValueError, match=r"first rewards must be \[.*\] to go on with run .*another, got \["):
        train(short_run.configuration, short_run.folder, resume=True)


def test_wrong_arguments_are_found_before_the_folder_is_made(tmp_path):
    wrong = replace(configuration(64), env_kwargs={"dither": 0.7})
    with pytest.raises(ValueError, match=r"dither must be in \[0, 0.5\], got 0.7"):
        train(wrong, tmp_path / "run")
    with pytest.raises(TypeError, match="unexpected keyword argument 'n_stops'"):
        train(configuration(64, n_stops=3), tmp_path / "run")
    assert not (tmp_path / "run").exists()
    with pytest.raises(ValueError, match=r"algorithm must be one of \['ppo', .*\], got 'magic'"):
        replace(wrong, algorithm="magic")
    with pytest.raises(ValueError, match=r"environment must be one of \['StickSlipCrawler-v0'\], got 'CartPole-v1'"):
        replace(wrong, environment="CartPole-v1")


def test_checkpoints_that_are_none_are_refused(short_run, tmp_path):
    with pytest.raises(ValueError, match="checkpoint must be a file"):
        load_policy(short_run, tmp_path / "none.zip", trust=True)
    (tmp_path / "text.zip").write_text("no zip", encoding="utf-8")
    with pytest.raises(ValueError, match="is not one of ppo"):
        load_policy(short_run, tmp_path / "text.zip", trust=True)


def test_a_long_reason_for_a_refusal_is_cut(short_run, monkeypatch):
    def fail(*_, **__):
        raise ValueError("x\n" * 300)

    monkeypatch.setattr(PPO, "load", fail)
    with pytest.raises(ValueError, match=r"checkpoint .*final\.zip is not one of ppo: (x ){100}$"):
        load_policy(short_run, short_run.final, trust=True)


@pytest.mark.parametrize("fails", [False, True])
def test_every_environment_is_closed_again(tmp_path, fails):
    closed = []

    class Noting(StickSlipVecEnv):
        def close(self):
            closed.append(self.num_envs)
            super().close()

    def progress(done):
        if fails:
            raise KeyboardInterrupt

    asked = replace(configuration(8, n_envs=2, n_steps=4, batch_size=8), env_kwargs=TRADE)
    with pytest.raises(KeyboardInterrupt) if fails else nullcontext():
        train(
            asked,
            tmp_path / "run",
            on_progress=progress,
            vec_env=lambda count, **arguments: Noting(count, max_episode_steps=5, **arguments),
        )
    assert sorted(closed) == [2, 32]


@pytest.mark.parametrize("changed", [{"scene": {"ratchet": False}}, {"hold": 3.0}, {"groups": "high-damping"}])
def test_a_checkpoint_of_another_configuration_is_refused(short_run, tmp_path, changed):
    other = replace(short_run.configuration, env_kwargs={**SPEED, **changed})
    run = Run.create(tmp_path / "other", other)
    (name,) = changed
    with pytest.raises(ValueError, match=rf"env_kwargs\.{name}.* must be absent as in checkpoint .*got"):
        load_policy(run, short_run.final, trust=True)


def test_the_same_task_trained_with_another_seed_may_be_compared(short_run, tmp_path):
    run = Run.create(tmp_path / "other", replace(short_run.configuration, seed=5))
    assert load_policy(run, short_run.final, trust=True).num_timesteps == 512


def test_a_best_policy_lost_in_a_crash_is_made_again(tmp_path):
    whole = configuration(512, n_envs=4, n_steps=64, batch_size=64)
    run = train(configuration(256, n_envs=4, n_steps=64, batch_size=64), tmp_path / "run")
    again = tmp_path / "again"
    Run.create(again, whole)
    run.checkpoint(256).rename(again / "checkpoints" / "256_steps.zip")
    (run.folder / "evaluations.csv").rename(again / "evaluations.csv")
    # A row from after the checkpoint, and better than any policy: neither may hide the next best one.
    with (again / "evaluations.csv").open("a") as table:
        table.write("400,9.0\n")
    finished = train(whole, again, resume=True)
    assert finished.best.exists()
    steps = [int(row.split(",")[0]) for row in (again / "evaluations.csv").read_text(encoding="utf-8").splitlines()[1:]]
    assert 400 not in steps
    assert len(steps) == len(set(steps))


def test_a_run_that_has_ended_may_be_extended(tmp_path):
    small = {"n_envs": 4, "n_steps": 64, "batch_size": 64}
    run = train(configuration(256, **small), tmp_path / "run")
    rows = (run.folder / "evaluations.csv").read_text(encoding="utf-8").splitlines()
    done = []
    extended = train(configuration(512, **small), run.folder, resume=True, on_progress=done.append)
    assert done[0] > 256
    assert load_policy(extended, extended.final, trust=True).num_timesteps == 512
    assert (run.folder / "evaluations.csv").read_text(encoding="utf-8").splitlines()[: len(rows)] == rows
    assert vars(load_policy(extended, extended.final, trust=True))["stickslip_configuration"] == asdict(
        extended.configuration
    )
    # The folder knows of it: a second crash would be resumed to the new end.
    assert Run.open(run.folder).configuration == configuration(512, **small)


def test_a_run_does_not_end_before_what_it_has_done_nor_change_otherwise(short_run):
    kept = short_run.configuration
    for name, value, message in (
        ("n_timesteps", 256, "n_timesteps must be at least 512, which run .* has done, got 256"),
        ("gamma", 0.5, r"hyperparameters\.gamma"),
    ):
        other = replace(kept, hyperparameters={**kept.hyperparameters, name: value})
        with pytest.raises(ValueError, match=message):
            train(other, short_run.folder, resume=True)
        assert Run.open(short_run.folder).configuration == kept


def test_what_is_left_of_a_run_is_not_mixed_into_another(short_run, tmp_path):
    (tmp_path / "evaluations.csv").write_text("steps,mean_reward_per_step\n", encoding="utf-8")
    with pytest.raises(ValueError, match="holds a run already"):
        Run.create(tmp_path, short_run.configuration)


def test_a_body_that_diverges_leaves_no_run_behind(tmp_path):
    wild = replace(configuration(64), env_kwargs={"groups": {"radial_coupling": 50, "duffing": 0}})
    with pytest.raises(SolverError, match="diverged"):
        train(wild, tmp_path / "run")
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("text", ["a: [1", "- 1", "\x00"])
def test_a_corrupted_configuration_is_refused(tmp_path, text):
    (tmp_path / "configuration.yml").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=r"configuration\.yml must"):
        Run.open(tmp_path)


def test_an_evaluation_writes_its_figures_numbers_and_clip(short_run):
    result = evaluate_run(short_run.folder, steps=1000)
    made = {path.name: path.stat().st_size for path in (short_run.folder / "evaluation").iterdir()}
    assert set(made) == {"results.json", "report.json", "report.md", "gait.png", "learning.png", "clip.mp4"}
    assert min(made.values()) > 0
    policy = load_policy(short_run, trust=True)
    environment = StickSlipCrawlerEnv(**short_run.configuration.env_kwargs)
    assert result["speed"]["mean"] == pytest.approx(measure(policy, environment, steps=1000)[0].speed)


def test_the_crawl_is_learned_within_a_few_updates(tmp_path):
    run = train(configuration(50_000), tmp_path / "run")
    environment = StickSlipCrawlerEnv(**run.configuration.env_kwargs)
    speed = measure(load_policy(run, trust=True), environment, steps=2000)[0].speed
    assert speed >= 0.95 * BEST_OPEN_LOOP


@pytest.mark.slow
@pytest.mark.parametrize("algorithm", [name for name in ALGORITHMS if name != "ppo"])
def test_every_algorithm_learns_to_crawl_within_its_shipped_budget(tmp_path, algorithm):
    steps = read_hyperparameters(algorithm, ID)["n_timesteps"]
    run = train(configuration(steps, algorithm=algorithm), tmp_path / "run")
    environment = StickSlipCrawlerEnv(**run.configuration.env_kwargs)
    speed = measure(load_policy(run, trust=True), environment, steps=2000)[0].speed
    # Held open or shut for ever the valve moves nothing but the start; coin flips crawl at a quarter of the optimum.
    assert speed >= 0.95 * BEST_OPEN_LOOP


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_shipped_hyperparameters_crawl_near_the_optimum(tmp_path, seed):
    start = time.perf_counter()
    run = train(configuration(read_hyperparameters("ppo", ID)["n_timesteps"], seed), tmp_path / "run")
    elapsed = time.perf_counter() - start
    environment = StickSlipCrawlerEnv(**run.configuration.env_kwargs)
    speed = measure(load_policy(run, trust=True), environment, steps=4000)[0].speed
    assert speed >= 0.95 * BEST_OPEN_LOOP
    # The promise of the command, with the seconds it took in the message should it be broken.
    assert elapsed <= 90.0, f"seed {seed} took {elapsed:.0f} s"


def test_threads_are_as_many_as_asked_for_and_given_back_after_a_failure():
    before, within = torch.get_num_threads(), []

    def fail():
        with library_threads(3):
            within.append(torch.get_num_threads())
            raise RuntimeError("within")

    with pytest.raises(RuntimeError, match="within"):
        fail()
    assert within == [3]
    assert torch.get_num_threads() == before


@pytest.mark.parametrize("count", [0, 1.5])
def test_threads_that_are_no_number_of_them_are_refused(count):
    before = torch.get_num_threads()
    with pytest.raises((ValueError, TypeError), match="count must be a whole number >= 1"), library_threads(count):
        pass
    assert torch.get_num_threads() == before
