"""A mesh from bare triangles: merged at seams, wound outward, its faults counted.

mesh = make_mesh(vertices, triangles)
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import UsageError, one_line
from .kernels.topology import join, orient
from .mesh import Indices, MeshFacts, TriangleMesh, Vectors, face_vectors, slices, smooth_normals, unit

FLAT = 0.01
"""A part whose volume is less than this times the power 3/2 of its area is a sheet, without an outside; of a sphere it
is .094."""
NO_AREA = 1e-12
"""A triangle's height over its longest edge, under which it counts as having no area."""
LARGEST = 1e15
"""Coordinates, at most: products of three of them are finite in single precision."""
MOST = 2**29
"""Triangles, at most: so that edges have numbers of 31 bits."""


@dataclass(frozen=True, slots=True, eq=False)
class RawMesh:
    """Triangles as a file has them; vertices may be there several times.

    vertices: (n, 3); triangles: (m, 3); normals: (n, 3) or None; uv: (m, 3, 2) or None; colours: (n, 3) linear or None;
    attributes: (n,) or (n, k) each; texture: as of `TriangleMesh`; notes: what was left out already.
    """

    vertices: npt.NDArray[Any]
    triangles: npt.NDArray[Any]
    normals: npt.NDArray[Any] | None = None
    uv: npt.NDArray[Any] | None = None
    colours: npt.NDArray[Any] | None = None
    attributes: Mapping[str, npt.NDArray[Any]] = field(default_factory=dict)
    texture: npt.NDArray[np.uint8] | None = None
    notes: tuple[str, ...] = ()


def make_mesh(vertices: npt.NDArray[Any], triangles: npt.NDArray[Any], where: str = "mesh") -> TriangleMesh:
    """The mesh of triangles (T, 3) of vertices (V, 3). Raises `UsageError`, which begins with ``where``."""
    return mesh_of(RawMesh(np.asarray(vertices), np.asarray(triangles)), where)


def mesh_of(raw: RawMesh, where: str) -> TriangleMesh:
    """The mesh of what a file has. Raises `UsageError`, which begins with ``where``, where nothing is to be drawn."""
    vertices, triangles = _checked(raw, where)
    raw, notes = _finite(raw)
    of_place = places(vertices)
    corners = of_place[triangles]
    kept = _with_area(vertices, corners)
    no_area = int(kept.size - np.count_nonzero(kept))
    first = _first_of_each(corners, kept)
    repeated = int(np.count_nonzero(kept) - first.size)
    if not first.size:
        raise UsageError(f"{where}: none of its {kept.size:,} triangles has an area; write it anew from its program")
    used, row = np.unique(corners[first], return_inverse=True)
    found = row.reshape(-1, 3).astype(np.int32)
    turned, counts, closed = oriented(vertices[used], found)
    merge = np.full(vertices.shape[0], -1, np.int32)
    merge[used] = np.arange(used.size, dtype=np.int32)
    merge = merge[of_place]
    facts = MeshFacts(
        no_area=no_area, repeated=repeated, unused=int(np.count_nonzero(merge < 0)),
        merged=int(np.count_nonzero(of_place != np.arange(of_place.size))), turned=int(turned.sum()), **counts,
    )  # fmt: skip
    order = np.where(turned[:, None], np.array((0, 2, 1)), np.array((0, 1, 2)))
    found = np.ascontiguousarray(np.take_along_axis(found, order, axis=1))
    uv = None if raw.uv is None else np.take_along_axis(raw.uv[first], order[:, :, None], axis=1)
    normals = smooth_normals(vertices[used], found)
    of_corners: Vectors | None = None
    if raw.normals is not None:
        rows = np.take_along_axis(triangles[first], order, axis=1)
        of_corners = _own_normals(raw.normals[rows], turned, normals[found])
    return TriangleMesh(
        vertices[used], found, normals, of_corners,
        None if uv is None else np.ascontiguousarray(uv, np.float32),
        None if raw.colours is None else np.ascontiguousarray(raw.colours[used], np.float32),
        {name: np.ascontiguousarray(values[used], np.float32) for name, values in raw.attributes.items()},
        raw.texture, closed, facts, (*raw.notes, *notes, *sentences(facts, found.shape[0]).values()), merge,
    )  # fmt: skip


