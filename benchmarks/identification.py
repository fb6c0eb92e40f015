"""How well bodies are found again in 200 experiments, an unseen gait foretold by four ways of learning, and SINDy.

Run ``python benchmarks/identification.py``; ``--experiments N`` for fewer. Every experiment is kept in
``benchmarks/results/identification.json`` as it ends, and a run that was stopped goes on where it stopped. At the end
the tables are written into ``docs/identification.md`` between their marks.
"""

import argparse
import json
import os
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from measuring import keep, machine, refresh
from mutating.page import wilson
from sklearn.neural_network import MLPRegressor
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from stickslip import Groups, identify, simulate, Trajectory
from stickslip.studies.benchmark.report import as_markdown
from stickslip.studies.claims.claim import interval
from stickslip.studies.claims.laws import WAYS
from stickslip.studies.claims.sindy import errors_of, fit, foretold, nmse, Setting, TARGETS
from stickslip.studies.identification import Identification, Measurements, regress
from stickslip.tasks import random_bits

BENCHMARKS = Path(__file__).parent
RESULTS = BENCHMARKS / "results" / "identification.json"
PAGE = BENCHMARKS.parent / "docs" / "identification.md"

HOLDS, HOLD, SAMPLES, NOISE = 200, 1.0, 8, 0.01
CHANNELS = ("deformation", "foot")
SPREAD, WRONG = 2.0, 3.0  # factors of the truth about the defaults, and of the guess about the truth
SEEDS = 8  # of SINDy
FINE = 50  # samples a hold from which laws are regressed
GAIT = (1, 1, 1, 0, 0, 1, 0, 0) * 25


def truth(generator: np.random.Generator) -> Groups:
    """A body within a factor of two of the default one."""
    values = {name: value * SPREAD ** generator.uniform(-1.0, 1.0) for name, value in Groups().to_dict().items()}
    values["kinetic_friction"] = min(values["kinetic_friction"], 0.95 * values["static_friction"])
    return Groups(**values)


def wrong(groups: Groups, generator: np.random.Generator) -> dict[str, float]:
    """A guess of which each group is off by a factor of three either way."""
    values = {name: value * WRONG ** generator.choice([-1.0, 1.0]) for name, value in groups.to_dict().items()}
    values["foot_mass_fraction"] = min(values["foot_mass_fraction"], 0.9)
    values["kinetic_friction"] = min(values["kinetic_friction"], values["static_friction"])
    return values


def experiment(seed: int) -> dict[str, Any]:
    """One body, measured and found again from a wrong guess."""
    generator = np.random.default_rng([2026, seed])
    groups = truth(generator)
    motion = simulate(groups, random_bits(HOLDS, seed), HOLD, samples_per_hold=SAMPLES)
    run = Measurements.of(motion, *CHANNELS, noise=NOISE, seed=seed)
    guess = wrong(groups, generator)
    began = time.process_time()
    found = identify(run, guess=guess)
    seconds = time.process_time() - began
    return {"seconds": seconds, "groups": asdict(groups), **told(found, groups)}


def told(found: Identification, groups: Groups) -> dict[str, Any]:
    """Relative errors, and whether the 95% intervals hold the truth."""
    intervals = found.interval(0.95)
    return {
        "warned": any("static_friction" in warning for warning in found.warnings),
        "errors": {name: getattr(found.groups, name) / getattr(groups, name) - 1.0 for name in found.names},
        "covered": {name: low <= getattr(groups, name) <= high for name, (low, high) in intervals.items()},
    }


def coverage_table(experiments: list[dict[str, Any]]) -> str:
    """A row a group."""
    rows = [["group", "median error, %", "largest error, %", "within 2%", "held by the 95% interval"]]
    for name in Groups().to_dict():
        errors = 100.0 * np.abs([each["errors"][name] for each in experiments])
        covered = sum(each["covered"][name] for each in experiments)
        low, high = wilson(covered, len(experiments))
        rows.append(
            [
                name,
                f"{np.median(errors):.3f}",
                f"{errors.max():.2f}",
                f"{int((errors < 2.0).sum())} of {len(experiments)}",
                f"{covered / len(experiments):.1%} [{low:.1%}, {high:.1%}]",
            ]
        )
    return as_markdown(rows)


