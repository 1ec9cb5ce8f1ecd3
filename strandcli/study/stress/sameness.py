"""Checks that nothing depends on what it should not: on time once at rest, on the step, on threads, on precision.

Each is a function of the solver's name that returns metrics.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ... import runtime
from ...scene.model import BoxSolid, RuleUse, Solid, SphereSolid
from ...simulate import solver_of
from ...simulate.rules import registry
from .axes import Case
from .scenes import groom_of, scene_of, times_of
from .strand import STEPS, Metrics, NotRepresented, only, prepared, rest, stepped

DRAPED: dict[str, Solid] = {
    "ball": SphereSolid(radius=0.2, position=(0.5, -0.25, 0.0)),
    "edge": BoxSolid(size=(0.4, 0.4, 0.4), position=(0.5, -0.4, 0.0)),
}
SINGLE = "it is single precision throughout"


def check_rest(solver: str, *, contact: str = "", dt: str = "60Hz", n: int = 10, double: bool = False) -> Metrics:
    """How far anything moves within a second, once it has come to rest; in contact, draped over a ball, or with whole
    segments over an edge of a box."""
    if double:
        only(solver, "rod", SINGLE)
    scene, groom = prepared(solver, gamma=100.0 if contact else 10.0, n=n, drag=2.0)
    if contact:
        touching = RuleUse("collision", registry()["collision"].Parameters(segments=contact == "edge"), "collision")
        rules = tuple(use for use in scene.rules if use.name != "collision")
        last = len(rules) - (solver == "thesis")  # the source's elasticity comes last
        scene = replace(
            scene, rules=(*rules[:last], touching, *rules[last:]),
            solids=(DRAPED[contact],),
        )  # fmt: skip
    step = STEPS[dt]
    one = stepped(scene, groom, step, round(30 / step), double)
    seen = []
    for i in range(round(1 / step)):
        one.step(30 + (i + 1) * step, step)
        seen.append(one.particles()[0].astype(np.float64))
    motion = float(np.ptp(np.array(seen), axis=0).max())
    return {"rest_motion_contact" if contact else "rest_motion": motion}


def check_rate(solver: str, *, gamma: float = 10.0, n: int = 10) -> Metrics:
    """Where the tip rests at 24 and at 240 Hz."""
    scene, groom = prepared(solver, gamma=gamma, n=n, drag=2.0)
    tips = [rest(scene, groom, 1 / rate, 30 * rate)[-1] for rate in (24, 240)]
    return {"rest_24_240": float(np.linalg.norm(tips[0] - tips[1]))}


def check_substeps(solver: str, *, n: int = 10) -> Metrics:
    """Rest at 24 frames a second with one substep and with eight."""
    scene, groom = prepared(solver, n=n, drag=2.0)
    found = []
    for substeps in (1, 8):
        one = replace(scene, time=replace(scene.time, fps=24.0, substeps=substeps))
        run = solver_of(one)(one, groom)
        run.advance(24 * 30)
        found.append(run.particles()[0].astype(np.float64))
    return {"rest_substeps": float(np.linalg.norm(found[0] - found[1], axis=1).max())}


def check_determinism(solver: str, *, labels: dict[str, str]) -> Metrics:
    """A groom of several blocks, twice on one thread and once on all."""
    import numba

    case = Case.of(solver, {"strands": "700", "start": "random", "wind": "gale", **labels})
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


def check_double(solver: str, *, n: int) -> Metrics:
    """Lengths in the solver's own double precision, in a gale."""
    only(solver, "rod", SINGLE)
    case = Case.of(solver, {"n": str(n), "start": "random", "wind": "gale"})
    times = times_of(case)
    one = stepped(scene_of(case, times), groom_of([case]), 1 / 60, len(times), double=True)
    edges = one.state.edges[0].reshape(n, 3, -1)[..., 0]
    if edges.dtype != np.float64:
        raise NotRepresented(f"its state is {edges.dtype} at {n} segments")
    return {"stretch_double": float(np.abs(np.linalg.norm(edges, axis=1) - 1).max())}
