#!/usr/bin/env python3
"""A strand that is clamped level and sags to rest, by PyElastica and by strandcli's rods: time at equal tip error.

    pip install pyelastica
    python examples/against_pyelastica.py

Both get the same weight, Γ = ρ A g L³ / B, the same drag and the same seconds to come to rest in; errors are distances
from the tip of the exact elastica, as shares of the length. PyElastica solves more than that: twist, shear and stretch.
In a thin strand these are what costs, because its steps have to follow shear waves across a radius: they go with the
square of the radius over the length, and hair is thirty times thinner than the rod here.

PyElastica gets what does it most good: a thick rod, the longest step of a series at which it is stable, many rods in
one simulator, and a clamp half an element behind the root, which makes it second order in the elements (with its usual
clamp, `--usual-clamp`, the rod is half an element too short). Each solver runs on one thread.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from strandcli.compiling import runtime
from strandcli.scene import loads
from strandcli.simulate import solver_of
from strandcli.simulate.rules import registry
from strandcli.study.references.base import DENSITY, G, groom, preset
from strandcli.study.references.elastica import hang

DRAG, SPAN = 8.0, 3.0
"""1/s, near the critical damping of the slowest swing; seconds, after which the tip is within 1e-4 L of its rest."""
ELEMENTS = (5, 10, 20)
STEPS = (1.0, 0.75, 0.5, 0.35, 0.25)
"""Of PyElastica, seconds for a rod as thick as long: they go with the square of its radius."""
SEGMENTS = (4, 6, 8, 10, 12, 14, 16, 18, 20, 32)
RATE = 24
"""Of strandcli, steps a second: where a strand rests does not depend on it."""


@dataclass
class Run:
    """One setting, measured."""

    solver: str
    pieces: int
    step: float
    strands: int
    error: float
    """Of the tip, as a share of the length."""
    seconds: float
    """A strand."""

    def row(self) -> str:
        """A line of the table."""
        step = f"1/{1 / self.step:.0f} s" if self.step > 2e-3 else f"{self.step:.1e} s"
        cost = f"{1e6 * self.seconds:,.1f} µs"
        return f"{self.solver:<12}{self.pieces:>8}{step:>12}{self.strands:>9,}{self.error:>12.1e}{cost:>16}"


def off(tip: Any, gamma: float) -> float:
    """Distance of a tip, for a root at the origin and a length of one, from its exact place."""
    out, down = hang(gamma).tip
    return float(np.linalg.norm(np.asarray(tip, np.float64) - (out, -down, 0.0)))


def of_strandcli(gamma: float, segments: int, strands: int) -> Run:
    """All strands at once; the best of three runs."""
    data = preset(G / gamma, strands, segments + 1, drag=DRAG)
    scene = loads(json.dumps({**data, "solver": "rod"}), rules=registry(), name="against PyElastica")
    straight = groom([[1, 0, 0]] * strands, [1.0] * strands)
    took = []
    for _ in range(3):
        solver = solver_of(scene)(scene, straight)
        solver.step(1 / RATE, 1 / RATE)  # compiles, and touches the memory
        began = time.perf_counter()
        for i in range(round(SPAN * RATE)):
            solver.step((i + 2) / RATE, 1 / RATE)
        took.append(time.perf_counter() - began)
    return Run("strandcli", segments, 1 / RATE, strands, off(solver.particles()[0, -1], gamma), min(took) / strands)


def of_pyelastica(elastica: Any, gamma: float, elements: int, step: float, rods: int, thick: float, usual: bool) -> Run:
    """All rods in one simulator."""

    class Simulator(elastica.BaseSystemCollection, elastica.Constraints, elastica.Forcing, elastica.Damping):  # type: ignore[misc,name-defined]
        pass

    size = 1 / elements if usual else 1 / (elements - 0.5)
    root = 0.0 if usual else -size / 2
    young = 4 * DENSITY * (G / gamma) / thick**2
    simulator, made = Simulator(), []
    for i in range(rods):
        rod = elastica.CosseratRod.straight_rod(
            elements, np.array([root, 0.0, 0.1 * i]), np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]),
            size * elements, thick, DENSITY, youngs_modulus=young,
        )  # fmt: skip
        simulator.append(rod)
        made.append(rod)
        held = {"constrained_position_idx": (0,), "constrained_director_idx": (0,)}
        simulator.constrain(rod).using(elastica.OneEndFixedBC, **held)
        simulator.add_forcing_to(rod).using(elastica.GravityForces, acc_gravity=np.array([0.0, -G, 0.0]))
        simulator.dampen(rod).using(elastica.AnalyticalLinearDamper, uniform_damping_constant=DRAG, time_step=step)
    simulator.finalize()
    stepper, now = elastica.PositionVerlet(), np.float64(0.0)
    for _ in range(3):
        now = stepper.step(simulator, now, step)  # compiles
    began = time.perf_counter()
    with np.errstate(all="ignore"):
        for _ in range(round(SPAN / step)):
            now = stepper.step(simulator, now, step)
    seconds = (time.perf_counter() - began) / rods
    return Run("PyElastica", elements, step, rods, off(made[0].position_collection[:, -1], gamma), seconds)


def settled(runs: list[Run]) -> Run | None:
    """The first of runs in ever smaller steps that agrees with the one after it: one that is not stable agrees with
    nothing."""
    for coarse, fine in pairwise(runs):
        if abs(coarse.error - fine.error) < 1e-4:
            return coarse
    return None


def main(arguments: list[str] | None = None) -> int:
    """Measure, and print a table and the comparison."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gamma", type=float, default=10.0, help="weight over rigidity (default 10)")
    parser.add_argument("--radius", type=float, default=0.01, help="of PyElastica's rod over its length (default 0.01)")
    parser.add_argument("--rods", type=int, default=16, help="rods in one simulator of PyElastica (default 16)")
    parser.add_argument("--strands", type=int, default=2560, help="strands of strandcli (default 2560)")
    parser.add_argument("--elements", type=int, nargs="+", default=ELEMENTS, help="of PyElastica (default 5 10 20)")
    parser.add_argument("--usual-clamp", action="store_true", help="clamp PyElastica's first element where it begins")
    given = parser.parse_args(arguments)
    try:
        import elastica
    except ImportError:
        print("PyElastica is not installed here: pip install pyelastica", file=sys.stderr)
        return 1

    def theirs_at(elements: int, step: float, rods: int) -> Run:
        return of_pyelastica(elastica, given.gamma, elements, step, rods, given.radius, given.usual_clamp)

    runtime.start(1)
    print(f"{'':<12}{'pieces':>8}{'step':>12}{'strands':>9}{'tip error':>12}{'time a strand':>16}")
    ours = [of_strandcli(given.gamma, segments, given.strands) for segments in SEGMENTS]
    for one in ours:
        print(one.row(), flush=True)
    theirs = []
    for elements in given.elements:
        runs: list[Run] = []
        for step in STEPS:
            runs.append(theirs_at(elements, given.radius**2 * step, 1))
            if settled(runs):
                break
        best = settled(runs)
        if best is None:
            print(f"PyElastica{elements:>10}   is stable at none of the steps")
            continue
        many = theirs_at(elements, best.step, given.rods)
        best = min(best, many, key=lambda run: run.seconds)
        theirs.append(best)
        print(best.row(), flush=True)
    for one in theirs:
        fit = min((run for run in ours if run.error <= one.error), key=lambda run: run.seconds, default=None)
        if fit is None:
            print(f"tip error {one.error:.1e}: none of strandcli's settings is as right")
        else:
            print(
                f"tip error at most {one.error:.1e}: PyElastica {1e3 * one.seconds:,.0f} ms a strand, strandcli "
                f"{1e6 * fit.seconds:,.1f} µs ({fit.pieces} segments, 1/{1 / fit.step:.0f} s): "
                f"{one.seconds / fit.seconds:,.0f} times less"
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
