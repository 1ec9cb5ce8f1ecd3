"""Read a mesh from OBJ, PLY, STL or glTF.

    mesh = read_mesh(Path("head.obj"))

Only the input of trimesh is used, and imported when a mesh is read.
"""

from __future__ import annotations

import logging
import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import StrandError, UsageError, one_line
from .files import Beside, pixels, whole
from .make import RawMesh, mesh_of
from .mesh import TriangleMesh, smooth_normals

SUFFIXES = (".obj", ".ply", ".stl", ".glb", ".gltf")
MENDS = "write it anew, as .obj, .ply, .stl or .glb with triangles"


def read_mesh(path: Path, like: TriangleMesh | None = None) -> TriangleMesh:
    """The mesh of a file, in its units and axes, triangles of all its parts together. Raises `UsageError` in one line.

    ``like``: an earlier mesh of a sequence, whose triangles, uv and attributes are kept; only the places of the
    vertices are read, which have to be as many in the file, in the same order.
    """
    raw = _raw(Path(path))
    return mesh_of(raw, str(path)) if like is None else _moved(raw, like, path)


def _moved(raw: RawMesh, like: TriangleMesh, path: Path) -> TriangleMesh:
    """Another mesh with the places of its vertices taken from a file."""
    merge = like.merge
    count = raw.vertices.shape[0]
    if merge is None or merge.size != count:
        known = "unknown" if merge is None else f"{merge.size:,}"
        raise UsageError(
            f"{path}: has {count:,} vertices, the mesh that it moves has {known}; "
            "write all files of the sequence from one mesh, in one format"
        )
    vertices = np.empty_like(like.vertices)
    vertices[merge[merge >= 0]] = raw.vertices[merge >= 0]
    if not np.isfinite(vertices).all():
        raise UsageError(f"{path}: has vertices that are not finite; mend it in its program")
    return replace(like, vertices=vertices, normals=smooth_normals(vertices, like.triangles), corner_normals=None)


def _raw(path: Path) -> RawMesh:
    """What a file holds, whatever its format."""
    suffix = path.suffix.lower()
    readers: dict[str, Callable[[Path, Beside], RawMesh]] = {
        ".obj": _obj, ".ply": _ply, ".stl": _stl, ".glb": _gltf, ".gltf": _gltf,
    }  # fmt: skip
    if suffix not in readers:
        raise UsageError(f"{path}: is no mesh that can be read; read are {', '.join(SUFFIXES)}")
    beside = Beside(path)
    log = logging.getLogger("trimesh")
    before, log.disabled = log.disabled, True
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            found = readers[suffix](path, beside)
    except StrandError:
        raise
    except MemoryError:
        raise UsageError(f"{path}: takes more memory than there is; write a coarser mesh") from None
    except Exception as error:  # trimesh lets through whatever a damaged file makes happen
        why = one_line(f"{type(error).__name__}: {error}")[:120]
        raise UsageError(f"{path}: cannot be read as {suffix} ({why}); {MENDS}") from None
    finally:
        log.disabled = before
    if beside.missing:
        note = f"not found, or not in its folder: {', '.join(one_line(name) for name in beside.missing[:3])}"
        found = replace(found, notes=(*found.notes, note))
    return found


def _obj(path: Path, beside: Beside) -> RawMesh:
    """Wavefront OBJ, with the materials' texture."""
    from trimesh.exchange.obj import load_obj

    found = load_obj(whole(path, ".obj file"), resolver=beside)  # type: ignore[arg-type]
    return _joined([_part(one, beside.found) for one in reversed(list(found.get("geometry", {}).values()))])


def _ply(path: Path, beside: Beside) -> RawMesh:
    from trimesh.exchange.ply import load_ply

    found = load_ply(whole(path, ".ply file"), resolver=beside, fix_texture=False)  # type: ignore[arg-type]
    return _joined([_part(found, beside.found)] if "faces" in found else [])


def _stl(path: Path, beside: Beside) -> RawMesh:
    from trimesh.exchange.stl import load_stl

    found = load_stl(whole(path, ".stl file"))
    parts = found["geometry"].values() if "geometry" in found else [found]
    return _joined([_part(one, False) for one in parts])


def _gltf(path: Path, beside: Beside) -> RawMesh:
    import trimesh

    kind = path.suffix.lower()[1:]
    resolver: Any = beside
    content = whole(path, f".{kind} file")
    scene: Any = trimesh.load(content, file_type=kind, resolver=resolver, process=False, force="scene")
    parts = []
    for node in scene.graph.nodes_geometry:
        matrix, name = scene.graph[node]
        mesh = scene.geometry[name]
        if hasattr(mesh, "faces"):
            parts.append(_placed(_part(_of_trimesh(mesh), True), np.asarray(matrix)))
    return _joined(parts)


