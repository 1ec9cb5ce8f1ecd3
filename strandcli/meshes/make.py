"""A mesh from bare triangles: merged at seams, wound outward, its faults counted.

mesh = make_mesh(vertices, triangles)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..common.counted import counted
from ..errors import UsageError, one_line
from ..exchange.edits import prints_of, repeats
from .mesh import FileNormals, Indices, MeshFacts, TriangleMesh, Vectors, face_vectors, slices
from .topology import oriented

NO_AREA = 1e-12
"""A triangle's height over its longest edge, under which it counts as having no area."""
LARGEST = 1e15
"""Coordinates, at most: products of three of them are finite in single precision."""
MOST = 2**29
"""Triangles, at most: so that edges have numbers of 31 bits."""
MOST_VERTICES = 2**31 - 2
"""Likewise."""


@dataclass(frozen=True, slots=True, eq=False)
class RawMesh:
    """Triangles as a file has them; vertices may be there several times.

    vertices: (n, 3); triangles: (m, 3); normals: (n, 3) or None; uv: (m, 3, 2) or None; colours: (n, 3) linear or None;
    attributes: (n,) or (n, k) each; texture: as of `TriangleMesh`; notes: what was left out already;
    normal_rows: (m, 3) rows of `normals` of corners, where these are not those of their vertices.
    """

    vertices: npt.NDArray[Any]
    triangles: npt.NDArray[Any]
    normals: npt.NDArray[Any] | None = None
    uv: npt.NDArray[Any] | None = None
    colours: npt.NDArray[Any] | None = None
    attributes: Mapping[str, npt.NDArray[Any]] = field(default_factory=dict)
    texture: npt.NDArray[np.uint8] | None = None
    notes: tuple[str, ...] = ()
    normal_rows: npt.NDArray[Any] | None = None


def lines_beside(count: int) -> tuple[str, ...]:
    """A note where a file has lines besides."""
    return (f"{counted(count, 'line')}, which 'render' and 'convert' read as strands",) if count else ()


def make_mesh(vertices: npt.NDArray[Any], triangles: npt.NDArray[Any], where: str = "mesh") -> TriangleMesh:
    """The mesh of triangles (T, 3) of vertices (V, 3). Raises `UsageError`, which begins with ``where``."""
    return mesh_of(RawMesh(np.asarray(vertices), np.asarray(triangles)), where)


