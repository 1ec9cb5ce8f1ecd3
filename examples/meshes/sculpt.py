"""Sculptures as signed distance fields: ellipsoids and tubes that run into each other, bumps and creases on them.

A sculpture is a list of parts, applied in order to one number, the distance to the surface (negative inside). All sizes
are metres. The field is a distance near simple parts and only nearly one elsewhere; what makes a mesh of it follows its
gradient, so this does no harm.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import contextmanager

import numpy as np
from numba import njit, prange

# Columns of a part.
KIND, OP, BLEND, AMOUNT = 0, 1, 2, 3
CENTRE = 4  # 3 numbers
FRAME = 7  # 9 numbers: rows are the part's axes
SIZE = 16  # 3 numbers: half-axes of an ellipsoid
BOUND = 19  # centre and radius of a ball round the part
FIRST, COUNT = 23, 24  # points of a tube; of a group, COUNT parts follow
COLUMNS = 25

ELLIPSOID, TUBE, GROUP, GROUP_END, PLANE = range(5)
ADD, CUT, KEEP, BUMP = range(4)
FAR = 1e3

Vector = Sequence[float]


def rotation(degrees: Vector) -> np.ndarray:
    """The matrix that turns about x, then y, then z. Shape (3, 3)."""
    (cx, sx), (cy, sy), (cz, sz) = ((math.cos(math.radians(a)), math.sin(math.radians(a))) for a in degrees)
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


def smooth_curve(points: np.ndarray, pieces: int) -> np.ndarray:
    """Points on the Catmull-Rom curve through the rows of an array, `pieces` for each of its spans."""
    before, after = 2 * points[:1] - points[1:2], 2 * points[-1:] - points[-2:-1]
    knots = np.concatenate([before, points, after])
    t = np.arange(pieces)[:, None] / pieces
    spans = []
    for a, b, c, d in zip(knots, knots[1:], knots[2:], knots[3:], strict=False):
        spans.append(b + t * (c - a) / 2 + t**2 * (a - 2.5 * b + 2 * c - d / 2) + t**3 * (1.5 * (b - c) + (d - a) / 2))
    return np.concatenate([*spans, points[-1:]])


def both_sides(rows: list[tuple[float, ...]]) -> list[tuple[float, ...]]:
    """A curve that begins in the middle, continued to the other side."""
    return [(-x, *rest) for x, *rest in rows[:0:-1]] + list(rows)


class Sculpture:
    """A list of parts. With `mirror` a part also appears on the other side of the plane x = 0."""

    def __init__(self) -> None:
        self.parts: list[np.ndarray] = []
        self.points: list[np.ndarray] = []

    def ball(
        self, at: Vector, size: Vector | float, blend: float, *, turn: Vector = (0, 0, 0), op: int = ADD,
        mirror: bool = False, amount: float = 0,
    ) -> None:  # fmt: skip
        """Add, cut or bump by an ellipsoid of half-axes `size`, turned by degrees; `blend` rounds where it joins."""
        sizes = np.broadcast_to(np.asarray(size, float), 3)
        reach = sizes.max() * (3.2 if op == BUMP else 1)
        for side in (1, -1) if mirror else (1,):
            flip = np.diag([side, 1.0, 1.0])
            part = np.zeros(COLUMNS)
            part[[KIND, OP, BLEND, AMOUNT]] = ELLIPSOID, op, blend, amount
            part[CENTRE : CENTRE + 3] = part[BOUND : BOUND + 3] = flip @ np.asarray(at, float)
            frame = rotation(turn) if np.ndim(turn) == 1 else np.asarray(turn)
            part[FRAME : FRAME + 9] = (flip @ frame @ flip).T.ravel()
            part[SIZE : SIZE + 3] = sizes
            part[BOUND + 3] = reach
            self.parts.append(part)

    def bump(self, at: Vector, size: Vector | float, amount: float, *, turn: Vector = (0, 0, 0), mirror=False) -> None:
        """Move the surface outward by `amount` metres, fading as a Gaussian of the given half-axes."""
        self.ball(at, size, 0, turn=turn, op=BUMP, mirror=mirror, amount=amount)

    def tube(
        self, points: Sequence[Vector], blend: float, *, op: int = ADD, mirror: bool = False, amount: float = 0,
        pieces: int = 6, drape: bool = False,
    ) -> None:  # fmt: skip
        """Add, cut or bump along a smooth curve through rows (x, y, z, radius).

        With `drape` the curve is moved in z onto the front of what there is so far, and its own z says how far ahead.
        """
        curve = smooth_curve(np.asarray(points, float), pieces)
        if drape:
            curve[:, 2] += self.front(curve[:, :2])
        for side in (1, -1) if mirror else (1,):
            there = curve * [side, 1, 1, 1]
            part = np.zeros(COLUMNS)
            part[[KIND, OP, BLEND, AMOUNT]] = TUBE, op, blend, amount
            part[[FIRST, COUNT]] = sum(len(p) for p in self.points), len(there)
            middle = (there[:, :3].min(0) + there[:, :3].max(0)) / 2
            part[BOUND : BOUND + 3] = middle
            grown = np.linalg.norm(there[:, :3] - middle, axis=1) + there[:, 3] * (3.2 if op == BUMP else 1)
            part[BOUND + 3] = grown.max()
            self.parts.append(part)
            self.points.append(there)

    def crease(self, points: Sequence[Vector], depth: float, *, mirror: bool = False, drape: bool = False) -> None:
        """Move the surface inward by `depth` along a curve through rows (x, y, z, radius); a ridge where negative."""
        self.tube(points, 0, op=BUMP, mirror=mirror, amount=-depth, drape=drape)

    def front(self, places: np.ndarray, start: float = 0.14) -> np.ndarray:
        """The foremost z of the surface at places (x, y), shape (N, 2)."""
        z = np.full(len(places), start)
        for _ in range(200):
            z -= 0.6 * self.field(np.column_stack([places, z]))
        return z

    def keep_above(self, height: float, blend: float) -> None:
        """Cut off what is below a height."""
        part = np.zeros(COLUMNS)
        part[[KIND, OP, BLEND]] = PLANE, KEEP, blend
        part[CENTRE + 1] = height
        self.parts.append(part)

    @contextmanager
    def group(self, bound: Vector, blend: float, *, op: int = ADD, mirror: bool = False):
        """Parts that are joined with each other before they join the rest. `bound`: centre and radius round them."""
        inner = Sculpture()
        yield inner
        for side in (1, -1) if mirror else (1,):
            flip = np.diag([side, 1.0, 1.0])
            head, end = np.zeros(COLUMNS), np.zeros(COLUMNS)
            head[[KIND, OP, BLEND, COUNT]] = GROUP, op, blend, len(inner.parts)
            head[BOUND : BOUND + 4] = np.asarray(bound, float) * [side, 1, 1, 1]
            end[[KIND, OP, BLEND]] = GROUP_END, op, blend
            self.parts.append(head)
            for part in inner.parts:
                copy = part.copy()
                copy[[CENTRE, BOUND]] *= side
                copy[FRAME : FRAME + 9] = (flip @ part[FRAME : FRAME + 9].reshape(3, 3) @ flip).ravel()
                if part[KIND] == TUBE:
                    copy[FIRST] = sum(len(p) for p in self.points)
                    first = int(part[FIRST])
                    self.points.append(np.concatenate(inner.points)[first : first + int(part[COUNT])] * [side, 1, 1, 1])
                self.parts.append(copy)
            self.parts.append(end)

    def tables(self) -> tuple[np.ndarray, np.ndarray]:
        """The parts and the points of tubes, as the field's kernel takes them."""
        return np.array(self.parts), np.concatenate(self.points) if self.points else np.zeros((1, 4))

    def field(self, points: np.ndarray) -> np.ndarray:
        """Distances of points, shape (..., 3), to the surface; negative inside."""
        flat = np.ascontiguousarray(points.reshape(-1, 3), float)
        return fields(*self.tables(), flat).reshape(points.shape[:-1])

    def gradient(self, points: np.ndarray, step: float = 2e-4) -> np.ndarray:
        """The field's gradient at points, shape (N, 3), by differences between the corners of a tetrahedron."""
        corners = np.array([[1, -1, -1], [-1, -1, 1], [-1, 1, -1], [1, 1, 1]])
        return sum(c * self.field(points + step * c)[:, None] for c in corners) / (4 * step)

    def project(self, points: np.ndarray, steps: int = 3) -> np.ndarray:
        """Points moved along the gradient onto the surface."""
        for _ in range(steps):
            g = self.gradient(points)
            move = self.field(points)[:, None] * g / np.maximum((g * g).sum(1, keepdims=True), 0.04)
            length = np.linalg.norm(move, axis=1, keepdims=True)
            points = points - move * np.minimum(1, 0.004 / np.maximum(length, 1e-12))
        return points


