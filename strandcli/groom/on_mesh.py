"""Roots on a mesh.

The mesh's triangles, or parts of them on which the density is linear, stand one behind the other on a line, each as
long as its area times its density. Neighbours on the line are neighbours on the surface: triangles that face the same
way follow each other along Hilbert's curve (1891), and on a triangle halves follow each other. Strand i grows where
the additive recurrence of the golden ratio is on that line, every prefix of which covers it evenly: it depends on the
seed and on i alone, and any number of the first strands is spread as the density wants.

Combed strands lie on the mesh that they grow on: ties move points out of it.

With the coat's pattern each strand has the colour of the mesh where it grows. Few colours stand for all, those of a
palette that depends on the mesh alone, so that the colour of strand i depends on the seed and on i alone. Each is
followed by its shades, dark to pale, among which the material's spread of brightness tells strands of one colour apart.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.counted import counted
from ..errors import UsageError
from ..files.inputs import cached
from ..mesh_file.maps import Pieces, Place, coloured, encoded, lookup, pieces, vectors
from ..mesh_file.prepared import distances
from ..mesh_file.read import KEPT, placed, placing
from ..meshes.mesh import TriangleMesh, face_vectors, unit
from ..scene.model import Emitter, MeshShape
from ..scene.model.emitter import LEAST_MAPPED
from .record import Anchors, Coat

Floats = NDArray[np.float64]

Y = 1
GOLDEN = 0.6180339887498949  # the golden ratio's fraction
BITS = 16
"""Of a coordinate along Hilbert's curve."""
OPEN = "open:"
"""How notes on holes begin: strands need no inside."""
LEAST_LENGTH, MOST_LENGTH = 1 / 1000, 10
"""Lengths of strands over the size of their mesh beyond which it is taken to be in another unit."""
AT_ONCE = 1 << 18
"""Strands that are placed at once, which bounds the memory."""


class Ground(NamedTuple):
    """Where strands grow. n: strands."""

    points: Floats
    """(n, 3) metres, in the emitter's frame."""
    normals: Floats
    """(n, 3) unit vectors, smooth."""
    anchors: Anchors
    lengths: Floats
    """(n,) factors of the length."""
    combed: Floats | None
    """(n, 3) directions in which strands are combed; None: the mesh has none."""


class Seedbed(NamedTuple):
    """A mesh as strands are spread over it. P: pieces."""

    mesh: TriangleMesh
    pieces: Pieces
    ends: Floats
    """(P,) where pieces end on the line from 0 to 1."""
    corners: Floats
    """(P, 3, 3) metres."""
    area: float
    """Of the mesh, m²."""
    grown: float
    """Of the pieces that bear strands, m²."""
    even: float
    """Area that would bear as many strands at the greatest density everywhere, m²."""
    used: int
    """Triangles that bear strands."""


def ground(shape: MeshShape, start: float, count: int) -> Ground:
    """Return where the first ``count`` strands of a mesh grow; ``start``: where on its line the first does, in [0, 1).
    Raises `UsageError` for a mesh or a map that cannot be used."""
    bed = seedbed(shape)
    piece, within = np.empty(count, np.int32), np.empty((count, 3))
    line = (start + GOLDEN * np.arange(count, dtype=np.float64)) % 1.0
    _place(bed, line, piece, within)
    triangles = bed.pieces.triangles[piece].astype(np.int32)
    shares = np.einsum("nk,nkc->nc", within, bed.pieces.corners[piece])
    anchors = Anchors(triangles, shares)
    points, normals = at_anchors(bed.mesh, anchors)
    lengths = np.ones(count)
    if shape.length:
        found = lookup(bed.mesh, shape.length, Place(shape.file, "emitter.shape.length"), triangles, shares)
        lengths = np.clip(found, LEAST_MAPPED, 1.0)
    combed = None
    if shape.comb:
        rows = vectors(bed.mesh, shape.comb, Place(shape.file, "emitter.shape.comb"), shape.up)
        combed = np.einsum("nk,nkc->nc", shares, rows[bed.mesh.triangles[triangles]])
    return Ground(points, normals, anchors, lengths, combed)


