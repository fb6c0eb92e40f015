"""What an installation weighs, and how long it takes to the first action of a policy and the first step of a crawler.

Run ``python benchmarks/size_and_start.py``. It installs the checkout twice, each into a virtual environment of its own
with the versions of `constraints.txt`: with all that it requires, and with NumPy and safetensors alone, which is enough
to run a policy. Sizes are those of the files that an installation adds, bytecode included. Times are processor seconds
of whole processes, by children that begin anew each time, so that others on the machine do not count; "cold" is with
no kernel kept, else with all. What the runner's own work takes in a hold is timed in this process, by readings that
cost nothing. Medians with quartiles are the tables of the docs and kept in `benchmarks/results/size_and_start.json`;
``--decision`` renews the last table alone.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
import venv
from pathlib import Path
from typing import Any

from measuring import keep, machine, quartiles, refresh

import stickslip
from stickslip.robot import Runner, VirtualClock

RESULTS = Path(__file__).parent / "results" / "size_and_start.json"
ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "hardware.md"
BARE, ROBOT = "all that it requires", "NumPy and safetensors"
COMMANDS = {
    BARE: [["{stickslip}"]],
    ROBOT: [["numpy", "safetensors"], ["--no-deps", "{stickslip}"]],  # in this order pip does not complain
}
"""What pip installs, call by call."""

POLICY = "stickslip.pretrained('knee').predict([0.0] * 8)"
WORK = {
    "Python": "pass",
    "import numpy": "import numpy",
    "import stickslip": "import stickslip",
    "import stickslip.robot": "import stickslip.robot",
    "first action of a policy": f"import stickslip; {POLICY}",
    "first step of the environment": (
        "import gymnasium, stickslip; env = gymnasium.make('StickSlipCrawler-v0'); env.reset(seed=0); env.step(1)"
    ),
    "first simulation": "import stickslip; stickslip.simulate('ecoflex-00-30', [1, 0], 0.5)",
}
COMPILED = ("first step of the environment", "first simulation")


def weight(folder: Path) -> int:
    """Bytes of the files in a folder."""
    return sum(file.lstat().st_size for file in folder.rglob("*") if file.is_file() or file.is_symlink())


def installed(folder: Path, commands: list[list[str]], wheel: Path) -> tuple[Path, dict[str, float]]:
    """Python of an environment with what pip is told to install, and MB of each package in it."""
    venv.create(folder, with_pip=True)
    python = folder / "bin" / "python"
    (site,) = folder.glob("lib/python*/site-packages")
    before = {path.name for path in site.iterdir()}
    for what in commands:
        named = [each.format(stickslip=wheel) for each in what]
        pip = [str(python), "-m", "pip", "install", "--quiet", "--constraint", str(ROOT / "constraints.txt")]
        subprocess.run([*pip, *named], check=True, env={**os.environ, "PYTHONPATH": ""})
    added = {path.name: weight(path) if path.is_dir() else path.stat().st_size for path in site.iterdir()}
    sizes = {name: size / 1e6 for name, size in added.items() if name not in before}
    return python, dict(sorted(sizes.items(), key=lambda each: -each[1]))


def seconds(python: Path, code: str, kernels: Path) -> float:
    """Of processors, by a fresh process and its children."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(kernels), "PYTHONPATH": "", "OMP_NUM_THREADS": "1"}
    subprocess.run([str(python), "-c", code], check=True, cwd=kernels, env=environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measured(rounds: int, cold_rounds: int) -> dict[str, Any]:
    results: dict[str, Any] = {"machine": machine("scipy", "gymnasium", "safetensors"), "installed": {}, "seconds": {}}
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        wheels = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(folder), str(ROOT)]
        subprocess.run(wheels, check=True)
        (wheel,) = folder.glob("*.whl")
        for name, commands in COMMANDS.items():
            python, sizes = installed(folder / name.replace(" ", "-"), commands, wheel)
            results["installed"][name] = sizes
            print(f"{name}: {sum(sizes.values()):.0f} MB", flush=True)
            times = results["seconds"][name] = {}
            kernels = folder / "kernels"
            kernels.mkdir(exist_ok=True)
            works = {work: code for work, code in WORK.items() if name == BARE or work not in COMPILED}
            cold = {}
            for work in COMPILED if name == BARE else ():
                cold[work] = []
                for k in range(cold_rounds):
                    empty = folder / f"{work}{k}"
                    empty.mkdir()
                    cold[work].append(seconds(python, works[work], empty))
                    print(f"{work}, cold: {cold[work][-1]:.2f} s", flush=True)
                seconds(python, works[work], kernels)
            every: dict[str, list[float]] = {work: [] for work in works}
            for k in range(rounds):
                for work in list(works)[:: 1 if k % 2 == 0 else -1]:
                    every[work].append(seconds(python, works[work], kernels))
            times |= {work: quartiles(values) for work, values in every.items()}
            times |= {f"{work}, cold": quartiles(values) for work, values in cold.items()}
    return results