@njit(cache=True)
def join(a, b, k):
    """The smaller of two distances, rounded over a width k; twice differentiable."""
    if k <= 0:
        return min(a, b)
    h = max(k - abs(a - b), 0.0) / k
    return min(a, b) - h * h * h * k / 6


@njit(cache=True)
def ellipsoid(part, p):
    """(relative radius, roughly the distance) of a point and an ellipsoid."""
    inner = 0.0
    steep = 0.0
    for i in range(3):
        d = 0.0
        for j in range(3):
            d += part[FRAME + 3 * i + j] * (p[j] - part[CENTRE + j])
        q = d / part[SIZE + i]
        inner += q * q
        steep += (q / part[SIZE + i]) ** 2
    radius = math.sqrt(inner)
    if steep == 0:
        return 0.0, -min(part[SIZE], part[SIZE + 1], part[SIZE + 2])
    return radius, radius * (radius - 1) / math.sqrt(steep)


@njit(cache=True)
def tube(part, points, p):
    """(relative distance, distance) of a point and a curve with radii."""
    first = int(part[FIRST])
    nearest = 1e9
    relative = 1e9
    for i in range(first, first + int(part[COUNT]) - 1):
        ab2 = 0.0
        along = 0.0
        for j in range(3):
            e = points[i + 1, j] - points[i, j]
            ab2 += e * e
            along += e * (p[j] - points[i, j])
        t = min(max(along / ab2, 0.0), 1.0)
        d2 = 0.0
        for j in range(3):
            d2 += (p[j] - points[i, j] - t * (points[i + 1, j] - points[i, j])) ** 2
        d = math.sqrt(d2)
        r = points[i, 3] + t * (points[i + 1, 3] - points[i, 3])
        nearest = min(nearest, d - r)
        relative = min(relative, d / r)
    return relative, nearest


