"""Strands that are combed to one place of the emitter and bound there, as a ponytail.

About the place below the tie the surface has polar coordinates: every root lies at a distance D along it in a direction
ψ, on the shortest path there is, a great circle of a sphere or a line of a plane. Per radian, A(d) is the area of the
surface nearer than d, and c(d) = A′(d) the arc at d.

Hair keeps its volume. A bundle of radius ρ holds all of it, each strand at ρ √(A(D) / A(D_rim)), so that strands rooted
evenly fill it evenly, neighbours stay neighbours, and those from the hairline lie outermost. Where the same hair
crosses the arc at d it lies as thick as that asks for, and a strand lies on all that is rooted between d and itself:

    h(d) = ρ² / 2 · (A(D) − A(d)) / (A(D_rim) c(d)).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..scene.model import DiscShape, Emitter, PlaneShape, SphereShape
from ..scene.model.emitter import TIED

if TYPE_CHECKING:
    from .record import Groom

Floats = NDArray[np.float64]
Over = Callable[[Floats, Floats], Floats]

ON_SURFACE = 14
"""Points of a path along the surface; the rest of `TIED` are where it turns up into the bundle."""
TURN = 1.2
"""Heights of the tie, beyond the bundle's radius, from which on strands turn up."""
NEAR = 1e-9
"""Metres under which a root has no direction from the tie."""


@dataclass(frozen=True)
class Chart:
    """An emitter's surface in polar coordinates about the place below its tie."""

    shape: SphereShape | DiscShape | PlaneShape
    foot: Floats
    """(3,) metres."""
    normal: Floats
    """(3,)"""
    radius: float
    """Of the surface's curvature, metres; infinite where it is flat."""

    def polar(self, points: Floats) -> tuple[Floats, Floats]:
        """Distances (N,) of points (N, 3) of the surface along it, and unit vectors (N, 3) in which each path begins
        at the foot."""
        away = points - self.foot
        if np.isfinite(self.radius):
            away = points - (points @ self.normal)[:, None] * self.normal
        size = np.linalg.norm(away, axis=1)
        some = np.cross(self.normal, [0.0, 0.0, 1.0] if abs(self.normal[2]) < 0.9 else [1.0, 0.0, 0.0])
        ways = np.where(size[:, None] > NEAR, away / np.maximum(size, NEAR)[:, None], some / np.linalg.norm(some))
        if np.isfinite(self.radius):
            size = self.radius * np.arctan2(size, points @ self.normal)
        return size, ways

    def area(self, d: Floats) -> Floats:
        """A(d), m²."""
        if np.isfinite(self.radius):
            return np.asarray(2 * (self.radius * np.sin(0.5 * d / self.radius)) ** 2)
        return 0.5 * d * d

    def arc(self, d: Floats) -> Floats:
        """c(d), m."""
        return np.asarray(self.radius * np.sin(d / self.radius)) if np.isfinite(self.radius) else d

    def point(self, d: Floats, ways: Floats, height: Floats) -> tuple[Floats, Floats]:
        """Points at distances d (N,) along paths that begin in ``ways`` (N, 3), so far above the surface, and its
        normals there, (N, 3) both."""
        if not np.isfinite(self.radius):
            normals = np.broadcast_to(self.normal, ways.shape)
            return self.foot + d[:, None] * ways + height[:, None] * normals, normals
        turn = (d / self.radius)[:, None]
        normals = np.cos(turn) * self.normal + np.sin(turn) * ways
        return (self.radius + height[:, None]) * normals, normals

    def rim(self, ways: Floats) -> Floats:
        """D_rim (N,): how far roots reach on the paths that begin in ``ways``, from a foot that they surround."""
        shape, x, z = self.shape, ways[:, 0], ways[:, 2]
        if isinstance(shape, SphereShape):  # the polar angle θ along a path: cos θ = a cos(d − δ)
            a = np.hypot(self.normal[1], ways[:, 1])
            middle = np.arctan2(ways[:, 1], self.normal[1])
            open_ = np.arccos(np.clip(np.cos(np.radians(shape.cap)) / np.maximum(a, 1e-12), -1.0, 1.0))
            # a circle that leaves the cap nowhere is followed as far as there are shortest ways
            return np.asarray(self.radius * np.where(open_ < np.pi, np.clip(middle + open_, 1e-3, np.pi), np.pi))
        u, w = self.foot[0], self.foot[2]
        if isinstance(shape, DiscShape):
            along = u * x + w * z
            return np.asarray(np.sqrt(np.maximum(along**2 + shape.radius**2 - u * u - w * w, 0.0)) - along)
        with np.errstate(divide="ignore", invalid="ignore"):
            sides = [
                (half - np.sign(way) * at) / np.abs(way)
                for half, at, way in ((shape.width / 2, u, x), (shape.depth / 2, w, z))
            ]
        return np.asarray(np.nanmin(sides, axis=0))


