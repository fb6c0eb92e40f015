"""Make the README's pictures from what ``make demo`` left in ``runs/demo``: ``python docs/pictures.py``."""

import shutil
from pathlib import Path

from moviepy import VideoFileClip

DEMO = Path("runs/demo")
IMAGES = Path("docs/images")


def main() -> None:
    """Copy the figure of the trade, and cut the clip down to a short animation."""
    shutil.copy(DEMO / "trade.png", IMAGES / "trade.png")
    with VideoFileClip(str(DEMO / "gait.mp4")) as clip:
        # Three cycles of the gait, from where the start is forgotten.
        clip.subclipped(2.0, 2.5).with_speed_scaled(0.4).resized(width=640).write_gif(
            str(IMAGES / "gait.gif"), fps=12, logger=None
        )


if __name__ == "__main__":
    main()
