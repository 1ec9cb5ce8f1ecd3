"""Binary .ply files of triangles, with colours and named numbers of vertices."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

LICENCE = "made by the project strandcli from formulas of its own, examples/meshes; MIT, as the project"


def write(
    path: Path, points: np.ndarray, normals: np.ndarray, faces: np.ndarray, colours: np.ndarray,
    numbers: Mapping[str, np.ndarray],
) -> None:  # fmt: skip
    """Write vertices (N, 3) with normals, colours (N, 3) uint8 in sRGB and named numbers (N,), and triangles (M, 3)."""
    small = len(points) < 65536
    vertex = [(n, "<f4") for n in ("x", "y", "z", "nx", "ny", "nz")] + [(n, "u1") for n in ("red", "green", "blue")]
    rows = np.empty(len(points), vertex + [(name, "<f4") for name in numbers])
    columns = [*points.T, *normals.T, *colours.T, *numbers.values()]
    for name, column in zip(rows.dtype.names, columns, strict=True):
        rows[name] = column
    lists = np.empty(len(faces), [("count", "u1"), ("corners", "<u2" if small else "<i4", 3)])
    lists["count"], lists["corners"] = 3, faces
    header = ["ply", "format binary_little_endian 1.0", f"comment {LICENCE}", f"element vertex {len(points)}"]
    header += [f"property {'uchar' if rows.dtype[n] == 'u1' else 'float'} {n}" for n in rows.dtype.names]
    header += [f"element face {len(faces)}", f"property list uchar {'ushort' if small else 'int'} vertex_indices"]
    header += ["end_header", ""]
    path.write_bytes("\n".join(header).encode() + rows.tobytes() + lists.tobytes())


def read(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Rows of vertices, by the names of their columns, and triangles (M, 3) of a file that `write` wrote."""
    head, body = path.read_bytes().split(b"end_header\n", 1)
    words = [line.split() for line in head.decode().splitlines()]
    vertices, triangles = (int(line[2]) for line in words if line[0] == "element")
    types = {"float": "<f4", "uchar": "u1"}
    vertex = np.dtype([(line[2], types[line[1]]) for line in words if line[0] == "property" and line[1] != "list"])
    index = next("<u2" if line[3] == "ushort" else "<i4" for line in words if line[:2] == ["property", "list"])
    lists = np.frombuffer(body, [("count", "u1"), ("corners", index, 3)], triangles, vertices * vertex.itemsize)
    return np.frombuffer(body, vertex, vertices), lists["corners"].astype(np.int64)
