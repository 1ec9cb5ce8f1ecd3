"""The mesh of a solid: read from its file, turned, scaled and placed in the solid's own frame."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import UsageError
from ..exchange.edit.transform import turning
from ..meshes.mesh import TriangleMesh
from ..meshes.read import read_mesh

UP = "y"
KEPT = 8
"""Meshes that are kept, of the last ones asked for."""


class Version(NamedTuple):
    """A file as it is now: one that is written anew is read anew."""

    path: str
    changed: int
    """Nanoseconds."""
    size: int
    """Bytes."""


def version(path: str) -> Version:
    """The file's version. Raises `UsageError` where there is none."""
    try:
        found = Path(path).stat()
    except OSError as error:
        raise UsageError(f"{path}: {error.strerror or error}") from None
    return Version(path, found.st_mtime_ns, found.st_size)


class Placing(NamedTuple):
    """How a file's mesh is placed: settings of `strandcli.solid_shapes.mesh`."""

    up: str
    scale: float
    size: float | None
    place: str


def placing(settings: Any) -> Placing:
    """What a solid's settings say of its place."""
    return Placing(settings.up, settings.scale or 1.0, settings.size, settings.place)


@functools.lru_cache(maxsize=KEPT)
def placed(file: Version, how: Placing) -> TriangleMesh:
    """The mesh of a file in metres, y up, as its solid has it."""
    mesh = as_in_file(file)
    turn = turning(how.up, UP)
    corners = np.array(mesh.box()) @ turn.T
    low, high = corners.min(axis=0), corners.max(axis=0)
    factor = how.scale if how.size is None else how.size / float((high - low).max())
    shift = np.zeros(3)
    if how.place != "file":
        shift = -0.5 * factor * (low + high)
        if how.place == "ground":
            shift[1] = -factor * low[1]
    if factor == 1 and not shift.any() and how.up == UP:
        return mesh
    moved = mesh.transformed(factor * turn, shift)
    if not np.abs(np.array(moved.box())).max() < 1e15:
        raise UsageError(f"{file.path}: is too far out for single precision; set the solid's scale or size")
    return moved


@functools.lru_cache(maxsize=KEPT)
def as_in_file(file: Version) -> TriangleMesh:
    """The mesh of a file, in its own units and axes."""
    return read_mesh(Path(file.path))