def mesh_of(raw: RawMesh, where: str) -> TriangleMesh:
    """The mesh of what a file has. Raises `UsageError`, which begins with ``where``, where nothing is to be drawn.

    Memory is the tightest while it runs: what is no longer needed is let go, and large steps go by slices.
    """
    vertices, rows = _checked(raw, where)
    raw, notes = _finite(raw)
    of_place = places(vertices)
    triangles = of_place[rows]
    with_area = _with_area(vertices, triangles)
    no_area = int(with_area.size - np.count_nonzero(with_area))
    first = _first_of_each(triangles, with_area)
    if not first.any():
        count = with_area.size
        raise UsageError(f"{where}: none of its {count:,} triangles has an area; write it anew from its program")
    whole = bool(first.all())
    repeated = int(np.count_nonzero(with_area) - np.count_nonzero(first))
    if not whole:
        triangles, rows = triangles[first], rows[first]
    wanted = None
    if raw.normals is not None:
        wanted = rows if raw.normal_rows is None else raw.normal_rows if whole else raw.normal_rows[first]
    del rows, with_area
    used, merge = _used(triangles, vertices.shape[0])
    if used is not None:
        triangles, vertices = merge[triangles], vertices[used]
    merged = int(np.count_nonzero(of_place != np.arange(of_place.size, dtype=np.int32)))
    merge = np.take(merge, of_place, out=of_place)
    del of_place
    turned, counts, closed = oriented(vertices, triangles)
    facts = MeshFacts(
        no_area=no_area, repeated=repeated, unused=int(np.count_nonzero(merge < 0)), merged=merged,
        turned=int(turned.sum()), **counts,
    )  # fmt: skip
    _turn(triangles, turned)
    own = None if raw.normals is None or wanted is None else FileNormals(raw.normals, wanted, turned)

    def of_used(values: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
        return np.ascontiguousarray(values if used is None else values[used], np.float32)

    uv = None
    if raw.uv is not None:
        uv = raw.uv if whole else raw.uv[first]
        _turn(uv, turned)
    return TriangleMesh(
        vertices, triangles, None, own, uv,
        None if raw.colours is None else of_used(raw.colours),
        {name: of_used(values) for name, values in raw.attributes.items()},
        raw.texture, closed, facts, (*raw.notes, *notes, *sentences(facts, triangles.shape[0]).values()), merge,
    )  # fmt: skip


def _used(triangles: Indices, vertices: int) -> tuple[Indices | None, Indices]:
    """The vertices that triangles have, None of all, and of each vertex (V,) which of them it is, or -1."""
    has = np.zeros(vertices, np.bool_)
    has[triangles.reshape(-1)] = True
    if has.all():
        return None, np.arange(vertices, dtype=np.int32)
    used = np.flatnonzero(has).astype(np.int32)
    number = np.full(vertices, -1, np.int32)
    number[used] = np.arange(used.size, dtype=np.int32)
    return used, number


def _turn(corners: npt.NDArray[Any], turned: npt.NDArray[np.bool_]) -> None:
    """Change the order of corners (T, 3, …) of the triangles that are turned."""
    corners[turned] = corners[turned][:, (0, 2, 1)]


def _checked(raw: RawMesh, where: str) -> tuple[Vectors, Indices]:
    """Vertices and triangles that can be computed with."""
    if np.ndim(raw.vertices) != 2 or np.shape(raw.vertices)[1] != 3:
        raise UsageError(f"{where}: its vertices have not three coordinates each; it is damaged: write it anew")
    with np.errstate(invalid="ignore"):
        vertices = np.array(raw.vertices, np.float64, order="C")
        vertices += 0.0  # -0 becomes 0
    triangles = np.asarray(raw.triangles)
    if not triangles.size:
        raise UsageError(f"{where}: has no triangles; strands grow on surfaces, not on points or lines")
    if triangles.shape[0] > MOST:
        raise UsageError(f"{where}: {triangles.shape[0]:,} triangles are more than {MOST:,}; write a coarser mesh")
    if vertices.shape[0] > MOST_VERTICES:
        raise UsageError(
            f"{where}: {vertices.shape[0]:,} vertices are more than {MOST_VERTICES:,}; write a coarser mesh"
        )
    triangles = triangles if triangles.dtype.kind in "iu" else triangles.astype(np.int64)
    for some in slices(triangles.shape[0]):
        outside = (triangles[some] < 0) | (triangles[some] >= vertices.shape[0])
        if outside.any():
            t, k = (int(one[0]) for one in np.nonzero(outside))
            raise UsageError(
                f"{where}: triangle {some.start + t:,} wants vertex {triangles[some.start + t, k]:,}, there are "
                f"{vertices.shape[0]:,}; it is damaged: write it anew"
            )
    wrong = np.empty(vertices.shape[0], np.bool_)
    for some in slices(wrong.size):
        wrong[some] = ~(np.abs(vertices[some]) <= LARGEST).all(axis=1)
    bad = wrong[triangles].any(axis=1) if wrong.any() else wrong[:0]
    if bad.any():
        t = int(np.flatnonzero(bad)[0])
        v = int(triangles[t][wrong[triangles[t]]][0])
        raise UsageError(
            f"{where}: vertex {v:,} is ({', '.join(f'{x:g}' for x in vertices[v])}), in "
            f"{counted(int(np.count_nonzero(bad)), 'triangle')}; coordinates are finite and at most {LARGEST:g}: "
            "mend it in its program"
        )
    vertices[wrong] = 0.0
    return vertices, np.ascontiguousarray(triangles, np.int32)


def _finite(raw: RawMesh) -> tuple[RawMesh, list[str]]:
    """What belongs to vertices and corners, with 0 for what is not finite, and a line for each that had such; normals
    are looked at later, and vertices and triangles, which are checked already, are left out."""
    notes: list[str] = []

    def finite(name: str, values: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
        with np.errstate(over="ignore", invalid="ignore"):
            single = np.asarray(values, np.float32)
        bad = single.size - int(np.count_nonzero(np.isfinite(single)))
        if bad:
            notes.append(f"{name}: {counted(bad, 'number')} not finite: taken as 0")
        return np.nan_to_num(single, nan=0.0, posinf=0.0, neginf=0.0)

    uv = None if raw.uv is None else finite("texture coordinates", raw.uv)
    colours = None if raw.colours is None else finite("colours", raw.colours)
    attributes = {one_line(name)[:80]: finite(one_line(name)[:80], values) for name, values in raw.attributes.items()}
    none, no_triangles = np.zeros((0, 3)), np.zeros((0, 3), np.int32)
    bare = replace(raw, vertices=none, triangles=no_triangles, uv=uv, colours=colours, attributes=attributes)
    return bare, notes


def places(vertices: Vectors) -> Indices:
    """Of each vertex (V,) the first one at the same place."""
    found = np.arange(vertices.shape[0], dtype=np.int32)
    first, again = equal_rows(found.size, lambda rows: vertices[rows].view(np.uint64))
    found[again] = first
    return found


def equal_rows(
    count: int, words: Callable[[Any], npt.NDArray[np.uint64]]
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Rows, of so many, that are equal to a lower one: the lowest, and their own. ``words``: of some rows the numbers
    (k, m) that tell them apart."""
    prints = np.empty(count, np.uint64)
    for rows in slices(count):
        prints[rows] = prints_of(words(rows))
    return repeats(prints, lambda one, other: np.asarray((words(one) == words(other)).all(axis=1)))


def _with_area(vertices: Vectors, corners: Indices) -> npt.NDArray[np.bool_]:
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


def _first_of_each(corners: Indices, with_area: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """The triangles (T,), among those with an area, that repeat no earlier one, however it is wound."""
    found, rows = with_area.copy(), np.flatnonzero(with_area).astype(np.int32)
    _, again = equal_rows(rows.size, lambda some: np.sort(corners[rows[some]], axis=1).astype(np.uint64))
    found[rows[again]] = False
    return found


def sentences(facts: MeshFacts, triangles: int) -> dict[str, str]:
    """What was found, by its name among the facts, and what it means in a sentence."""
    was = "was" if facts.turned == 1 else "were"
    found = {
        "no_area": ("triangle", "triangles", "without area: left out"),
        "repeated": ("triangle", "triangles", "equal to another: left out"),
        "unused": ("vertex", "vertices", "of no triangle: left out"),
        "turned": ("of", "of", f"{triangles:,} triangles {was} wound the opposite way: turned"),
        "twisted": ("edge", "edges", "whose triangles cannot agree on an outside; mend the mesh there"),
        "crowded": ("edge", "edges", "of three triangles or more; what is inside is doubtful there"),
        "boundary": ("edge", "edges", "on its rim; inside is where the surface goes more than half around"),
    }
    said = {}
    for name, (one, many, words) in found.items():
        count = getattr(facts, name)
        if count:
            said[name] = f"{counted(count, one, many)} {words}"
    if facts.boundary:
        said["boundary"] = f"open: {counted(facts.holes, 'hole')}, {said['boundary']}"
    return said
