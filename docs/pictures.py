"""Make the pages' pictures: ``python docs/pictures.py``, after ``make demo``, for the clip in ``runs/demo``."""

from pathlib import Path

import gymnasium as gym
import numpy as np

from stickslip.common.extras import optional_import
from stickslip.envs import tile

with optional_import():
    from matplotlib import image
    from moviepy import VideoFileClip

DEMO = Path("runs/demo")
IMAGES = Path("docs/images")


def main() -> None:
    """Cut the demo's clip down to a short animation, and draw four crawlers of many."""
    if DEMO.exists():
        with VideoFileClip(str(DEMO / "gait.mp4")) as clip:
            # Three cycles of the gait, from where the start is forgotten.
            clip.subclipped(2.0, 2.5).with_speed_scaled(0.4).resized(width=640).write_gif(
                str(IMAGES / "gait.gif"), fps=12, logger=None
            )
    shown = [0, 1, 2048, 4095]
    batch = gym.make_vec("stickslip:StickSlipCrawler-v0", 4096, render_mode="rgb_array", rendered=shown)
    batch.reset(seed=0)
    generator = np.random.default_rng(0)
    for _ in range(40):
        batch.step(generator.integers(0, 2, 4096))
    image.imsave(IMAGES / "tile.png", tile(batch.render(), shown))


if __name__ == "__main__":
    main()
