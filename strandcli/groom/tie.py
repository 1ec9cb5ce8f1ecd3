"""Ties: strands that are combed to one point of the emitter and bound there, as a ponytail.

A sphere has geodesic polar coordinates around the point below the tie: each root is at a distance D in a direction ψ on
the shortest path, a great circle. Per radian, A(d) is the area within d, and c(d) = A′(d) is the arc at d.

Hair keeps its volume. A bundle of radius ρ contains all of it, each strand at ρ √(A(D) / A(D_rim)): uniform roots fill
it uniformly, neighbours stay neighbours, and those from the hairline are outermost. Conservation of volume gives the
thickness of the hair that crosses the arc at d; a strand lies on all strands rooted between d and itself:

    h(d) = ρ² / 2 · (A(D) − A(d)) / (A(D_rim) c(d)).

A mesh has the coordinates of a sphere about the emitter's origin, from which its surface is seen: paths are great
circles of the sphere, moved out of the mesh.

Wisps are strands along the hairline that are too short for the tie, and stand off at their tips. Their share is `wisps`
at the hairline, and falls to 1/e over `wisp_length`. They do not hang: they are computed once, in the emitter's frame,
and move with it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..scene.model import Emitter, MeshShape, SphereShape
from ..scene.model.emitter import TIED
from .record import frame

if TYPE_CHECKING:
    from ..scene.model import Emitter
    from .record import Groom

Floats = NDArray[np.float64]
Over = Callable[[Floats, Floats], Floats]

ON_SURFACE = 14
"""Points of a path along the surface; the rest of `TIED` are on the curve into the bundle."""
TURN = 1.2
"""Distance from the bundle at which strands turn up, in heights of the tie."""
NEAR = 1e-9
"""Distance from the tie, metres, below which a root has no direction."""
SECTORS = 72
"""Directions about the tie in which the rim of the roots on a mesh is known."""
RIM = 0.2
"""Density on a mesh, as a share of the greatest, at which the rim of the roots is."""
BELOW = 0.9
"""Radius of the sphere below a mesh, as a share of the least distance of a root from the emitter's origin."""


@dataclass(frozen=True)
class Chart:
    """Geodesic polar coordinates of an emitter's sphere around the point below its tie, the foot; of a mesh, of the
    sphere below it."""

    cap: float
    """Polar angle from +y down to which strands grow, radians; of a mesh not used."""
    foot: Floats
    """(3,) metres."""
    normal: Floats
    """(3,)"""
    radius: float
    """Of the sphere, metres."""
    reach: Floats | None = None
    """(SECTORS,) of a mesh: the greatest polar angle of roots, radians, in equal sectors about the normal."""

    def polar(self, points: Floats) -> tuple[Floats, Floats]:
        """Return the distances (N,) of points (N, 3) of the surface from the foot along it, and the unit directions
        (N, 3) of their paths at the foot."""
        away = points - (points @ self.normal)[:, None] * self.normal
        size = np.linalg.norm(away, axis=1)
        some = np.cross(self.normal, [0.0, 0.0, 1.0] if abs(self.normal[2]) < 0.9 else [1.0, 0.0, 0.0])
        headings = np.where(size[:, None] > NEAR, away / np.maximum(size, NEAR)[:, None], some / np.linalg.norm(some))
        return self.radius * np.arctan2(size, points @ self.normal), headings

    def area(self, d: Floats) -> Floats:
        """Return A(d), m² a radian."""
        return np.asarray(2 * (self.radius * np.sin(0.5 * d / self.radius)) ** 2)

    def arc(self, d: Floats) -> Floats:
        """Return c(d), metres a radian."""
        return np.asarray(self.radius * np.sin(d / self.radius))

    def point(self, d: Floats, headings: Floats) -> tuple[Floats, Floats]:
        """Return points at distances d (N,) on paths with the ``headings`` (N, 3) at the foot, and the sphere's
        normals there; (N, 3) both."""
        turn = (d / self.radius)[:, None]
        normals = np.cos(turn) * self.normal + np.sin(turn) * headings
        return self.radius * normals, normals

    def rim(self, headings: Floats) -> Floats:
        """Return D_rim (N,), the greatest distance of roots on paths with the ``headings`` at the foot."""
        if self.reach is not None:
            every = np.arange(SECTORS + 1)
            return self.radius * np.interp(_sectors(self.normal, headings), every, np.append(self.reach, self.reach[0]))
        # the polar angle θ along a path: cos θ = a cos(d − δ)
        a = np.hypot(self.normal[1], headings[:, 1])
        middle = np.arctan2(headings[:, 1], self.normal[1])
        open_ = np.arccos(np.clip(np.cos(self.cap) / np.maximum(a, 1e-12), -1.0, 1.0))
        # a circle entirely within the cap is followed as far as it is a shortest path
        return np.asarray(self.radius * np.where(open_ < np.pi, np.clip(middle + open_, 1e-3, np.pi), np.pi))


