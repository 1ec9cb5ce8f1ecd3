"""Checks of physics: what rods at rest and in motion have to agree with, by the exact solutions of `..references`.

Each is a function of the solver's name that returns metrics.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...scene.model import PoseKey
from ...simulate import solver_of
from ..axes import Request
from ..exactness import Exactness
from ..references import beam, chain
from ..references.base import G
from ..references.exact.elastica import hang
from .strand import STEPS, Metrics, NotRepresented, only, prepared, rest, stepped

MASSLESS = "its particles have neither mass nor velocity"
UNPHYSICAL = "its stiffness is a number a step, not a rigidity"


@cache
def droop(gamma: str, segments: int) -> float:
    """Height over width of a level rod's rest, over that of the elastica, less one."""
    tip = rest(*prepared("rod", gamma=float(gamma), n=segments, drag=2.0))[-1]
    return float(-tip[1] / tip[0] / hang(float(gamma)).droop - 1)


STILL = 96
"""Steps for which a sag-free start is watched."""


def check_droop(solver: str, *, gamma: str) -> Metrics:
    """Nine segments against the elastica."""
    only(solver, "rod", UNPHYSICAL)
    return {"droop_10" if gamma == "10" else "droop_soft": abs(droop(gamma, 9))}


def check_order(solver: str, *, gamma: str) -> Metrics:
    """Order in the number of segments, from 9 to 18."""
    only(solver, "rod", UNPHYSICAL)
    return {"droop_order": float(np.log2(abs(droop(gamma, 9) / droop(gamma, 18))))}


def check_buckling(solver: str, *, gamma: str, dt: str) -> Metrics:
    """A column that leans by a hundred thousandth: below Γ = 7.83735 it stands, above it does not."""
    only(solver, "rod", UNPHYSICAL)
    scene, groom = prepared(solver, gamma=float(gamma), n=20, way=(1e-5, 1.0, 0.0), drag=0.5)
    tip = rest(scene, groom, STEPS[dt], max(400, round(50 / STEPS[dt])))[-1]
    return {"upright" if gamma == "7.7" else "tilted": float(np.hypot(tip[0], tip[2]))}


def check_energy(solver: str, *, B: str, dt: str) -> Metrics:
    """A level rod let go without any damping: the most energy that it ever gains, over m g L."""
    only(solver, "rod", MASSLESS)
    scene, groom = prepared(solver, B=float(B))
    rod: Any = solver_of(scene)(scene, groom)
    pull, most = 10 * (float(B) or 1.0), 0.0
    for step in range(240):
        rod.step((step + 1) * STEPS[dt], STEPS[dt])
        most = max(most, energy(rod, pull))
    return {"energy_growth": most / pull}


def energy(rod: Any, pull: float) -> float:
    """Kinetic, bending and potential energy over ρ A L of a straight rod of one metre clamped along +x: masses ℓ and
    half of it at the tip, joints of rigidity B / ℓ and twice that at the clamp. What it was at the start is none."""
    n = rod.state.edges.shape[1]
    e = np.asarray(rod.state.edges[0].reshape(n, 3, -1)[..., 0], np.float64)
    v = np.asarray(rod.state.velocity[0].reshape(n, 3, -1)[..., 0], np.float64)
    mass = np.append(np.ones(n - 1), 0.5) / n
    joint = np.append(2.0, np.ones(n - 1)) * n * rod.scene.rod.young
    bend = np.diff(np.vstack([[1.0, 0.0, 0.0], e]), axis=0)
    height = np.cumsum(e[:, 1]) / n
    return float((mass * (0.5 * (v**2).sum(1) + pull * height)).sum() + 0.5 * (joint * (bend**2).sum(1)).sum())


def check_swing(solver: str) -> Metrics:
    """A pendulum of one segment and two seconds, ten degrees aside, ten cycles at 60 Hz."""
    only(solver, "rod", MASSLESS)
    tilt = np.radians(10.0)
    way = (float(np.sin(tilt)), -float(np.cos(tilt)), 0.0)
    scene, groom = prepared(solver, gamma=np.pi**2, B=0.0, n=1, way=way)
    rod = solver_of(scene)(scene, groom)
    angle = [tilt]
    for step in range(1320):
        rod.step((step + 1) / 60, 1 / 60)
        tip = rod.particles()[0, -1]
        angle.append(float(np.arctan2(tip[0], -tip[1])))
    tops = crests(np.array(angle))
    return {"amplitude_kept": float((tops[-1] / tops[0]) ** (1 / (len(tops) - 1)))}


def crests(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Heights of the maxima of a sampled wave, by the parabola through three samples each."""
    a, b, c = values[:-2], values[1:-1], values[2:]
    top = (b > a) & (b >= c)
    a, b, c = a[top], b[top], c[top]
    return np.asarray(b + (a - c) ** 2 / (8 * (2 * b - a - c)))


def check_mode(solver: str, *, of: str) -> Metrics:
    """The first mode of a beam or a chain of nine segments, as `strandcli study` measures it: at 120 steps a
    swing, as 60 Hz are for the pendulum of two seconds (what BDF2 takes away grows with the cube of the step)."""
    only(solver, "rod", MASSLESS)
    swings = {"beam": beam.SLOWEST, "chain": math.sqrt(G) * chain.shapes().frequencies[0]}
    step = 2 * math.pi / swings[of] / 120
    knobs = {"solver": "rod", "emitter.particles": 10, "dt": step}
    loss = Exactness(Request(name=of)).measure(knobs).error["loss"]
    return {"amplitude_kept": np.nan if loss is None else 1 - loss}


def check_sag(solver: str, *, gamma: str, n: int, way: tuple[float, float, float], dt: str = "24Hz") -> Metrics:
    """A rod that was made to hang still as it was emitted: how far its first frame moves, how far it is away after a
    while, and after its root has turned by 30 degrees and back."""
    only(solver, "rod", "it has no rest shape to choose")
    scene, groom = prepared(solver, gamma=float(gamma), n=n, way=way, rest="sag_free", drag=2.0)
    step = STEPS[dt]
    one = solver_of(scene)(scene, groom)
    start = one.particles()[0].astype(np.float64)
    away = []
    for i in range(STILL if n <= 32 else STILL // 8):
        one.step((i + 1) * step, step)
        away.append(float(np.linalg.norm(one.particles()[0] - start, axis=1).max()))
    metrics = {"sag": away[0], "sag_later": max(away)}
    if n <= 32 and dt == "24Hz":
        keys = [(0.0, 0.0), (0.25, 30.0), (0.5, 0.0), (1e3, 0.0)]
        turned = tuple(PoseKey(time, (0.0, 0.0, 0.0), (0.0, 0.0, angle), "linear") for time, angle in keys)
        one = stepped(replace(scene, emitter=replace(scene.emitter, keys=turned)), groom, step, round(20 / step))
        metrics["sag_regained"] = float(np.linalg.norm(one.particles()[0] - start, axis=1).max())
    return metrics


def check_twist(solver: str) -> Metrics:
    """Torsion of the cross sections."""
    raise NotRepresented("twist is not part of the model")
