"""A case as a scene, a groom and the moments of its steps: what a preset and an emitter would have made of it.

The matrix goes beyond what presets may say (a rigidity of zero, a tip of a thousandth). The strand is clamped along +x
and gravity points down, so that straight is not its rest.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...groom.record import Groom
from ...scene.model import Emitter, PoseKey, Rod, RuleUse, Scene, SphereSolid, Time
from ...simulate.rules import registry
from .matrix import Case

NOTHING = 1e-300
"""Zero in single precision, and yet no rule calls itself idle for it: all scenes of a solver then share one compiled
step, whatever is zero in them."""
STEPS = 24
LEAP = 100.0
SHAKE = 0.1
HERTZ = 50.0
GROUP = 4
"""Strands of a case whose strands may meet, in place of one: contact is dear, and of few strands it is as hard."""
CLOSE = 0.05
"""By how much their roots are brought together where no solid is in their way."""
RADIUS = 0.02
"""Of theirs, in L: the rest have 2 L, which no cell could be smaller than."""
POWERS = {"thickness": 1, "cell": 1, "density": -2}
"""Of L, that settings of what strands do to each other grow with."""
COIL, AXIS = 0.6, np.array([0.8, 0.6, 0.0])
"""Radians by which a coil's edges turn from one to the next, about which unit vector."""


