"""Lines of `.gltf` and `.glb`: primitives of the modes LINES, LINE_LOOP and LINE_STRIP, where nodes put them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ...errors import UsageError
from ..bounded import Beside, not_finite, too_many
from ..files import ReadOptions
from ..gltf_file import MAGIC, Gltf, placed_meshes
from ..parts import Part, concatenated, joined, moved
from ..strands import Offsets, Points, Source, Strands, without_short
from .obj import IS_MESH, OF_POINT, Lines, at_rows, joined_lines

name = ".gltf"
suffixes = (".gltf", ".glb")

LINES, LOOP, STRIP, TRIANGLES = 1, 2, 3, 4
"""Modes of primitives; those from the last one on are meshes."""


def sniff(head: bytes, size: int) -> bool:
    """Whether it is a `.glb`; a `.gltf` begins as any JSON."""
    return head.startswith(MAGIC)


def is_mesh(path: Path) -> bool:
    """Whether a file has triangles, and is no strands, or not alone."""
    return any(_mode(one) >= TRIANGLES for mesh in Gltf(path, Beside(path)).primitives() for one in mesh)


def read(path: Path, options: ReadOptions) -> Strands:
    """The strands of all lines of the scene. Of pairs one that begins where the one before it ends goes on with it."""
    parts, meshes_left = _parts(path)
    facts: dict[str, Any] = {"not_read": {"primitives of a mesh": meshes_left}} if meshes_left else {}
    strands, lost = joined(parts, Source(name, "2.0", facts, 1.0, "y"))
    if lost:
        facts["attributes_not_read"] = lost
    bad, point = not_finite(strands.points)
    if bad and not options.lenient:
        raise UsageError(f"{path}: point {point:,} of its lines is not finite; 'convert --fix' mends it")
    return without_short(strands)


def _parts(path: Path) -> tuple[list[Part], int]:
    """The lines of each node, and how many primitives there are that are no lines but meshes."""
    file = Gltf(path, Beside(path))
    meshes = file.primitives()
    lines = [[one for one in mesh if LINES <= _mode(one) <= STRIP] for mesh in meshes]
    placed = [one for one in placed_meshes(file) if lines[one[0]]]
    meshes_left = sum(_mode(one) >= TRIANGLES for mesh in meshes for one in mesh)
    if not placed:
        raise UsageError(f"{path}: {IS_MESH}") if meshes_left else file.fault("scene", "has no lines")
    counts = [sum(_count(file, one) for one in mesh) for mesh in lines]
    why = too_many("points of its lines", sum(counts[mesh] for mesh, _, _ in placed), OF_POINT, file.size)
    if why:
        raise UsageError(f"{path}: {why}; write fewer")
    known: dict[int, Part] = {}
    parts = []
    for mesh, matrix, label in placed:
        if mesh not in known:
            known[mesh] = _part(file, lines[mesh], f"meshes[{mesh}]")
        one = known[mesh]
        points = moved(one.points, None if np.array_equal(matrix, np.eye(4)) else matrix.T)
        parts.append(Part(label, one.counts, points, unread=one.unread))
    return parts, meshes_left


def _mode(primitive: dict[str, Any]) -> int:
    """The mode of a primitive; that of points where it has none that is known."""
    found = primitive.get("mode", TRIANGLES)
    return found if isinstance(found, int) else 0


def _count(file: Gltf, primitive: dict[str, Any]) -> int:
    """Points that the lines of a primitive take, or its positions where these are more."""
    there, _, _ = file.shape(primitive["attributes"]["POSITION"], "meshes")
    return max(file.count(primitive, "meshes"), there) + (_mode(primitive) == LOOP)


def _part(file: Gltf, primitives: list[dict[str, Any]], where: str) -> Part:
    """The strands of the primitives of a mesh."""
    counts, points = [], []
    unread: dict[str, None] = {}
    for one in primitives:
        table, first, rows = _lines(file, one, where)
        counts.append(np.diff(first))
        points.append(at_rows(table, rows))
        unread |= dict.fromkeys(name for name in one["attributes"] if name != "POSITION")
    return Part("", concatenated(counts), concatenated(points), unread=list(unread))


def _lines(file: Gltf, primitive: dict[str, Any], where: str) -> tuple[Points, Offsets, npt.NDArray[np.int32]]:
    """The positions of a primitive, offsets of its strands, and the rows of their points."""
    found = file.numbers(primitive["attributes"]["POSITION"], 3, where)
    table = np.require(found, np.float32, ("C", "A"))
    rows = file.rows(primitive, len(table), where)
    mode = _mode(primitive)
    if mode == LINES:
        pairs = rows.size // 2
        each, object_of = (np.broadcast_to(np.int32(one), pairs) for one in (2, 0))
        lines = Lines(each, rows[: 2 * pairs], object_of)
        return table, *joined_lines(lines)[:2]
    rows = np.append(rows, rows[:1]) if mode == LOOP else rows
    return table, np.array([0, rows.size]), rows
