"""Make the pages' pictures: ``python docs/pictures.py``."""

from pathlib import Path

import gymnasium as gym
import numpy as np

from stickslip.common.extras import optional_import
from stickslip.envs import tile
from stickslip.train.evaluation import film
from stickslip.train.policies.pretrained import pretrained

with optional_import():
    from matplotlib import image

IMAGES = Path("docs/images")


def main() -> None:
    """Film the policy of the knee, its readout long trained, and draw four crawlers of many."""
    knee = pretrained("knee")
    film(knee, IMAGES / "gait.gif", env_kwargs=knee.env_kwargs, steps=16, seed=3, washout=404)
    shown = [0, 1, 2048, 4095]
    batch = gym.make_vec("stickslip:StickSlipCrawler-v0", 4096, render_mode="rgb_array", rendered=shown)
    batch.reset(seed=0)
    generator = np.random.default_rng(0)
    for _ in range(40):
        batch.step(generator.integers(0, 2, 4096))
    image.imsave(IMAGES / "tile.png", tile(batch.render(), shown))


if __name__ == "__main__":
    main()
