"""Checks that one extreme scene cannot make: physics with a reference, rest, energy, repetition.

Each is a function of the solver's name that returns metrics; the name it is listed under is what replays it.
`NotRepresented` says that the solver has no such thing, which is never a pass.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import runtime
from ...scene.model import RuleUse, Scene, SphereSolid
from ...simulate import solver_of
from ...simulate.rules import registry
from .axes import Case
from .scenes import Started, groom_of, scene_of, times_of

DROOP = {"0.1": 0.0124996, "1": 0.124562, "10": 1.06680}
"""Height over width of the heavy elastica clamped level: θ″ = −Γ (1 − s) cos θ, θ(0) = 0, θ′(1) = 0."""
MASSLESS = "its particles have neither mass nor velocity"
UNPHYSICAL = "its stiffness is a number a step, not a rigidity"

Metrics = dict[str, float]
Check = Callable[[str], Metrics]


class NotRepresented(Exception):
    """The solver has nothing that could be checked; the text says why."""


def prepared(
    solver: str, *, gamma: float = 10.0, B: float = 1.0, n: int = 10, way: tuple[float, float, float] = (1, 0, 0),
    **rod: Any,
) -> tuple[Scene, Started]:  # fmt: skip
    """One straight strand of a metre along ``way``, n segments, with changes to the rod's settings; the pull is
    gamma · B, or gamma where B is zero."""
    case = Case.of(solver)
    scene, groom = scene_of(case, times_of(case)), groom_of([case])
    unit = np.array([way], np.float64) / np.linalg.norm(way)
    groom = replace(groom, directions=unit.astype(np.float32), edges=np.repeat(unit[:, None], n, 1))
    emitter = replace(scene.emitter, particles=n + 1)
    return replace(
        scene, emitter=emitter, rules=pulled(scene.rules, gamma * (B or 1.0)), rod=replace(scene.rod, young=B, **rod)
    ), groom


def pulled(rules: tuple[RuleUse, ...], pull: float) -> tuple[RuleUse, ...]:
    """The same rules with another gravity."""
    gravity = registry()["gravity"].Parameters(acceleration=(0.0, -pull, 0.0))
    return tuple(replace(use, parameters=gravity) if use.name == "gravity" else use for use in rules)


def only(solver: str, which: str, why: str) -> None:
    """Raise `NotRepresented` for any other solver."""
    if solver != which:
        raise NotRepresented(why)


def stepped(scene: Scene, groom: Started, dt: float, steps: int) -> Any:
    """The solver after so many steps."""
    solver = solver_of(scene)(scene, groom)
    for step in range(steps):
        solver.step((step + 1) * dt, dt)
    return solver


def rest(scene: Scene, groom: Started, dt: float = 0.5, steps: int = 240) -> NDArray[np.float64]:
    """(particles, 3) of the first strand after so many steps, by default two minutes."""
    return np.asarray(stepped(scene, groom, dt, steps).particles()[0], np.float64)


def droop(gamma: str, segments: int) -> float:
    """Height over width of a level rod's rest, over that of the elastica, less one."""
    tip = rest(*prepared("rod", gamma=float(gamma), n=segments, drag=2.0))[-1]
    return float(-tip[1] / tip[0] / DROOP[gamma] - 1)


def check_droop(solver: str, *, gamma: str) -> Metrics:
    """Nine segments against the elastica."""
    only(solver, "rod", UNPHYSICAL)
    return {"droop_10" if gamma == "10" else "droop_soft": abs(droop(gamma, 9))}


def check_order(solver: str, *, gamma: str) -> Metrics:
    """Order in the number of segments, from 9 to 18."""
    only(solver, "rod", UNPHYSICAL)
    return {"droop_order": float(np.log2(abs(droop(gamma, 9) / droop(gamma, 18))))}


