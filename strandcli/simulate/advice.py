"""Warnings about valid scenes that are probably not intended."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import solids
from ..groom.record import Groom
from ..scene.fields import settings_of
from ..scene.model import Rod
from ..scene.model.solids import has_data, shape_of
from ..scene.motion import emitter_pose, own_pose, solid_pose
from ..scene.rule_type import touched
from ..solids import custom
from .rod.material import matter_along, stiffness, torsion
from .rod.rest_shape import coiled, hold, unit_edges
from .rod.surroundings import gravity

if TYPE_CHECKING:
    from ..scene.model import Emitter, Scene

Floats = NDArray[np.float64]

DEEP = 1.0
"""Depth of a root, in segments, beyond which its strand cannot leave the solid."""
COARSE = 0.01
"""Spacing of single-precision numbers, as a share of a segment, above which strands look ragged."""
SAMPLED_ROOTS = 1000
"""Roots that are tested in each frame between the first and the last, evenly chosen."""
GRAZED = 0.02
"""Least share of the roots in a moving solid that is reported; below, the solid only grazes the emitter."""
MOST_FRAMES = 1000
"""Frames that are looked at, the last and more, evenly spaced; all of films that have no more."""
ROUNDED = 1e-12
"""Relative error of a stiffness that is no more than rounding."""
RETURNED = 1e-6
"""Tolerance between the first and the last pose of a loop, metres and elements of the rotation matrix."""
FEWEST_A_TURN = 5.0
"""Segments a turn of a curl below which it may not come to rest: what carries its shape along turns too far in one."""
HALF = 0.5
"""Share of a strand's joints that are a curl's above which it is one."""
BENT = 0.2
"""Radians by which edges turn from one to the next from which a joint counts as that of a curl."""
SMALL = 0.5
"""Radius of a sphere or capsule, in segments, below which it fits between two particles."""


def warnings(scene: Scene, groom: Groom) -> list[str]:
    """Return warnings, a line each: solids that contain roots in some frame, or fit between two particles; rules that
    the solver ignores; strands so far from the origin that positions are rounded; loops that do not close; rods that
    `sag_free` stiffens. Imports NumPy but not Numba, for `strandcli plan`."""
    found = []
    for use in scene.rules:
        if scene.solver == "rod" and use.name == "stiffness" and use.parameters.strength > 0:
            found.append(f"rule {use.path}: ignored, rods bend by their material; set rod.young and rod.radius instead")
    if scene.solver == "rod" and scene.time.jitter > 0:
        found.append("time.jitter: ignored, rods move by equal steps; take it out, or set solver: thesis")
    found += _idle_rod(scene)
    whole = any(use.name == "collision" and use.parameters.segments for use in scene.rules)
    segment = groom.lengths.astype(np.float64) / max(scene.emitter.particles - 1, 1)
    away = float(np.abs(_roots(scene, groom.roots, 0.0)).max())
    step = float(np.spacing(np.float32(away)))
    if step > COARSE * segment.max():
        found.append(
            f"strands are {away:.3g} m from the origin, where places are rounded to {step:.2g} m, "
            f"{100 * step / segment.max():.2g} % of a segment: they become ragged; move the scene to the origin"
        )
    met = {id(solid) for solid in touched(scene)}
    found += _meshes(scene, groom, met)
    for name, solid in _named(scene):
        if id(solid) not in met:
            continue
        swallowed = _swallowed(solid, scene, groom, segment)
        if swallowed is not None:
            found.append(f"{name}: {swallowed}")
        elif solid.kind in ("sphere", "capsule") and not whole and solid.radius < SMALL * segment.max():
            found.append(
                f"{name}: its radius of {solid.radius:g} m is less than half a segment of {segment.max():.3g} m, so it "
                f"passes between two particles unnoticed; {_catching(scene)}, or use more emitter.particles"
            )
    return found + _broken_loops(scene) + coarse_curls(scene, groom) + softness(scene, groom)


def _idle_rod(scene: Scene) -> list[str]:
    """Return a warning for settings of ``rod`` beside another solver. Panels that compare solvers share them."""
    if scene.solver == "rod" or scene.label:
        return []
    keys = [key for key, setting in settings_of(Rod).items() if getattr(scene.rod, key) != setting.spec.default]
    if not keys:
        return []
    names = ", ".join(f"rod.{key}" for key in keys)
    return [f"{names}: ignored by solver {scene.solver}; set solver: rod to have {'them' if keys[1:] else 'it'} act"]


def _meshes(scene: Scene, groom: Groom, met: set[int]) -> list[str]:
    """Return warnings about solids that are meshes; met: ids of solids that a rule touches."""
    if not any(solid.kind == "mesh" for solid in scene.solids):
        return []
    from ..mesh_file.needs import warnings as of_mesh

    extent = float(np.ptp(groom.roots.astype(np.float64), axis=0).max() + groom.lengths.max())
    return [
        line
        for name, solid in _named(scene)
        if solid.kind == "mesh"
        for line in of_mesh(name, solid, extent, id(solid) in met)
    ]


def _named(scene: Scene) -> list[tuple[str, Any]]:
    """Return solids with what they are called in messages."""
    return [(f"solids.{k}" + (f" ({one.name})" if one.name else ""), one) for k, one in enumerate(scene.solids)]


def _catching(scene: Scene) -> str:
    """Return the advice that keeps segments out of solids. Rules after collision in the source's solver move segments
    back in."""
    places = [k for k, use in enumerate(scene.rules) if use.name == "collision"]
    later = [use.path for use in scene.rules[places[-1] + 1 :] if use.name != "emitter_motion"]
    if scene.solver == "rod" or not later:
        return "set collision.segments: true"
    after = " and ".join(later)
    return f"list collision last (what comes after it, {after}, moves particles back) and set its segments: true"


def _broken_loops(scene: Scene) -> list[str]:
    """Return a warning for each emitter or solid whose pose at the end of a loop differs from that at its beginning."""
    if not scene.time.loop:
        return []
    found = []
    for name, thing in [("emitter", scene.emitter), *_named(scene)]:
        if not thing.keys:
            continue
        first, last = (
            np.append(np.ravel(pose.rotation), pose.translation)
            for pose in (own_pose(thing, time) for time in (0.0, scene.time.period))
        )
        if np.abs(last - first).max() > RETURNED:
            found.append(
                f"{name}: time.loop repeats all motion after {scene.time.period:g} s, where its keys have not led back "
                "to where they began: it jumps there; give it a last key like the first"
            )
    return found


def coarse_curls(scene: Scene, groom: Groom) -> list[str]:
    """Return a warning if curls that rods are to keep have fewer than `FEWEST_A_TURN` segments a turn."""
    n = scene.emitter.particles - 1
    if scene.solver != "rod" or scene.rod.rest == "straight" or n < 3:
        return []
    edges = np.stack(unit_edges(groom, n)[0])
    # of a helix bends are across its axis, and from one to the next turn as it does
    bends = np.diff(edges / np.linalg.norm(edges, axis=2, keepdims=True), axis=0)
    size = np.maximum(np.linalg.norm(bends, axis=2), ROUNDED)
    turns = np.arccos(np.clip((bends[1:] * bends[:-1]).sum(2) / (size[1:] * size[:-1]), -1, 1))
    curled = np.minimum(size[1:], size[:-1]) > BENT
    mean = (turns * curled).sum(0) / np.maximum(curled.sum(0), 1)
    coarse = (mean > 2 * np.pi / FEWEST_A_TURN * (1 + RETURNED)) & (curled.mean(0) > HALF)
    if not coarse.any():
        return []
    return [
        f"rod.rest: {scene.rod.rest}: {int(coarse.sum()):,} of {groom.strands:,} strands have curls with as few as "
        f"{2 * np.pi / mean.max():.2g} segments a turn, and may move for ever: a curl needs {FEWEST_A_TURN:g}, and "
        "more to have its shape; use more emitter.particles, or fewer turns"
    ]


def softness(scene: Scene, groom: Groom) -> list[str]:
    """Return a warning if strands are too soft for a sag-free start, so that `sag_free` stiffens them."""
    if scene.solver != "rod" or scene.rod.rest != "sag_free":
        return []
    n = scene.emitter.particles - 1
    lengths = groom.lengths.astype(np.float64) / n
    edges = [edge / np.linalg.norm(edge, axis=1, keepdims=True) for edge in unit_edges(groom, n)[0]]
    mass, joint = matter_along(scene.rod, n)
    own = stiffness(scene.rod, lengths)
    turn = np.array(emitter_pose(scene.emitter, 0.0).rotation)
    pull = turn.T @ gravity(scene) / lengths[:, None]
    twist = torsion(scene.rod, coiled(edges))
    rest = hold(groom.directions.astype(np.float64), np.stack(edges), mass, joint, own, twist, pull)
    stiffer = rest.stiffness > own * (1 + ROUNDED)
    if not stiffer.any():
        return []
    return [
        f"rod.rest: sag_free: {int(stiffer.sum()):,} of {groom.strands:,} strands are too soft to stay as they "
        f"are emitted, and are made up to {(rest.stiffness / own).max():.3g} times as stiff; a greater "
        "rod.radius or rod.young, or a shape that hangs, leaves the material as it is"
    ]


def _swallowed(solid: Any, scene: Scene, groom: Groom, segment: Floats) -> str | None:
    """Return a warning about a solid that contains roots, or None: any at the start, a share of `GRAZED` later, or any
    at the end. It names the first frame from which on it contains some until then."""
    frames = [1]
    if solid.keys or (scene.emitter.keys and (solid.follow != "emitter" or not _carried(scene))):
        frames += sorted(range(scene.time.frames, 1, -max(1, -(-scene.time.frames // MOST_FRAMES))))

    def under(frame: int, some: slice) -> Floats:
        time = (frame - 1) / scene.time.fps
        return depth(_roots(scene, groom.roots[some], time), solid, scene.emitter, time)

    first = None
    for frame in frames:
        some = slice(None, None, 1 if frame in (1, scene.time.frames) else -(-groom.strands // SAMPLED_ROOTS))
        share = (under(frame, some) > DEEP * segment[some]).mean()
        first = (first or frame) if share > 0 else None
        if share >= GRAZED or (frame == 1 and share > 0):
            break
    if first is None:
        return None
    found = under(first, slice(None))
    lost = int((found > DEEP * segment).sum())
    when = "" if first == 1 else f"from frame {first} on "
    return (
        f"{when}swallows the roots of {lost:,} of {groom.strands:,} strands, up to {found.max():.3g} m deep: "
        "they cannot get out; make it smaller, move it, or leave it out with collision.with"
    )


def _carried(scene: Scene) -> bool:
    """Return whether roots move with the emitter."""
    return any(use.name == "emitter_motion" for use in scene.rules)


def _roots(scene: Scene, roots: NDArray[np.floating], time: float) -> Floats:
    """Return points (k, 3) of the emitter's frame in world space at a time."""
    turn, moved = (np.array(part) for part in emitter_pose(scene.emitter, time * _carried(scene)))
    return np.asarray(roots.astype(np.float64) @ turn.T + moved)


