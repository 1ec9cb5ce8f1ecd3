"""Hair of a file put on a solid: roots onto its surface, and strands out of it.

Roots that float or sink go to the nearest point of the surface; their strands go with them, by less and less along a
part of their length. Then points inside, or nearer than a small clearance, are moved along the shortest path out, and
their neighbours on the strand with them, again and again, until all are out. Segments keep their lengths throughout.
Strands that are in place already keep every bit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.counted import counted
from ..errors import UsageError
from ..exchange.strands import Strands, offsets, spans
from ..groom.record import Anchors
from ..mesh_file.prepared import key_of, prepared
from ..meshes.bvh import closest
from ..scene.motion import Pose, pose_in_emitter
from .fits import UP, Frame, Near, Surface, better, hangs_from, words
from .kernels import rows as kernel

if TYPE_CHECKING:
    from ..scene.model import Scene
    from ..scene.model.emitter import GroomFile

Floats = NDArray[np.float64]

SEATED = 1e-5
"""Distance of roots from the surface that counts as on it, over the solid's size."""
CLEARANCE = 0.002
"""Least distance of points beyond the root from the surface, over the solid's size."""
GOAL = 1.2
"""Clearances to which they are moved."""
RISE = 4.0
"""Clearances along a strand from its root over which its points have less than one."""
FADE, FADE_SHARE = 10.0, 0.3
"""How far along a strand its root's shift fades: in shifts, and at least so much of its length."""
REACH, REACH_SHARE = 3.0, 0.1
"""How far along a strand neighbours move along: in the greatest need of a point, and at least so much of its length."""
ROUNDS = 24
PASSES = 3
"""Of smoothing what points move along a strand."""
TINY = 1e-300
BATCH = 1 << 20
"""Points of strands that are moved out at once."""
FAR = 0.5
"""Median distance of roots from the surface, over the solid's size, beyond which hair is not its own."""
FAR_UNLIKE, UNLIKE = 0.1, 8.0
"""The same where the box of the roots is so many times larger or smaller than the solid."""


class Head(NamedTuple):
    """A solid that hair is put on."""

    solid: Any
    pose: Pose
    """In the emitter's frame, at the start."""
    name: str

    @property
    def frame(self) -> Frame:
        """The same as matrix and vector."""
        return Frame(np.array(self.pose.rotation), np.array(self.pose.translation))


@dataclass
class Fit:
    """What was done to strands."""

    off: Floats
    """(S,) distances of roots from the surface before."""
    seated: int = 0
    moved_out: int = 0
    deepest: float = 0.0
    """Depth of the deepest point before, once roots were in place."""
    farthest: float = 0.0
    """Distance that a point was moved, at most."""
    stretch: float = 0.0
    """Share by which a strand's length changed, at most."""
    left: int = 0
    """Strands that were not out in the end by bending alone, whose points were then put out one by one."""


def head_of(scene: Scene) -> Head | None:
    """Return the solid that a scene's hair is put on, None without one."""
    given = scene.emitter.groom
    if given is None or not given.on:
        return None
    solid: Any = next(one for one in scene.solids if one.name == given.on)
    return Head(solid, pose_in_emitter(solid, scene.emitter), given.on)


def put_on(
    strands: Strands, head: Head, file: str, notes: list[str], up: str = UP, given: GroomFile | None = None
) -> Strands:
    """Return strands in metres, in the emitter's frame, put on a solid; notes say what was done. ``up``: the axis of
    the file that has become y; ``given``: the settings that placed them, for advice. Raises `UsageError` for hair that
    cannot be meant for it."""
    surface, frame = Surface(head.solid), head.frame
    roots = frame.own(strands.roots())
    near = surface.nearest(roots)
    fit = Fit(np.abs(near.distances))
    likely = up if hangs_from(strands) == UP else None
    found = better(strands.roots().astype(np.float64), up, surface, frame, likely)
    size = None if given is None else given.size
    median = float(np.median(fit.off))
    advice = "" if found is None else f"with {words(found, up, size)} it would be {found.median:.2g} m"
    _check(roots, fit.off, surface, head, file, advice or _replaced(given))
    if advice:
        notes.append(
            f"{file}: its roots are {median:.3g} m off {head.name} in the median, before they are moved to it; {advice}"
            ": perhaps its up axis or unit is another one"
        )
    free = fit.off > SEATED * surface.size
    fit.seated = int(free.sum())
    wanted = free | _near(strands, surface, frame)
    shifts = np.where(free[:, None], near.points - roots, 0.0)
    moved = strands.points.copy()
    rows = np.flatnonzero(wanted)
    counts = strands.counts()
    batch = np.cumsum(counts[rows]) // BATCH
    for some in (rows[batch == number] for number in np.unique(batch)):
        _put_batch(strands, some, shifts, surface, frame, fit, moved)
    notes += said(fit, surface, head, file)
    return replace(strands, points=moved) if fit.seated or fit.moved_out else strands


