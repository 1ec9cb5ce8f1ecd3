"""Collision: a particle inside a solid is put onto its surface (thesis §2).

For a sphere p_i' = p_i + (r − |p_i − o|) n, n = (p_i − o) / |p_i − o|, when |p_i − o| < r; not the root. A particle at
the very centre has no direction and leaves upward. Capsules, planes and boxes follow the same form: along the gradient
of the distance to the surface. Point based as in the source, so a long segment can cut through a solid; with
``segments: true`` the deepest point of the segment is found as well and the segment is turned until that point is out,
and at the end of the step particles are put out once more.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ...scene.fields import boolean, names
from ...scene.touched import chosen
from .rule import Moment, Pass

if TYPE_CHECKING:
    from ...scene.model import Scene

name = "collision"
order = 40.0
ROUNDS = 3
"""Times that particles are put out of solids at the end of a step, where one solid or rule may undo another."""
_SHIPPED = ("sphere", "capsule", "plane", "box")


@dataclass(frozen=True, slots=True)
class Parameters:
    """Which solids stop the strands, and how closely they are looked at."""

    with_: tuple[str, ...] = names(doc="names of solids; empty: all")
    segments: bool = boolean(False, doc="also keep segments outside solids, not only particles")


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
    """One pass for each kind of solid that is there, after one for its segments where asked.

    A plane that no particle is below is cut by no segment: it needs no pass of its own.
    """
    from ...solids import others
    from ...solids.shapes import other_code
    from . import collision_segments as segments

    packed = Packed(parameters, scene)
    ends = _ends(packed)
    if not parameters.segments:
        return ends
    through = {"sphere": segments.sphere, "capsule": segments.capsule, "box": segments.box}
    caught = [Pass(through[kind], packed.kind(kind)) for kind in packed.kinds if kind in through]
    foreign = others(chosen(parameters, scene))
    if foreign:
        caught.append(Pass(other_code.module_for(foreign).catch, packed.others))
    return caught + ends


def closing(parameters: Parameters, scene: Scene) -> list[Pass]:
    """With segments, particles once more at the end of a step: a turned segment may have put its end into another
    solid, and rules that come later move it. Where elasticity is one of them, solids and lengths take turns. What one
    solid after the other leaves inside is led out of all together."""
    from ..thesis.kernels.depenetrate import leave, turn
    from . import elasticity

    if not parameters.segments:
        return []
    places = [k for k, use in enumerate(scene.rules) if use.parameters is parameters]
    later = scene.rules[places[0] + 1 :] if places else ()
    packed = Packed(parameters, scene)
    ends = _ends(packed)
    lengths = [one for use in later if use.name == elasticity.name for one in elasticity.passes(use.parameters, scene)]
    if lengths:
        return (ends + lengths[:1]) * ROUNDS + [Pass(turn, packed.all)]
    if len(chosen(parameters, scene)) > 1:
        return ends * ROUNDS + [Pass(leave, packed.all)]
    return ends if later else []


def _ends(packed: Packed) -> list[Pass]:
    """One pass a kind of solid, for particles alone."""
    from ...solids import others
    from ...solids.kernels import box, capsule, plane, sphere
    from ...solids.shapes import other_code

    points = {"sphere": sphere.collide, "capsule": capsule.collide, "plane": plane.collide, "box": box.collide}
    found = [Pass(points[kind], packed.kind(kind)) for kind in packed.kinds]
    foreign = others(packed.chosen)
    if foreign:
        found.append(Pass(other_code.module_for(foreign).collide, packed.others))
    return found


class Packed:
    """The solids of a rule as its passes take them, packed once a step."""

    def __init__(self, parameters: Parameters, scene: Scene) -> None:
        from ...solids import pack

        self.chosen = chosen(parameters, scene)
        """The solids of the scene that the rule is for."""
        self.kinds = [one for one in _SHIPPED if one in {solid.kind for solid in self.chosen}]
        """Kinds of those that have kernels of their own, in the order of their passes."""
        self._last: tuple[Moment | None, dict[str, Any]] = None, {}
        self._pack = pack

    def of_kind(self, kind: str, moment: Moment) -> Any:
        """Return those of a kind at a moment."""
        last, rows = self._last
        if last is not moment:
            rows = {one: rows[one] for one in rows if one not in self.kinds}  # none of a kind are none at any moment
            self._last = moment, rows
        if kind not in rows:
            rows[kind] = self._pack(kind, self.chosen, moment.scene.emitter, moment.pose_time)
        return rows[kind]

    def kind(self, kind: str) -> Callable[[Moment], Any]:
        """Return `of_kind` for passes that take one kind."""
        return lambda moment: self.of_kind(kind, moment)

    def all(self, moment: Moment) -> Any:
        """Return all of them at a moment, a `strandcli.solids.Solids`."""
        import numpy as np

        from ...solids import SHAPES, joined

        scene = moment.scene
        shipped = [self.of_kind(kind, moment) for kind in SHAPES]
        return joined(shipped, self.chosen, scene.emitter, moment.pose_time, np.float32)

    def others(self, moment: Moment) -> Any:
        """Return those without kernels of their own, with the data of their shapes."""
        import numpy as np

        from ...scene.motion import solid_pose
        from ...solids import others
        from ...solids.shapes import other, other_code

        there = others(self.chosen)
        poses = [solid_pose(one, moment.scene.emitter, moment.pose_time) for one in there]
        return other_code.together(there, other.pack(there, poses, np.float32), moment.pose_time)
