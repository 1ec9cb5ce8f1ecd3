"""The mesh of a solid: read from its file, turned, scaled and placed in the solid's own frame."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..common.rotations import turning
from ..errors import UsageError, about
from ..files.inputs import cached
from ..meshes.make import LARGEST
from ..meshes.mesh import TriangleMesh, Vectors
from ..meshes.read import read_mesh

UP = "y"
KEPT = 8
"""Meshes that are cached, of the last ones asked for."""


class Placing(NamedTuple):
    """How a file's mesh is placed: settings of `strandcli.solid_shapes.mesh`."""

    up: str
    scale: float
    size: float | None
    place: str


def placing(settings: Any) -> Placing:
    """What a solid's settings say of its place."""
    return Placing(settings.up, settings.scale or 1.0, settings.size, settings.place)


class Moment(NamedTuple):
    """A moment of a mesh that deforms: between two files."""

    before: str
    after: str
    share: float
    """Share from the first to the second."""


def moment(keys: Sequence[Any], time: float) -> Moment:
    """The moment at a time in seconds of files with times, which ascend; clamped before the first and after the
    last."""
    times = [key.time for key in keys]
    place = min(max(bisect_right(times, time), 1), len(keys) - 1) if len(keys) > 1 else 0
    before, after = keys[max(place - 1, 0)], keys[place]
    span = after.time - before.time
    share = min(max((time - before.time) / span, 0.0), 1.0) if span > 0 else 0.0
    return Moment(before.file, after.file, share)


@cached(KEPT)
def placed(file: str, how: Placing) -> TriangleMesh:
    """The mesh of a file in metres, y up, as its solid has it."""
    mesh = as_in_file(file)
    linear, shift = _transform(file, how)
    if (linear == np.eye(3)).all() and not shift.any():
        return mesh
    moved = mesh.transformed(linear, shift)
    if not np.abs(np.array(moved.box())).max() < LARGEST:
        with about("mesh", file):
            raise UsageError(f"{file}: is too far out for single precision; set the solid's scale or size")
    return moved


@cached(KEPT)
def deformed(file: str, how: Placing, other: str) -> Vectors:
    """The vertices of a mesh as another file has them, placed as those of its own file."""
    if other == file:
        return placed(file, how).vertices
    linear, shift = _transform(file, how)
    found: Vectors = read_mesh(Path(other), like=as_in_file(file)).vertices @ linear.T + shift
    return found


def vertices_at(settings: Any, time: float) -> Vectors:
    """The vertices (V, 3) of a placed mesh at a time in seconds, as it deforms."""
    file, how = settings.file, placing(settings)
    if not settings.deform:
        return placed(file, how).vertices
    return between(file, how, moment(settings.deform, time))


def between(file: str, how: Placing, at: Moment) -> Vectors:
    """The vertices of a placed mesh at a moment."""
    first, second = deformed(file, how, at.before), deformed(file, how, at.after)
    found: Vectors = first + at.share * (second - first)
    return found


@cached(KEPT)
def _transform(file: str, how: Placing) -> tuple[Vectors, Vectors]:
    """The matrix and the shift that place the mesh of a file."""
    factor, shift = standing(np.array(as_in_file(file).box()), *how)
    return factor * turning(how.up, UP), shift


def standing(
    box: Vectors, up: str, scale: float, size: float | None, place: str
) -> tuple[float, Vectors]:  # fmt: skip
    """Metres of a unit, and the shift (3,) in metres, of what is turned upright and scaled, so that it has a longest
    side of ``size`` and stands as settings say; box (2, 3): its low and high corner in the file, whose up axis is
    ``up``."""
    corners = box @ turning(up, UP).T
    low, high = corners.min(axis=0), corners.max(axis=0)
    factor = scale if size is None else size / float((high - low).max())
    shift = np.zeros(3)
    if place != "file":
        shift = -0.5 * factor * (low + high)
        if place == "ground":
            shift[1] = -factor * low[1]
    return factor, shift


@cached(KEPT)
def as_in_file(file: str) -> TriangleMesh:
    """The mesh of a file, in its own units and axes."""
    return read_mesh(Path(file))