def depth(points: Floats, solid: Any, emitter: Emitter, time: float = 0.0) -> Floats:
    """Return (k,) the depth of points (k, 3) below a solid's surface at a time; outside it is at most 0 and not less
    than the negative distance."""
    if solid.kind in solids.SHAPES:
        row = solids.pack(solid.kind, [solid], emitter, time, np.float64)[0]
        return np.asarray(solids.SHAPES[solid.kind].depth(row, points))
    row = custom.pack([solid], [solid_pose(solid, emitter, time)], np.float64)[0]
    shape: Any = shape_of(solid.kind)
    own = (points - row[:3]) @ row[custom.ROW_X : custom.REACH].reshape(3, 3)
    outside = np.linalg.norm(own, axis=1) - row[custom.REACH]
    if has_data(shape):
        from ..solids.kernels.custom import distances

        found = outside.copy()
        near = np.flatnonzero(outside <= 0)
        away = np.zeros(len(near))
        distances(custom.together([solid], row[None], time), 0, np.ascontiguousarray(points[near]), away)
        found[near] = away
        return -found
    given = tuple(row[custom.NUMBERS :].tolist())
    pairs = zip(outside.tolist(), own.tolist(), strict=True)
    return np.array([-far if far > 0 else -float(shape.distance(*one, given)) for far, one in pairs])