def _checked(raw: RawMesh, where: str) -> tuple[Vectors, npt.NDArray[np.int64]]:
    """Vertices and triangles that can be computed with."""
    if np.ndim(raw.vertices) != 2 or np.shape(raw.vertices)[1] != 3:
        raise UsageError(f"{where}: its vertices have not three coordinates each; it is damaged: write it anew")
    with np.errstate(invalid="ignore"):
        vertices = np.ascontiguousarray(raw.vertices, np.float64) + 0.0  # -0 becomes 0
    triangles = np.ascontiguousarray(raw.triangles, np.int64)
    if not triangles.size:
        raise UsageError(f"{where}: has no triangles; strands grow on surfaces, not on points or lines")
    if triangles.shape[0] > MOST:
        raise UsageError(f"{where}: {triangles.shape[0]:,} triangles are more than {MOST:,}; write a coarser mesh")
    outside = (triangles < 0) | (triangles >= vertices.shape[0])
    if outside.any():
        t, k = (int(one[0]) for one in np.nonzero(outside))
        raise UsageError(
            f"{where}: triangle {t:,} wants vertex {triangles[t, k]:,}, there are {vertices.shape[0]:,}; "
            "it is damaged: write it anew"
        )
    with np.errstate(invalid="ignore"):
        wrong: npt.NDArray[np.bool_] = np.logical_not((np.abs(vertices) <= LARGEST).all(axis=1))
    bad = wrong[triangles].any(axis=1)
    if bad.any():
        t = int(np.flatnonzero(bad)[0])
        v = int(triangles[t][wrong[triangles[t]]][0])
        raise UsageError(
            f"{where}: vertex {v:,} is ({', '.join(f'{x:g}' for x in vertices[v])}), in {np.count_nonzero(bad):,} "
            f"triangles; coordinates are finite and at most {LARGEST:g}: mend it in its program"
        )
    vertices[wrong] = 0.0
    return vertices, triangles


def _finite(raw: RawMesh) -> tuple[RawMesh, list[str]]:
    """What belongs to vertices and corners with 0 for what is not finite, and a line for each that had such; normals
    are looked at later."""
    notes: list[str] = []

    def finite(name: str, values: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
        with np.errstate(over="ignore", invalid="ignore"):
            single = np.asarray(values, np.float32)
        bad = single.size - np.count_nonzero(np.isfinite(single))
        if bad:
            notes.append(f"{name}: {bad:,} numbers that are not finite: taken as 0")
        return np.nan_to_num(single, nan=0.0, posinf=0.0, neginf=0.0)

    uv = None if raw.uv is None else finite("texture coordinates", raw.uv)
    colours = None if raw.colours is None else finite("colours", raw.colours)
    attributes = {one_line(name)[:80]: finite(one_line(name)[:80], values) for name, values in raw.attributes.items()}
    return replace(raw, uv=uv, colours=colours, attributes=attributes), notes


def places(vertices: Vectors) -> npt.NDArray[np.int64]:
    """Of each vertex (V,) the first one at the same place."""
    order = np.lexsort(vertices.T)
    ordered = vertices[order]
    new = np.ones(order.size, np.bool_)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    found = np.empty(order.size, np.int64)
    found[order] = order[new][np.cumsum(new) - 1]
    return found


def _with_area(vertices: Vectors, corners: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
    """Which triangles have an area."""
    found = np.empty(corners.shape[0], np.bool_)
    for rows in slices(corners.shape[0]):
        some = corners[rows]
        points = vertices[some]
        longest = np.zeros(some.shape[0])
        for k in range(3):
            edge = points[:, (k + 1) % 3] - points[:, k]
            longest = np.maximum(longest, np.einsum("ij,ij->i", edge, edge))
        area = np.linalg.norm(face_vectors(points), axis=1)
        found[rows] = (some != np.roll(some, 1, axis=1)).all(axis=1) & (area > NO_AREA * longest)
    return found


def _first_of_each(corners: npt.NDArray[np.int64], kept: npt.NDArray[np.bool_]) -> npt.NDArray[np.int64]:
    """The triangles, among those that are kept, that repeat no earlier one, whichever way it is wound."""
    rows = np.flatnonzero(kept)
    ordered = np.sort(corners[rows], axis=1)
    order = np.lexsort(ordered.T)
    new = np.ones(rows.size, np.bool_)
    new[1:] = (ordered[order[1:]] != ordered[order[:-1]]).any(axis=1)
    return rows[np.sort(order[new])]


def _own_normals(normals: npt.NDArray[Any], turned: npt.NDArray[np.bool_], smooth: Vectors) -> Vectors:
    """Normals (T, 3, 3) of corners from the file's; smooth ones where the file has none. Normals of triangles that were
    wound the wrong way point inward, as far as they agree with that winding."""
    found = np.where(np.isfinite(normals).all(axis=2, keepdims=True), normals, 0.0)
    found = unit(found)
    inward = turned & (np.einsum("tkj,tkj->t", found, smooth) < 0)
    found[inward] *= -1.0
    return np.where(found.any(axis=2, keepdims=True), found, smooth)


def oriented(vertices: Vectors, triangles: Indices) -> tuple[npt.NDArray[np.bool_], dict[str, int], bool]:
    """Which triangles (T,) have to be turned so that neighbours agree and parts are wound outward; facts about edges;
    and whether the mesh is closed then."""
    count = triangles.shape[0]
    neighbours, opposed, boundary, crowded = _across_edges(triangles, vertices.shape[0])
    part = np.full(count, -1, np.int32)
    turned, queue = np.zeros(count, np.bool_), np.empty(count, np.int32)
    parts = orient(neighbours, opposed, part, turned, queue)
    vectors, centres = np.empty((count, 3)), np.empty((count, 3))
    for rows in slices(count):
        corners = vertices[triangles[rows]]
        vectors[rows] = 0.5 * face_vectors(corners) * np.where(turned[rows], -1.0, 1.0)[:, None]
        centres[rows] = corners.mean(axis=1)
    area = np.linalg.norm(vectors, axis=1)
    whole = np.bincount(part, area, parts)
    middle = np.stack([np.bincount(part, area * centres[:, k], parts) / whole for k in range(3)], axis=1)
    volume = np.bincount(part, np.einsum("ij,ij->i", centres - middle[part], vectors), parts) / 3.0
    against = np.bincount(part, turned, parts) * 2 > np.bincount(part, minlength=parts)
    turned ^= np.where(np.abs(volume) > FLAT * whole**1.5, volume < 0, against)[part]
    agree = (neighbours < 0) | (turned[:, None] ^ turned[neighbours] == opposed)
    twisted = int(np.count_nonzero(~agree)) // 2
    facts = {
        "boundary": boundary.shape[0], "holes": _rings(boundary), "crowded": crowded, "twisted": twisted,
        "parts": parts,
    }  # fmt: skip
    return turned, facts, _balanced(np.where(turned[:, None], triangles[:, ::-1], triangles), vertices.shape[0])


def _half_edges(triangles: Indices, vertices: int) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.bool_]]:
    """Of each half edge (3 T,) a number that both sides share, and whether it goes from the lower vertex."""
    a, b = triangles.reshape(-1).astype(np.int64), np.roll(triangles, -1, axis=1).reshape(-1).astype(np.int64)
    return np.minimum(a, b) * vertices + np.maximum(a, b), a < b