def anchors_on(head: Head | None, roots: NDArray[np.float32]) -> Anchors | None:
    """Return the places of a mesh that are nearest to roots (n, 3), metres, in the emitter's frame, where the mesh
    deforms; else None."""
    if head is None or head.solid.kind != "mesh" or not head.solid.deform:
        return None
    found = closest(prepared(key_of(head.solid)).bvh, head.frame.own(roots))
    return Anchors(found.triangles, found.barycentrics)


def said(fit: Fit, surface: Surface, head: Head, file: str) -> list[str]:
    """Return in words what was done, a line each."""
    found = []
    if fit.seated:
        found.append(
            f"{file}: {counted(fit.seated, 'strand')} of {len(fit.off):,} had roots off {head.name}, and were moved "
            f"to it: median {np.median(fit.off):.2g} m, at most {fit.off.max():.2g} m"
        )
    if fit.moved_out:
        rest = f"; {counted(fit.left, 'strand')} point by point" if fit.left else ""
        found.append(
            f"{file}: {counted(fit.moved_out, 'strand')} moved out of {head.name}, up to {fit.deepest:.2g} m deep, "
            f"to at least {CLEARANCE * surface.size:.2g} m from it{rest}"
        )
    if found:
        found[-1] += f"; points moved by up to {fit.farthest:.2g} m, lengths by up to {100 * fit.stretch:.2g} %"
    return found


def _put_batch(
    strands: Strands, some: NDArray[np.int64], shifts: Floats, surface: Surface, frame: Frame,
    fit: Fit, moved: NDArray[np.float32],
) -> None:  # fmt: skip
    """Put some strands on the surface, and write those that changed to the points ``moved`` of all."""
    counts = strands.counts()[some]
    first = offsets(counts)
    own = np.repeat(strands.first[some] - first[:-1], counts) + np.arange(first[-1])
    before = frame.own(strands.points[own])
    steps = np.zeros(len(before))
    steps[1:] = np.linalg.norm(np.diff(before, axis=0), axis=1)
    steps[first[:-1]] = 0.0
    along = np.cumsum(steps)
    along -= np.repeat(along[first[:-1]], counts)
    whole = along[first[1:] - 1]
    away = np.linalg.norm(shifts[some], axis=1)
    free = away > 0
    fades = np.minimum(np.maximum(FADE * away, FADE_SHARE * whole), np.maximum(whole, TINY))
    t = np.minimum(along / np.repeat(np.maximum(fades, TINY), counts), 1.0)
    points = np.empty_like(before)
    kernel.follow(
        first, points, before + (1 - t * t * (3 - 2 * t))[:, None] * np.repeat(shifts[some], counts, 0), steps
    )
    points[~np.repeat(free, counts)] = before[~np.repeat(free, counts)]
    moved_out = _move_out(first, points, surface, steps, along, fit)
    changed = free | moved_out
    rows = np.repeat(changed, counts)
    if not changed.any():
        return
    fit.moved_out += int(moved_out.sum())
    fit.farthest = max(fit.farthest, float(np.linalg.norm(points[rows] - before[rows], axis=1).max()))
    after = np.zeros(len(points))
    after[1:] = np.linalg.norm(np.diff(points, axis=0), axis=1)
    after[first[:-1]] = 0.0
    lengths = np.add.reduceat(after, first[:-1])
    fit.stretch = max(fit.stretch, float((np.abs(lengths - whole) / np.maximum(whole, 1e-30)).max()))
    moved[own[rows]] = points[rows] @ frame.turn.T + frame.shift


