"""Cost of the chain by number of segments and mass of the tube, relative to the crawler.

Run ``python benchmarks/chain_cost.py``. Chain and crawler are timed in turn, so that the machine's drift falls on both
alike; the median ratio is printed, with its quartiles.
"""

import time

import numpy as np

from stickslip.crawler import Groups, Scene, simulate

WORD = [1, 1, 1, 1, 0, 0, 0, 0]
TOLERANCE = 1e-6
ROUNDS = 9


def main() -> None:
    """Print the table."""
    print(f"cost per unit of time over the crawler's at tolerance {TOLERANCE:g}: median [quartiles]")
    for tube_mass in (0.1, 1.0):
        for segments in (1, 2, 4, 8, 16, 32):
            scene, words = Scene(segments=segments, tube_mass=tube_mass), 25 if segments < 16 else 2
            seconds(scene, 1)
            seconds(Scene(), 1)
            ratios = [seconds(scene, words) / seconds(Scene(), 25) for _ in range(ROUNDS)]
            low, median, high = np.percentile(ratios, (25, 50, 75))
            print(f"tube_mass {tube_mass:g}, segments {segments:2d}: {median:.1f} [{low:.1f}, {high:.1f}]")


def seconds(scene: Scene, words: int) -> float:
    """Seconds a unit of time, over so many words of eight holds."""
    start = time.perf_counter()
    simulate(Groups(), WORD * words, 1.0, scene=scene, tolerance=TOLERANCE)
    return (time.perf_counter() - start) / (words * len(WORD))


if __name__ == "__main__":
    main()
