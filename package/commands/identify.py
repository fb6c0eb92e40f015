"""``stickslip identify``."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, TYPE_CHECKING

from ..common.extras import optional_import
from .options import actuator_of, groups_of, json_object, number_or_text, SceneOption
from .printing import print_table, say, write_json

with optional_import():
    import typer

if TYPE_CHECKING:
    from ..studies.identification import Identification
    from ..studies.identification.log import Log

__all__ = ["identify"]

# What a log tells of a body that has been weighed, and whose bore and pressure are known.
_OF_AN_ACTUATOR = (
    "stiffness",
    "cubic_stiffness",
    "damping",
    "lag",
    "radial_coupling",
    "static_friction",
    "kinetic_friction",
)


def identify(
    logs: Annotated[
        list[Path],
        typer.Argument(
            help="CSV files, a run each, with columns time, valve (0 or 1) and one at least of deformation, velocity, "
            "pressure, foot, foot_velocity and payload: all in natural units, or each with its own, as in time_s, "
            "foot_mm, pressure_kPa. An empty cell is a gap."
        ),
    ],
    free: Annotated[
        str | None,
        typer.Option(help="What to find, such as 'duffing,deborah': all groups; of --actuator what is not weighed."),
    ] = None,
    guess: Annotated[
        str | None, typer.Option(help="Groups to look about: a preset's name, or JSON such as '{\"duffing\": 2}'.")
    ] = None,
    actuator: Annotated[
        str | None, typer.Option(help="The body to look about, as JSON in SI units, or 'ecoflex': for logs in SI.")
    ] = None,
    scene: SceneOption = "{}",
    hold: Annotated[
        str | None,
        typer.Option(
            help="Length of a hold, in the log's unit of time or such as '20 ms'; found from the valve's turns."
        ),
    ] = None,
    level: Annotated[float, typer.Option(help="Of the intervals, 0 to 1.")] = 0.95,
    design: Annotated[
        int | None,
        typer.Option(help="Holds of a next run: the word is told that would tell most about what is known least."),
    ] = None,
    output: Annotated[Path, typer.Option(help="Folder of identification.json and the figures.")] = Path(
        "runs/identification"
    ),
) -> None:
    """Find a body from logs of how it moved: groups or SI parameters with intervals, and what the logs cannot tell."""
    from ..common.figures import save_figure
    from ..common.validation import number_within, whole_number
    from ..crawler import Actuator
    from ..studies.identification import identify as find
    from ..studies.identification.log import read_log

    if guess is not None and actuator is not None:
        raise ValueError("--guess is of groups and --actuator of a body in SI: one of them must be given, not both")
    number_within("--level", level, "(0, 1)")
    if design is not None:
        whole_number("--design", design, 1, 1000)
    body = actuator_of(actuator) if actuator is not None else None if guess is None else groups_of(guess, "--guess")
    names = None if free is None else [name.strip() for name in free.split(",")]
    if names is None and isinstance(body, Actuator):
        names = list(_OF_AN_ACTUATOR)
    ground = json_object("--scene", scene)
    read = [read_log(log, None if hold is None else number_or_text(hold), body) for log in logs]
    for log, each in zip(logs, read, strict=True):
        _check_units(log, each, isinstance(body, Actuator))
    found = find([each.run for each in read], free=names, guess=body, scene=ground)
    _print(found, read, level)
    told = found.to_dict(level) | {"logs": [str(log) for log in logs], "holds": [each.run.hold for each in read]}
    told["hold_bounds"] = [each.hold_bounds for each in read]
    if design is not None:
        following = found.next_word(design)
        told["design"] = asdict(following)
        now, then, random = (
            f"{100.0 * each[following.aim]:.2g}%" for each in (following.known, following.errors, following.random)
        )
        say(
            f"Least is known of {following.aim}, to {now} by its standard error. A run of {following.word} would leave "
            f"{then}, a random word {random}."
        )

    output.mkdir(parents=True, exist_ok=True)
    write_json(output / "identification.json", told, indent=2)
    for i in range(len(read)):
        name = "fit" if len(read) == 1 else f"fit-{i + 1}"
        save_figure(found.plot(i), *(output / f"{name}.{form}" for form in ("png", "svg")))
    say(f"identification.json and figures of the fit in {output}")


def _check_units(log: Path, read: "Log", si: bool) -> None:
    """Refuse a log in other units than those of the guess."""
    if read.si and not si:
        raise ValueError(f"--actuator must say about which body to look, since {log} is in SI units")
    if si and not read.si:
        raise ValueError(f"--actuator is for logs in SI units, and {log} is in natural ones: --guess is for these")


def _print(found: "Identification", read: list["Log"], level: float) -> None:
    for each in read:
        run = each.run
        unit = "s" if each.si else "natural units of time"
        channels = ", ".join(name.replace("_", " ") for name in run.measured)
        say(f"{run.valve.size} holds of {run.hold:.6g} {unit}, {run.times.size} samples of {channels}")
        if each.hold_bounds is not None:
            low, high = each.hold_bounds
            say(f"the valve's turns let a hold be {low:.6g} to {high:.6g}; --hold says it exactly")
        if each.ignored:
            say(f"no channel, and not used: {', '.join(each.ignored)}")
    rows = [["", "found", f"{100.0 * level:g}% interval", ""]]
    for name, (low, high) in found.interval(level).items():
        value = getattr(found.body, name)
        wide = f"± {50.0 * (high - low) / abs(value):.2g}%" if value else ""
        rows.append([name, f"{value:.5g}", f"{low:.5g} to {high:.5g}", wide])
    print_table(f"From {found.samples} numbers", rows)
    if read[0].si:
        groups = ", ".join(f"{name} {value:.4g}" for name, value in found.groups.to_dict().items())
        say(f"In groups: {groups}")
    say(*(f"warning: {sentence}" for sentence in found.warnings))