def _of_trimesh(mesh: Any) -> dict[str, Any]:
    """The arguments that a mesh of trimesh is made of."""
    found = {"vertices": mesh.vertices, "faces": mesh.faces, "visual": mesh.visual}
    if "vertex_normals" in mesh._cache.cache:
        found["vertex_normals"] = mesh.vertex_normals
    found["vertex_attributes"] = dict(mesh.vertex_attributes)
    return found


def _part(found: dict[str, Any], textured: bool) -> RawMesh:
    """A part from trimesh's arguments; textured: whether its picture is one of the file's, not trimesh's own."""
    vertices = np.asarray(found["vertices"], np.float64)
    triangles = fans(np.asarray(found["faces"]))
    normals = found.get("vertex_normals")
    visual = found.get("visual")
    uv, texture = getattr(visual, "uv", None), None
    image = getattr(getattr(visual, "material", None), "image", None)
    if image is None:
        image = getattr(getattr(visual, "material", None), "baseColorTexture", None)
    if textured and image is not None:
        texture = pixels(image)
    colours = found.get("vertex_colors")
    if colours is None and getattr(visual, "kind", None) == "vertex":
        colours = visual.vertex_colors  # type: ignore[union-attr]
    return RawMesh(
        vertices, triangles,
        np.asarray(normals, np.float64) if normals is not None and np.shape(normals) == vertices.shape else None,
        np.asarray(uv, np.float64)[triangles] if uv is not None and np.shape(uv) == (vertices.shape[0], 2) else None,
        _linear(colours, vertices.shape[0]),
        {str(k).strip("_").lower(): v for k, v in found.get("vertex_attributes", {}).items()},
        texture,
    )  # fmt: skip


def fans(faces: npt.NDArray[Any]) -> npt.NDArray[np.int64]:
    """Triangles (T, 3) of polygons (F, k), each a fan about its first corner."""
    if faces.ndim != 2 or faces.shape[1] < 3:
        return np.zeros((0, 3), np.int64)
    count = faces.shape[1]
    return np.stack([faces[:, (0, k, k + 1)] for k in range(1, count - 1)], axis=1).reshape(-1, 3).astype(np.int64)


def _linear(colours: Any, count: int) -> npt.NDArray[np.float32] | None:
    """Linear colours (V, 3) from sRGB ones, bytes or 0 to 1."""
    if colours is None or np.ndim(colours) != 2 or np.shape(colours)[0] != count or np.shape(colours)[1] < 3:
        return None
    values = np.asarray(colours)[:, :3]
    shown = values.astype(np.float64) / (255.0 if values.dtype.kind in "iu" else 1.0)
    shown = np.clip(np.nan_to_num(shown), 0.0, 1.0)
    linear = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)
    return linear.astype(np.float32)


def _placed(part: RawMesh, matrix: npt.NDArray[Any]) -> RawMesh:
    """A part where its node puts it."""
    if np.array_equal(matrix, np.eye(4)):
        return part
    linear = matrix[:3, :3]
    normals = part.normals
    if normals is not None:
        normals = normals @ np.linalg.inv(linear) if abs(np.linalg.det(linear)) > 0 else None
    return replace(part, vertices=part.vertices @ linear.T + matrix[:3, 3], normals=normals)


def _joined(parts: Sequence[RawMesh]) -> RawMesh:
    """Several parts as one."""
    if not parts:
        return RawMesh(np.zeros((0, 3)), np.zeros((0, 3), np.int64))
    if len(parts) == 1:
        return parts[0]
    begins = np.cumsum([0, *(one.vertices.shape[0] for one in parts)])
    textures = [one.texture for one in parts if one.texture is not None]
    notes = tuple(note for one in parts for note in one.notes)
    if len(textures) > 1:
        notes += (f"{len(textures)} textures: the first is taken for all of it",)
    names = {name: one.attributes[name].shape[1:] for one in parts for name in one.attributes}

    def together(values: list[Any], shapes: Sequence[tuple[int, ...]], empty: float) -> Any:
        """All values one after the other, and `empty` where a part has none; None where no part has any."""
        if all(one is None for one in values):
            return None
        pairs = zip(values, shapes, strict=True)
        return np.concatenate([np.full(shape, empty) if one is None else one for one, shape in pairs])

    sizes = [one.vertices.shape for one in parts]
    corners = [(one.triangles.shape[0], 3, 2) for one in parts]
    return RawMesh(
        np.concatenate([one.vertices for one in parts]),
        np.concatenate([one.triangles + begin for one, begin in zip(parts, begins, strict=False)]),
        together([one.normals for one in parts], sizes, 0.0),
        together([one.uv for one in parts], corners, 0.0),
        together([one.colours for one in parts], sizes, 1.0),
        {
            name: together(
                [one.attributes.get(name) for one in parts], [(size[0], *shape) for size in sizes], 0.0
            )
            for name, shape in names.items()
        },
        textures[0] if textures else None, notes,
    )  # fmt: skip
