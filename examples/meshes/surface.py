"""A closed triangle mesh of a field: surface nets on a grid, then remeshing to a wanted length of edges."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numba import njit

Field = Callable[[np.ndarray], np.ndarray]


def net(field: Field, axes: tuple[np.ndarray, np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (N, 3) and triangles (M, 3), outward, of the field's zero surface on a grid of uneven spacing.

    A vertex a cell that the surface passes, in the middle of the places where it crosses the cell's edges; a
    quadrilateral an edge that it crosses (surface nets, Gibson 1998).
    """
    x, y, z = axes
    values = sampled(field, axes)
    inside = values < 0
    shape = tuple(n - 1 for n in values.shape)
    total, count = np.zeros((*shape, 3)), np.zeros(shape)
    corner = np.stack(np.meshgrid(x, y, z, indexing="ij"), -1)
    for axis in range(3):
        others = [a for a in range(3) if a != axis]
        low, high = ([slice(None)] * 3 for _ in range(2))
        low[axis], high[axis] = slice(None, -1), slice(1, None)
        low, high = tuple(low), tuple(high)
        crossed = inside[low] != inside[high]
        t = np.where(crossed, values[low] / np.where(crossed, values[low] - values[high], 1), 0)[..., None]
        place = np.where(crossed[..., None], corner[low] + t * (corner[high] - corner[low]), 0)
        for first in (slice(None, -1), slice(1, None)):
            for second in (slice(None, -1), slice(1, None)):
                pick = [slice(None)] * 3
                pick[others[0]], pick[others[1]] = first, second
                total += place[tuple(pick)]
                count += crossed[tuple(pick)]
    used = count > 0
    number = np.where(used, np.cumsum(used.ravel()).reshape(shape) - 1, -1)
    return total[used] / count[used][:, None], quads(inside, number)


