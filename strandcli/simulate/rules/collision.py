"""Collision: a particle inside a solid is put onto its surface (thesis §2).

For a sphere p_i' = p_i + (r − |p_i − o|) n, n = (p_i − o) / |p_i − o|, when |p_i − o| < r; not the root. A particle at
the very centre leaves upward. Other shapes follow the same form: along the gradient of the distance to the surface.
With ``segments: true`` the segment is turned until its deepest point is out, and at the end of the step particles are
put out once more.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ...scene.fields import boolean, names
from ...scene.rule_type import chosen
from .rule import Moment, Pass

if TYPE_CHECKING:
    from ...scene.model import Scene

name = "collision"
order = 40.0
ROUNDS = 3
"""Times that particles are put out of solids at the end of a step, where one solid or rule may undo another."""


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
    from ...solids.kernels import custom
    from ..contact.kernels import segments

    met = chosen(parameters, scene)
    through = {"sphere": segments.sphere, "capsule": segments.capsule, "box": segments.box}
    return (_by_kind(met, through, custom.catch) if parameters.segments else []) + _ends(met)


def closing(parameters: Parameters, scene: Scene) -> list[Pass]:
    """With segments, particles once more at the end of a step: a turned segment may have put its end into another
    solid, and rules that come later move it. Where elasticity is one of them, solids and lengths take turns."""
    from . import elasticity

    if not parameters.segments:
        return []
    places = [k for k, use in enumerate(scene.rules) if use.parameters is parameters]
    later = scene.rules[places[0] + 1 :] if places else ()
    met = chosen(parameters, scene)
    lengths = [one for use in later if use.name == elasticity.name for one in elasticity.passes(use.parameters, scene)]
    rounds = ROUNDS if lengths or len(met) > 1 else int(bool(later))
    return (_ends(met) + lengths[:1]) * rounds


def _ends(met: list[Any]) -> list[Pass]:
    """One pass a kind of solid, for particles alone."""
    from ...solids.kernels import box, capsule, custom, plane, sphere

    points = {"sphere": sphere.collide, "capsule": capsule.collide, "plane": plane.collide, "box": box.collide}
    return _by_kind(met, points, custom.collide)


def _by_kind(met: list[Any], shipped: dict[str, Any], custom: Callable[..., None]) -> list[Pass]:
    """One pass for each kind of the solids that are ``met``, by the functions of ``shipped`` kinds, and one for those
    without kernels of their own, by the function ``custom``."""
    import numpy as np

    from ...scene.motion import solid_pose
    from ...solids import custom_of, pack
    from ...solids.custom import pack as pack_custom
    from ...solids.custom import together

    def rows(kind: str) -> Callable[[Moment], Any]:
        return lambda moment: pack(kind, met, moment.scene.emitter, moment.pose_time)

    def custom_rows(moment: Moment) -> Any:
        poses = [solid_pose(one, moment.scene.emitter, moment.pose_time) for one in rest]
        return together(rest, pack_custom(rest, poses, np.float32), moment.pose_time)

    there, rest = {solid.kind for solid in met}, custom_of(met)
    found = [Pass(function, rows(kind)) for kind, function in shipped.items() if kind in there]
    return found + ([Pass(custom, custom_rows)] if rest else [])
