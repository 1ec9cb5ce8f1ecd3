"""What `strandcli info` tells of a file with a mesh: counts, sizes, faults, and guesses of up axis and unit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import StrandError
from ..exchange.bounded import opened
from ..exchange.ply_header import read_header
from .make import sentences
from .mesh import TriangleMesh, Vectors, face_vectors
from .read import SUFFIXES, read_mesh

GLTF = (".glb", ".gltf")
"""Formats that tell their unit, the metre, and up axis, y."""
BASE, RIM, FACING = 0.02, 0.02, 0.95
"""A mesh stands on a side where so much of its area lies flat or is missing: within the rim, a share of its extent, and
facing that way by this cosine at least."""
CLEARLY = 2.0
"""How much larger a base is than all others, where up is guessed by it."""
SIZES = {"m": (0.1, 1.0, 1.0), "cm": (10.0, 100.0, 0.01), "mm": (100.0, 1000.0, 0.001)}
"""Longest sides of a head, a bust or a small animal in each unit, and its metres."""
AT_ONCE = 1 << 16
"""Triangles whose corners are looked at together: those of millions take many times the file."""


def is_mesh(path: Path) -> bool:
    """Whether a file is read as a mesh: by the end of its name, and of `.ply` by whether there are faces."""
    suffix = path.suffix.lower()
    if suffix != ".ply":
        return suffix in SUFFIXES
    try:
        with opened(path, ".ply file") as file:
            _, elements, _ = read_header(file)
    except StrandError:
        return False
    return "face" in elements and elements["face"].count > 0


def facts_of_file(path: Path) -> tuple[dict[str, Any], TriangleMesh]:
    """What is in a file, as JSON has it, and its mesh. Raises `UsageError`."""
    mesh = read_mesh(path)
    told = path.suffix.lower() in GLTF
    data = {
        "file": str(path), "bytes": path.stat().st_size, "format": path.suffix.lower(), **facts(mesh),
        "unit": 1.0 if told else None, "up": "y" if told else None,
    }  # fmt: skip
    if told:
        data["guess"] = {"up": None, "unit": None}
    return data, mesh


def facts(mesh: TriangleMesh) -> dict[str, Any]:
    """What a mesh is like, in units of its file, after what could be mended was."""
    low, high = mesh.box()
    said = sentences(mesh.facts, mesh.triangles.shape[0])
    middles, vectors = _middles_and_vectors(mesh)
    areas = np.sqrt(np.einsum("tj,tj->t", vectors, vectors))
    volume = None
    if mesh.closed:
        middle = 0.5 * (low + high)
        volume = (float(np.einsum("tj,tj->", middles, vectors)) - float(middle @ vectors.sum(axis=0))) / 3
    return {
        "vertices": mesh.vertices.shape[0], "triangles": mesh.triangles.shape[0], "parts": mesh.facts.parts,
        "merged": mesh.facts.merged, "closed": mesh.closed, "holes": mesh.facts.holes,
        "box": {"min": low.tolist(), "max": high.tolist(), "size": (high - low).tolist()},
        "area": float(areas.sum()), "volume": volume, "triangle_area": _spread(areas),
        "attributes": _attributes(mesh),
        "guess": {"up": up_axis(middles, vectors, areas, high - low), "unit": unit(mesh.size())},
        "faults": [{"fault": name, "count": getattr(mesh.facts, name), "text": text} for name, text in said.items()],
        "notes": [note for note in mesh.notes if note not in said.values()],
    }  # fmt: skip


def _middles_and_vectors(mesh: TriangleMesh) -> tuple[Vectors, Vectors]:
    """Of triangles (T, 3) their middles, and their normals, as long as their areas."""
    middles, vectors = np.empty((2, *mesh.triangles.shape))
    for begin in range(0, mesh.triangles.shape[0], AT_ONCE):
        corners = mesh.vertices[mesh.triangles[begin : begin + AT_ONCE]]
        middles[begin : begin + AT_ONCE] = corners.mean(axis=1)
        vectors[begin : begin + AT_ONCE] = 0.5 * face_vectors(corners)
    return middles, vectors


def up_axis(middles: Vectors, vectors: Vectors, areas: Vectors, extent: Vectors) -> str | None:
    """The axis away from the side that a mesh stands on or was cut off at: where most area lies flat, or is missing.
    None where no side is clearly that.

    ``middles``: (T, 3) of triangles; ``vectors``: (T, 3) their normals, as long as their areas (T,); ``extent``:
    (3,) of the box. Normals of a closed surface add up to 0, so their sum is that of what is missing, turned around.
    """
    whole, missing = float(areas.sum()), -vectors.sum(axis=0)
    bases: dict[str, float] = {}
    for axis, name in enumerate("xyz"):
        along = middles[:, axis]
        rim = RIM * float(extent[axis])
        for sign, up in ((-1.0, name), (1.0, f"-{name}")):
            flat = (sign * vectors[:, axis] >= FACING * areas) & (sign * along >= (sign * along).max() - rim)
            bases[up] = float(areas[flat].sum()) + max(0.0, sign * float(missing[axis]))
    (best, size), (_, second), *_ = sorted(bases.items(), key=lambda one: -one[1])
    return best if size > BASE * whole and size > CLEARLY * second else None


def unit(size: float) -> dict[str, Any] | None:
    """The unit in which a mesh whose longest side is so long would be a head, a bust or a small animal, and the factor
    to metres; None where there is none."""
    for name, (least, most, metres) in SIZES.items():
        if least <= size < most:
            return {"unit": name, "scale": metres}
    return None


def _spread(values: npt.NDArray[np.float64]) -> dict[str, float]:
    return {
        "min": float(values.min()), "median": float(np.median(values)), "mean": float(values.mean()),
        "max": float(values.max()),
    }  # fmt: skip


def _attributes(mesh: TriangleMesh) -> list[dict[str, Any]]:
    """What belongs to vertices and corners, beside their places."""
    found: list[tuple[str, str, Any]] = []
    for name, domain, values in (
        ("normals", "corner", mesh.corner_normals), ("uv", "corner", mesh.uv), ("colours", "vertex", mesh.colours),
        ("texture", "pixel", mesh.texture), *((name, "vertex", one) for name, one in mesh.attributes.items()),
    ):  # fmt: skip
        if values is not None:
            found.append((name, domain, values))
    return [
        {"name": name, "domain": domain, "shape": list(values.shape), "type": values.dtype.name,
         "min": values.min().item(), "max": values.max().item()}
        for name, domain, values in found
    ]  # fmt: skip
