"""`.glb` and `.gltf`: the meshes of a scene, where its nodes put them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .files import Beside, pixels, whole
from .gltf_check import MAGIC, check, header_of
from .make import RawMesh
from .polygons import fans


def read_gltf(path: Path, beside: Beside) -> list[RawMesh]:
    """What each mesh of a file holds. Raises `UsageError`, or whatever trimesh raises."""
    import trimesh

    content = whole(path, "glTF file")
    tree = header_of(path, content)
    check(path, tree, len(content.getbuffer()) + _named(tree, beside))
    kind = "glb" if content.getbuffer()[:4] == MAGIC else "gltf"
    resolver: Any = beside
    scene: Any = trimesh.load(content, file_type=kind, resolver=resolver, process=False, force="scene")
    parts = []
    for node in scene.graph.nodes_geometry:
        matrix, name = scene.graph[node]
        if hasattr(scene.geometry[name], "faces"):
            parts.append(_placed(_part(scene.geometry[name]), np.asarray(matrix, np.float64)))
    return parts


def _named(tree: Any, beside: Beside) -> int:
    """Bytes of all files that a header names for its buffers."""
    buffers = tree.get("buffers", []) if isinstance(tree, dict) else []
    names = [one.get("uri") for one in buffers if isinstance(one, dict)] if isinstance(buffers, list) else []
    return sum(beside.size(name) for name in names if isinstance(name, str) and not name.startswith("data:"))


def _part(mesh: Any) -> RawMesh:
    """A mesh of trimesh; normals only where the file has them."""
    visual = mesh.visual
    triangles = fans(np.asarray(mesh.faces))
    count = len(mesh.vertices)
    uv = getattr(visual, "uv", None)
    picture = getattr(getattr(visual, "material", None), "baseColorTexture", None)
    colours = visual.vertex_colors if getattr(visual, "kind", None) == "vertex" else None
    if colours is None and "color" in getattr(visual, "vertex_attributes", {}):
        colours = visual.vertex_attributes["color"]
    return RawMesh(
        np.asarray(mesh.vertices), triangles,
        np.asarray(mesh.vertex_normals) if "vertex_normals" in mesh._cache.cache else None,
        np.asarray(uv)[triangles] if uv is not None and np.shape(uv) == (count, 2) else None,
        _unit_colours(colours, count),
        {
            str(name).strip("_").lower(): _column(values)
            for name, values in mesh.vertex_attributes.items() if np.shape(values)[:1] == (count,)
        },
        None if picture is None else pixels(picture),
    )  # fmt: skip


def _unit_colours(colours: Any, count: int) -> npt.NDArray[np.float32] | None:
    """Colours 0 to 1; glTF's are linear, and trimesh makes them bytes."""
    if colours is None or np.ndim(colours) != 2 or np.shape(colours)[0] != count or np.shape(colours)[1] < 3:
        return None
    values = np.asarray(colours)[:, :3]
    most = {"u1": 255.0, "u2": 65535.0}.get(values.dtype.str[1:], 1.0)
    return np.clip(np.nan_to_num(values.astype(np.float64) / most), 0.0, 1.0).astype(np.float32)


def _placed(part: RawMesh, matrix: npt.NDArray[np.float64]) -> RawMesh:
    """A part where its node puts it."""
    if np.array_equal(matrix, np.eye(4)):
        return part
    linear = matrix[:3, :3]
    normals = part.normals
    if normals is not None:
        normals = normals @ np.linalg.inv(linear) if abs(np.linalg.det(linear)) > 0 else None
    return replace(part, vertices=part.vertices @ linear.T + matrix[:3, 3], normals=normals)


def _column(values: Any) -> npt.NDArray[np.float32]:
    """Numbers (V, k), or (V,) where there is one of each vertex."""
    found = np.asarray(values, np.float32)
    return found[:, 0] if found.ndim == 2 and found.shape[1] == 1 else found
