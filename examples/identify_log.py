"""A body from a log: its stiffness, damping, lag and frictions, from what a camera and a gauge have told of it.

Run ``python examples/identify_log.py``. A crawler of Ecoflex is driven by 40 holds of random bits, and a log is written
as instruments would: positions of foot and payload to a fifth of a millimetre, 200 a second, with gaps where the marker
was hidden, and the pressure to a tenth of a kilopascal. Then a body is looked for about a guess that is a third off, as
``stickslip identify log.csv --actuator ...`` does.
"""

import argparse
import csv
from dataclasses import replace
from pathlib import Path

import numpy as np

from stickslip import Actuator, simulate
from stickslip.common.figures import save_figure
from stickslip.studies.identification import identify, read_log
from stickslip.tasks import random_bits

TRUTH = Actuator.ecoflex()
GUESS = replace(
    TRUTH,
    stiffness=85.0,
    cubic_stiffness=25e3,
    damping=0.3,
    lag=0.04,
    radial_coupling=4.5,
    static_friction=1.1,
    kinetic_friction=0.7,
)
FREE = ("stiffness", "cubic_stiffness", "damping", "lag", "radial_coupling", "static_friction", "kinetic_friction")
HOLDS, HOLD, SAMPLES = 40, 0.06, 12  # seconds, and samples a hold
CAMERA, GAUGE = 0.2e-3, 100.0  # standard deviations of errors, m and Pa
HIDDEN = slice(100, 130)


def write_log(file: Path, seed: int) -> None:
    """What the instruments would tell of the true body."""
    generator = np.random.default_rng(seed)
    valve = random_bits(HOLDS, seed)
    motion = simulate(TRUTH, valve, HOLD / TRUTH.scales.time, samples_per_hold=SAMPLES).in_si(TRUTH)
    foot, payload = (each + CAMERA * generator.standard_normal(each.size) for each in (motion.foot, motion.payload))
    pressure = motion.pressure + GAUGE * generator.standard_normal(motion.pressure.size)
    foot[HIDDEN] = np.nan
    with file.open("w", encoding="utf-8", newline="") as log:
        rows = csv.writer(log)
        rows.writerow(["time_s", "valve", "foot_mm", "payload_mm", "pressure_kPa"])
        for i, t in enumerate(motion.time.tolist()):
            lengths = ["" if np.isnan(each[i]) else f"{1e3 * each[i]:.2f}" for each in (foot, payload)]
            rows.writerow([f"{t:.4f}", int(valve[i // SAMPLES]), *lengths, f"{1e-3 * pressure[i]:.2f}"])


def main(folder: Path, seed: int) -> None:
    """Write the log, find the body, and print it beside the true one."""
    folder.mkdir(parents=True, exist_ok=True)
    write_log(folder / "log.csv", seed)
    found = identify(read_log(folder / "log.csv").run, free=FREE, guess=GUESS)
    print(f"{'':17} {'guess':>8} {'found':>8} {'true':>8}   95% interval")
    for name, (low, high) in found.interval(0.95).items():
        guess, value, true = (getattr(body, name) for body in (GUESS, found.body, TRUTH))
        print(f"{name:17} {guess:8.4g} {value:8.4g} {true:8.4g}   {low:.4g} to {high:.4g}")
    for warning in found.warnings:
        print("warning:", warning)
    save_figure(found.plot(), folder / "fit.png")
    print(f"log.csv and fit.png in {folder}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="A body from a log.")
    parser.add_argument("--output", type=Path, default=Path("runs/identify_log"))
    parser.add_argument("--seed", type=int, default=0)
    chosen = parser.parse_args()
    main(chosen.output, chosen.seed)
