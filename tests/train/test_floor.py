"""A floor on speed: what it is worth, what it pays, and that a training above one is chosen by it."""

import numpy as np
import pytest

from stickslip.train.evaluations import read_evaluations
from stickslip.train.floor import Floor, FloorVecEnv
from stickslip.train.hyperparameters import read_hyperparameters
from stickslip.train.run import Configuration
from stickslip.train.training import train
from stickslip.train.vec_env import StickSlipVecEnv
from stickslip.train.verdict import REPORT

FLOOR = Floor(0.3)


@pytest.mark.parametrize("speed", [-0.1, 0.1, 0.2, 0.22, 0.28, 0.31, 0.8])
def test_the_weights_are_as_the_derivatives_of_the_utility(speed):
    step = 1e-6
    of_speed = (FLOOR.utility(speed + step, 2.0) - FLOOR.utility(speed - step, 2.0)) / (2 * step)
    of_memory = (FLOOR.utility(speed, 2.0 + step) - FLOOR.utility(speed, 2.0 - step)) / (2 * step)
    weight = FLOOR.weight(speed)
    assert of_speed / of_memory == pytest.approx((1 - weight) / weight, abs=1e-6)
    assert FLOOR.weight(0.0) == pytest.approx(0.1)  # however slow it is, a policy hears of its memory


def test_above_the_floor_memory_alone_counts_and_below_it_speed_does():
    assert FLOOR.utility(0.3, 3.0) == FLOOR.utility(0.9, 3.0) == 3.0
    assert FLOOR.weight(0.3) == FLOOR.weight(0.9) == 1.0
    # Over the quadratic part, 0.09 wide, the price rises from 0 to 9; below it stays.
    assert FLOOR.utility(0.21, 3.0) == pytest.approx(3.0 - 0.09 * 9 / 2)
    assert FLOOR.utility(0.11, 3.0) == pytest.approx(3.0 - 0.09 * 9 / 2 - 0.1 * 9)


def test_a_batch_is_paid_by_how_fast_it_has_been():
    """Beside the environment that tells both objectives, over the end of an episode."""
    asked = {"dither": 0.1, "hold": 0.5, "max_episode_steps": 7}
    paid = FloorVecEnv(3, floor=Floor(0.05), sparse_infos=True, **asked)
    plain = StickSlipVecEnv(3, **asked)
    for environments in (paid, plain):
        environments.seed(4)
        environments.reset()
    mean = 0.0
    weights = []
    for step in range(20):
        commands = np.array([1, step % 2, (step // 3) % 2])
        _, rewards, _, _ = paid.step(commands)
        _, _, _, infos = plain.step(commands)
        speed, memory = (np.array([info[name] for info in infos]) for name in ("speed", "memory"))
        weights.append(Floor(0.05).weight(mean))
        np.testing.assert_allclose(rewards, (1 - weights[-1]) * speed + weights[-1] * memory, rtol=1e-6)
        mean += (speed.mean() - mean) / 100
        assert paid.mean_speed == pytest.approx(mean)
    assert len(set(weights)) > 5
    for environments in (paid, plain):
        environments.close()


def test_a_training_above_a_floor_is_evaluated_by_its_utility(tmp_path):
    entry = read_hyperparameters("ppo", "StickSlipCrawler-v0")
    entry |= {"n_envs": 2, "n_steps": 4, "batch_size": 8, "n_timesteps": 16}
    run = train(Configuration(env_kwargs={"dither": 0.1}, hyperparameters=entry, floor=0.3, start="open"), tmp_path)
    rows = read_evaluations(run.folder / "evaluations.csv")
    assert [row.reward for row in rows] == pytest.approx([FLOOR.utility(row.speed, row.memory) for row in rows])
    assert not (run.folder / REPORT).exists()
    assert run.best_policy.with_suffix(".json").exists()
