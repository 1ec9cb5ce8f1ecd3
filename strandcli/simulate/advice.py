"""What a person should know before a run that is possible, but hardly what was meant."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import solids
from ..groom.emit import Groom
from ..scene.motion import emitter_pose
from .rules import collision

DEEP = 1.0
"""Segments that a root must be below a surface for its strand not to get out: the next particle reaches no further."""
COARSE = 0.01
"""Of a segment: a step from one number of single precision to the next that shows in the shapes of strands."""
SMALL = 0.5
"""Diameter of a ball or capsule, in segments, below which it slips through between two particles."""


def warnings(scene: Any, groom: Groom) -> list[str]:
    """One line for each solid that swallows roots when the run begins, and for each that is too small to be noticed by
    particles; for a rule that the solver leaves out although it asks for something; and for strands so far from the
    origin that their places are rounded."""
    found = []
    for use in scene.rules:
        if scene.solver == "rod" and use.name == "stiffness" and use.parameters.strength > 0:
            found.append(
                f"rule {use.path}: left out, rods bend by their material; set rod.young and rod.radius instead"
            )
    collisions = [use for use in scene.rules if use.name == "collision"]
    numbers = {id(solid): place for place, solid in enumerate(scene.solids)}
    touched = {id(one): one for use in collisions for one in collision.chosen(use.parameters, scene)}
    whole = any(use.parameters.segments for use in collisions)
    segment = groom.lengths.astype(np.float64) / max(scene.emitter.particles - 1, 1)
    turn, moved = (np.array(part) for part in emitter_pose(scene.emitter, 0.0))
    roots = groom.roots.astype(np.float64) @ turn.T + moved
    away = float(np.abs(roots).max())
    step = float(np.spacing(np.float32(away)))
    if step > COARSE * segment.max():
        found.append(
            f"strands are {away:.3g} m from the origin, where places are rounded to {step:.2g} m, "
            f"{100 * step / segment.max():.2g} % of a segment: they become ragged; move the scene to the origin"
        )
    for key, solid in touched.items():
        name = f"solids.{numbers[key]}" + (f" ({solid.name})" if solid.name else "")
        under = depth(roots, solid, scene.emitter)
        lost = under > DEEP * segment
        if lost.any():
            found.append(
                f"{name}: swallows the roots of {int(lost.sum()):,} of {groom.strands:,} strands, up to "
                f"{under.max():.3g} m deep: they cannot get out; make it smaller, move it, or leave it out with "
                "collision.with"
            )
        elif solid.kind in ("sphere", "capsule") and not whole and solid.radius < SMALL * segment.max():
            found.append(
                f"{name}: its radius of {solid.radius:g} m is less than half a segment of {segment.max():.3g} m, so it "
                "passes between two particles unnoticed; set collision.segments: true, or use more emitter.particles"
            )
    return found


def depth(points: NDArray[np.float64], solid: Any, emitter: Any) -> NDArray[np.float64]:
    """(k,) depth of points (k, 3) below the nearest surface of a solid at time 0; not positive outside."""
    row = solids.pack(solid.kind, [solid], emitter, 0.0, np.float64)[0]
    return np.asarray(solids.SHAPES[solid.kind].depth(row, points))
