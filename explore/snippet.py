"""A setup as a program that makes the same numbers."""

from collections.abc import Sequence
from dataclasses import fields

from ..crawler import Groups, Scene
from .driving import environment_kwargs, SEED, takes_weight
from .measures import DELAYS, LONG, NODES, WASHOUT
from .motion import samples_of, shown_holds
from .setup import Setup
from .units import actuator_with

__all__ = ["program_of"]


def program_of(setup: Setup, bits: Sequence[int] = ()) -> str:
    """Python that reproduces what a page shows.

    Parameters
    ----------
    setup : Setup
    bits : sequence of 0 and 1
        What the valve was told at the space bar, if the setup is live.

    Returns
    -------
    str
        A program that imports `stickslip` and leaves ``motion``, a `Trajectory` in the units of the setup, and, unless
        the setup is live, ``speed``, ``memory`` (a `MemoryCapacity`; not without flips) and ``spectrum``.
    """
    live = setup.drive == "live"
    parts = [_imports(setup), _body(setup), _valve_live(bits) if live else _valve(setup), _motion(setup)]
    if not live:
        parts.append(_measures(setup))
    return "\n\n".join(parts) + "\n"


def _imports(setup: Setup) -> str:
    names = {"Groups", "Scene", "simulate"} | ({"Actuator"} if setup.units == "SI" else set())
    lines = []
    if setup.drive != "live":
        names |= {"lyapunov_spectrum"} | ({"memory_capacity"} if setup.dither else set())
        if setup.drive == "policy":
            names |= {"pretrained"}
            lines.append("from stickslip.envs import StickSlipCrawlerEnv")
        if setup.dither:
            lines.append("from stickslip.tasks import body_states, innovation")
        if setup.drive == "policy":
            lines.append("from stickslip.train.evaluation import roll_out")
        else:
            lines.append("from stickslip.train.schedules import repeat")
    return "\n".join([f"from stickslip import {', '.join(sorted(names, key=str.lower))}", *lines])


def _body(setup: Setup) -> str:
    usual = Groups().to_dict()
    groups = [f"{name}={value!r}" for name, value in setup.groups.to_dict().items() if value != usual[name]]
    lines = [f"groups = Groups({', '.join(groups)})"]
    if setup.units == "SI":
        body = actuator_with(setup.groups)
        parts = ", ".join(
            f"{each.name}={getattr(body, each.name)!r}" for each in fields(body) if each.name != "segments"
        )
        lines.append(f"actuator = Actuator({parts})")
    plain = Scene().to_dict()
    ground = [f"{name}={value!r}" for name, value in setup.scene.to_dict().items() if value != plain[name]]
    lines += [
        f"scene = Scene({', '.join(ground)})",
        f"hold, tolerance = {setup.hold!r}, {setup.tolerance!r}",
    ]
    return "\n".join(lines)


def _valve(setup: Setup) -> str:
    if setup.drive == "word":
        return "\n".join(
            [
                "# The word, each bit flipped with a probability.",
                f"dither = {setup.dither!r}",
                f'command, valve = repeat("{setup.word}", {LONG}, dither=dither, seed={SEED})',
            ]
        )
    kwargs = environment_kwargs(setup)
    at = f".at({setup.weight!r})" if takes_weight(setup.policy) else ""
    return "\n".join(
        [
            "# The policy in its environment, each command flipped with a probability.",
            f"dither = {setup.dither!r}",
            f'policy = pretrained("{setup.policy}"){at}',
            "environment = StickSlipCrawlerEnv(",
            "    groups=groups,",
            "    scene=scene,",
            "    hold=hold,",
            "    tolerance=tolerance,",
            "    dither=dither,",
            f"    memory_weight={kwargs['memory_weight']!r},",
            f"    valve_history={kwargs['valve_history']!r},",
            ")",
            f"command, valve = roll_out(policy, environment, {LONG}, {SEED})",
        ]
    )


def _valve_live(bits: Sequence[int]) -> str:
    return (
        f'# What the space bar told the valve, hold by hold.\nvalve = [int(bit) for bit in "{"".join(map(str, bits))}"]'
    )


def _motion(setup: Setup) -> str:
    part = "" if setup.drive == "live" else f"[:{shown_holds(setup.hold)}]"
    lines = [
        "# The motion that is drawn.",
        "motion = simulate(",
        f"    groups, valve{part}, hold, scene=scene, tolerance=tolerance, samples_per_hold={samples_of(setup.hold)}",
        ")",
    ]
    if setup.units == "SI":
        lines.append("motion = motion.in_si(actuator)")
    return "\n".join([*lines, "print(motion)"])


def _measures(setup: Setup) -> str:
    lines = [
        "# Speed, memory and exponents, of a long run.",
        f"long = simulate(groups, valve, hold, scene=scene, tolerance=tolerance, samples_per_hold={NODES})",
        "speed = long.foot[-1] / (len(valve) * hold)",
        'print(f"speed {speed:.3f} z_c / t_c")',
    ]
    if setup.dither:
        lines += [
            "memory = memory_capacity(",
            f"    body_states(long), innovation(valve, command, dither), {DELAYS}, washout={WASHOUT}",
            ")",
            'print(f"memory capacity {memory.corrected:.2f}")',
        ]
    lines += [
        "spectrum = lyapunov_spectrum(",
        f"    groups, valve, hold, scene=scene, tolerance=tolerance, washout={WASHOUT}",
        ")",
        'print(f"first exponent {spectrum.exponents[0]:.4f} / t_c, {spectrum.verdict}")',
    ]
    return "\n".join(lines)
