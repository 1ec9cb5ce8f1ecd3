"""What `strandcli info` tells of a file with a mesh: counts, sizes, faults, and guesses of up axis and unit."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..errors import StrandError
from ..exchange.facts import spread
from ..exchange.files import drivers
from . import SUFFIXES
from .make import sentences
from .mesh import FileNormals, TriangleMesh, Vectors, face_vectors, slices
from .read import read_mesh

GLTF = (".glb", ".gltf")
"""Formats that tell their unit, the metre, and up axis, y."""
BASE, RIM, FACING = 0.02, 0.02, 0.95
"""A mesh stands on a side where so much of its area lies flat or is missing: within the rim, a share of its extent, and
facing that way by this cosine at least."""
CLEARLY = 2.0
"""How much larger a base is than the rest, where up is guessed by it."""
SIZES = {"m": (0.1, 1.0, 1.0), "cm": (10.0, 100.0, 0.01), "mm": (100.0, 1000.0, 0.001)}
"""Longest sides of a head, a bust or a small animal in each unit, and its metres."""
UP = ("x", "y", "z", "-x", "-y", "-z")
"""Axes away from the lower sides, then from the upper ones."""


def is_mesh(path: Path) -> bool:
    """Whether a file is read as a mesh: by the end of its name, and by whether there are polygons where strands may
    have that name, too."""
    suffix = path.suffix.lower()
    both = [one for one in drivers() if suffix in one.suffixes and hasattr(one, "is_mesh")]
    if suffix not in SUFFIXES or not both:
        return suffix in SUFFIXES
    try:
        return any(one.is_mesh(path) for one in both)
    except StrandError:
        return False


def facts_of_file(path: Path) -> tuple[dict[str, Any], TriangleMesh]:
    """What is in a file, as JSON has it, and its mesh. Raises `UsageError`."""
    mesh = read_mesh(path)
    is_gltf = path.suffix.lower() in GLTF
    data = {
        "file": str(path), "bytes": path.stat().st_size, "format": path.suffix.lower(), **facts(mesh),
        "unit": 1.0 if is_gltf else None, "up": "y" if is_gltf else None,
    }  # fmt: skip
    if is_gltf:
        data["guess"] = {"up": None, "unit": None}
    return data, mesh


def facts(mesh: TriangleMesh) -> dict[str, Any]:
    """What a mesh is like, in units of its file, after what could be mended was."""
    low, high = mesh.box()
    said = sentences(mesh.facts, mesh.triangles.shape[0])
    measures = measured(mesh)
    return {
        "vertices": mesh.vertices.shape[0], "triangles": mesh.triangles.shape[0], "parts": mesh.facts.parts,
        "merged": mesh.facts.merged, "closed": mesh.closed, "holes": mesh.facts.holes,
        "box": {"min": low.tolist(), "max": high.tolist(), "size": (high - low).tolist()},
        "area": measures.area, "volume": measures.volume if mesh.closed else None,
        "triangle_area": measures.triangle_area, "attributes": _attributes(mesh),
        "guess": {"up": up_axis(mesh, measures), "unit": unit(mesh.size())},
        "faults": [{"fault": name, "count": getattr(mesh.facts, name), "text": text} for name, text in said.items()],
        "notes": [note for note in mesh.notes if note not in said.values()],
    }  # fmt: skip


class Measures(NamedTuple):
    """Sums over all triangles, in units of the file."""

    area: float
    volume: float
    """Within the surface, where it is closed."""
    vector: Vectors
    """(3,) the sum of normals as long as their triangles' areas; 0 of a closed surface."""
    least: Vectors
    most: Vectors
    """(3,) the least and the largest coordinates of middles of triangles."""
    triangle_area: dict[str, float] | None


def measured(mesh: TriangleMesh) -> Measures:
    """The measures of a mesh."""
    low, high = mesh.box()
    middle = 0.5 * (low + high)
    areas = np.empty(mesh.triangles.shape[0])
    vector, least, most, volume = np.zeros(3), high, low, 0.0
    for rows in slices(areas.size):
        middles, vectors = _middles_and_vectors(mesh, rows)
        areas[rows] = np.sqrt(np.einsum("tj,tj->t", vectors, vectors))
        vector += vectors.sum(axis=0)
        volume += float(np.einsum("tj,tj->", middles - middle, vectors)) / 3
        least, most = np.minimum(least, middles.min(axis=0)), np.maximum(most, middles.max(axis=0))
    return Measures(float(areas.sum()), volume, vector, least, most, spread(areas))


def _middles_and_vectors(mesh: TriangleMesh, rows: slice) -> tuple[Vectors, Vectors]:
    """Of some triangles (n, 3) their middles, and their normals, as long as their areas."""
    corners = mesh.vertices[mesh.triangles[rows]]
    return corners.mean(axis=1), 0.5 * face_vectors(corners)


def up_axis(mesh: TriangleMesh, measures: Measures) -> str | None:
    """The axis away from the side that a mesh stands on or was cut off at: where most area lies flat, or is missing.
    None where no side is clearly that.

    Normals of a closed surface add up to 0, so their sum is that of what is missing, turned around.
    """
    low, high = mesh.box()
    rim = RIM * (high - low)
    flat = np.zeros((2, 3))
    for rows in slices(mesh.triangles.shape[0]):
        middles, vectors = _middles_and_vectors(mesh, rows)
        areas = np.sqrt(np.einsum("tj,tj->t", vectors, vectors))[:, None]
        below = (-vectors >= FACING * areas) & (middles <= measures.least + rim)
        above = (vectors >= FACING * areas) & (middles >= measures.most - rim)
        flat += [(areas * below).sum(axis=0), (areas * above).sum(axis=0)]
    missing = np.maximum([measures.vector, -measures.vector], 0.0)
    sizes = (flat + missing).ravel().tolist()
    (size, best), (second, _), *_ = sorted(zip(sizes, UP, strict=True), reverse=True)
    return best if size > BASE * measures.area and size > CLEARLY * second else None


def unit(size: float) -> dict[str, Any] | None:
    """The unit in which a mesh whose longest side is so long would be a head, a bust or a small animal, and the factor
    to metres; None where there is none."""
    for name, (least, most, metres) in SIZES.items():
        if least <= size < most:
            return {"unit": name, "scale": metres}
    return None


def _attributes(mesh: TriangleMesh) -> list[dict[str, Any]]:
    """What belongs to vertices and corners, beside their places."""
    found = []
    own = mesh.own
    if own is not None:
        parts = (own.of_corners(mesh, rows) if isinstance(own, FileNormals) else own[rows]
                 for rows in slices(mesh.triangles.shape[0]))  # fmt: skip
        found.append(_described("normals", "corner", (*mesh.triangles.shape, 3), parts))
    for name, domain, values in (
        ("uv", "corner", mesh.uv), ("colours", "vertex", mesh.colours), ("texture", "pixel", mesh.texture),
        *((name, "vertex", one) for name, one in mesh.attributes.items()),
    ):  # fmt: skip
        if values is not None:
            found.append(_described(name, domain, values.shape, [values]))
    return found


def _described(name: str, domain: str, shape: tuple[int, ...], parts: Iterable[npt.NDArray[Any]]) -> dict[str, Any]:
    """What is reported of values of which there are some at once."""
    each = [(one.min().item(), one.max().item(), one.dtype.name) for one in parts]
    lows, highs, kinds = zip(*each, strict=True)
    return {
        "name": name, "domain": domain, "shape": list(shape), "type": kinds[0], "min": min(lows), "max": max(highs),
    }  # fmt: skip