def at_anchors(mesh: TriangleMesh, anchors: Anchors) -> tuple[Floats, Floats]:
    """Return the points of a mesh at anchors, and its smooth unit normals there, both (n, 3)."""
    corners = mesh.triangles[anchors.triangles]
    points = np.einsum("nk,nkc->nc", anchors.shares, mesh.vertices[corners])
    normals = np.einsum("nk,nkc->nc", anchors.shares, mesh.normals[corners])
    size = np.linalg.norm(normals, axis=1)
    faces = unit(face_vectors(mesh.vertices[corners]))
    normals = np.where((size > 0.1)[:, None], normals, faces)  # at a sharp fold smooth normals cancel
    return points, unit(normals)


def seedbed(shape: MeshShape) -> Seedbed:
    """Return a mesh as strands are spread over it, cached as long as its files stay. Raises `UsageError`."""
    return _seedbed(shape.file, placing(shape), shape.density, shape.above)


@cached(KEPT)
def _seedbed(file: str, how: Any, density: str, above: float | None) -> Seedbed:
    mesh = placed(file, how)
    found = pieces(mesh, density, Place(file, "emitter.shape.density"))
    corners = np.einsum("pck,pkd->pcd", found.corners, mesh.vertices[mesh.triangles[found.triangles]])
    areas = 0.5 * np.linalg.norm(face_vectors(corners), axis=1)
    values = np.maximum(found.values, 0.0)
    if above is not None:
        values = np.where(corners[:, :, Y] > above, values, 0.0)
    measure = areas * values.mean(axis=1)
    whole, most = float(measure.sum()), float(values.max())
    if not whole > 0:
        raise UsageError(
            f"{file}: emitter.shape.density: {density!r} is 0 all over the mesh, so that nothing grows; "
            "take another one, or mend it"
            if above is None
            else f"{file}: emitter.shape.above: nothing grows above {above:g} m, where no vertex has "
            f"a density; it reaches from {corners[:, :, Y].min():.3g} to {corners[:, :, Y].max():.3g} m"
        )
    order = along_curve(corners.mean(axis=1), face_vectors(corners))
    order = order[measure[order] > 0]
    triangles = found.triangles[order]
    ends = np.cumsum(measure[order]) / whole
    ends[-1] = 1.0
    return Seedbed(
        mesh, Pieces(triangles, found.corners[order], values[order]), ends, np.ascontiguousarray(corners[order]),
        float(areas.sum()), float(areas[order].sum()), whole / most, len(np.unique(triangles)),
    )  # fmt: skip


def _place(bed: Seedbed, line: Floats, piece: NDArray[np.int32], within: Floats) -> None:
    """Set the pieces (n,) of places on the line (n,), and barycentric coordinates (n, 3) in them."""
    from .kernels.surface import place

    scratch = np.empty((min(len(line), AT_ONCE), 9))
    values = np.ascontiguousarray(bed.pieces.values)
    for begin in range(0, len(line), AT_ONCE):
        some = slice(begin, begin + AT_ONCE)
        place(line[some], bed.ends, bed.corners, values, scratch, piece[some], within[some])


def along_curve(points: Floats, normals: Floats) -> NDArray[np.int64]:
    """Return an order of points (n, 3) in which neighbours are near each other and on the same side: by the axis that
    normals (n, 3) are nearest to, and then along Hilbert's curve (Skilling 2004, "Programming the Hilbert curve")."""
    low = points.min(axis=0)
    size = max(float((points.max(axis=0) - low).max()), 1e-300)
    x = np.minimum((points - low) * ((1 << BITS) / size), (1 << BITS) - 1).astype(np.int64).T.copy()
    bit = 1 << (BITS - 1)
    while bit > 1:
        mask = bit - 1
        for axis in range(3):
            high = (x[axis] & bit) != 0
            swapped = (x[0] ^ x[axis]) & mask
            x[0] ^= np.where(high, mask, swapped)
            x[axis] ^= np.where(high, 0, swapped)
        bit >>= 1
    x[1] ^= x[0]
    x[2] ^= x[1]
    turn = np.zeros_like(x[0])
    bit = 1 << (BITS - 1)
    while bit > 1:
        turn ^= np.where((x[2] & bit) != 0, bit - 1, 0)
        bit >>= 1
    x ^= turn
    key = np.zeros_like(x[0])
    for place in range(BITS - 1, -1, -1):
        for axis in range(3):
            key = (key << 1) | ((x[axis] >> place) & 1)
    axis = np.argmax(np.abs(normals), axis=1)
    side = 2 * axis + (np.take_along_axis(normals, axis[:, None], 1)[:, 0] < 0)
    return np.lexsort((key, side))