def chart_of(emitter: Emitter) -> Chart:
    """The chart of an emitter that has a tie."""
    assert emitter.tie is not None
    at = np.array(emitter.tie.position, np.float64)
    if isinstance(emitter.shape, SphereShape):
        normal = at / np.linalg.norm(at)
        return Chart(emitter.shape, emitter.shape.radius * normal, normal, emitter.shape.radius)
    return Chart(emitter.shape, at * [1.0, 0.0, 1.0], np.array([0.0, 1.0, 0.0]), np.inf)


def bind(emitter: Emitter, roots: Floats) -> tuple[Floats, Floats]:
    """Where strands with ``roots`` (N, 3) on the surface are bound, and the unit directions in which they leave the
    tie, (N, 3) both, in the emitter's frame."""
    tie, chart = emitter.tie, chart_of(emitter)
    assert tie is not None
    axis = _axis(emitter, chart)
    d, ways = chart.polar(roots)
    # the least turn that takes the normal to the axis takes the ways along
    both = chart.normal + axis
    sides = ways - (ways @ axis / (1.0 + axis @ chart.normal))[:, None] * both
    share = np.sqrt(np.clip(chart.area(d) / chart.area(chart.rim(ways)), 0.0, 1.0))
    angle = np.radians(tie.spread) * share[:, None]
    return (
        chart.foot + tie.lift * axis + tie.radius * share[:, None] * sides,
        np.cos(angle) * axis + np.sin(angle) * sides,
    )


def paths(emitter: Emitter, groom: Groom, bows: Floats, over: Over) -> Floats:
    """The ways of tied strands from where they grow to where they are bound, (N, 1 + `TIED`, 3) metres in the emitter's
    frame: a point before the root, in whose direction from there they begin, the root, and on, the end left out.

    ``bows`` (N, 2): how far each departs from its way at the most, up and aside, metres. ``over``: how far up points
    (N, 3) have to be moved along normals (N, 3).
    """
    tie, chart = emitter.tie, chart_of(emitter)
    assert tie is not None
    assert groom.grown is not None
    ends, directions = groom.roots.astype(np.float64), groom.directions.astype(np.float64)
    d, ways = chart.polar(groom.grown)
    aside = np.cross(chart.normal, ways)
    whole = chart.area(chart.rim(ways))
    own = np.linalg.norm(ends - chart.foot - tie.lift * _axis(emitter, chart), axis=1)
    last = np.minimum(own + TURN * max(tie.lift, 0.5 * tie.radius), 0.5 * d)

    def on(at: Floats) -> Floats:
        below = np.maximum(chart.area(d) - chart.area(at), 0.0)
        height = 0.5 * tie.radius**2 * below / np.maximum(whole * chart.arc(at), 1e-30)
        bow = np.sin(np.pi * np.clip(at / np.maximum(d, NEAR), 0.0, 1.0)) ** 2
        bare, normals = chart.point(at, ways, 0 * at)
        height += bows[:, 0] * bow + over(bare, normals)
        return np.asarray(bare + height[:, None] * normals + (bows[:, 1] * bow)[:, None] * aside)

    step = 1e-3 * np.maximum(d, NEAR)
    found = [on(d + step)]
    found += [on(d + (last - d) * (k / ON_SURFACE)) for k in range(ON_SURFACE)]
    start = on(last)
    way = _unit(start - on(last + step))
    # a cubic by Hermite up into the bundle
    size = np.linalg.norm(ends - start, axis=1)[:, None]
    normals = chart.point(last, ways, 0 * last)[1]
    turn = TIED - ON_SURFACE
    for k in range(turn):
        t = k / turn
        there = (
            (1 + 2 * t) * (1 - t) ** 2 * start + t * (1 - t) ** 2 * size * way
            + t * t * (3 - 2 * t) * ends - t * t * (1 - t) * size * directions
        )  # fmt: skip
        found.append(there + over(there, normals)[:, None] * normals)
    # so far before the root as the next point is behind it
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