def sampled(field: Field, axes: tuple[np.ndarray, np.ndarray, np.ndarray]) -> np.ndarray:
    """The field on a grid; in blocks of 4 x 4 x 4 that are far from the surface, the value in the block's middle."""
    shape = tuple(len(a) for a in axes)
    blocks = [np.array_split(np.arange(len(a)), -(-len(a) // 4)) for a in axes]
    low, high = ([np.array([a[i[k]] for i in split]) for a, split in zip(axes, blocks, strict=True)] for k in (0, -1))
    middle = np.stack(np.meshgrid(*((a + b) / 2 for a, b in zip(low, high, strict=True)), indexing="ij"), -1)
    half = np.stack(np.meshgrid(*((b - a) / 2 for a, b in zip(low, high, strict=True)), indexing="ij"), -1)
    coarse = field(middle)
    owner = np.ix_(*(np.repeat(np.arange(len(split)), [len(i) for i in split]) for split in blocks))
    values = coarse[owner]
    near = (np.abs(coarse) < 2 * np.linalg.norm(half, axis=-1) + 0.006)[owner]
    at = np.nonzero(near)
    values[at] = field(np.stack([a[i] for a, i in zip(axes, at, strict=True)], -1))
    assert values.shape == shape
    return values


def quads(inside: np.ndarray, number: np.ndarray) -> np.ndarray:
    """Triangles, two for each edge of the grid between inside and outside; `number` has the vertices of cells."""
    found = []
    for axis in range(3):
        low = [slice(1, -1)] * 3
        high = [slice(1, -1)] * 3
        low[axis], high[axis] = slice(None, -1), slice(1, None)
        a, b = inside[tuple(low)], inside[tuple(high)]
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for change, turn in ((a & ~b, 1), (~a & b, -1)):
            at = np.argwhere(change)
            at[:, [u, v]] += 1
            ring = []
            for du, dv in ((-1, -1), (0, -1), (0, 0), (-1, 0))[::turn]:
                cell = at.copy()
                cell[:, u] += du
                cell[:, v] += dv
                ring.append(number[tuple(cell.T)])
            found += [np.stack([ring[0], ring[1], ring[2]], 1), np.stack([ring[0], ring[2], ring[3]], 1)]
    return np.concatenate(found)


def crowded(faces: np.ndarray) -> bool:
    """Whether an edge belongs to more than two faces."""
    edges = np.sort(faces[:, [1, 2, 2, 0, 0, 1]].reshape(-1, 2), 1)
    return bool((np.unique(edges, axis=0, return_counts=True)[1] > 2).any())


def edges_of(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges (E, 2), smaller end first, and for each edge the two faces' corners opposite to it, as (E, 2) vertices.

    Of a closed mesh: each edge has two faces.
    """
    ends = faces[:, [1, 2, 2, 0, 0, 1]].reshape(-1, 2)
    forward = ends[:, 0] < ends[:, 1]
    order = np.lexsort((~forward, ends.max(1), ends.min(1)))
    pairs = np.sort(ends, 1)[order].reshape(-1, 2, 2)
    assert (pairs[:, 0] == pairs[:, 1]).all(), "the mesh is not closed"
    return pairs[:, 0], order.reshape(-1, 2)


class Remesher:
    """Triangles of a surface, brought to edges of a wanted length by splits, collapses, flips and relaxing."""

    def __init__(self, sculpture, size: Callable[[np.ndarray], np.ndarray], points: np.ndarray, faces: np.ndarray):
        self.sculpture, self.size, self.points, self.faces = sculpture, size, points, faces
        self.rng = np.random.default_rng(1)

    def edges(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Edges, the half-edges of each, and their length in units of the wanted one."""
        edges, half = edges_of(self.faces)
        a, b = self.points[edges[:, 0]], self.points[edges[:, 1]]
        return edges, half, np.linalg.norm(a - b, axis=1) / self.size((a + b) / 2)

    def split(self, limit: float = 1.4) -> int:
        """Put a vertex in the middle of long edges; returns their number."""
        edges, half, length = self.edges()
        cut = length > limit
        new = np.full(len(edges), -1)
        new[cut] = len(self.points) + np.arange(cut.sum())
        self.points = np.concatenate([self.points, self.points[edges[cut]].mean(1)])
        middle = np.empty(3 * len(self.faces), int)
        middle[half[:, 0]] = middle[half[:, 1]] = new
        middle = middle.reshape(-1, 3)  # opposite to each corner
        count = (middle >= 0).sum(1)
        out: list[np.ndarray] = [self.faces[count == 0]]
        for n in (1, 2, 3):
            f, m = self.faces[count == n], middle[count == n]
            if n < 3:  # turn so that the first corner is opposite to the only cut edge, or to the only whole one
                shift = np.argmax((m >= 0) if n == 1 else (m < 0), axis=1)
                pick = (shift[:, None] + np.arange(3)) % 3
                f, m = np.take_along_axis(f, pick, 1), np.take_along_axis(m, pick, 1)
            (a, b, c), (p, q, r) = f.T, m.T
            if n == 1:
                pieces = [(a, b, p), (a, p, c)]
            elif n == 2:
                pieces = [(a, r, q), (r, b, q), (b, c, q)]
            else:
                pieces = [(a, r, q), (r, b, p), (q, p, c), (p, q, r)]
            out += [np.stack(piece, 1) for piece in pieces]
        self.faces = np.concatenate(out)
        return int(cut.sum())

    def collapse(self, limit: float = 0.72) -> int:
        """Draw the ends of short edges together where the surface stays closed and unfolded; returns their number."""
        edges, _, length = self.edges()
        short = np.nonzero(length < limit)[0]
        short = short[np.argsort(length[short], kind="stable")]
        corners = np.argsort(self.faces.ravel(), kind="stable")
        start = np.searchsorted(self.faces.ravel()[corners], np.arange(len(self.points) + 1))
        move = np.arange(len(self.points))
        place = self.points.copy()
        number = collapse_edges(edges[short], self.faces, start, corners // 3, self.points, (move, place))
        faces = move[self.faces]
        kept = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
        used, faces = np.unique(faces[kept], return_inverse=True)
        self.points, self.faces = place[used], faces.reshape(-1, 3)
        return number

    def flip(self) -> int:
        """Swap diagonals where that brings numbers of neighbours nearer to six; returns how many."""
        edges, half, _ = self.edges()
        degree = np.bincount(edges.ravel(), minlength=len(self.points))
        tips = self.faces.ravel()[half]
        a, b, c, d = *edges.T, *tips.T  # faces (c, a, b) and (d, b, a)
        now = sum((degree[v] - 6) ** 2 for v in (a, b, c, d))
        after = sum((degree[v] - 6 + s) ** 2 for v, s in ((a, -1), (b, -1), (c, 1), (d, 1)))
        gain = (now - after).astype(float)
        p = self.points
        first, second = cross(p[a], p[d], p[c]), cross(p[b], p[c], p[d])
        flat = cosine(first, second) > 0.8
        mean = cross(p[a], p[b], p[c]) + cross(p[b], p[a], p[d])
        flat &= (cosine(first, mean) > 0.6) & (cosine(second, mean) > 0.6)
        flat &= (degree[a] > 4) & (degree[b] > 4)
        exists = set(map(tuple, edges.tolist()))
        wish = flat & (gain > 0)
        score = np.where(wish, gain + 0.01 * self.rng.random(len(gain)), -np.inf)
        best = np.full(len(p), -np.inf)
        for v in (a, b, c, d):
            np.maximum.at(best, v, score)
        chosen = wish & np.logical_and.reduce([score >= best[v] for v in (a, b, c, d)])
        for e in np.nonzero(chosen)[0]:
            key = (min(c[e], d[e]), max(c[e], d[e]))
            if key in exists:
                chosen[e] = False
            exists.add(key)
        faces = self.faces.copy()
        faces[half[chosen, 0] // 3] = np.stack([c, a, d], 1)[chosen]
        faces[half[chosen, 1] // 3] = np.stack([d, b, c], 1)[chosen]
        self.faces = faces
        return int(chosen.sum())

    def relax(self, share: float = 0.6) -> None:
        """Move vertices towards the middle of their neighbours' faces, along the surface."""
        p, f = self.points, self.faces
        middle = p[f].mean(1)
        weight = np.linalg.norm(area_vectors(p, f), axis=1) / self.size(middle) ** 2
        total, sum_ = np.zeros(len(p)), np.zeros_like(p)
        for corner in range(3):
            np.add.at(total, f[:, corner], weight)
            np.add.at(sum_, f[:, corner], middle * weight[:, None])
        step = sum_ / total[:, None] - p
        normal = unit(self.sculpture.gradient(p))
        step -= normal * (normal * step).sum(1, keepdims=True)
        self.points = self.sculpture.project(p + share * step, 2)

    def run(self, rounds: int) -> None:
        """Remesh in a number of rounds."""
        for number in range(rounds):
            self.split()
            for _ in range(12 if number == 0 else 5):
                if self.collapse() < len(self.points) // 200:
                    break
            for _ in range(5):
                if self.flip() < len(self.points) // 200:
                    break
            self.relax()
        self.points = self.sculpture.project(self.points, 8)


@njit(cache=True)
def collapse_edges(edges, faces, start, around, points, out):
    """Collapse edges in the order given, no two of them near each other; returns how many.

    Writes where each vertex goes (`move`) and where the remaining ones lie (`place`). An edge stays if its ends have
    more than two neighbours in common, or if a face would turn by more than 60 degrees.
    """
    move, place = out
    locked = np.zeros(len(points), np.bool_)
    mark = np.full(len(points), -1)
    number = 0
    for e in range(len(edges)):
        a, b = edges[e]
        free = True
        common = 0
        for v in (a, b):
            for k in range(start[v], start[v + 1]):
                for c in range(3):
                    w = faces[around[k], c]
                    free = free and not locked[w]
                    if v == a:
                        mark[w] = e
                    elif mark[w] == e and w != a and w != b:
                        mark[w] = -2
                        common += 1
        if not free or common != 2:
            continue
        middle = (points[a] + points[b]) / 2
        for v in (a, b):
            for k in range(start[v], start[v + 1]):
                f = faces[around[k]]
                if (f == a).sum() + (f == b).sum() == 2:
                    continue
                p = points[f]
                old = np.cross(p[1] - p[0], p[2] - p[0])
                for c in range(3):
                    if f[c] == v:
                        p[c] = middle
                new = np.cross(p[1] - p[0], p[2] - p[0])
                free = free and (old * new).sum() > 0.5 * math.sqrt((old * old).sum() * (new * new).sum())
        if not free:
            continue
        move[b] = a
        place[a] = middle
        number += 1
        for v in (a, b):
            for k in range(start[v], start[v + 1]):
                for c in range(3):
                    locked[faces[around[k], c]] = True
    return number


def area_vectors(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Normals of faces, twice as long as their area."""
    return cross(*(points[faces[:, i]] for i in range(3)))


def cross(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """The vectors (b - a) x (c - a)."""
    return np.cross(b - a, c - a)


def unit(v: np.ndarray) -> np.ndarray:
    """Vectors of length one."""
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-12)


def cosine(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Cosines of the angles between vectors."""
    return (unit(a) * unit(b)).sum(-1)