def _across_edges(triangles: Indices, vertices: int) -> tuple[Indices, npt.NDArray[np.bool_], Indices, int]:
    """Neighbours (T, 3), whether they are wound the other way, edges of one triangle alone (B, 2), and the number of
    edges of three or more."""
    number, forward = _half_edges(triangles, vertices)
    order = np.argsort(number, kind="stable")
    number = number[order]
    begin = np.flatnonzero(np.append(True, number[1:] != number[:-1]))
    count = np.diff(np.append(begin, order.size))
    neighbours = np.full(order.size, -1, np.int32)
    opposed = np.zeros(order.size, np.bool_)
    one, other = order[begin[count == 2]], order[begin[count == 2] + 1]
    neighbours[one], neighbours[other] = other // 3, one // 3
    opposed[one] = opposed[other] = forward[one] == forward[other]
    alone = number[begin[count == 1]]
    boundary = np.stack([alone // vertices, alone % vertices], axis=1).astype(np.int32)
    return neighbours.reshape(-1, 3), opposed.reshape(-1, 3), boundary, int(np.count_nonzero(count > 2))


def _rings(boundary: Indices) -> int:
    """Rings that boundary edges (B, 2) make."""
    if not boundary.size:
        return 0
    vertices, row = np.unique(boundary, return_inverse=True)
    parent = np.empty(vertices.size, np.int32)
    join(row.reshape(-1, 2).astype(np.int32), parent)
    return int(np.unique(parent).size)


def _balanced(triangles: Indices, vertices: int) -> bool:
    """Whether every edge is gone along as often in one direction as in the other."""
    number, forward = _half_edges(triangles, vertices)
    return np.array_equal(np.sort(number[forward]), np.sort(number[~forward]))


def sentences(facts: MeshFacts, triangles: int) -> dict[str, str]:
    """What was found, by its name among the facts, and what it means in a sentence."""
    turned = f"{{:,}} of {triangles:,} triangles were wound the other way: turned"
    holes = f"open: {facts.holes:,} holes of {{:,}} edges; inside is where the surface goes more than half around"
    found = {
        "no_area": "{:,} triangles without area: left out",
        "repeated": "{:,} triangles that repeat another: left out",
        "unused": "{:,} vertices of no triangle: left out",
        "turned": turned,
        "twisted": "{:,} edges whose triangles cannot agree on an outside; mend the mesh there",
        "crowded": "{:,} edges of three triangles or more; what is inside is doubtful there",
        "boundary": holes,
    }
    counts = {name: getattr(facts, name) for name in found}
    return {name: text.format(counts[name]) for name, text in found.items() if counts[name]}
