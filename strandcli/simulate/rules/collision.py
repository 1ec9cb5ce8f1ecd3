"""Collision: a particle inside a solid is put onto its surface (thesis §2).

For a sphere p_i' = p_i + (r − |p_i − o|) n, n = (p_i − o) / |p_i − o|, when |p_i − o| < r; not the root. A particle at
the very centre has no direction and leaves upward. Capsules, planes and boxes follow the same form: along the gradient
of the distance to the surface. Point based as in the source, so a long segment can cut through a solid; with
``segments: true`` the deepest point of the segment is found as well and the segment is turned until that point is out.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ...scene.fields import boolean, names
from ...scene.touched import chosen
from .rule import Pass

if TYPE_CHECKING:
    from ...scene.model import Scene

name = "collision"
order = 40.0


@dataclass(frozen=True, slots=True)
class Parameters:
    """Which solids stop the strands, and how closely they are looked at."""

    with_: tuple[str, ...] = names(doc="names of the solids; none given: all of them")
    segments: bool = boolean(False, doc="also catch a segment that passes through between two particles")


def check(parameters: Parameters, scene: Scene) -> Iterable[tuple[str, str]]:
    """Faults that only the whole scene shows."""
    known = [solid.name for solid in scene.solids]
    for place, given in enumerate(parameters.with_):
        if given not in known:
            have = ", ".join(sorted(filter(None, known))) or "no named solids"
            yield f"with.{place}", f"no solid is called {given!r}; this scene has {have}"


def idle(parameters: Parameters, scene: Scene) -> str:
    """Why this rule has nothing to do, or nothing."""
    return "" if chosen(parameters, scene) else "there is no solid to collide with"


def passes(parameters: Parameters, scene: Scene) -> list[Pass]:
    """One pass for each kind of solid that is there, and one more for its segments where asked.

    A plane that no particle is below is cut by no segment: it needs no pass of its own.
    """
    import numpy as np

    from ...scene.motion import solid_pose
    from ...solids import others, pack
    from ...solids.kernels import box, capsule, plane, sphere
    from ...solids.shapes import other
    from . import collision_segments as segments

    points = {"sphere": sphere.collide, "capsule": capsule.collide, "plane": plane.collide, "box": box.collide}
    through = {"sphere": segments.sphere, "capsule": segments.capsule, "box": segments.box}

    def prepare(kind: str) -> Any:
        return lambda moment: pack(kind, chosen(parameters, moment.scene), moment.scene.emitter, moment.pose_time)

    kinds = [kind for kind in points if any(solid.kind == kind for solid in chosen(parameters, scene))]
    caught = [kind for kind in kinds if parameters.segments and kind in through]
    ends = [Pass(points[kind], prepare(kind)) for kind in kinds]
    if caught and len(chosen(parameters, scene)) > 1:  # a turned segment may have put its end into another solid
        ends *= 2
    found = [Pass(through[kind], prepare(kind)) for kind in caught] + ends
    foreign = others(chosen(parameters, scene))
    if foreign:
        written = other.module_for(foreign)

        def rows(moment: Any) -> Any:
            there = others(chosen(parameters, moment.scene))
            poses = [solid_pose(one, moment.scene.emitter, moment.pose_time) for one in there]
            return other.pack(there, poses, np.float32)

        found += [Pass(one, rows) for one in ([written.catch] if parameters.segments else []) + [written.collide]]
    return found
