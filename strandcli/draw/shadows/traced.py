"""Exact shadows of strands on strands (`shadow: {model: traced}`).

A shadow map blurs the shadows of single strands: harmless where a pixel shows many strands, visible where it shows few.
This model tests each strand against all others. It averages only along the strand, over one sample of the picture or
the distance between two lit vertices, whichever is longer. A strand does not shade itself.

A grid over each of a light's views lists the strand segments that overlap each cell: about `LIST`, which was measured
to be fastest, and more where the lists would exceed `GRID_BYTES`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...constants import GRID_BYTES, GRID_SIDE
from ...scene.model import Light
from ..common.kernels.view_columns import CORNER_STRETCH
from ..common.scratch import Scratch
from ..geometry.curves import NOT_ALONG, Polylines
from ..geometry.extent import Thickness
from ..geometry.kernels import silhouette
from ..geometry.kernels.silhouette import STEEPEST
from ..view.camera import View, ball
from ..view.kernels import project
from ..zbuffer.raster import sort_into_bands, to_screen
from .kernels import grid as cells
from .kernels import interval_bits
from .kernels import traced as kernel
from .kernels.occluder_intervals import OccluderLists
from .shadow import light_views, texel_of
from .vertex_shadows import VertexShadows

LIST = 400.0
"""Target number of segments that overlap a cell."""
COARSE = 64
"""Cells along a side of the grid that estimates the area covered by strands."""
SOME, MANY = 1000, 50_000
"""Strands whose segments are measured, and vertices that estimate the covered area."""
LISTED = 8 + 4 * cells.ROWS
"""Bytes of one list entry."""
PLACES = 2.0
"""Visibility samples along a strand, per strand width."""
WORDS = 8
"""Greatest number of 64-bit words of visibility samples along a segment."""
ALL_SHOWN = np.zeros((0, 0), np.uint64)
APART = (float(STEEPEST) + 1) / 2
"""Lateral distance in the light's view, in strand widths, within which a strand does not shade itself: the greatest
distance of its visible surface from its axis, plus half the width of a band."""


@dataclass(frozen=True)
class Grid(VertexShadows):
    """Strands as one light sees them, sorted into cells."""

    lists: OccluderLists
    words: int
    """64-bit words of visibility samples along a segment."""
    thickness: Thickness
    together: int = 1
    """Least number of lines across a strand that share one computed shadow, of `column_light.LINES`."""

    @property
    def nbytes(self) -> int:
        """Bytes of the lists."""
        return self.lists.begin.nbytes + self.lists.keys.nbytes + self.lists.rows.nbytes

    def visibility_across(
        self, lines: Polylines, marks: NDArray[np.uint8], screen: NDArray[np.float32], out: NDArray[np.float32],
        eye: View, slots: NDArray[np.int32], shown: NDArray[np.uint64] | None, shades: NDArray[np.uint64],
    ) -> None:  # fmt: skip
        """Compute visibility along and across strands: `visibility` with all its optional arguments."""
        self.visibility(lines, marks, screen, out, eye, slots, shown, shades)

    def visibility(
        self, lines: Polylines, marks: NDArray[np.uint8], screen: NDArray[np.float32], out: NDArray[np.float32],
        eye: View | None = None, slots: NDArray[np.int32] | None = None,
        shown: NDArray[np.uint64] | None = None, shades: NDArray[np.uint64] | None = None,
    ) -> None:  # fmt: skip
        """Write the visibility of the light, 0 to 1, at the marked vertices of the grid's polylines to out (V,).

        ``screen`` (V, 3): the vertices as a camera sees them. ``slots`` (V,): vertices whose shadows across the strand
        are written to ``shades`` (n, LINES), for the camera ``eye`` and the places in ``shown``: see
        `kernels.traced.WideStrands`."""
        longest = int(np.diff(lines.first).max(initial=1))
        width = np.float32(self.thickness.width)
        taper, along = lines.tapered(self.thickness.taper)
        shaded = kernel.ShadedLines(
            lines.first, lines.world, NOT_ALONG if along is None else along, lines.scale, marks, screen,
            lines.stride, longest, self.words,
            np.float32(APART * self.thickness.width),
        )  # fmt: skip
        wide = kernel.WideStrands(
            None if eye is None else eye.pack(), width, taper, slots,
            ALL_SHOWN if shown is None else shown, shades, self.together,
        )  # fmt: skip
        kernel.visibility(shaded, self.lists, wide, out)


def grid_of(
    light: Light, lines: Polylines, thickness: Thickness, opacity: float, bounds: NDArray[np.float64], workers: int,
    scratch: Scratch, number: int = 0, room: int = GRID_BYTES, left_out: NDArray[np.uint8] | None = None,
) -> Grid:  # fmt: skip
    """Build a light's grid of all strands, which lie in the box ``bounds`` (2, 3), metres.

    ``number``: index of the light among those with a grid; ``room``: greatest size of the lists, bytes;
    ``left_out`` (V,): non-zero at vertices whose segments are not listed."""
    piece = max(_mean_piece(lines), 1e-6 * ball(bounds)[1])
    margin = piece + thickness.width
    wider = np.stack([bounds[0] - margin, bounds[1] + margin])
    fine = light_views(light, GRID_SIDE, wider)
    texel = max(texel_of(view, wider) for view in fine)
    cell = _cell(lines, light_views(light, COARSE, wider), GRID_SIDE / COARSE * texel, piece)
    size = int(np.clip(GRID_SIDE * texel / max(cell, thickness.width), 8, GRID_SIDE))
    while True:
        views = light_views(light, size, wider)
        sides = [_bands_of(lines, view, thickness, scratch) for view in views]
        if left_out is not None:
            for bands in sides:
                bands[left_out != 0, 2] = 0  # as what is behind the light
        begin = np.zeros(len(views) * size * size + 1, np.int64)
        for side, bands in enumerate(sides):
            here = slice(1 + side * size * size, 1 + (side + 1) * size * size)
            _list(lines, bands, views[side], workers, scratch, begin[here], None)
        np.cumsum(begin, out=begin)
        if LISTED * int(begin[-1]) <= room or size <= 8:
            break
        size = max(size // 2, 8)
    keys = scratch.borrow(f"grid_keys_{number}", int(begin[-1]), np.int64)
    rows = scratch.borrow(f"grid_rows_{number}", cells.ROWS * int(begin[-1]), np.float32)
    for side, bands in enumerate(sides):
        ends = begin[side * size * size : (side + 1) * size * size + 1]
        _list(lines, bands, views[side], workers, scratch, ends[:-1].copy(), keys)
        table = scratch.borrow("equations", (len(bands), cells.ROWS), np.float32)
        focal = np.float32(views[side].focal if views[side].perspective else 0.0)
        cells.equations(lines.first, bands, focal, np.float32(size / 2), table)
        cells.order(ends, size, table, keys, rows)
    words = math.ceil(PLACES * piece / max(thickness.width, 1e-9 * piece) / interval_bits.WORD)
    lists = OccluderLists(
        np.stack([view.pack() for view in views]), np.full(len(views), size, np.int64),
        size * size * np.arange(len(views), dtype=np.int64), begin, keys, rows,
        round(opacity * int(interval_bits.OPACITY_STEPS)), np.float32(light.shadow.bias),
    )  # fmt: skip
    return Grid(lists, min(words, WORDS), thickness)


def _mean_piece(lines: Polylines) -> float:
    """Return the mean segment length of the first `SOME` strands, metres."""
    first = lines.first[: SOME + 1]
    steps = np.diff(lines.world[: int(first[-1])], axis=0)
    last = first[1:-1] - 1
    steps[last[(last >= 0) & (last < len(steps))]] = 0  # strands that fade may have no vertices at all
    total = float(np.sqrt((steps**2).sum(1)).sum(dtype=np.float64))
    return total / max(int(first[-1]) - int(np.count_nonzero(np.diff(first))), 1)


def _cell(lines: Polylines, views: list[View], texel: float, piece: float) -> float:
    """Return the side, metres, of cells that about `LIST` segments overlap.

    Of segments of length l that begin uniformly over an area, those that begin in an area of c (c + 4 l / π) overlap a
    cell of side c. ``views``: `COARSE` cells a side, each ``texel`` metres wide; ``piece``: l, metres."""
    points = lines.world[:: max(len(lines.world) // MANY, 1)].astype(np.float64)
    covered = 0
    for view in views:
        away = points - view.eye
        depth = away @ view.forward
        away, depth = away[depth > view.near], depth[depth > view.near]
        scale = view.focal / depth if view.perspective else view.focal
        x, y = (np.clip(COARSE / 2 + scale * (away @ axis), 0, COARSE - 1) for axis in (view.right, view.up))
        covered += int(np.count_nonzero(np.bincount(y.astype(np.int64) * COARSE + x.astype(np.int64))))
    area = LIST * max(covered, 1) * texel**2 / max(lines.segments, 1)
    reach = 4 / math.pi * piece
    return (math.sqrt(reach**2 + 4 * area) - reach) / 2


def _bands_of(lines: Polylines, view: View, thickness: Thickness, scratch: Scratch) -> NDArray[np.float32]:
    """Return bands (V, 4), as in `kernels.grid.list_bands`."""
    screen = to_screen(lines, view, scratch, "light_screen")
    packed, width = view.pack(), np.float32(thickness.width)
    taper, along = lines.tapered(thickness.taper)
    silhouette.move_ends(lines.first, lines.world, packed, width, taper, lines.scale, lines.lost, screen)
    widths = scratch.borrow("light_widths", len(screen), np.float32)
    project.widths(
        lines.first, screen, packed, width, taper, lines.scale, np.float32(0.0), np.float32(0.0), along, widths
    )  # fmt: skip
    out = np.empty((len(screen), 4), np.float32)
    out[:, :3] = screen
    np.multiply(widths, np.float32(0.5), out=out[:, 3])
    return out


def _list(
    lines: Polylines, bands: NDArray[np.float32], view: View, workers: int, scratch: Scratch, at: NDArray[np.int64],
    keys: NDArray[np.int64] | None,
) -> None:  # fmt: skip
    size, stretch = int(view.width), view.pack()[CORNER_STRETCH]
    margin = float(stretch * bands[:, 3].max(initial=0.0, where=bands[:, 2] > 0)) + 1.0
    rows = sort_into_bands(lines.first, bands, size, margin, workers, scratch)
    cells.list_bands(lines.first, bands, stretch, rows.members, rows.begin, size, rows.rows, workers, at, keys)
