"""Real processes, interrupted at random moments: none ends by a fault, and what was finished is kept."""

import json
import os
import random
import shlex
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import typer

from stickslip.commands import app
from stickslip.reservoir import echo_state, EchoStateNetwork
from stickslip.tasks import chaos, lorenz

MAIN = "from stickslip.cli import main; main()"
# What each works for, made once beforehand: LLVM does not stop in the midst of a kernel.
BEGIN = """
import numpy as np
import gymnasium as gym
from stickslip import Groups, Scene, simulate

valve = np.random.default_rng(0).integers(0, 2, 1_000_000)
chain = Scene(segments=4, tube_mass=0.3)
linear = Groups(duffing=0, radial_coupling=0)
undamped = Groups(damping_ratio=0, static_friction=10)

def steps(env, action, count):
    env.reset(seed=0)
    while count:
        env.step(action)
        count -= 1

def single():
    return gym.make("StickSlipCrawler-v0", max_episode_steps=-1)

def batch(n, **arguments):
    return gym.make_vec("StickSlipCrawler-v0", n, threads=2, dither=0, memory_weight=0, **arguments)

"""
PROGRAMS = {
    "long simulation": (
        "simulate(Groups(), valve[:9], 0.5)",
        "simulate(Groups(), valve, 0.5, samples_per_hold=4)",
    ),
    "long simulation in closed form": ("simulate(linear, valve[:9], 0.5)", "simulate(linear, valve, 0.5)"),
    "long hold": ("simulate(undamped, [1], 10)", "simulate(undamped, [1], 1e7, max_steps=10**9)"),
    "short simulations": (
        "simulate(Groups(), valve[:100], 0.5)",
        "simulate(Groups(), valve[:100], 0.5)",
    ),
    "many crawlers": (
        "simulate(Groups(), valve[:9], 0.5)",
        "simulate([Groups(duffing=d) for d in np.linspace(0, 3, 1000)], valve[:10_000], 0.5)",
    ),
    "chain": ("simulate(Groups(), valve[:9], 0.5, scene=chain)", "simulate(Groups(), valve, 0.5, scene=chain)"),
    "steps": ("steps(single(), 1, 2)", "steps(single(), 1, -1)"),
    "batched steps": ("steps(batch(9), np.ones(9, int), 2)", "steps(batch(2000), np.ones(2000, int), -1)"),
    "batched steps of long holds": (
        "steps(batch(9, hold=10_000), np.ones(9, int), 2)",
        "steps(batch(400, hold=10_000), np.ones(400, int), -1)",
    ),
}
COMMANDS = {
    "search": ["--task", "memory capacity", "--evaluations", "5000", "--length", "1000"],
    "bench": ["--length", "2000", "--seeds", "20"],
    "bench by two": ["--length", "2000", "--seeds", "20", "--processes", "2"],
    "train": ["--steps", "500000"],
    "demo": [],
    "trade": ["--longest", "4", "--resolution", "8", "--judges", "2", "--holds", "2000", "--seeds", "1"],
}