def chart_of(emitter: Emitter) -> Chart:
    """Return the chart of an emitter with a tie."""
    assert emitter.tie is not None
    at = np.array(emitter.tie.position, np.float64)
    normal = at / np.linalg.norm(at)
    if isinstance(emitter.shape, MeshShape):
        return _chart_of_mesh(emitter.shape, normal)
    assert isinstance(emitter.shape, SphereShape)
    radius = emitter.shape.radius
    return Chart(float(np.radians(emitter.shape.cap)), radius * normal, normal, radius)


def _chart_of_mesh(shape: MeshShape, normal: Floats) -> Chart:
    """Return the chart of a mesh: of the greatest sphere about the origin that is well below its roots."""
    from .on_mesh import rise, seedbed

    bed = seedbed(shape)
    places = bed.corners[bed.pieces.values >= RIM * bed.pieces.values.max()]
    far = np.linalg.norm(places, axis=1)
    radius = BELOW * max(float(far.min()), NEAR)
    foot = radius * normal[None]
    chart = Chart(np.pi, (foot + rise(shape, foot, normal[None])[:, None] * normal)[0], normal, radius)
    d, headings = chart.polar(places)
    reach = np.zeros(SECTORS)
    np.maximum.at(reach, np.rint(_sectors(normal, headings)).astype(int) % SECTORS, d / radius)
    some = np.flatnonzero(reach)
    reach = np.interp(np.arange(SECTORS), some, reach[some], period=SECTORS)
    smooth = np.mean([np.roll(reach, k) for k in range(-2, 3)], axis=0)
    return replace(chart, reach=smooth)


def _sectors(normal: Floats, headings: Floats) -> Floats:
    """Return where unit vectors (N, 3) perpendicular to the normal lie about it, in sectors from 0 to `SECTORS`."""
    first, second = frame(normal[None])
    turn = np.arctan2(headings @ second[0], headings @ first[0])
    return np.asarray(turn / (2 * np.pi) % 1.0 * SECTORS)


def bind(emitter: Emitter, roots: Floats) -> tuple[Floats, Floats]:
    """Return the points at which strands with ``roots`` (N, 3) on the surface are bound, and their unit directions
    there; (N, 3) both, in the emitter's frame."""
    tie, chart = emitter.tie, chart_of(emitter)
    assert tie is not None
    axis = _axis(emitter, chart)
    d, headings = chart.polar(roots)
    # the least rotation from the normal to the axis, applied to the headings
    both = chart.normal + axis
    sides = headings - (headings @ axis / (1.0 + axis @ chart.normal))[:, None] * both
    share = np.sqrt(np.clip(chart.area(d) / chart.area(chart.rim(headings)), 0.0, 1.0))
    angle = np.radians(tie.spread) * share[:, None]
    return (
        chart.foot + tie.lift * axis + tie.radius * share[:, None] * sides,
        np.cos(angle) * axis + np.sin(angle) * sides,
    )