def decisions(rounds: int, holds: int = 500) -> dict[str, list[float]]:
    """Processor milliseconds a hold of the runner's own work, by what it does."""
    told = {"deformation_mm": 1.0, "foot_mm": 2.0, "pressure_kPa": 3.0}
    rates = {"velocity_mm_s": 0.0, "foot_velocity_mm_s": 0.0}
    observation, policy = [0.1] * 8, stickslip.pretrained("knee")

    def runner(readings: int, **measured: float) -> Runner:
        settings = {"actuator": stickslip.Actuator.ecoflex(), "clock": VirtualClock(), "readings": readings}
        return Runner(policy, lambda: measured, lambda valve: None, **settings)

    def decided() -> None:
        for _ in range(holds):
            policy.predict(observation)

    works = {
        "the policy alone": decided,
        "2 readings with velocities, and the policy": lambda: runner(2, **told, **rates).run(holds),
        "2 readings without, and the policy": lambda: runner(2, **told).run(holds),
        "8 readings without, and the policy": lambda: runner(8, **told).run(holds),
    }
    spent: dict[str, list[float]] = {name: [] for name in works}
    for k in range(rounds):
        for name in list(works)[:: 1 if k % 2 == 0 else -1]:
            began = time.process_time()
            works[name]()
            spent[name].append(1e3 * (time.process_time() - began) / holds)
    return {name: quartiles(values) for name, values in spent.items()}


def tables(results: dict[str, Any]) -> dict[str, str]:
    sizes = ["| installed | MB | of these |", "| --- | ---: | --- |"]
    for name, of_packages in results["installed"].items():
        largest = ", ".join(f"{package} {size:.0f}" for package, size in list(of_packages.items())[:5])
        sizes.append(f"| {name} | {sum(of_packages.values()):.0f} | {largest} |")
    names = list(results["seconds"])
    start = ["| processor seconds of a whole process | " + " | ".join(names) + " |", "| --- |" + " ---: |" * len(names)]
    for work in results["seconds"][BARE]:
        cells = [_spread(results["seconds"][name].get(work)) for name in names]
        start.append(f"| {work} | " + " | ".join(cells) + " |")
    own = ["| processor milliseconds a hold | |", "| --- | ---: |"]
    own += [f"| {name} | {_spread(values)} |" for name, values in results["decisions"].items()]
    return {"sizes": "\n".join(sizes), "start": "\n".join(start), "decision": "\n".join(own)}


def _spread(values: list[float] | None) -> str:
    if values is None:
        return ""
    low, middle, high = values
    return f"{middle:.2f} [{low:.2f}, {high:.2f}]"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--cold-rounds", type=int, default=1)
    parser.add_argument("--decision", action="store_true", help="only what the runner's own work takes")
    arguments = parser.parse_args()
    if arguments.decision:
        results = json.loads(RESULTS.read_text(encoding="utf-8"))
    else:
        results = measured(arguments.rounds, arguments.cold_rounds)
    results["decisions"] = decisions(arguments.rounds)
    keep(RESULTS, results)
    made = tables(results)
    print("\n\n".join(made.values()))
    refresh(PAGE, made)


if __name__ == "__main__":
    main()
