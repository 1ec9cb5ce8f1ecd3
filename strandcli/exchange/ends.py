"""What strands themselves tell: which end is the root, and the up axis.

Hair leaves a scalp: its roots lie on a wide part of a sphere, strands fan out from there, and stay outside. Where they
end they do no such thing. Hair that hangs from a scalp tells which axis is up. Each is a guess only where all of
that is clear; grass on a plane, a mohawk, a fringe, fur that is trimmed tell nothing, for the other end may be the root
as well.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..common.rotations import AXES, axis
from .strands import Mask, Offsets, Strands

Floats = npt.NDArray[np.float64]

LEAST_STRANDS = 40
"""With fewer, nothing is guessed."""
ENOUGH = 5_000
"""Strands that are looked at, at most."""
MOST, ROUNDS = 0.9, 4
"""Share of the points that a sphere is fitted to, and how often anew: strands that run from tip to root are not."""
FITS = 0.08
"""Misfit of roots to the scalp's sphere, at most, over its radius and over the strands' reach."""
THICK = 0.18
"""Extent (root mean square) of a scalp across itself, at least, over the sphere's radius: half a ball has .29, a
straight or flat set none."""
FANS = 0.2
"""By how much the mean of the directions in which strands leave a scalp is shorter than at their other end, at least:
its length is 1 where all are parallel."""
LEAVES = 0.6
"""Median cosine between that direction and the sphere's normal, at least."""
OUTSIDE = 0.85
"""Share of the strands that stay outside the sphere in the mean, at least."""
CLEARER, LARGER = 0.7, 0.4
"""Distances of roots from their sphere are at most so much of those of tips from theirs; and roots are spread at least
so much as tips: hair that is drawn to a knot ends on a sphere, too."""
HANGS = 0.7
"""Cosine between hanging hair and down, at least, and between up and the way from the head's middle to the scalp's."""
CAP = 0.2
"""The latter, at least, over the radius."""


class Sphere(NamedTuple):
    """A sphere, and the root mean square of the distances of the points that it is fitted to."""

    centre: Floats
    radius: float
    misfit: float

    def height(self, points: npt.NDArray[np.floating]) -> Floats:
        """How far points (..., 3) are outside, radii."""
        found: Floats = np.linalg.norm(points - self.centre, axis=-1) / self.radius - 1
        return found


