"""What a tube of Ecoflex 00-30 pushes with, against the paper's cubic body: `python benchmarks/materials.py`.

It writes the tables of `docs/materials.md`: the lumped body nearest to the tube by threads and peak pressure, how far
its force is off, and how far the tube may be stretched for that to be 5% of the largest force.
"""

import math
from pathlib import Path

from measuring import refresh

from stickslip.crawler.model.elastomer import ECOFLEX_00_30, Yeoh
from stickslip.crawler.model.tube_force import Tube

PAGE = Path(__file__).parent.parent / "docs" / "materials.md"
# The tube of `Actuator.ecoflex`.
LENGTH, BORE, WALL = 0.125, 1.0e-4, 1.14e-4
INNER, OUTER = math.sqrt(BORE / math.pi), math.sqrt((BORE + WALL) / math.pi)
PRESSURES = (2e3, 5e3, 10e3, 20e3)
MATERIALS = {"Ecoflex 00-30": ECOFLEX_00_30, "neo-Hookean": Yeoh.neo_hookean(ECOFLEX_00_30.youngs_modulus)}


def tube(material: Yeoh, thread_radius: float | None) -> Tube:
    """The tube of `Actuator.ecoflex`, of a material, with threads at a radius."""
    return Tube(material=material, outer_radius=OUTER, inner_radius=INNER, length=LENGTH, thread_radius=thread_radius)


def bodies() -> str:
    """A row for each material, radius of the threads and peak pressure."""
    lines = [
        "| material | threads | P_max, kPa | held at z, mm (of L_0) | k_1, N/m | k_3 z_c²/k_1 | A, cm² | alpha z_c | "
        "error | within 5% up to z, mm (of L_0) |",
        "|---|---|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for name, material in MATERIALS.items():
        for where, radius in (("at the bore", INNER), ("outside", OUTER)):
            here = tube(material, radius)
            for pressure in PRESSURES:
                held = here.deformation_at(pressure)
                body = here.lumped((0.0, held), pressure)
                unit = pressure * body.pressure_area / body.stiffness
                reach = here.reach(pressure)
                lines.append(
                    f"| {name} | {where} | {pressure / 1e3:.0f} | {_length(held)} | {body.stiffness:.1f} | "
                    f"{body.cubic_stiffness * unit**2 / body.stiffness:.3f} | {body.pressure_area * 1e4:.3f} | "
                    f"{body.radial_coupling * unit:.3f} | {body.error:.1%} | {_length(reach)} |"
                )
    return "\n".join(lines)


def rest() -> str:
    """What small deformations and pressures do, threads or none."""
    lines = [
        "| threads | stiffness at rest, N/m | of E A_w / L_0 | push of 100 Pa, mN | on an area, cm² |",
        "|---|---:|---:|---:|---:|",
    ]
    simple = ECOFLEX_00_30.youngs_modulus * WALL / LENGTH
    for where, radius in (("none", None), ("at the bore", INNER), ("outside", OUTER)):
        here = tube(ECOFLEX_00_30, radius)
        # Under a pressure that keeps the threads taut at either deformation.
        far, load = 1e-6, 0.0 if radius is None else 100.0
        ends = here.force([-far, far], load)
        stiffness, push = float(ends[0] - ends[1]) / (2.0 * far), float(here.force(0.0, 100.0))
        area = push / 100.0 * 1e4
        lines.append(f"| {where} | {stiffness:.1f} | {stiffness / simple:.3f} | {push * 1e3:.4f} | {area:.4f} |")
    return "\n".join(lines)


def _length(z: float) -> str:
    return f"{z * 1e3:.1f} ({z / LENGTH:.1%})"


def main() -> None:
    """Print the tables and write them into the page."""
    made = {"rest": rest(), "bodies": bodies()}
    print("\n\n".join(made.values()))
    refresh(PAGE, made)


if __name__ == "__main__":
    main()
