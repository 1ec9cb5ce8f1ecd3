"""Solids that consist of triangles, in the z-buffer: by the triangles that each pixel may show, not by the pixel."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...scene.model.solids import shape_of
from ...solids import Solids, custom
from ...solids.kernels.custom import distances
from ..common.kernels.keys import FIRST
from ..view.camera import View
from .kernels import triangles as kernels
from .kernels.triangles import BAND, ROUNDING, Picture, Rays, Solid, Spans
from .kernels.visible import BOTTOM, LEFT, RIGHT, TOP

NEAR = 1.001
"""Times its reach within which an eye may be in a solid."""


class Surface(NamedTuple):
    """The triangles of a solid, in its own frame."""

    number: int
    """Of the solid, among all."""
    row: NDArray[np.float32]
    """(columns,) its row."""
    corners: NDArray[np.float64]
    """(T, 3, 3) metres."""


def surfaces(solids: Solids, view: View) -> list[Surface]:
    """The solids that consist of triangles, and that no ray of the view may begin in."""
    kinds = getattr(getattr(type(solids), "custom_class", None), "kinds", ())
    first = sum(len(one) for one in solids[:4])
    found = []
    rows = getattr(solids, "custom", ())
    for m, row in enumerate(rows):
        place = int(row[custom.KIND])
        shape: Any = shape_of(kinds[place])
        if getattr(shape, "triangles", None) is None or _begins_inside(solids, m, row, view):
            continue
        data = shape.Data(*(getattr(solids, f"data_{place}_{name}") for name in shape.Data._fields))
        found.append(Surface(first + m, row, shape.triangles(row[custom.NUMBERS :], data)))
    return found


def _begins_inside(solids: Any, m: int, row: NDArray[np.float32], view: View) -> bool:
    """Whether a ray may begin inside of solid m of those with such rows, where it meets nothing."""
    off = view.eye - row[:3]
    away = float(np.linalg.norm(off)) if view.perspective else abs(float(off @ view.forward))
    if away > NEAR * row[custom.REACH]:
        return False
    if not view.perspective:
        return True
    found = np.empty(1, np.float32)
    distances(type(solids).custom_class(*solids[4:]), m, view.eye.astype(np.float32)[None], found)
    return bool(found[0] < 0)


def draw(
    surface: Surface, frame: NDArray[np.int64], view: View, size: tuple[int, int], keys: NDArray[Any],
    shown: NDArray[np.int32],
) -> None:  # fmt: skip
    """Draw a solid into the z-buffer (height * width,), and where it is in front its triangles into ``shown``
    (height * width,) or (0,). frame: its screen bounds, as in `kernels.visible.find`."""
    packed = view.pack()
    rays = _rays(surface.row, frame, view)
    count = len(surface.corners)
    spans = Spans(np.empty((count, 4), np.int32), np.empty(count, np.float32), np.empty(count, np.uint8))
    kernels.bound(surface.corners, rays, packed, frame, spans)
    listed, begin = _bands(spans, frame)
    identity = FIRST + np.uint64(surface.number)
    width, height = size
    kernels.draw(
        surface.corners, listed, begin, Solid(surface.row[None]), rays, packed, frame, spans, identity,
        Picture(keys.reshape(height, width), shown.reshape(height if len(shown) else 0, width)),
    )  # fmt: skip


def _rays(row: NDArray[np.float32], frame: NDArray[np.int64], view: View) -> Rays:
    """The rays of a view in the frame of a solid's row."""
    turn = row[custom.ROW_X : custom.REACH].reshape(3, 3).astype(np.float64)
    place = row[:3].astype(np.float64)
    off = view.eye - place
    size = np.linalg.norm(view.eye) + np.linalg.norm(place) + np.linalg.norm(off) + 2 * float(row[custom.REACH])
    longest = 1.0
    if view.perspective:
        (x, y), edges = view.middle, frame.astype(np.float64)
        wide = max(abs(edges[LEFT] - x), abs(edges[RIGHT] - x)) / view.focal
        high = max(abs(edges[TOP] - y), abs(edges[BOTTOM] - y)) / view.focal
        longest = math.sqrt(1.0 + wide * wide + high * high)
    axes = np.stack([view.right, view.up, view.forward]).astype(np.float64)
    return Rays(axes @ turn, off @ turn, ROUNDING * float(size), longest)


def _bands(spans: Spans, frame: NDArray[np.int64]) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Triangles of each band of rows of a frame, those that face the eye first, and where the bands begin among
    them."""
    there = np.flatnonzero((spans.box[:, RIGHT] > spans.box[:, LEFT]) & (spans.box[:, BOTTOM] > spans.box[:, TOP]))
    low = (spans.box[there, TOP] - frame[TOP]) // BAND
    many = (spans.box[there, BOTTOM] - 1 - frame[TOP]) // BAND + 1 - low
    ends = np.cumsum(many)
    band = np.repeat(low - ends + many, many) + np.arange(ends[-1] if len(ends) else 0)
    listed = np.repeat(there, many)
    count = max(-(-int(frame[BOTTOM] - frame[TOP]) // BAND), 0)
    # few bits, so that the sort takes each number's place at once
    order = np.argsort((2 * band + spans.turned[listed]).astype(np.uint16), kind="stable")
    begin = np.zeros(count + 1, np.int64)
    np.cumsum(np.bincount(band, minlength=count), out=begin[1:])
    return listed[order].astype(np.int32), begin