@dataclass(frozen=True, slots=True)
class End:
    """One end of strands: the sphere through its points; the root mean square of these about their mean, and across
    the direction in which they are thinnest; how long the mean is of the directions in which strands leave them, and
    its median cosine to the normal; the share of strands outside the sphere."""

    sphere: Sphere
    spread: float
    thin: float
    fan: float
    leaves: float
    outside: float

    def like_scalp(self, reach: float) -> bool:
        """Whether strands that reach so far leave it as they do a scalp."""
        return (
            self.sphere.misfit <= FITS * min(self.sphere.radius, reach) and self.thin >= THICK * self.sphere.radius
            and self.leaves >= LEAVES and self.outside >= OUTSIDE
        )  # fmt: skip

    def clearer(self, other: End) -> bool:
        """Whether it is a scalp sooner than another end, by a margin."""
        return (
            self.sphere.misfit <= CLEARER * other.sphere.misfit and self.spread >= LARGER * other.spread
            and self.fan <= other.fan - FANS
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Ends:
    """Which end is the root: "first", "last" or "" where nothing tells; the sphere of the scalp, None where roots lie
    on none."""

    root: str = ""
    scalp: Sphere | None = None


WHY = "there strands fan out from a scalp, and clearly less at their first points"
"""What tells that roots are last."""


def ends(strands: Strands) -> Ends:
    """Which end of finite strands is the root."""
    if strands.count < LEAST_STRANDS:
        return Ends()
    rows = _some(strands)
    reach = float(np.median(np.linalg.norm(_at(strands, rows, 1, False) - _at(strands, rows, 0, False), axis=1)))
    first, last = _end(strands, rows, False), _end(strands, rows, True)
    for name, one, rest in (("first", first, last), ("last", last, first)):
        if one.like_scalp(reach) and one.clearer(rest):
            return Ends(name, one.sphere)
    return Ends()


def _some(strands: Strands) -> Offsets:
    """The strands that are looked at, evenly chosen."""
    return np.arange(0, strands.count, -(-strands.count // ENOUGH))


def _end(strands: Strands, rows: Offsets, back: bool) -> End:
    """The first points of some strands, or with ``back`` the last ones."""
    points = _at(strands, rows, 0, back)
    sphere, near = fitted(points)
    among = points[near] - points[near].mean(axis=0)
    extents = np.linalg.eigvalsh(among.T @ among / len(among))
    leaving = _leaving(strands, rows, back, sphere.radius)
    heights = sum(sphere.height(_at(strands, rows, part, back)) for part in (0.25, 0.5, 0.75, 1.0))
    along = np.einsum("ij,ij->i", _units(points - sphere.centre), leaving)
    return End(
        sphere, float(np.sqrt(extents.sum())), float(np.sqrt(max(extents[0], 0.0))),
        float(np.linalg.norm(leaving.mean(axis=0))), float(np.median(along)),
        float(np.mean(heights > 0)),
    )  # fmt: skip


def _at(strands: Strands, rows: Offsets, part: float, back: bool) -> Floats:
    """The points of some strands at a share of their number, from the first, or with ``back`` from the last one."""
    counts = strands.first[rows + 1] - strands.first[rows] - 1
    place = np.clip((part * counts).astype(np.int64), min(1, int(part > 0)), counts)
    return strands.points[strands.first[rows] + (counts - place if back else place)].astype(np.float64)


def _leaving(strands: Strands, rows: Offsets, back: bool, radius: float) -> Floats:
    """Unit vectors along the beginnings of some strands: a sixth of them, or less where that is half a radius."""
    begin = _at(strands, rows, 0, back)
    found = _at(strands, rows, 1e-9, back) - begin
    for part in (0.02, 0.04, 0.08, 0.16):
        longer = _at(strands, rows, part, back) - begin
        found = np.where(np.linalg.norm(longer, axis=1, keepdims=True) < 0.5 * radius, longer, found)
    return _units(found)


def _units(vectors: Floats) -> Floats:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-30)


def fitted(points: npt.NDArray[np.floating]) -> tuple[Sphere, Mask]:
    """The sphere through most points, and which: fitted some times, each time to the points that were nearest to the
    last one, and first to those nearest to the middle: one point far away would make a sphere so large that all others
    lie on it."""
    points = points.astype(np.float64)  # whose squares overflow in single precision
    far = np.linalg.norm(points - np.median(points, axis=0), axis=1)
    for _ in range(ROUNDS + 1):
        near = far <= np.quantile(far, MOST)
        found = _fitted(points[near])
        far = np.abs(found.height(points))
    return found, near


def _fitted(p: Floats) -> Sphere:
    """The sphere of the least squares of |p|² − 2 c·p − (r² − |c|²)."""
    middle = p.mean(axis=0)
    p = p - middle
    size = float(np.sqrt((p * p).sum(axis=1).mean())) or 1.0
    p /= size
    solution = np.linalg.lstsq(np.column_stack([2 * p, np.ones(p.shape[0])]), (p * p).sum(axis=1), rcond=None)[0]
    centre = solution[:3]
    radius = float(np.sqrt(max(solution[3] + centre @ centre, 1e-30)))
    off = np.linalg.norm(p - centre, axis=1) - radius
    return Sphere(middle + size * centre, size * radius, size * float(np.sqrt((off * off).mean())))


def up_axis(strands: Strands, found: Ends) -> tuple[str, float] | None:
    """The up axis, and the cosine between hanging hair and down; None where hair hangs from no scalp above it."""
    if found.scalp is None:
        return None
    one, other = (_at(strands, _some(strands), part, found.root == "last") for part in (0, 1))
    reach = np.linalg.norm(other - one, axis=1)
    usual = np.minimum(reach, np.quantile(reach, MOST))  # how much a strand counts: no single one decides
    hanging = (usual @ _units(other - one)) / max(float(usual.sum()), 1e-30)
    cap = (np.median(one, axis=0) - found.scalp.centre) / found.scalp.radius
    for name in AXES:
        least = max(CAP, HANGS * float(np.linalg.norm(cap)))
        if hanging @ axis(name) <= -HANGS and cap @ axis(name) >= least:
            return name, float(-(hanging @ axis(name)))
    return None