def times_of(case: Case) -> NDArray[np.float64]:
    """(steps,) the ends of the steps, seconds: fewer where they are dear."""
    n = case.value("n")
    count = STEPS if n <= 32 else STEPS // 2 if n <= 100 else STEPS // 4
    lengths = np.full(count, case.value("dt") / case.value("substeps"))
    if case.label("dt") == "noisy":
        lengths *= 1 + 0.5 * np.random.Generator(np.random.Philox(key=(7, count))).uniform(-1, 1, count)
    share = 1 if not case.grouped else 4 if "contact" in case.value("between") else 2
    return np.cumsum(lengths)[: -(-count // share)]


def strands_of(case: Case) -> int:
    """How many strands the groom of a case has."""
    return GROUP if case.grouped and case.value("strands") == 1 else int(case.value("strands"))


def scene_of(case: Case, times: NDArray[np.float64]) -> Scene:
    """The scene of a case whose steps end at ``times``."""
    L, B = case.value("L"), case.value("B")
    # without rigidity Γ is infinite; its place is then taken by the pull that it means for a B of 1
    pull = case.value("gamma") * (B or 1.0) * L
    wind = case.value("wind")
    rules: list[tuple[str, dict[str, Any]]] = [
        ("emitter_motion", {}),
        ("gravity", {"acceleration": (0.0, -max(pull, NOTHING), 0.0)}),
        ("wind", wind_of(wind * L, float(times[0]))),
    ]
    solids = solids_of(case, times)
    if case.solver == "thesis":
        # B in 1/s² is the strength of the source's stiffness; it always collides, with a ball that is never there
        rules.append(("stiffness", {"strength": max(B, NOTHING)}))
        solids = solids or (SphereSolid(radius=L, position=(case.value("offset") * L, 1e6 * L, 0.0)),)
    if solids:
        rules.append(("collision", {"segments": case.value("collide")}))
    if case.solver == "thesis":
        rules.append(("elasticity", {}))
    for name, given in case.value("between").items():  # of an L of 1
        scaled = {key: given[key] * L**power for key, power in POWERS.items() if key in given}
        rules.append((name, given | scaled))
    # radius 2 and density 1 make B / (ρ A) = E R² / (4 ρ) Young's modulus itself
    radius = RADIUS * L if case.grouped else 2.0
    matter: dict[str, Any] = {"rest": "straight", **case.value("twist")}
    return Scene(
        solver=case.solver,
        rod=Rod(
            density=1.0, radius=radius, young=B * L**4 * (2 / radius) ** 2, tip=math.sqrt(case.value("tip")),
            drag=1.0 if wind else 0.0, damping=0.0, end=case.value("end"), root=case.value("root"),
            torsion=case.value("torsion"), **matter,
        ),
        time=Time(fps=float(1 / times[0]), frames=1000),
        emitter=Emitter(
            strands=strands_of(case), particles=case.value("n") + 1, length=L, keys=keys_of(case, times)
        ),
        rules=tuple(RuleUse(name, registry()[name].Parameters(**given), name) for name, given in rules),
        solids=solids,
    )  # fmt: skip


def groom_of(cases: Sequence[Case]) -> Groom:
    """The strands of a batch: one a case where cases are single strands, else those of the one groom."""
    first = cases[0]
    n, L, strands, free = first.value("n"), first.value("L"), strands_of(first), first.label("contact") == "none"
    if strands > 1:
        assert len(cases) == 1
        draw = np.random.Generator(np.random.Philox(key=(11, strands)))
        roots = L * draw.uniform(-1, 1, (strands, 3))
        directions = _units(draw, (strands,)) if free else _along_x(strands)
        spread = first.value("lengths") * draw.uniform(-1, 1, strands)
        if not free:
            roots *= (0.0, 0.0, 0.05)  # side by side in front of the solids
        edges = _started(first.label("start"), directions, n)
    else:
        roots, directions, spread = np.zeros((len(cases), 3)), _along_x(len(cases)), np.zeros(len(cases))
        edges = np.concatenate([_started(case.label("start"), directions[:1], n) for case in cases])
    if first.label("twist") == "coil":
        edges = coil(edges)
    near = np.float32(CLOSE if first.grouped and free else 1.0)
    return Groom(
        roots.astype(np.float32) * near, directions.astype(np.float32), (L * (1 + spread)).astype(np.float32),
        np.zeros(len(roots), np.float32), edges=edges,
    )  # fmt: skip


def coil(edges: NDArray[np.float64]) -> NDArray[np.float64]:
    """Edges (strands, n, 3), each turned by `COIL` more than the one before."""
    angle = COIL * np.arange(1, edges.shape[1] + 1)[:, None]
    along = (edges @ AXIS)[..., None] * AXIS
    return np.asarray(along + (edges - along) * np.cos(angle) + np.cross(AXIS, edges) * np.sin(angle))


def _started(start: str, directions: NDArray[np.float64], n: int) -> NDArray[np.float64]:
    """(strands, n, 3) edges at the start."""
    edges = np.repeat(directions[:, None], n, 1)
    if start == "zero":
        edges[:, n // 2] = 0
    elif start == "coincident":
        edges[:] = 0
    elif start == "folded":
        edges[:, 1::2] *= -1
        edges[:, 0] *= -1 if n == 1 else 1
    elif start == "random":
        edges = _units(np.random.Generator(np.random.Philox(key=(13, n))), edges.shape[:2])
    return edges


def _along_x(count: int) -> NDArray[np.float64]:
    return np.tile([1.0, 0.0, 0.0], (count, 1))


def _units(draw: np.random.Generator, shape: tuple[int, ...]) -> NDArray[np.float64]:
    direction = draw.normal(size=(*shape, 3))
    return np.asarray(direction / np.linalg.norm(direction, axis=-1, keepdims=True))


def wind_of(strength: float, step: float) -> dict[str, Any]:
    """Parameters of a wind that swings half round, and from nothing to its full strength, between two steps."""
    return {
        "direction": (0.0, 0.0, 1.0), "strength": max(strength, NOTHING), "per_length": False,
        "gust": 1.0 if strength else 0.0, "sway": 90.0 if strength else 0.0, "period": 2 * step / 1.618,
    }  # fmt: skip


def keys_of(case: Case, times: NDArray[np.float64]) -> tuple[PoseKey, ...]:
    """The emitter's motion. Whatever happens at once happens at a third of the run."""
    L, kind = case.value("L"), case.label("emitter")
    x = case.value("offset") * L
    keys = [(0.0, (x, 0.0, 0.0), (0.0, 0.0, 0.0))]
    late = float(times[len(times) // 3])
    if kind == "still":
        keys.append((late, (x, 0.0, 0.0), (0.0, 0.0, 0.0)))
    elif kind == "teleport":
        keys.append((late, (x, 0.0, LEAP * L), (0.0, 0.0, 0.0)))
    elif kind == "flip":
        keys.append((late, (x, 0.0, 0.0), (0.0, 0.0, 180.0)))
    else:
        for step, time in enumerate(times):
            # steps longer than half a period see it at its turning points, the worst that they can see
            coarse = case.value("dt") / case.value("substeps") > 0.5 / HERTZ
            y = (-1.0) ** step if coarse else math.sin(2 * math.pi * HERTZ * time)
            keys.append((float(time), (x, SHAKE * L * y, 0.0), (0.0, 0.0, 0.0)))
    return tuple(PoseKey(time, position, rotation, "step") for time, position, rotation in keys)


def solids_of(case: Case, times: NDArray[np.float64]) -> tuple[SphereSolid, ...]:
    """What the strand, which reaches from its root by L along x, has to do with."""
    L, n = case.value("L"), case.value("n")
    root = case.value("offset") * L

    def ball(x: float, y: float, radius: float) -> SphereSolid:
        return SphereSolid(radius=radius, position=(x + root, y, 0.0))

    match case.label("contact"):
        case "inside":  # the root on the surface
            return (ball(0.6 * L, 0.0, 0.6 * L),)
        case "through":
            return (ball(0.5 * L, 0.0, 0.3 * L),)
        case "overlap":
            return (ball(0.5 * L, 0.1 * L, 0.25 * L), ball(0.5 * L, -0.1 * L, 0.25 * L))
        case "small":  # between two particles
            return (ball((n // 2 + 0.5) * L / n, 0.0, 0.4 * L / n),)
        case "moving":  # through the strand from above, in half of the run
            late = float(times[len(times) // 2])
            ends = (0.0, ball(0.6 * L, L, 0.0)), (late, ball(0.6 * L, -L, 0.0))
            keys = tuple(PoseKey(time, one.position, (0.0, 0.0, 0.0), "linear") for time, one in ends)
            return (replace(ball(0.0, 0.0, 0.3 * L), keys=keys),)
    return ()