def check_buckling(solver: str, *, gamma: str, dt: float) -> Metrics:
    """A column that leans by a hundred thousandth: below Γ = 7.83735 it stands, above it does not."""
    only(solver, "rod", UNPHYSICAL)
    scene, groom = prepared(solver, gamma=float(gamma), n=20, way=(1e-5, 1.0, 0.0), drag=0.5)
    tip = rest(scene, groom, dt, max(400, round(50 / dt)))[-1]
    return {"upright" if gamma == "7.7" else "tilted": float(np.hypot(tip[0], tip[2]))}


def check_energy(solver: str, *, B: str, dt: float, integrator: str) -> Metrics:
    """A level rod let go without any damping: the most energy that it ever gains, over m g L."""
    only(solver, "rod", MASSLESS)
    scene, groom = prepared(solver, B=float(B), integrator=integrator)
    rod: Any = solver_of(scene)(scene, groom)
    pull = 10 * float(B)
    most = 0.0
    for step in range(240):
        rod.step((step + 1) * dt, dt)
        most = max(most, energy(rod, pull))
    return {"energy_growth": most / pull}


def energy(rod: Any, pull: float) -> float:
    """Kinetic, bending and potential energy over ρ A L of a straight rod of one metre clamped along +x: masses ℓ and
    half of it at the tip, joints of rigidity B / ℓ and twice that at the clamp. What it was at the start is none."""
    n = rod.edges.shape[1]
    e = np.asarray(rod.edges[0].reshape(n, 3, -1)[..., 0], np.float64)
    v = np.asarray(rod.velocity[0].reshape(n, 3, -1)[..., 0], np.float64)
    mass = np.append(np.ones(n - 1), 0.5) / n
    joint = np.append(2.0, np.ones(n - 1)) * n * rod.scene.rod.young
    bend = np.diff(np.vstack([[1.0, 0.0, 0.0], e]), axis=0)
    height = np.cumsum(e[:, 1]) / n
    return float((mass * (0.5 * (v**2).sum(1) + pull * height)).sum() + 0.5 * (joint * (bend**2).sum(1)).sum())


def check_swing(solver: str) -> Metrics:
    """A pendulum of one segment and two seconds, ten degrees aside, ten cycles at 60 Hz with BDF2."""
    only(solver, "rod", MASSLESS)
    tilt = np.radians(10.0)
    way = (float(np.sin(tilt)), -float(np.cos(tilt)), 0.0)
    scene, groom = prepared(solver, gamma=np.pi**2, B=0.0, n=1, way=way, integrator="bdf2")
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


def check_rest(solver: str, *, contact: bool) -> Metrics:
    """How far anything moves within a second, once it has come to rest; in contact, draped over a ball."""
    scene, groom = prepared(solver, gamma=100.0 if contact else 10.0, drag=2.0)
    if contact:
        touching = RuleUse("collision", registry()["collision"].Parameters(), "collision")
        rules = tuple(use for use in scene.rules if use.name != "collision")
        last = len(rules) - (solver == "thesis")  # the source's elasticity comes last
        scene = replace(
            scene, rules=(*rules[:last], touching, *rules[last:]),
            solids=(SphereSolid(radius=0.2, position=(0.5, -0.25, 0.0)),),
        )  # fmt: skip
    one = stepped(scene, groom, 1 / 60, 1800)
    seen = []
    for step in range(60):
        one.step(30 + (step + 1) / 60, 1 / 60)
        seen.append(one.particles()[0].astype(np.float64))
    motion = float(np.ptp(np.array(seen), axis=0).max())
    return {"rest_motion_contact" if contact else "rest_motion": motion}


def check_rate(solver: str) -> Metrics:
    """Where the tip rests at 24 and at 240 Hz."""
    scene, groom = prepared(solver, drag=2.0)
    tips = [rest(scene, groom, 1 / rate, 30 * rate)[-1] for rate in (24, 240)]
    return {"rest_24_240": float(np.linalg.norm(tips[0] - tips[1]))}


