"""``stickslip run``."""

import math
import runpy
from pathlib import Path
from typing import Annotated, Any

from ..common.extras import optional_import
from ..common.validation import number_within, whole_number
from .options import actuator_of, number_or_text, policy_of, WeightOption
from .printing import say, write_json

with optional_import():
    import typer

__all__ = ["run_policy"]


def run_policy(
    policy: Annotated[
        str, typer.Argument(help="Folder of a run, a .safetensors, or the name of a pretrained policy, such as knee.")
    ],
    plant: Annotated[
        Path | None,
        typer.Option(
            help="A Python file with read(), which returns numbers such as {'deformation_mm': 4.1, 'foot_mm': 12}, and "
            "write(valve), which takes 0 or 1, or the volts. It is run."
        ),
    ] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="The simulator is the plant.")] = False,
    actuator: Annotated[str, typer.Option(help="The body, as JSON in SI units, or 'ecoflex'.")] = "ecoflex",
    hold: Annotated[
        str | None, typer.Option(help="Between two decisions, such as '20 ms' or '0.5 t_c'; the policy's own.")
    ] = None,
    holds: Annotated[int, typer.Option(help="How many.")] = 200,
    readings: Annotated[int, typer.Option(help="Of the sensors, in each hold.")] = 8,
    weight: WeightOption = None,
    dither: Annotated[
        float | None, typer.Option(help="Probability that a command is flipped, 0 to 0.5; the policy's own.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Of the flips.")] = 0,
    volts: Annotated[
        tuple[float, float] | None, typer.Option(help="Of the shut and of the open valve, if write takes them.")
    ] = None,
    pace: Annotated[
        float, typer.Option(help="Of a dry run, times real time; inf waits for nobody, and is the same every time.")
    ] = 1.0,
    log: Annotated[Path | None, typer.Option(help="CSV file of what was read; `stickslip identify` reads it.")] = None,
    report: Annotated[Path | None, typer.Option(help="JSON file of how well time was kept.")] = None,
) -> None:
    """Run a policy on a real valve at a fixed rate, or try it on the simulator first."""
    from ..crawler.model.holds import said_of_hold
    from ..robot import RealClock, Runner, SimulatedPlant, VirtualClock
    from ..robot.acting import other_groups

    if dry_run == (plant is not None):
        got = "both" if dry_run else "neither"
        raise ValueError(f"--dry-run or --plant must be given, and one of them alone, got {got}")
    if plant is not None and pace != 1.0:
        raise ValueError(f"--pace must be left out with --plant, whose time is real, got {pace:g}")
    if dry_run and volts is not None:
        raise ValueError(f"--volts must be left out with --dry-run, whose valve is 0 or 1, got {volts}")
    whole_number("--holds", holds, 1)
    number_within("--pace", pace, "(0, inf]")
    body, acting = actuator_of(actuator), policy_of(policy, weight)
    clock = VirtualClock() if math.isinf(pace) else RealClock(pace)
    if plant is None:
        simulated = SimulatedPlant(body, clock, scene=acting.env_kwargs.get("scene"))
        read, write = simulated.read, simulated.write
    else:
        read, write = _functions(plant)
    runner = Runner(
        acting,
        read,
        write,
        actuator=body,
        hold=None if hold is None else number_or_text(hold),
        readings=readings,
        dither=dither,
        seed=seed,
        volts=volts,
        clock=clock,
    )
    say(f"{acting!r}, {holds} holds of {said_of_hold(runner.hold / body.scales.time, body)}")
    for name, (trained, here) in other_groups(acting, body.groups.to_dict()).items():
        say(f"another body than that of the training: {name} {here:.4g} instead of {trained:.4g}")
    try:
        runner.run(holds, log=log)
    finally:
        for line in str(runner.report).splitlines():
            say(line)
        if report is not None:
            write_json(report, runner.report.to_dict(), indent=2)
    _say_how_far(runner.log.names, runner.log.rows)


def _functions(file: Path) -> tuple[Any, Any]:
    """``read`` and ``write`` of a Python file, which is run."""
    if not file.is_file():
        raise ValueError(f"--plant must be a Python file, {file} is no file")
    found = runpy.run_path(str(file), run_name="stickslip_plant")
    if missing := [name for name in ("read", "write") if not callable(found.get(name))]:
        raise ValueError(f"--plant must define read() and write(valve), {file} lacks {' and '.join(missing)}")
    return found["read"], found["write"]


def _say_how_far(names: tuple[str, ...], rows: Any) -> None:
    if "foot_mm" in names:
        time, foot = rows[-1, 0] - rows[0, 0], rows[-1, names.index("foot_mm")] - rows[0, names.index("foot_mm")]
        say(f"the foot went {foot:.4g} mm in {time:.4g} s, {foot / time:.4g} mm/s")