@njit(cache=True)
def distance(parts, points, p):
    """The field at one point."""
    f = FAR
    outer = FAR
    i = 0
    while i < len(parts):
        part = parts[i]
        kind, op, k = int(part[KIND]), int(part[OP]), part[BLEND]
        if kind == PLANE:
            f = -join(-f, p[1] - part[CENTRE + 1], k)
            i += 1
            continue
        if kind == GROUP_END:
            f, inner = outer, f
            if op == ADD:
                f = join(f, inner, k)
            elif op == CUT:
                f = -join(-f, inner, k)
            else:
                f = -join(-f, -inner, k)
            i += 1
            continue
        apart = 0.0
        for j in range(3):
            apart += (p[j] - part[BOUND + j]) ** 2
        apart = math.sqrt(apart) - part[BOUND + 3]
        if (op == ADD and apart > f + k) or (op == CUT and apart > k - f) or (op == BUMP and apart > 0):
            i += int(part[COUNT]) + 2 if kind == GROUP else 1
            continue
        if kind == GROUP:
            outer = f
            f = FAR
            i += 1
            continue
        relative, d = ellipsoid(part, p) if kind == ELLIPSOID else tube(part, points, p)
        if op == ADD:
            f = join(f, d, k)
        elif op == CUT:
            f = -join(-f, d, k)
        elif op == KEEP:
            f = -join(-f, -d, k)
        elif relative < 3.2:
            f -= part[AMOUNT] * (math.exp(-relative * relative) - 3.57e-5)
        i += 1
    return f


@njit(cache=True, parallel=True)
def fields(parts, points, where):
    """The field at the rows of `where`."""
    out = np.empty(len(where))
    for i in prange(len(where)):
        out[i] = distance(parts, points, where[i])
    return out
