"""A glTF 2 file: the objects of its header, the numbers of its accessors, the bytes that it names, and where
its nodes place meshes.

Nothing that the header tells is believed, and no memory is taken for it, before it was compared with what is there.
"""

from __future__ import annotations

import binascii
import json
import math
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote_to_bytes

import numpy as np
import numpy.typing as npt

from ..common.rotations import of_quaternion
from ..errors import UsageError, one_line
from .bounded import Beside, whole

MAGIC, JSON_CHUNK, BINARY_CHUNK = b"glTF", 0x4E4F534A, 0x004E4942
KINDS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
"""Types of numbers, by glTF's codes."""
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
"""Numbers of an item; those of matrices are not read."""
MARKS = 1_000_000
"""Commas and brackets of a header, at most: each takes up to 100 bytes when it is parsed."""
PACKED = ("KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression")
"""Extensions that hold the geometry in another form, which is not read."""


class Gltf:
    """A file whose header was parsed."""

    def __init__(self, path: Path, beside: Beside) -> None:
        self.path, self.beside = path, beside
        self.header, self.binary, self._size = _chunks(path)
        if not isinstance(self.header, dict) or not self.header:
            raise self.fault("header", "is no object of glTF")
        packed = self.packed(self.header.get("extensionsRequired"))
        if packed:
            raise packed
        self.meshes = self.objects(self.header, "meshes")
        self._buffers = [self._bytes(k, one) for k, one in enumerate(self.objects(self.header, "buffers"))]

    @property
    def size(self) -> int:
        """Bytes of the file and of those that it names."""
        return self._size + self.beside.size

    def fault(self, where: str, why: str) -> UsageError:
        """An error that says where."""
        text = one_line(f"{where}: {why}")[:200]
        return UsageError(f"{self.path}: {text}; it is damaged or no glTF: write it anew, as .glb with triangles")

    def packed(self, extensions: Any) -> UsageError | None:
        """An error where some extensions hold geometry in a form that is not read."""
        found = [name for name in PACKED if isinstance(extensions, dict | list) and name in extensions]
        if not found:
            return None
        return UsageError(
            f"{self.path}: stores its geometry by {found[0]}, which is not read; write it without compression"
        )

    def objects(self, parent: dict[str, Any], name: str, where: str = "header") -> list[dict[str, Any]]:
        """A list of objects, empty where there is none."""
        found = parent.get(name, [])
        if not (isinstance(found, list) and all(isinstance(one, dict) for one in found)):
            raise self.fault(where, f"{name} is no list of objects")
        return found

    def named(self, name: str, index: Any, where: str) -> dict[str, Any]:
        """The object of a list of the header that another one names by its index."""
        found = self.header.get(name)
        if not isinstance(found, list) or not _is_whole(index) or not 0 <= index < len(found):
            raise self.fault(where, f"wants {name}[{index!r:.20}], which there is not")
        if not isinstance(found[index], dict):
            raise self.fault(f"{name}[{index}]", "is no object")
        return found[index]

    def whole(self, one: dict[str, Any], key: str, where: str, least: int = 0, most: int = 1 << 62) -> int:
        """A whole number of an object; 0 where it is not there."""
        found = one.get(key, 0)
        if not _is_whole(found) or (key in one and not least <= found <= most):
            raise self.fault(where, f"{key} is {found!r:.40}")
        return int(found)

    def reals(self, one: dict[str, Any], key: str, count: int, where: str) -> npt.NDArray[np.float64] | None:
        """So many finite numbers of an object; None where they are not there."""
        if key not in one:
            return None
        found = one[key]
        if not isinstance(found, list) or len(found) != count or not all(map(_is_finite, found)):
            raise self.fault(where, f"{key} is not {count} finite numbers")
        return np.array(found, np.float64)

    def shape(self, index: Any, where: str) -> tuple[int, int, str]:
        """Of an accessor its items, the numbers of each (0 of matrices), and their type as NumPy has it."""
        one, at = self.named("accessors", index, where), f"accessors[{index}]"
        kind, width = one.get("componentType"), one.get("type")
        if not isinstance(kind, int) or kind not in KINDS or not isinstance(width, str):
            raise self.fault(at, f"holds {width!r:.20} of {kind!r:.20}")
        return self.whole(one, "count", at), WIDTHS.get(width, 0), KINDS[kind]

    def numbers(self, index: Any, width: int, where: str) -> npt.NDArray[Any]:
        """(n, width) what an accessor holds, a view of the file where it can be one; float32 where it is normalized.
        Who calls has looked at how many there are."""
        one, at = self.named("accessors", index, where), f"accessors[{index}]"
        count, found, kind = self.shape(index, where)
        if "sparse" in one:
            raise self.fault(where, f"{at} is sparse, which is not read")
        if found != width:
            raise self.fault(where, f"{at} holds {one.get('type')!r:.20}, in place of {width} numbers an item")
        values = self._items(one, count, width, kind, at) if "bufferView" in one else np.zeros((count, width), kind)
        if one.get("normalized") is True and kind[1] != "f":
            values = np.maximum(values / np.float32(np.iinfo(kind).max), np.float32(-1))
        return values

    def primitives(self) -> list[list[dict[str, Any]]]:
        """The primitives of each mesh, whose attributes are objects with positions."""
        found = [self.objects(one, "primitives", f"meshes[{k}]") for k, one in enumerate(self.meshes)]
        for k, mesh in enumerate(found):
            for one in mesh:
                if not isinstance(one.get("attributes"), dict) or "POSITION" not in one["attributes"]:
                    raise self.fault(f"meshes[{k}]", "a primitive has no positions")
        return found

    def count(self, primitive: dict[str, Any], where: str) -> int:
        """How many positions a primitive names, one after the other."""
        return self.shape(primitive.get("indices", primitive["attributes"]["POSITION"]), where)[0]

    def rows(self, primitive: dict[str, Any], positions: int, where: str) -> npt.NDArray[np.int32]:
        """Which of so many positions a primitive names, one after the other."""
        if "indices" not in primitive:
            return np.arange(positions, dtype=np.int32)
        found = self.numbers(primitive["indices"], 1, where)[:, 0]
        if found.dtype.kind not in "iu":
            raise self.fault(where, "indices are no whole numbers")
        outside = np.flatnonzero((found < 0) | (found >= positions))
        if outside.size:
            raise self.fault(where, f"indices want vertex {found[outside[0]]:,} of {positions:,}")
        return found.astype(np.int32)

    def _items(self, one: Any, count: int, width: int, kind: str, where: str) -> npt.NDArray[Any]:
        """(count, width) numbers of a view from an offset on; one: an accessor."""
        data = self.view(one.get("bufferView"), where)
        view = self.named("bufferViews", one["bufferView"], where)
        item = np.dtype(kind).itemsize
        begin = self.whole(one, "byteOffset", where)
        stride = self.whole(view, "byteStride", where, least=1, most=252) or width * item
        if count and begin + (count - 1) * stride + width * item > len(data):
            raise self.fault(where, f"{count:,} items are more than its bufferView has")
        return np.ndarray((count, width), kind, data, begin, (stride, item)) if count else np.zeros((0, width), kind)

    def view(self, index: Any, where: str) -> memoryview:
        """The bytes of a buffer's view."""
        one, at = self.named("bufferViews", index, where), f"bufferViews[{index}]"
        packed = self.packed(one.get("extensions"))
        if packed:
            raise packed
        self.named("buffers", one.get("buffer"), at)
        data = self._buffers[one["buffer"]]
        begin, size = self.whole(one, "byteOffset", at), self.whole(one, "byteLength", at)
        if begin + size > len(data):
            raise self.fault(at, f"goes beyond the {len(data):,} bytes of its buffer")
        return data[begin : begin + size]

    def _bytes(self, index: int, buffer: dict[str, Any]) -> memoryview:
        """The bytes of a buffer; none of one that stands for packed geometry."""
        if "uri" in buffer:
            return memoryview(self.content(buffer.pop("uri"), f"buffers[{index}]"))
        return self.binary if index == 0 else memoryview(b"")

    def content(self, uri: Any, where: str) -> bytes | bytearray:
        """The bytes that an address names: its own, or those of a file of the folder."""
        if not isinstance(uri, str):
            raise self.fault(where, f"uri is {uri!r:.20}")
        try:
            if not uri.startswith("data:"):
                return self.beside.get(uri)
            begin = uri.find(",") + 1 or len(uri)
            base64 = uri.endswith(";base64,", 0, begin)
            return binascii.a2b_base64(uri[begin:]) if base64 else unquote_to_bytes(uri[begin:])
        except (OSError, ValueError) as error:
            raise self.fault(where, f"{uri:.60}: {error}") from None


