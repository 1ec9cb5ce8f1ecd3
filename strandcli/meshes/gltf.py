"""`.glb` and `.gltf`: the triangles of a scene, where its nodes put them, and the picture that colours them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..errors import UsageError
from ..exchange.bounded import Beside
from ..exchange.gltf_file import Gltf, placed_meshes
from ..files.picture_samples import pixels
from .make import RawMesh, lines_beside

TRIANGLES, OTHERS = 4, (5, 6)
"""Modes of primitives that are read, and of strips and fans."""
LINES = (1, 2, 3)
"""Modes of strands."""
TIMES, ROOM = 3, 30e6
"""Bytes that the arrays of all placed meshes may take: so many times the file, and so many beside."""
OF_PART = 1000
"""Bytes that a placed part takes beside its arrays."""


class Group(NamedTuple):
    """Primitives of a mesh that have the same vertices."""

    primitives: list[dict[str, Any]]
    attributes: dict[str, Any]
    """Accessors by the names of what they hold."""
    uv: str
    """The attribute that places the material's picture."""
    where: str


def read_gltf(path: Path, beside: Beside) -> list[RawMesh]:
    """What each mesh of the scene holds. Raises `UsageError`."""
    file = Gltf(path, beside)
    meshes = file.primitives()
    groups = [_groups(file, mesh, f"meshes[{k}]") for k, mesh in enumerate(meshes)]
    sizes = [OF_PART + sum(_bytes(file, group) for group in mesh) for mesh in groups]
    placed: list[tuple[int, npt.NDArray[np.float64]]] = []
    total, most = 0, TIMES * file.size + ROOM
    for mesh, matrix, _ in placed_meshes(file):
        total += sizes[mesh]
        if total > most:
            raise UsageError(
                f"{path}: {len(placed) + 1:,} of the meshes that its nodes place take {total / 1e6:,.0f} MB, of a file "
                f"of {file.size / 1e6:,.3g} MB; write fewer or coarser ones"
            )
        placed.append((mesh, matrix))
    parts: dict[int, list[RawMesh]] = {}
    found = []
    for mesh, matrix in placed:
        if mesh not in parts:
            parts[mesh] = [_part(file, group) for group in groups[mesh]]
        found += [_moved(part, matrix) for part in parts[mesh]]
    if found:
        primitives = [one for mesh in parts for group in groups[mesh] for one in group.primitives]
        found[0] = with_texture(file, found[0], primitives)
        notes = found[0].notes + lines_beside(sum(one.get("mode") in LINES for mesh in meshes for one in mesh))
        found[0] = replace(found[0], notes=notes)
    return found


def _groups(file: Gltf, mesh: list[dict[str, Any]], where: str) -> list[Group]:
    """The primitives of triangles, those with the same vertices together."""
    found: dict[Any, Group] = {}
    for one in mesh:
        mode = one.get("mode", TRIANGLES)
        if mode in OTHERS:
            raise file.fault(where, "its triangles are in strips or fans, which are not read")
        if mode != TRIANGLES:
            continue
        attributes = one["attributes"]
        packed = file.packed(one.get("extensions"))
        if packed and "bufferView" not in file.named("accessors", attributes["POSITION"], where):
            raise packed
        texture = texture_of(file, one)
        uv = f"TEXCOORD_{file.whole(texture, 'texCoord', where, most=99)}"
        key = (uv, *sorted((name, repr(index)) for name, index in attributes.items()))
        found.setdefault(key, Group([], attributes, uv, where)).primitives.append(one)
    return list(found.values())


def _columns(file: Gltf, group: Group) -> dict[str, int]:
    """Numbers of an item of each attribute that is read."""
    known = {"POSITION": 3, "NORMAL": 3, group.uv: 2}
    count, _, _ = file.shape(group.attributes["POSITION"], group.where)
    found = {}
    for name, index in group.attributes.items():
        rows, width, _ = file.shape(index, group.where)
        if name in known or (name == "COLOR_0" and width in (3, 4)) or (name.startswith("_") and width):
            if rows != count:
                raise file.fault(group.where, f"{name} has {rows:,} items, POSITION {count:,}")
            found[name] = known.get(name, width)
    return found


def _bytes(file: Gltf, group: Group) -> int:
    """Bytes that the arrays of a group take."""
    count, _, _ = file.shape(group.attributes["POSITION"], group.where)
    columns = _columns(file, group)
    corners = sum(file.count(one, group.where) for one in group.primitives)
    return OF_PART + count * 8 * sum(columns.values()) + corners * (12 if group.uv in columns else 4)


