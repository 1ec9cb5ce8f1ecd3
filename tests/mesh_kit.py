"""Meshes for tests, and what is known of them by going through all triangles."""

from __future__ import annotations

import json
import struct
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from strandcli.meshes.make import make_mesh
from strandcli.meshes.mesh import TriangleMesh

CUBE = np.array([
    (0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6),
    (1, 3, 5), (3, 7, 5),
])  # fmt: skip


def cube() -> tuple[np.ndarray, np.ndarray]:
    """The box of corners -1 and 1, wound outward."""
    vertices = np.array([[x, y, z] for z in (-1.0, 1.0) for y in (-1.0, 1.0) for x in (-1.0, 1.0)])
    return vertices, CUBE


def sphere(times: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """A sphere of radius 1: an octahedron whose edges are halved so many times."""
    vertices = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
    triangles = np.array([(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)])
    for _ in range(times):
        edges = np.sort(np.concatenate([triangles[:, (0, 1)], triangles[:, (1, 2)], triangles[:, (2, 0)]]), axis=1)
        ends, row = np.unique(edges, axis=0, return_inverse=True)
        middles = vertices[ends].sum(axis=1)
        new = vertices.shape[0] + row.reshape(3, -1).T
        vertices = np.concatenate([vertices, middles / np.linalg.norm(middles, axis=1, keepdims=True)])
        a, b, c = triangles.T
        ab, bc, ca = new.T
        triangles = np.concatenate(
            [np.stack(one, axis=1) for one in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
        )
    return vertices, triangles


def ball(times: int, radius: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """The same, enlarged to the volume of a sphere of a radius."""
    vertices, triangles = sphere(times)
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    return vertices * radius * (4 * np.pi / 3 / volume) ** (1 / 3), triangles


@cache
def mesh(name: str) -> TriangleMesh:
    """A closed ball and box, a bowl that is open above, triangles anywhere, and slivers."""
    generator = np.random.default_rng(7)
    if name == "ball":
        return make_mesh(*sphere())
    if name == "box":
        return make_mesh(*cube())
    if name == "bowl":
        vertices, triangles = sphere()
        return make_mesh(vertices, triangles[(vertices[triangles, 1] < 0.5).all(axis=1)])
    if name == "sliver":
        vertices = np.repeat(generator.normal(size=(60, 3)), 3, axis=0)
        vertices[1::3] += generator.normal(size=(60, 3))
        vertices[2::3] = vertices[1::3] + 1e-5 * generator.normal(size=(60, 3))
        return make_mesh(vertices, np.arange(180).reshape(-1, 3))
    assert name == "soup"
    return make_mesh(generator.normal(size=(180, 3)), np.arange(180).reshape(-1, 3))


def all_hits(mesh: TriangleMesh, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, ...]:
    """t, u, v (R, T) of rays and all triangles; t infinite where they do not meet (Möller & Trumbore 1997)."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    along, across = b - a, c - a
    p = np.cross(directions[:, None], across)
    with np.errstate(all="ignore"):
        inverse = 1.0 / (along * p).sum(axis=2)
        from_a = origins[:, None] - a
        u = (from_a * p).sum(axis=2) * inverse
        q = np.cross(from_a, along)
        v = (directions[:, None] * q).sum(axis=2) * inverse
        t = (across * q).sum(axis=2) * inverse
        met = (u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0)
    return np.where(met, t, np.inf), u, v


def obj(mesh: TriangleMesh) -> bytes:
    """Wavefront OBJ, with the uv of corners where there are any."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
    if mesh.uv is None:
        lines += [f"f {a} {b} {c}" for a, b, c in (mesh.triangles + 1).tolist()]
    else:
        lines += [f"vt {u} {v}" for u, v in mesh.uv.reshape(-1, 2).tolist()]
        for t, (a, b, c) in enumerate((mesh.triangles + 1).tolist()):
            lines.append(f"f {a}/{3 * t + 1} {b}/{3 * t + 2} {c}/{3 * t + 3}")
    return ("\n".join(lines) + "\n").encode()


def write(
    path: Path, vertices: np.ndarray, triangles: np.ndarray, colours: np.ndarray | None = None,
    uv: np.ndarray | None = None,
) -> Path:  # fmt: skip
    """An OBJ file; colours (V, 3) follow the vertices, uv (V, 2) are those of vertices."""
    rows = vertices if colours is None else np.hstack([vertices, colours])
    lines = ["v " + " ".join(f"{x:.9g}" for x in row) for row in rows]
    lines += [] if uv is None else [f"vt {s:.9g} {t:.9g}" for s, t in uv]
    lines += ["f " + " ".join(f"{i + 1}" if uv is None else f"{i + 1}/{i + 1}" for i in row) for row in triangles]
    path.write_text("\n".join(lines) + "\n")
    return path


def ply(
    mesh: TriangleMesh,
    order: str = "<",
    faces: list[list[int]] | None = None,
    more: dict[str, np.ndarray] | None = None,
    length: str = "u1",
) -> bytes:
    """PLY of a byte order, or text (""): double coordinates, further numbers of vertices, and the type of the length
    of lists."""
    more = more or {}
    polygons = mesh.triangles.tolist() if faces is None else faces
    kinds = {"f4": "float", "f8": "double", "u1": "uchar", "i4": "int"}
    header = ["ply", f"format { {'<': 'binary_little_endian', '>': 'binary_big_endian', '': 'ascii'}[order] } 1.0"]
    header += ["comment made by a test", f"element vertex {mesh.vertices.shape[0]}"]
    header += [f"property double {axis}" for axis in "xyz"]
    header += [f"property {kinds[values.dtype.str[1:]]} {name}" for name, values in more.items()]
    header += [f"element face {len(polygons)}", f"property list {kinds[length]} int vertex_indices", "end_header", ""]
    begin = "\n".join(header).encode()
    columns = [*mesh.vertices.T, *more.values()]
    if not order:
        rows = [" ".join(repr(value) for value in row) for row in zip(*(one.tolist() for one in columns), strict=True)]
        rows += [" ".join(map(str, [len(one), *one])) for one in polygons]
        return begin + ("\n".join(rows) + "\n").encode()
    names = ["x", "y", "z", *more]
    record = np.empty(
        mesh.vertices.shape[0], [(n, order + c.dtype.str[1:]) for n, c in zip(names, columns, strict=True)]
    )
    for name, values in zip(names, columns, strict=True):
        record[name] = values
    lists = b"".join(
        np.array(len(one), order + length).tobytes() + np.array(one, order + "i4").tobytes() for one in polygons
    )
    return begin + record.tobytes() + lists


def stl(mesh: TriangleMesh, text: bool = False) -> bytes:
    """STL, binary or text."""
    corners = mesh.vertices[mesh.triangles]
    if text:
        lines = ["solid a"]
        for triangle in corners.tolist():
            lines += ["facet normal 0 0 0", "outer loop"]
            lines += [f"vertex {x!r} {y!r} {z!r}" for x, y, z in triangle]
            lines += ["endloop", "endfacet"]
        return ("\n".join([*lines, "endsolid a"]) + "\n").encode()
    rows = np.zeros(corners.shape[0], [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    rows["corners"] = corners
    return bytes(80) + np.uint32(corners.shape[0]).tobytes() + rows.tobytes()


CODES = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}


class Maker:
    """A glTF file in the making, of one primitive a mesh."""

    def __init__(self) -> None:
        self.data = b""
        self.tree: dict[str, Any] = {
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": []}], "accessors": [], "bufferViews": [], "buffers": [{}],
        }  # fmt: skip

    def view(self, content: bytes, **more: Any) -> int:
        self.data += bytes(-len(self.data) % 4)
        self.tree["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(content), **more})
        self.data += content
        return len(self.tree["bufferViews"]) - 1

    def accessor(self, values: np.ndarray, stride: int = 0, offset: int = 0, **more: Any) -> int:
        """Numbers (n, k), each row so many bytes after the one before, the first one at an offset of its view."""
        rows = np.ascontiguousarray(values).view(np.uint8).reshape(len(values), -1)
        step = stride or rows.shape[1]
        content = np.full((len(values), step), 0xAA, np.uint8)
        content[:, : rows.shape[1]] = rows
        view = self.view(bytes(offset) + content.tobytes(), **({"byteStride": stride} if stride else {}))
        return self.entry(values, bufferView=view, byteOffset=offset, **more)

    def entry(self, values: np.ndarray, **more: Any) -> int:
        kind = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}[values.shape[1]]
        self.tree["accessors"].append(
            {"componentType": CODES[values.dtype.str[1:]], "count": len(values), "type": kind, **more}
        )
        return len(self.tree["accessors"]) - 1

    def primitive(self, attributes: dict[str, int], **more: Any) -> None:
        self.tree["meshes"][0]["primitives"].append({"attributes": attributes, **more})

    def picture(self, content: bytes, **more: Any) -> dict[str, Any]:
        """What a primitive has whose material shows a picture."""
        self.tree |= {
            "images": [{"bufferView": self.view(content), "mimeType": "image/png"}], "textures": [{"source": 0}],
            "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, **more}}}],
        }  # fmt: skip
        return {"material": 0}

    def whole(self) -> tuple[dict[str, Any], bytes]:
        """The header, and the buffer."""
        self.tree["buffers"][0]["byteLength"] = len(self.data)
        return self.tree, self.data

    def glb(self, path: Path) -> Path:
        path.write_bytes(glb(*self.whole()))
        return path


def gltf_tree(mesh: TriangleMesh, **attributes: np.ndarray) -> tuple[dict[str, Any], bytes]:
    """The header of a glTF file of a mesh, and the buffer; attributes: further ones, float32."""
    maker = Maker()
    arrays = {"POSITION": mesh.vertices.astype("<f4"), **attributes}
    named = {name: maker.accessor(one.reshape(len(one), -1)) for name, one in arrays.items()}
    maker.primitive(named, indices=maker.accessor(mesh.triangles.reshape(-1, 1).astype("<u4")))
    return maker.whole()


def glb(tree: dict, content: bytes) -> bytes:
    """A `.glb` of a header and a buffer."""
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    content += bytes(-len(content) % 4)
    size = 12 + 8 + len(text) + 8 + len(content)
    head = struct.pack("<4sII", b"glTF", 2, size) + struct.pack("<I4s", len(text), b"JSON")
    return head + text + struct.pack("<I4s", len(content), b"BIN\0") + content


def head(rings: int = 100) -> tuple[np.ndarray, np.ndarray]:
    """A closed shape as large and as bumpy as a head, metres, of 2 (rings - 1) rings triangles; a nose towards +z."""
    polar = np.linspace(0, np.pi, rings + 1)[1:-1, None]
    around = 2 * np.pi * np.arange(rings) / rings
    unit = np.stack(
        np.broadcast_arrays(np.sin(polar) * np.sin(around), np.cos(polar), np.sin(polar) * np.cos(around)), 2
    )
    unit = np.concatenate([[[0, 1.0, 0]], unit.reshape(-1, 3), [[0, -1.0, 0]]])
    x, y, z = unit.T
    bump = 0.25 * np.exp(-((x / 0.12) ** 2 + ((y + 0.1) / 0.2) ** 2)) * (z > 0)
    bump += 0.15 * np.exp(-(((np.abs(x) - 1) / 0.2) ** 2) - (z / 0.25) ** 2 - (y / 0.3) ** 2) + 0.02 * np.sin(
        9 * x
    ) * np.sin(7 * y)
    vertices = unit * (0.075, 0.12, 0.095) * (1 + bump)[:, None]
    row, column = np.divmod(np.arange((rings - 2) * rings), rings)
    a, b = 1 + row * rings + column, 1 + row * rings + (column + 1) % rings
    ring = np.arange(rings)
    last, end = 1 + (rings - 2) * rings, vertices.shape[0] - 1
    faces = [
        np.stack([0 * ring, 1 + ring, 1 + (ring + 1) % rings], axis=1),
        np.stack([a, a + rings, b], axis=1), np.stack([b, a + rings, b + rings], axis=1),
        np.stack([last + ring, 0 * ring + end, last + (ring + 1) % rings], axis=1),
    ]  # fmt: skip
    return vertices, np.concatenate(faces)
