"""The scratch array that the solvers work on: which row holds what."""

from ...compiling.roots import LARGEST_DEGREE

__all__ = [
    "CHANGES",
    "CORRECTION",
    "END_FORCE",
    "END_V",
    "END_Z",
    "FIRST",
    "FLATTEST",
    "FORCE",
    "HIGHEST",
    "LENGTH",
    "LOWEST",
    "ROWS",
    "SCRATCH",
    "STAGE_A",
    "STAGE_F",
    "STAGE_P",
    "STAGE_V",
    "STAGE_Z",
    "STEEPEST",
    "STEP",
    "VISCOUS",
    "WIDTH",
    "WORK",
    "P",
    "V",
    "Z",
]

# Polynomials of z, v, p and F in the time since the step's start, what else a step needs, and one row for events.
# Then, for a collocation, values of z, v, p, v' and F at the start and the nodes, and one row for its iteration. Last
# come the tangents: see `tangent` and `lyapunov`.
ROWS = 16
WIDTH = LARGEST_DEGREE + 2
CHANGES = 4
Z, V, P, FORCE, STEP, SCRATCH, STAGE_Z, STAGE_V, STAGE_P, STAGE_A, STAGE_F, CORRECTION = range(ROWS - CHANGES)
# Columns of the row STEP: its length; z, v and F at its end; the least and the greatest that the terms of the event
# function beyond the constant one can add up to, the first of these, and the least and the greatest slope times the
# length; and the step's energies.
LENGTH, END_Z, END_V, END_FORCE, LOWEST, HIGHEST, FIRST, STEEPEST, FLATTEST, WORK, VISCOUS = range(11)