def _is_whole(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _is_finite(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _chunks(path: Path) -> tuple[Any, memoryview, int]:
    """The header of a `.gltf` or a `.glb`, the binary chunk of the latter, and the bytes of the file."""
    content = whole(path, "glTF file")
    data, binary = memoryview(content), memoryview(b"")
    size = len(data)
    if data[:4] == MAGIC:
        if size < 20:
            raise UsageError(f"{path}: ends within its header; write it anew")
        _, version, declared, long, kind = struct.unpack("<4sIIII", data[:20])
        if version != 2:
            raise UsageError(f"{path}: is glTF {version}; glTF 2 is read: write it anew")
        if kind != JSON_CHUNK or long > size - 20 or declared > size:
            raise UsageError(f"{path}: declares {declared:,} bytes and has {size:,}; it is damaged: write it anew")
        if size >= 28 + long and struct.unpack("<I", data[24 + long : 28 + long])[0] == BINARY_CHUNK:
            binary = data[28 + long :][: struct.unpack("<I", data[20 + long : 24 + long])[0]]
        data = data[20 : 20 + long]
    try:
        text = str(data, "utf-8-sig")
        del content, data
        marks = sum(map(text.count, (",", "[", "{")))
        if marks > MARKS:
            raise UsageError(f"{path}: its header lists {marks:,} things, more than {MARKS:,}; write it anew, as .ply")
        return json.loads(text), binary, size
    except (ValueError, RecursionError) as error:
        why = one_line(str(error))[:80]
        raise UsageError(f"{path}: its header is no JSON ({why}); it is damaged or no glTF: write it anew") from None


def placed_meshes(file: Gltf) -> Iterator[tuple[int, npt.NDArray[np.float64], str]]:
    """The meshes of the scene, the matrices (4, 4) that place them, and names of nodes or meshes; each once where there
    are no nodes."""
    names = [_name(one) or f"mesh{k}" for k, one in enumerate(file.meshes)]
    nodes = file.objects(file.header, "nodes")
    if not nodes:
        yield from ((k, np.eye(4), name) for k, name in enumerate(names))
    parents = [0] * len(nodes)
    for k, node in enumerate(nodes):
        children = node.get("children", [])
        if not isinstance(children, list):
            raise file.fault(f"nodes[{k}]", "children are no list")
        for child in children:
            file.named("nodes", child, f"nodes[{k}]")
            parents[child] += 1
    roots: Any = [k for k, count in enumerate(parents) if not count]
    if max(parents, default=0) > 1 or _reached(nodes, roots) < len(nodes):
        raise file.fault("nodes", "one has several parents, or some go round in a ring")
    if file.objects(file.header, "scenes"):
        scene = file.named("scenes", file.header.get("scene", 0), "scene")
        roots = scene.get("nodes", [])
    if not isinstance(roots, list) or len(set(map(repr, roots))) < len(roots):
        raise file.fault("scenes", "nodes are no list of nodes, each once")
    waiting = [(root, np.eye(4)) for root in reversed(roots)]
    while waiting:
        k, above = waiting.pop()
        node = file.named("nodes", k, "scenes")
        matrix = above @ _matrix(file, node, f"nodes[{k}]")
        if "mesh" in node:
            file.named("meshes", node["mesh"], f"nodes[{k}]")
            yield node["mesh"], matrix, _name(node) or names[node["mesh"]]
        waiting += [(child, matrix) for child in reversed(node.get("children", []))]


def _name(one: dict[str, Any]) -> str:
    """The name of a node or a mesh, empty where it has none."""
    found = one.get("name")
    return found if isinstance(found, str) else ""


def _reached(nodes: list[dict[str, Any]], roots: list[int]) -> int:
    """How many nodes hang on some roots, of nodes with one parent each at most; rings hang on none."""
    waiting, found = list(roots), 0
    while waiting and found <= len(nodes):
        found += 1
        waiting.extend(nodes[waiting.pop()].get("children", []))
    return found


def _matrix(file: Gltf, node: dict[str, Any], where: str) -> npt.NDArray[np.float64]:
    """The matrix (4, 4) by which a node places what hangs on it: its own, or translation · rotation · scale."""
    found = np.eye(4)
    columns = file.reals(node, "matrix", 16, where)
    if columns is not None:
        return columns.reshape(4, 4).T
    turn, shift, scale = (file.reals(node, *one, where) for one in (("rotation", 4), ("translation", 3), ("scale", 3)))
    if turn is not None and (size := float(np.linalg.norm(turn))) > 0:
        found[:3, :3] = of_quaternion(np.roll(turn, 1) / size)
    if scale is not None:
        found[:3, :3] *= scale
    if shift is not None:
        found[:3, 3] = shift
    return found