def start(arguments, **kwargs):
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    return subprocess.Popen(
        [sys.executable, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        env=environment,
        start_new_session=True,
        **kwargs,
    )


def interrupt(process, *, all_of_them=False):
    """Interrupt a process, or all of its session as a terminal does; what it said, once it has ended."""
    began = time.monotonic()
    if all_of_them:
        os.killpg(process.pid, signal.SIGINT)
    else:
        process.send_signal(signal.SIGINT)
    try:
        _, said = process.communicate(timeout=60)
    finally:
        process.kill()
    print(f"ended {time.monotonic() - began:.2f} s after its interrupt")
    ended_by_interrupt = process.returncode == 130 or said.rstrip().endswith("KeyboardInterrupt")
    assert ended_by_interrupt, (process.returncode, said)
    assert process.returncode in (130, -signal.SIGINT), said
    return said


def command(name, folder):
    """A command of the package, as `start` wants it."""
    return ["-c", MAIN, name.split()[0], "--output", str(folder), *COMMANDS[name]]


def wait_for(pattern, folder, process):
    """Wait until there is such a file."""
    until = time.monotonic() + 300
    while not list(folder.glob(pattern)):
        assert time.monotonic() < until
        assert process.poll() is None, process.communicate()
        time.sleep(0.05)


def go_on(said):
    """The command that the last line names."""
    line = said.strip().splitlines()[-1]
    assert line.startswith("interrupted; go on with: stickslip "), said
    return shlex.split(line.removeprefix("interrupted; go on with: stickslip "))


def interrupt_program(beforehand, work):
    # However fast the machine, it is still at work when the interrupt comes.
    process = start(["-c", f"{BEGIN}{beforehand}\nprint('go', flush=True)\nwhile True: {work}"])
    assert process.stdout.readline() == "go\n"
    time.sleep(random.uniform(0.0, 3.0))
    said = interrupt(process)
    assert "KeyboardInterrupt" in said


@pytest.mark.parametrize("name", ["short simulations", "long hold", "batched steps of long holds"])
def test_an_interrupted_program_ends_by_keyboard_interrupt(name):
    interrupt_program(*PROGRAMS[name])


def test_an_interrupted_search_says_how_to_go_on(tmp_path):
    process = start(command("search", tmp_path))
    wait_for("evaluations.json", tmp_path, process)
    again = go_on(interrupt(process))
    assert again == command("search", tmp_path)[2:]
    assert json.loads((tmp_path / "evaluations.json").read_text(encoding="utf-8"))["evaluations"]


@pytest.mark.parametrize(
    ("name", "kept", "expected"),
    [
        ("train", None, "stickslip train --output 'a run'"),
        ("train", "configuration.yml", "stickslip train --output 'a run' --resume"),
        ("bench", None, "stickslip bench --output 'a run'"),
        ("bench", "finished", "stickslip bench --output 'a run' --resume"),
        ("search", None, "stickslip search --output 'a run'"),
        ("demo", None, "stickslip demo --output 'a run'"),
        ("trade", None, "stickslip trade --output 'a run'"),
        ("speed", None, None),
        ("evaluate", None, None),
    ],
)
def test_the_way_on_is_a_command(tmp_path, monkeypatch, name, kept, expected):
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "a run"
    folder.mkdir()
    if kept:
        (folder / kept).touch()
    command = typer.main.get_command(app).commands[name]
    assert command.way_on(folder, [name, "--output", "a run"]) == expected
    if kept:
        assert command.way_on(folder, [name, "--output", "a run", "--resume"]) == expected


@pytest.mark.parametrize(
    ("module", "limit", "compute"),
    [
        (chaos, "_STEPS_OF_A_CALL", lambda: lorenz(20, transient=3.0, step=0.1)),
        (echo_state, "_PRODUCTS_OF_A_CALL", lambda: EchoStateNetwork(5).states(np.linspace(0.0, 1.0, 30))),
    ],
    ids=["Lorenz", "echo state"],
)
def test_more_calls_of_compiled_code_change_no_bit(monkeypatch, module, limit, compute):
    whole = compute()
    monkeypatch.setattr(module, limit, 2)
    np.testing.assert_array_equal(compute(), whole)


@pytest.mark.slow
@pytest.mark.parametrize("attempt", range(4))
@pytest.mark.parametrize("name", PROGRAMS)
def test_a_program_interrupted_at_any_moment(name, attempt):
    interrupt_program(*PROGRAMS[name])


@pytest.mark.slow
@pytest.mark.parametrize("attempt", range(4))
@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_interrupted_at_any_moment(tmp_path, name, attempt):
    process = start(command(name, tmp_path))
    time.sleep(random.uniform(1.0, 12.0))
    interrupt(process, all_of_them=attempt % 2 == 1)
    for file in tmp_path.rglob("[!.]*.json"):
        json.loads(file.read_text(encoding="utf-8"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "first", "shorter"),
    [
        ("search", "evaluations.json", {"--evaluations": "40", "--length": "1000"}),
        (
            "bench",
            "finished/[!.]*-*.json",
            {"--seeds": "1", "--length": "1500", "--tasks": "memory capacity"},
        ),
        ("train", "checkpoints/[!.]*.zip", {"--steps": "60000"}),
        ("demo", "trade/cells/[!.]*-*.json", {"--steps": "60000"}),
        ("trade", "cells/[!.]*-*.json", {"--steps": "20000", "--weights": "0,0.2"}),
    ],
)
def test_the_way_on_ends_what_was_begun(tmp_path, monkeypatch, name, first, shorter):
    options = dict(zip(COMMANDS[name][::2], COMMANDS[name][1::2], strict=True)) | shorter
    monkeypatch.setitem(COMMANDS, name, [part for option in options.items() for part in option])
    process = start(command(name, tmp_path))
    wait_for(first, tmp_path, process)
    kept = {file: file.read_bytes() for file in tmp_path.glob(first)}
    again = start(["-c", MAIN, *go_on(interrupt(process))])
    printed, said = again.communicate(timeout=600)
    assert again.returncode == 0, said
    assert printed
    if name in ("bench", "train", "demo", "trade"):
        assert kept == {file: file.read_bytes() for file in kept}  # finished once
