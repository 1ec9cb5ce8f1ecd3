"""What the header of a glTF file tells, checked before anything makes room for it."""

from __future__ import annotations

import io
import json
import struct
from pathlib import Path
from typing import Any

from ..errors import UsageError, one_line

MAGIC, JSON_CHUNK = b"glTF", 0x4E4F534A
ITEM = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
"""Bytes of a number, by glTF's code of its type."""
NUMBERS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
"""Numbers of an item."""
MOST = 4
"""How often over what the file holds may be told in views, in accessors, and in placed triangles."""
PACKED = ("KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression")
"""Extensions that hold the geometry in another way, which is not read."""


class Header:
    """The header of a file; ``size``: bytes of the file and of those that it names."""

    def __init__(self, path: Path, tree: Any, size: int) -> None:
        self.path, self.size = path, size
        self.tree: dict[str, Any] = tree if isinstance(tree, dict) else {}
        if not self.tree:
            raise self.fault("header", "is no object of glTF")

    def fault(self, where: str, why: str) -> UsageError:
        """An error that says where."""
        text = one_line(f"{where}: {why}")[:200]
        return UsageError(f"{self.path}: {text}; it is damaged or no glTF: write it anew, as .glb with triangles")

    def entries(self, name: str) -> list[dict[str, Any]]:
        """A list of objects."""
        found = self.tree.get(name, [])
        if not (isinstance(found, list) and all(isinstance(one, dict) for one in found)):
            raise self.fault(name, "is no list of objects")
        return found

    def number(self, one: dict[str, Any], key: str, where: str, least: int = 0, most: int = 1 << 62) -> int:
        """A whole number of an entry; 0 where it is not there."""
        found = one.get(key, 0)
        if not isinstance(found, int) or isinstance(found, bool) or not least <= found <= most:
            raise self.fault(where, f"{key} is {found!r:.40}")
        return found


def header_of(path: Path, content: io.BytesIO) -> Any:
    """The header of a `.gltf`, or that of a `.glb`."""
    data = content.getbuffer()
    begin, end = 0, len(data)
    if data[:4] == MAGIC:
        if len(data) < 20:
            raise UsageError(f"{path}: ends within its header; write it anew")
        _, version, told, long, kind = struct.unpack("<4sIIII", data[:20])
        if version != 2:
            raise UsageError(f"{path}: is glTF {version}; glTF 2 is read: write it anew")
        if kind != JSON_CHUNK or long > len(data) - 20 or told > len(data):
            raise UsageError(f"{path}: tells {told:,} bytes and holds {len(data):,}; it is damaged: write it anew")
        begin, end = 20, 20 + long
    try:
        return json.loads(bytes(data[begin:end]).decode("utf-8"))
    except (ValueError, RecursionError) as error:
        why = one_line(str(error))[:80]
        raise UsageError(f"{path}: its header is no JSON ({why}); it is damaged or no glTF: write it anew") from None


def check(path: Path, tree: Any, size: int) -> None:
    """Raise `UsageError` where a header tells more than there is; size: bytes of the file and of those it names."""
    header = Header(path, tree, size)
    packed = [name for name in PACKED if name in str(header.tree.get("extensionsRequired", ""))]
    if packed:
        raise UsageError(f"{path}: holds its geometry by {packed[0]}, which is not read; write it without compression")
    views = header.entries("bufferViews")
    buffers = header.entries("buffers")
    told = 0
    for k, view in enumerate(views):
        where = f"bufferViews[{k}]"
        header.number(view, "buffer", where, most=len(buffers) - 1)
        header.number(view, "byteOffset", where, most=size)
        told += header.number(view, "byteLength", where, most=size)
    if told > MOST * size:
        raise header.fault("bufferViews", f"tell {told:,} bytes, of {size:,}")
    triangles = _accessors(header, views)
    _nodes(header, triangles)


def _accessors(header: Header, views: list[dict[str, Any]]) -> list[int]:
    """Check what accessors tell; returns of each how many items it has."""
    counts, told = [], 0
    for k, one in enumerate(header.entries("accessors")):
        where = f"accessors[{k}]"
        if one.get("componentType") not in ITEM or one.get("type") not in NUMBERS:
            raise header.fault(where, f"holds {one.get('type')!r:.20} of {one.get('componentType')!r:.20}")
        count = header.number(one, "count", where)
        header.number(one, "byteOffset", where, most=header.size)
        told += count * ITEM[one["componentType"]] * NUMBERS[one["type"]]
        if "bufferView" in one:
            view = views[header.number(one, "bufferView", where, most=len(views) - 1)]
            header.number(view, "byteStride", where, most=252)
        counts.append(count)
        if told > MOST * header.size:
            raise header.fault(where, f"{count:,} items are more than the file holds")
    return counts


def _nodes(header: Header, counts: list[int]) -> None:
    """Check that nodes make trees, and that what they place is no more than the file could hold itself."""
    nodes, meshes = header.entries("nodes"), header.entries("meshes")
    sizes = []
    for k, mesh in enumerate(meshes):
        found = 0
        primitives = mesh.get("primitives", [])
        if not (isinstance(primitives, list) and all(isinstance(one, dict) for one in primitives)):
            raise header.fault(f"meshes[{k}]", "primitives are no list of objects")
        for one in primitives:
            packed = [name for name in PACKED if name in (one.get("extensions") or {})]
            if packed and "bufferView" not in str(header.tree.get("accessors", "")):
                raise header.fault(f"meshes[{k}]", f"holds its geometry by {packed[0]}, which is not read")
            attributes = one.get("attributes")
            if not isinstance(attributes, dict):
                raise header.fault(f"meshes[{k}]", "a primitive has no attributes")
            for key in [*attributes, "indices"]:
                place = header.number(
                    one if key == "indices" else attributes, key, f"meshes[{k}]", most=max(len(counts) - 1, 0)
                )
                found += counts[place] if place < len(counts) else 0
        sizes.append(found)
    placed, parents = 0, [0] * len(nodes)
    for k, node in enumerate(nodes):
        children = node.get("children", [])
        if not isinstance(children, list):
            raise header.fault(f"nodes[{k}]", "children are no list")
        for child in children:
            if not isinstance(child, int) or not k != child or not 0 <= child < len(nodes):
                raise header.fault(f"nodes[{k}]", f"has a child {child!r:.20}")
            parents[child] += 1
        if "mesh" in node:
            placed += sizes[header.number(node, "mesh", f"nodes[{k}]", most=len(meshes) - 1)]
    if any(count > 1 for count in parents):
        raise header.fault("nodes", "one has several parents")
    if placed > MOST * header.size:
        raise header.fault("nodes", f"place {placed:,} numbers, of a file of {header.size:,} bytes")
    # a ring of nodes, each with one parent, is on no way from a root
    waiting = [k for k, count in enumerate(parents) if not count]
    reached = 0
    while waiting:
        reached += 1
        waiting.extend(nodes[waiting.pop()].get("children", []))
    if reached != len(nodes):
        raise header.fault("nodes", "go round in a ring")