def described(shape: MeshShape, strands: int) -> str:
    """Return in words what strands are spread over."""
    bed = seedbed(shape)
    count = len(bed.mesh.triangles)
    share = "" if bed.used == count else f", {bed.grown:.3g} m² on {bed.used:,} of them bear strands"
    return f"{bed.area:.3g} m² of {counted(count, 'triangle')}{share}; {strands / (1e4 * bed.grown):.3g} strands a cm²"


def notes(emitter: Emitter) -> list[str]:
    """Return what a person should know of the mesh that an emitter's strands grow on, a line each."""
    shape, length = emitter.shape, emitter.length
    assert isinstance(shape, MeshShape)
    bed = seedbed(shape)
    found = [f"{shape.file}: {words}" for words in bed.mesh.notes if not words.startswith(OPEN)]
    size = bed.mesh.size()
    if not LEAST_LENGTH * size <= length <= MOST_LENGTH * size:
        found.append(
            f"{shape.file}: is {size:.3g} m large and emitter.length {length:.3g} m: perhaps its file has another "
            "unit; set emitter.shape.scale, or its size in metres"
        )
    return found


RESOLUTION = 128
"""Nodes along the longest side of the grid of distances from the mesh."""
CLEAR = 0.1
"""Distance from the mesh, in cells of that grid, that counts as outside: several times its error."""


def rise(shape: MeshShape, points: Floats, normals: Floats) -> Floats:
    """Return (N,) how far points (N, 3), metres in the emitter's frame, must move along unit normals (N, 3) to be
    outside of a mesh. Raises `UsageError` for a mesh that cannot be read."""
    from .kernels.surface import lift_off_mesh

    grid = distances(shape.file, placing(shape), RESOLUTION)
    out = np.empty(len(points))
    lift_off_mesh(np.ascontiguousarray(points), np.ascontiguousarray(normals), grid, CLEAR * float(grid.spacing), out)
    return out


MOST = 96
"""Colours of a palette."""
SHADES = 6
"""Of each."""
NEAR_CORNERS = np.full((3, 3), 0.2) + 0.4 * np.eye(3)
"""Barycentric coordinates of the points of a triangle that the palette is made of."""
COMPARED = 1 << 14
"""Strands that are compared with the palette at once, which bounds the memory."""


def coat(shape: MeshShape, anchors: Anchors, tones: NDArray[np.float32]) -> Coat | None:
    """Return the colours of strands at anchors, of tones (n,) in [−1, 1); None where they are the material's. Raises
    `UsageError` for a mesh without colours."""
    if shape.colours == "none":
        return None
    file, how = shape.file, placing(shape)
    palette = _palette(file, how)
    found = encoded(coloured(placed(file, how), anchors.triangles, anchors.shares)).astype(np.float32)
    codes = encoded(palette).astype(np.float32)
    rows = np.empty(len(found), np.int64)
    for begin in range(0, len(found), COMPARED):
        some = found[begin : begin + COMPARED]
        rows[begin : begin + COMPARED] = (((some[:, None] - codes) ** 2).sum(axis=2)).argmin(axis=1)
    shade = np.minimum((0.5 * (tones + 1) * SHADES).astype(np.int64), SHADES - 1)
    places = 2.0 * (rows * SHADES + shade) / (len(palette) * SHADES - 1) - 1.0
    return Coat(palette, SHADES, places.astype(np.float32))


@cached(KEPT)
def _palette(file: str, how: Any) -> NDArray[np.float32]:
    """Linear colours (k, 3), at most `MOST`, of a mesh by median cut over points of its triangles."""
    from PIL import Image

    mesh = placed(file, how)
    if mesh.colours is None and (mesh.texture is None or mesh.uv is None):
        raise UsageError(
            f"{file}: emitter.shape.colours: has neither vertex colours nor a texture; take a mesh that has, or "
            "colours: none"
        )
    triangles = np.repeat(np.arange(len(mesh.triangles)), len(NEAR_CORNERS))
    shares = np.tile(NEAR_CORNERS, (len(mesh.triangles), 1))
    light = coloured(mesh, triangles, shares)
    picked = Image.fromarray(encoded(light)[None]).quantize(MOST, method=Image.Quantize.MEDIANCUT)
    rows = np.unique(np.asarray(picked).reshape(-1), return_inverse=True)[1].reshape(-1)
    sums = np.stack([np.bincount(rows, light[:, c]) for c in range(3)], axis=1)
    return np.asarray(sums / np.bincount(rows)[:, None], np.float32)