def _part(file: Gltf, group: Group) -> RawMesh:
    """The triangles of a group; normals only where the file has them."""
    columns = _columns(file, group)
    found = {name: file.numbers(group.attributes[name], width, group.where) for name, width in columns.items()}
    parts = [_triangles(file, one, found["POSITION"].shape[0], group.where) for one in group.primitives]
    triangles = parts[0] if len(parts) == 1 else np.concatenate(parts)
    uv = found.get(group.uv)
    if uv is not None and triangles.size and triangles.max() < uv.shape[0]:
        uv = np.asarray(uv, np.float32)[triangles]
        uv[..., 1] = 1 - uv[..., 1]  # glTF's origin is the upper left
    else:
        uv = None
    return RawMesh(
        found["POSITION"], triangles, found.get("NORMAL"), uv, _linear(found.get("COLOR_0")),
        {
            name.strip("_").lower(): np.asarray(values[:, 0] if values.shape[1] == 1 else values, np.float32)
            for name, values in found.items() if name.startswith("_")
        },
    )  # fmt: skip


def _triangles(file: Gltf, primitive: dict[str, Any], count: int, where: str) -> npt.NDArray[Any]:
    """Triangles (T, 3) of a primitive of so many vertices."""
    corners = file.rows(primitive, count, where)
    if corners.size % 3:
        raise file.fault(where, f"{corners.size:,} corners are not three of each triangle")
    return corners.reshape(-1, 3)


def _linear(colours: npt.NDArray[Any] | None) -> npt.NDArray[np.float32] | None:
    """Colours 0 to 1; glTF's are linear."""
    if colours is None:
        return None
    most = {"u1": 255.0, "u2": 65535.0}.get(colours.dtype.str[1:], 1.0)  # of files that leave out `normalized`
    return np.clip(np.nan_to_num(colours[:, :3].astype(np.float64) / most), 0.0, 1.0).astype(np.float32)


def _moved(part: RawMesh, matrix: npt.NDArray[np.float64]) -> RawMesh:
    """A part where its node puts it."""
    if np.array_equal(matrix, np.eye(4)):
        return part
    linear = matrix[:3, :3]
    normals = part.normals
    if normals is not None:
        normals = normals @ np.linalg.inv(linear) if abs(np.linalg.det(linear)) > 0 else None
    return replace(part, vertices=part.vertices @ linear.T + matrix[:3, 3], normals=normals)


COLOURS = (
    ("pbrMetallicRoughness", "baseColorTexture"),
    ("extensions", "KHR_materials_pbrSpecularGlossiness", "diffuseTexture"),
)
"""Where a material may name the picture of its colour."""
WEBP = "EXT_texture_webp"


def texture_of(file: Gltf, primitive: dict[str, Any]) -> dict[str, Any]:
    """How a primitive's material names the picture of its colour; empty where it has none."""
    if "material" not in primitive:
        return {}
    material = file.named("materials", primitive["material"], "material")
    for path in COLOURS:
        found: Any = material
        for name in path:
            found = found.get(name) if isinstance(found, dict) else None
        if isinstance(found, dict):
            return found
    return {}


def with_texture(file: Gltf, part: RawMesh, primitives: list[dict[str, Any]]) -> RawMesh:
    """A part with the first picture that primitives have, which alone is decoded, once. A note tells where more have
    another one, or one of a kind that is not read. Raises `UsageError` for one that is no picture."""
    images = []
    for one in primitives:
        named = texture_of(file, one)
        if named:
            texture = file.named("textures", named.get("index"), "material")
            extensions = texture.get("extensions")
            webp = extensions.get(WEBP) if isinstance(extensions, dict) else None
            images.append((webp if isinstance(webp, dict) else texture).get("source"))
    notes, found = [], None
    for index in dict.fromkeys(images):
        if index is None:
            notes.append("a texture of a kind that is not read; save it as PNG or JPEG")
        elif found is None:
            image, where = file.named("images", index, "texture"), f"images[{index}]"
            content = file.content(image["uri"], where) if "uri" in image else file.view(image.get("bufferView"), where)
            try:
                found = pixels(bytes(content))
            except ValueError:
                raise file.fault(where, "is no picture that can be read, such as PNG or JPEG") from None
    if len(set(images)) > 1:
        notes.append(f"{len(set(images))} textures: the first is taken for all of it")
    return replace(part, texture=found, notes=(*part.notes, *notes))
