"""The crawlers at the edges of the ranges: what each is, and the stored reference of the stiff judge for it.

A row's `condition` is how many times a defect comes out magnified: the largest change of any sample per change of the
initial deformation or velocity, or of the internal force by a constant, in phase with the deformation, or with its
rate. Every row is held to ten times the tolerance all the same.
"""

import json
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

from stickslip.crawler import Groups, REST, Scene, State

__all__ = ["REFERENCES", "ROWS", "Row", "stored"]

REFERENCES = Path(__file__).with_name("extremes.json")
SYMMETRIC = Scene(ratchet=False)
# Linear, undamped and without pressure the force is -z.
BARE = {"duffing": 0.0, "damping_ratio": 0.0, "radial_coupling": 0.0}
LIGHT, HEAVY = 1e-6, 1.0 - 1e-6


@dataclass(frozen=True)
class Row:
    """Arguments of `simulate`, and the tolerances at which its answer is compared."""

    groups: Groups = field(default_factory=Groups)
    valve: str = "11110000"
    hold: float = 1.0
    scene: Scene = field(default_factory=Scene)
    initial: State = REST
    samples_per_hold: int = 2
    tolerances: tuple[float, ...] = (1e-6, 1e-9)

    @property
    def schedule(self) -> list[int]:
        return [int(letter) for letter in self.valve]

    @property
    def options(self) -> dict:
        """Keyword arguments of `simulate` and of the judges."""
        return {"scene": self.scene, "initial": self.initial, "samples_per_hold": self.samples_per_hold}

    def inputs(self) -> dict:
        """All that the reference depends on, ready for JSON; its floats are read back bit for bit."""
        return {
            "groups": self.groups.to_dict(),
            "valve": self.valve,
            "hold": self.hold,
            "scene": {name: value for name, value in asdict(self.scene).items() if value != getattr(Scene(), name)},
            "initial": list(self.initial),
            "samples_per_hold": self.samples_per_hold,
        }


def _with(**groups) -> Row:
    return Row(Groups(**groups))


def _rubbing(static, kinetic, **groups) -> Groups:
    return Groups(static_friction=static, kinetic_friction=kinetic, **groups)


def _graze(miss) -> Row:
    # From z = -amplitude at rest the pull is greatest, and equal to the amplitude, half a period later.
    groups = _rubbing(0.4, 0.2, **BARE)
    return Row(groups, "00", 3.0, initial=State(-(0.4 + miss)))


LINEAR = {"duffing": 0.0, "radial_coupling": 0.0}
FOUR_STIFF = {"duffing": 1e6, "damping_ratio": 1e4, "deborah": 1e-6, "foot_mass_fraction": LIGHT}
_SNAPPY = _rubbing(0.25, 0.25, deborah=1e-6, foot_mass_fraction=LIGHT, **BARE)

ROWS: dict[str, Row] = {
    "default": Row(),
    "Pi1 = 0": _with(duffing=0.0),
    "Pi1 = 1e2": _with(duffing=1e2),
    "Pi1 = 1e4": _with(duffing=1e4),
    "Pi1 = 1e6": _with(duffing=1e6),
    "Pi1 = 1e6, undamped": _with(duffing=1e6, damping_ratio=0.0),
    "Pi2 = 0": _with(damping_ratio=0.0),
    "Pi2 = 1": _with(damping_ratio=1.0),
    # A creeping body pulls the foot by little: only little friction lets it slip.
    "Pi2 = 1e2": Row(_rubbing(2e-3, 1e-3, damping_ratio=1e2)),
    "Pi2 = 1e4": Row(_rubbing(2e-5, 1e-5, damping_ratio=1e4)),
    "Pi2 = 1e4, default friction": _with(damping_ratio=1e4),
    "Pi4 = 1e-6": _with(deborah=1e-6),
    "Pi4 = 1e-3": _with(deborah=1e-3),
    "Pi4 = 1e3": replace(_with(deborah=1e3), initial=State(0.9, 0.0, 0.5)),
    "Pi4 = 1e6": replace(_with(deborah=1e6), initial=State(0.9, 0.0, 0.5)),
    "Pi5 = 0": _with(radial_coupling=0.0),
    "Pi5 = 2": _with(radial_coupling=2.0),
    "Pi5 = 5": _with(radial_coupling=5.0),
    "r = 1e-6": _with(foot_mass_fraction=LIGHT),
    "r = 1e-6, undamped": _with(foot_mass_fraction=LIGHT, damping_ratio=0.0),
    "r = 1 - 1e-6": _with(foot_mass_fraction=HEAVY),
    "r = 1 - 1e-6, undamped": Row(Groups(foot_mass_fraction=HEAVY, damping_ratio=1e-5, deborah=1e-3), hold=0.02),
    "no friction": Row(_rubbing(0.0, 0.0)),
    "equal frictions": Row(_rubbing(0.3, 0.3)),
    "equal frictions, both ways": Row(_rubbing(0.2, 0.2), scene=SYMMETRIC),
    "friction 1e3": Row(_rubbing(1e3, 8e2), initial=State(13.0)),
    "friction 1e3, both ways": Row(_rubbing(1e3, 1e3), initial=State(13.0), scene=SYMMETRIC),
    "friction 1e3, from rest": Row(_rubbing(1e3, 1e3)),
    "hold 1e-6": Row(valve="1100" * 10, hold=1e-6, initial=State(0.9)),
    "hold 1e4": Row(valve="110", hold=1e4),
    "hold 1e3, undamped": Row(Groups(damping_ratio=0.0), "1", 1e3, samples_per_hold=10),
    "four stiff": _with(**FOUR_STIFF),
    "four stiff, slippery": Row(_rubbing(0.01, 0.005, **FOUR_STIFF)),
    "at the threshold, falling": Row(_rubbing(0.25, 0.1, **BARE), initial=State(0.25, 0.1)),
    "at the threshold, rising": Row(_rubbing(0.25, 0.1, **BARE), "00", initial=State(0.25, -0.1)),
    "at the threshold, equal frictions": Row(_rubbing(0.25, 0.25, **BARE), initial=State(0.25, 0.1)),
    "graze missed by 1e-4": _graze(-1e-4),
    "graze met by 1e-4": _graze(1e-4),
    "graze missed by 1e-7": replace(_graze(-1e-7), tolerances=(1e-9,)),
    "graze met by 1e-7": replace(_graze(1e-7), tolerances=(1e-9,)),
    # A quick fluid and a light foot, which answers to a push of 1e-7 at once; equal frictions, F = -s at the start.
    "slip and stop within 1e-12": Row(_SNAPPY, "01111111", 2e-13, initial=State(1.25, pressure=1.0)),
    "stop and slip within 1e-12": Row(
        _SNAPPY, "10000000", 3e-13, initial=State(0.75, pressure=0.5, foot_velocity=1e-14)
    ),
    "linear": _with(**LINEAR),
    "linear, hold 1e4": Row(Groups(**LINEAR), "110", 1e4),
    "linear, four stiff": Row(_rubbing(0.01, 0.005, **FOUR_STIFF | LINEAR)),
    "linear, undamped, hold 1e3": Row(Groups(**BARE), "1", 1e3, samples_per_hold=10),
}


def stored() -> dict[str, dict]:
    """The stored references by the rows' names: inputs, samples, events, slips, clearance, condition."""
    return json.loads(REFERENCES.read_text(encoding="utf-8"))