def paths(emitter: Emitter, groom: Groom, bows: Floats, over: Over) -> Floats:
    """Return the paths of tied strands from root to tie, (N, 1 + `TIED`, 3) metres in the emitter's frame: a point
    before the root, the root, and so on, without the end.

    bows (N, 2): greatest deviation of each from its path, up and sideways, metres; over: function of points (N, 3) and
    normals (N, 3), how far the points must move along the normals to be outside of solids.
    """
    tie, chart = emitter.tie, chart_of(emitter)
    assert tie is not None
    assert groom.grown is not None
    ends, directions = groom.roots.astype(np.float64), groom.directions.astype(np.float64)
    d, headings = chart.polar(groom.grown)
    aside = np.cross(chart.normal, headings)
    whole = chart.area(chart.rim(headings))
    own = np.linalg.norm(ends - chart.foot - tie.lift * _axis(emitter, chart), axis=1)
    last = np.minimum(own + TURN * max(tie.lift, 0.5 * tie.radius), 0.5 * d)

    def on(at: Floats) -> Floats:
        below = np.maximum(chart.area(d) - chart.area(at), 0.0)
        height = 0.5 * tie.radius**2 * below / np.maximum(whole * chart.arc(at), 1e-30)
        bow = np.sin(np.pi * np.clip(at / np.maximum(d, NEAR), 0.0, 1.0)) ** 2
        bare, normals = chart.point(at, headings)
        height += bows[:, 0] * bow + over(bare, normals)
        return np.asarray(bare + height[:, None] * normals + (bows[:, 1] * bow)[:, None] * aside)

    step = 1e-3 * np.maximum(d, NEAR)
    found = [on(d + step)]
    found += [on(d + (last - d) * (k / ON_SURFACE)) for k in range(ON_SURFACE)]
    start = on(last)
    tangent = _unit(start - on(last + step))
    # a cubic Hermite curve into the bundle
    size = np.linalg.norm(ends - start, axis=1)[:, None]
    normals = chart.point(last, headings)[1]
    turn = TIED - ON_SURFACE
    for k in range(turn):
        t = k / turn
        there = (
            (1 + 2 * t) * (1 - t) ** 2 * start + t * (1 - t) ** 2 * size * tangent
            + t * t * (3 - 2 * t) * ends - t * t * (1 - t) * size * directions
        )  # fmt: skip
        found.append(there + over(there, normals)[:, None] * normals)
    # as far before the root as the next point is after it
    found[0] = found[1] + np.linalg.norm(found[2] - found[1], axis=1)[:, None] * _unit(found[0] - found[1])
    return np.stack(found, 1)


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1), 1e-30)[:, None])


def _axis(emitter: Emitter, chart: Chart) -> Floats:
    assert emitter.tie is not None
    if emitter.tie.direction is None:
        return chart.normal
    axis = np.array(emitter.tie.direction, np.float64)
    return np.asarray(axis / np.linalg.norm(axis))


ASIDE = 0.7
"""Greatest angle, radians, between the path to the tie and a wisp's direction at its root."""
BEND = 1.2
"""Greatest angle by which a wisp turns from root to tip, radians."""
OFF = 0.4
"""Greatest distance of tips from the surface as a share of the length; half of them have less than an eighth of it."""
SHORTEST = 0.4
"""Least length as a share of `wisp_length`."""

LENGTH, DIRECTION, SWING, TIP = range(4)
"""Columns of the random numbers of wisps."""


def chosen(emitter: Emitter, groom: Groom, lots: Floats) -> NDArray[np.int64]:
    """Return (K,) the numbers of the strands that are wisps; lots (strands,): uniform random numbers in [0, 1)."""
    tie, chart = emitter.tie, chart_of(emitter)
    assert tie is not None
    assert groom.grown is not None
    d, headings = chart.polar(groom.grown)
    inside = np.maximum(chart.rim(headings) - d, 0.0)
    return np.flatnonzero(lots < tie.wisps * np.exp(-inside / tie.wisp_length))


def wisps(emitter: Emitter, roots: Floats, lots: Floats, rows: int, over: Over) -> NDArray[np.float32]:
    """Return wisps with ``roots`` (K, 3): (K, rows, 3) metres in the emitter's frame, the point before the root first.
    lots (K, 4): uniform random numbers in [0, 1) for length, direction, bend and distance of the tip; over: as in
    `tie.paths`."""
    tie, chart = emitter.tie, chart_of(emitter)
    assert tie is not None
    d, headings = chart.polar(roots)
    begins, normals = chart.point(d, headings)
    ahead = chart.point(d - 1e-4 * tie.wisp_length, headings)[0] - begins
    ahead /= np.linalg.norm(ahead, axis=1)[:, None]
    aside = np.cross(normals, ahead)
    length = tie.wisp_length * (SHORTEST + (1.0 - SHORTEST) * lots[:, LENGTH])
    begin, bend = ASIDE * (2.0 * lots[:, DIRECTION] - 1.0), BEND * (2.0 * lots[:, SWING] - 1.0)
    pieces = rows - 2
    found, flat = [], roots.astype(np.float64)
    for k in range(pieces + 1):
        share = k / pieces
        up = flat / np.linalg.norm(flat, axis=1)[:, None]
        bare = chart.radius * up
        height = OFF * lots[:, TIP] ** 3 * length * share * share + over(bare, up)
        found.append(bare + height[:, None] * up)
        turn = begin + bend * (share + 0.5 / pieces)
        flat = flat + (length / pieces)[:, None] * (np.cos(turn)[:, None] * ahead + np.sin(turn)[:, None] * aside)
    return np.stack([2.0 * found[0] - found[1], *found], 1).astype(np.float32)