def _move_out(
    first: NDArray[np.int64], points: Floats, surface: Surface, steps: Floats, along: Floats, fit: Fit
) -> NDArray[np.bool_]:
    """Move points (P, 3) out of the surface, and return which strands (S,) were moved."""
    counts = np.diff(first)
    clear = CLEARANCE * surface.size
    # between two points a strand is lower over a curved surface than at them
    least = (clear + steps**2 / (4 * surface.size)) * np.minimum(along / (RISE * clear), 1.0)
    least[first[:-1]] = -np.inf
    whole = along[first[1:] - 1]
    moved_out = np.zeros(len(counts), np.bool_)
    active = np.arange(len(counts))
    for number in range(ROUNDS + 1):
        rows = np.concatenate([np.arange(first[s], first[s + 1]) for s in active])
        part = offsets(counts[active])
        near = surface.nearest(points[rows])
        short = np.logical_or.reduceat(near.distances < least[rows], part[:-1])
        if number == 0:
            depths = -near.distances[np.isfinite(least[rows])]
            fit.deepest = max(fit.deepest, float(depths.max(initial=0.0)))
        if not short.any():
            return moved_out
        moved_out[active[short]] = True
        active, keep = active[short], np.repeat(short, np.diff(part))
        rows, part = rows[keep], offsets(counts[active])
        near = Near(*(one[keep] for one in near))
        needs = np.where(near.distances < GOAL * least[rows], GOAL * least[rows] - near.distances, 0.0)
        if number == ROUNDS:
            fit.left += len(active)
            points[rows] += needs[:, None] * near.outward
            return moved_out
        reach = np.maximum(REACH * np.maximum.reduceat(needs, part[:-1]), REACH_SHARE * whole[active])
        own = points[rows]
        moves = _smooth(part, needs[:, None] * near.outward, reach, along[rows], steps[rows])
        kernel.follow(part, own, own + moves, steps[rows])
        points[rows] = own
    return moved_out


def _smooth(first: NDArray[np.int64], moves: Floats, reach: Floats, along: Floats, steps: Floats) -> Floats:
    """What points (P, 3) move of strands of which some have to: their neighbours as well, by less the farther they are,
    over about ``reach`` (S,) metres; roots, which do not, and the points behind them up to the first that has to by
    more and more."""
    counts, less = np.diff(first), 1 / (1 + steps / np.repeat(np.maximum(reach, TINY), np.diff(first)))
    needed = np.where(moves.any(axis=1), np.arange(len(moves)), len(moves))
    deep = np.repeat(np.minimum.reduceat(needed, first[:-1]), counts)
    order = range(2, int(counts.max()))
    for step, places in ((1, order), (-1, reversed(order))):
        for place in places:
            i = first[:-1][counts > place] + (place if step > 0 else place - 1)
            fading = less[i if step > 0 else i + 1][:, None] * moves[i - step]
            more = (fading**2).sum(axis=1) > (moves[i] ** 2).sum(axis=1)
            moves[i[more]] = fading[more]
    moves[np.arange(len(moves)) < deep] *= (along / np.maximum(along[deep], TINY))[np.arange(len(moves)) < deep, None]
    for _ in range(PASSES):
        after, before = np.roll(moves, -1, axis=0), np.roll(moves, 1, axis=0)
        after[first[1:] - 1] = moves[first[1:] - 1]
        smoothed = 0.25 * before + 0.5 * moves + 0.25 * after
        smoothed[first[:-1]] = 0.0
        moves = smoothed
    return moves


def _near(strands: Strands, surface: Surface, frame: Frame) -> NDArray[np.bool_]:
    """Return (S,) whether any point of a strand may be too near to the surface."""
    clear = CLEARANCE * surface.size
    found = np.zeros(strands.count, np.bool_)
    for rows, part in spans(strands.first, BATCH):
        points = frame.own(strands.points[part])
        steps = np.zeros(len(points))
        steps[1:] = ((points[1:] - points[:-1]) ** 2).sum(axis=1)
        least = surface.least(points) < clear + steps / (4 * surface.size)
        found[rows] = np.logical_or.reduceat(least, strands.first[rows] - part.start)
    return found


def _check(roots: Floats, off: Floats, surface: Surface, head: Head, file: str, advice: str) -> None:
    """Raise `UsageError` for roots (S, 3) so far off the surface that they cannot be meant for it, with advice."""
    large = float(np.ptp(roots, axis=0).max())
    ratio = max(large, 1e-30) / surface.size
    limit = FAR if 1 / UNLIKE < ratio < UNLIKE else FAR_UNLIKE
    if head.solid.kind == "plane" or not float(np.median(off)) > limit * surface.size:
        return
    advice = advice or "move, scale or turn one of them"
    raise UsageError(
        f"{file}: its roots are {np.median(off):.3g} m off {head.name}, which is {surface.size:.3g} m large, and "
        f"{large:.3g} m apart; {advice}"
    )


def _replaced(given: GroomFile | None) -> str:
    """What is advised where settings put hair elsewhere than its file does."""
    if given is None or (given.size is None and given.place == "file"):
        return ""
    return "emitter.groom.size and place move it; to have it where its file does, set size: null and place: file"