def check_substeps(solver: str) -> Metrics:
    """Rest at 24 frames a second with one substep and with eight."""
    scene, groom = prepared(solver, drag=2.0)
    found = []
    for substeps in (1, 8):
        one = replace(scene, time=replace(scene.time, fps=24.0, substeps=substeps))
        run = solver_of(one)(one, groom)
        run.advance(24 * 30)
        found.append(run.particles()[0].astype(np.float64))
    return {"rest_substeps": float(np.linalg.norm(found[0] - found[1], axis=1).max())}


def check_determinism(solver: str) -> Metrics:
    """A groom of several blocks, twice on one thread and once on all."""
    import numba

    case = Case.of(solver, {"strands": "700", "start": "random", "wind": "gale"})
    times = times_of(case)
    before = int(numba.get_num_threads())
    found = []
    try:
        for threads in (1, 1, None):
            runtime.start(threads)
            scene = scene_of(case, times)
            one = stepped(scene, groom_of([case]), 1 / 60, 12)
            found.append(np.array(one.positions).view(np.uint32))
    finally:
        runtime.start(before)
    return {"differences": float(max(np.count_nonzero(found[0] != other) for other in found[1:]))}


def check_sag(solver: str) -> Metrics:
    """A level rod that was made to hang still as it was emitted: how far its first frame moves."""
    only(solver, "rod", "it has no rest shape to choose")
    scene, groom = prepared(solver, gamma=1.0, rest="sag_free")
    one = solver_of(scene)(scene, groom)
    before = one.particles()[0].astype(np.float64)
    one.step(1 / 24, 1 / 24)
    return {"sag": float(np.linalg.norm(one.particles()[0] - before, axis=1).max())}


def check_double(solver: str) -> Metrics:
    """Lengths in the solver's own double precision: 32 segments in a gale."""
    only(solver, "rod", "it is single precision throughout")
    case = Case.of(solver, {"n": "32", "start": "random", "wind": "gale"})
    times = times_of(case)
    one = stepped(scene_of(case, times), groom_of([case]), 1 / 60, len(times))
    edges = one.edges[0].reshape(32, 3, -1)[..., 0]
    if edges.dtype != np.float64:
        raise NotRepresented(f"its state is {edges.dtype} at 32 segments")
    return {"stretch_double": float(np.abs(np.linalg.norm(edges, axis=1) - 1).max())}


def check_twist(solver: str) -> Metrics:
    """Torsion of the cross sections."""
    raise NotRepresented("twist is not part of the model")


CHECKS: dict[str, Check] = {
    **{f"check=droop/gamma={g}": partial(check_droop, gamma=g) for g in DROOP},
    **{f"check=order/gamma={g}": partial(check_order, gamma=g) for g in ("1", "10")},
    **{
        f"check=buckling/gamma={g}/dt={label}": partial(check_buckling, gamma=g, dt=dt)
        for g in ("7.7", "7.9")
        for label, dt in (("60Hz", 1 / 60), ("0.5", 0.5))
    },
    **{
        f"check=energy/B={B}/dt={label}/integrator={kind}": partial(check_energy, B=B, dt=dt, integrator=kind)
        for B in ("1e-2", "1", "1e2")
        for label, dt in (("240Hz", 1 / 240), ("60Hz", 1 / 60), ("0.5", 0.5))
        for kind in ("euler", "bdf2")
    },
    "check=swing/integrator=bdf2": check_swing,
    "check=rest": partial(check_rest, contact=False),
    "check=rest/contact": partial(check_rest, contact=True),
    "check=rate": check_rate,
    "check=substeps": check_substeps,
    "check=determinism": check_determinism,
    "check=sag-free": check_sag,
    "check=lengths/precision=double": check_double,
    "check=twist": check_twist,
}
"""By the name that follows the solver's."""

QUICK = ("check=droop/gamma=1", "check=buckling/gamma=7.7/dt=60Hz", "check=rest", "check=determinism", "check=twist")
"""Those that need no kernel of their own."""
