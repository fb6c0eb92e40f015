"""Where on the ground chaos does exist, and what memory does there."""

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binomtest

from ...crawler import Groups, lyapunov_spectrum, simulate
from ...reservoir import memory_capacity
from ...tasks import body_states, dithered, innovation
from ..maps.edge import best_cell, chaotic, difference
from .study import DEBORAH, READ, Study
from .wording import at, exponent_at, said, Told

__all__ = ["chaos_on_the_ground", "chaotic_words"]


def chaos_on_the_ground(study: Study) -> Told:
    """Low damping and strong stiffening under fair bits."""
    x = ("duffing", np.geomspace(100.0, 2000.0, study.size.ground))
    y = ("deborah", np.geomspace(*DEBORAH, study.size.rows))
    common = {"groups": {"damping_ratio": 0.002}, "hold": 0.5}
    exponents = study.map("low damping exponents", x, y, measures=["lyapunov", "start"], virtual_nodes=1, **common)
    rows, told = (
        [
            [
                "read",
                "chaotic cells",
                "largest λ",
                "most memory",
                "at",
                "λ there",
                "most of a chaotic cell",
                "most less chaotic",
            ]
        ],
        {},
    )
    for read, nodes in READ.items():
        found = study.map(f"low damping {read}", x, y, measures=["memory", "parity"], virtual_nodes=nodes, **common)
        found = found.merge(exponents.drop_vars("status"))
        where = chaotic(found.lyapunov.values)
        best, inside = best_cell(found.memory.values), best_cell(found.memory.values, where)
        top = best_cell(found.lyapunov.values, least=None)
        assert best is not None
        assert top is not None
        row = [
            read,
            f"{where.sum()} of {where.size}",
            said(top.estimate, 3),
            said(best.estimate),
            at(found, best),
            said(exponent_at(found, best.cell), 3),
        ]
        row += ["", ""] if inside is None else [said(inside.estimate), said(difference(best, inside))]
        rows.append(row)
        told[read] = {"chaotic": int(where.sum()), "cells": where.size, "largest": top.estimate.mean}
    return rows, told


def chaotic_words(study: Study) -> Told:
    """Short periodic words on the ground, bodies at random, friction as ever: how many move chaotically."""
    random = np.random.default_rng(0)
    tries, holds, washout = study.size.words, study.size.holds, study.size.holds // 2
    bodies = [
        Groups(
            duffing=float(random.uniform(0.0, 200.0)),
            deborah=float(np.exp(random.uniform(*np.log(DEBORAH)))),
            damping_ratio=float(random.choice([0.02, 0.05])),
        )
        for _ in range(tries)
    ]
    lengths = np.exp(random.uniform(np.log(0.5), np.log(4.0), tries))
    words = ["".join(map(str, random.integers(0, 2, random.integers(2, 9)))) for _ in range(tries)]
    commands = np.array([np.resize([int(bit) for bit in word], holds) for word in words])
    found = lyapunov_spectrum(bodies, commands, lengths, washout=washout, tolerance=1e-7)
    first, error = found.exponents[:, 0], found.standard_error[:, 0]
    where = np.flatnonzero((first > 3.0 * error) & (first > 1e-3))
    low, high = binomtest(len(where), tries).proportion_ci(method="wilson")
    flipped = np.array([dithered(command, 0.1, 0) for command in commands])
    under_flips = lyapunov_spectrum(bodies, flipped, lengths, washout=washout, tolerance=1e-6).exponents[:, 0]
    states = body_states(simulate(bodies, flipped, lengths, tolerance=1e-6, samples_per_hold=4))
    each = zip(states, flipped, commands, strict=True)
    memory = np.array([memory_capacity(x, innovation(valve, command, 0.1), 20).corrected for x, valve, command in each])
    rows = [["word", "hold", "Π₁", "Π₂", "Π₄", "λ", "λ under flips", "memory of the flips"]]
    for i in sorted(where.tolist(), key=lambda i: -first[i])[:8]:
        body = bodies[i]
        row = [words[i], f"{lengths[i]:.2f}", f"{body.duffing:.0f}", f"{body.damping_ratio:g}", f"{body.deborah:.2f}"]
        rows.append([*row, f"{first[i]:.3f} ± {error[i]:.3f}", f"{under_flips[i]:.3f}", f"{memory[i]:.2f}"])
    calm = np.setdiff1d(np.arange(tries), where)
    rows.append(
        [
            f"median of the {len(calm)} that are not chaotic",
            "",
            "",
            "",
            "",
            f"{np.median(first[calm]):.3f}",
            f"{np.median(under_flips[calm]):.3f}",
            f"{np.median(memory[calm]):.2f}",
        ]
    )
    told = {"tries": tries, "chaotic": len(where), "share": [len(where) / tries, low, high]}
    told |= {
        "largest": float(first.max()),
        "memory of chaotic": median_of(memory[where]),
        "memory of others": median_of(memory[calm]),
    }
    told |= {"chaotic under flips": int((under_flips[where] > 0.0).sum())}
    return rows, told


def median_of(values: NDArray[np.float64]) -> float | None:
    return float(np.median(values)) if len(values) else None