def gait_foretold(seed: int) -> dict[str, float]:
    """NMSE of z in a gait that was not seen, by what learned from the same noisy run of random bits."""
    true = Groups()
    motion = simulate(true, random_bits(HOLDS, [seed, 0]), HOLD, samples_per_hold=FINE)
    run = Measurements.of(motion, "deformation", "velocity", "pressure", "foot_velocity", noise=NOISE, seed=seed)
    gait = simulate(true, GAIT, HOLD, samples_per_hold=FINE)
    law = regress(run).groups
    bodies = {"regression that finds slips": law, "identify, from that": identify(run, guess=law, starts=1).groups}
    errors = {
        name: nmse(simulate(body, GAIT, HOLD, samples_per_hold=FINE).deformation, gait.deformation)
        for name, body in bodies.items()
    }
    z, foot = (fit(Setting(target, noise=NOISE), true, seed=seed) for target in ("deformation", "foot"))
    integrated, _ = foretold([z], [foot], [GAIT], true.deborah, HOLD)
    errors["cubic by SINDy, integrated"] = nmse(integrated[0], gait.deformation)
    errors["network (64, 64), iterated"] = nmse(_iterated(run, gait, seed), gait.deformation)
    return errors


def _iterated(run: Measurements, gait: Trajectory, seed: int) -> np.ndarray:
    """Z of a black box that maps deformation, velocity, pressure, foot velocity and valve to the next sample."""
    channels = np.stack([getattr(run, name) for name in run.measured], axis=1)
    valves = np.repeat(run.valve, FINE)
    inputs = np.column_stack([channels[:-1], valves[1:]])
    model = make_pipeline(StandardScaler(), MLPRegressor(hidden_layer_sizes=(64, 64), max_iter=60, random_state=seed))
    model.fit(inputs, (channels[1:] - channels[:-1]) / channels.std(axis=0))
    state, found = np.zeros(channels.shape[1]), []
    for valve in np.repeat(gait.valve, FINE):
        state = np.clip(
            state + model.predict(np.append(state, valve)[np.newaxis])[0] * channels.std(axis=0), -10.0, 10.0
        )
        found.append(state[0])
    return np.array(found)


def gaits_table(found: list[dict[str, float]]) -> str:
    """A row a way of learning."""
    rows = [["learned by", "NMSE of z over 200 holds of an unseen gait: median", "least", "most"]]
    for name in found[0]:
        values = [each[name] for each in found]
        rows.append([name, *(f"{value:.1e}" for value in (np.median(values), min(values), max(values)))])
    return as_markdown(rows)


def regressed(way: str) -> dict[str, list[float]]:
    """NMSE of what one way of SINDy tells of runs that it has not seen, by seeds."""
    return {name: errors.tolist() for name, errors in errors_of(WAYS[way], Groups(), range(SEEDS)).items()}


def regressed_table(found: dict[str, dict[str, list[float]]]) -> str:
    """A row a way, means over seeds with 95% intervals."""
    rows = [["way", "one step of X_p''", "one step of X_f''", "one step of z''", "z, whole runs", "foot, whole runs"]]
    for name in WAYS:
        errors = [found[name][key] for key in (*TARGETS, "z", "way of the foot")]
        rows.append([name, *(str(interval(np.array(each), least=0.0)) for each in errors)])
    return as_markdown(rows)


def main() -> None:
    """Do what is not done, and write the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--experiments", type=int, default=200)
    parser.add_argument("--gaits", type=int, default=5)
    asked = parser.parse_args()
    results: dict[str, Any] = {"experiments": {}, "gaits": {}, "regressed": {}}
    if RESULTS.exists():
        results |= json.loads(RESULTS.read_text(encoding="utf-8"))
    for kind, work, cells in (
        ("experiments", experiment, range(asked.experiments)),
        ("gaits", gait_foretold, range(asked.gaits)),
        ("regressed", regressed, WAYS),
    ):
        for number, cell in enumerate(cells, 1):
            if str(cell) not in results[kind]:
                results[kind][str(cell)] = work(cell)
                keep(RESULTS, results | {"machine": machine("scipy", "scikit-learn", "pysindy")})
                print(f"{kind} {number} of {len(cells)}", flush=True)
    made = tables(results)
    refresh(PAGE, made)
    print("\n\n".join(made.values()))


def tables(results: dict[str, Any]) -> dict[str, str]:
    """The tables of the page, by name."""
    experiments = list(results["experiments"].values())
    seconds = [each["seconds"] for each in experiments]
    low, middle, high = np.quantile(seconds, [0.05, 0.5, 0.95])
    plain = [each["errors"]["static_friction"] for each in experiments if not each["warned"]]
    close = sum(abs(error) < 0.02 for error in plain)
    return {
        "coverage": coverage_table(experiments)
        + f"\n\n{len(experiments)} experiments; a fit took {middle:.2f} s of one processor in the median, "
        f"{low:.2f} to {high:.2f} in nine of ten. In {len(experiments) - len(plain)} of them a warning said that the "
        f"static friction may be next to the kinetic one; of the others it was within 2% in {close} of {len(plain)}.",
        "gaits": gaits_table(list(results["gaits"].values())),
        "regressed": regressed_table(results["regressed"]),
    }


if __name__ == "__main__":
    main()
