"""The resolver `sorted`: strands as fragments with their coverage of each pixel, sorted by depth.

A picture is resolved in layers, each a range of rows, as few as keep the fragments within `FRAGMENTS`. For each layer,
segments of strands are binned into tiles, and the fragments of each tile are found and sorted; then light is computed
at visible vertices; then the fragments are blended with the picture.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...constants import FRAGMENT_BYTES, FRAGMENTS, LAYER_ROOM, PART_BYTES, SORTED_BYTES
from ...errors import RefusedError
from ..common.kernels.view_columns import FLAT, DepthSlope
from ..common.scratch import Scratch
from ..geometry.curves import Polylines
from ..geometry.extent import extents_on_screen
from ..geometry.kernels.ribbon import ScreenLines
from ..solids.edges import Edges
from .kernels import resolve, tile_binning
from .kernels.fragments import SolidPixels
from .kernels.tile_binning import TileSegments
from .kernels.tiles import BLOCK, MOST, PIXELS, SAFE, SPAN, STEP, TILE_HEIGHT, TILE_WIDTH, Fragments, PictureWindows
from .kernels.width_profiles import Profiles, add_to_fragments

Rows = tuple[int, int]
"""The first row of a part of a picture, and its end."""
NO_WINDOWS = PictureWindows(np.zeros(0, np.float32), 0, 0)


@dataclass(frozen=True)
class Picture:
    """Input that all layers of a picture share."""

    lines: ScreenLines
    extents: NDArray[np.float32]
    """(S, `COLUMNS`) from `geometry.extent.extents_on_screen`."""
    stride: int
    """Every stride-th vertex is lit."""
    edges: Edges | None
    """Edges of the solids."""
    windows: PictureWindows
    depth_slope: DepthSlope
    closed: NDArray[np.uint8]
    """As in `tiles.Fragments`."""
    scratch: Scratch


def windows_of(edges: Edges | None, size: tuple[int, int]) -> PictureWindows:
    """Return the windows of a picture, behind which its solids hide strands; size: of the picture, samples."""
    least_of = functools.partial(functools.reduce, np.minimum)
    across, down = (-(-samples // BLOCK) for samples in size)
    if edges is None or across * down >= MOST:
        return NO_WINDOWS
    padded = np.full((down * BLOCK, across * BLOCK), np.inf, np.float32)
    padded[: size[1], : size[0]] = edges.hides.reshape(size[::-1])
    blocks = np.full((down + SPAN - 1, across + SPAN - 1), np.inf, np.float32)
    rows = least_of([padded[j::BLOCK] for j in range(BLOCK)])
    blocks[:down, :across] = least_of([rows[:, i::BLOCK] for i in range(BLOCK)])
    rows = least_of([blocks[j : j + down] for j in range(SPAN)])
    least = least_of([rows[:, i : i + across] for i in range(SPAN)]) * SAFE
    return PictureWindows(np.append(least, np.float32(0)), across, down)


TASKS_A_WORKER = 16
UNSURE = 1.2
"""Times what is estimated: a layer for which there is no room has to be drawn again, in parts."""
NO_LIGHT = np.zeros((0, 3), np.float32)
NOTHING = np.zeros(0, np.float32)
NO_SOLIDS = SolidPixels(NOTHING, np.zeros(0, np.int64), NOTHING, NOTHING)
AT_ONCE = 1 << 18
"""Segments that are counted at once."""
SLIGHT = np.float32(0.05)
"""What is let through by all before a fragment, below which it takes light from every second lit vertex alone, and not
from both about it. All such fragments have no more than this share of a pixel, however thin strands are: a bound of
their own weights would hold for all of thin ones."""
RISE = np.float32(1.5)
"""Rows across that a cell of a strand of no width touches, on average over all slopes, about: one more where it crosses
a border of rows, half the time."""


@dataclass(frozen=True)
class Layer:
    """The sorted fragments in some rows of a picture, without their light."""

    fragments: Fragments
    light: NDArray[np.float32]
    """(E, 3) radiance of solids at their edges."""
    tasks: int
    """Tasks among which the tiles are divided."""
    marks: NDArray[np.uint8]
    """(V,) not 0 at the vertices where light has to be computed for this layer."""

    def blend(self, colours: NDArray[np.float32], image: NDArray[np.float32]) -> None:
        """Blend the fragments with the picture (height, width, 3); colours (V, 3): radiance of all vertices marked so
        far."""
        resolve.blend(self.fragments, colours, self.light, self.tasks, image)

    def add_departures(self, profiles: Profiles, image: NDArray[np.float32]) -> None:
        """Add the departures of wide strands' light from the average over their width to the picture."""
        add_to_fragments(self.fragments, profiles, image)


class Coverage:
    """Resolves frame after frame; the number of fragments of one frame predicts the layers of the next."""

    def __init__(self, size: tuple[int, int], opacity: float, room: int = FRAGMENTS) -> None:
        """``size``: of the picture, samples; ``opacity``: of the material; ``room``: greatest number of fragments in
        memory."""
        self.size = size
        self.opacity = np.float32(opacity)
        self.room = room
        self.rows: NDArray[np.floating[Any]] = np.zeros(size[1])
        """Number of fragments in each row of the last frame, or about how many there will be in the first."""
        self.fragments = 0
        """Number of fragments in the last frame."""
        self._tasks = TASKS_A_WORKER
        """Tasks a worker: fewer for crowded strands, because each task has an equal share of the room."""
        self.peak_bytes = 0
        """Bytes of the fragments of the last frame's fullest layer, and of the rows of segments that they come from."""

    def empty_layer(self, lines: ScreenLines, depth_slope: DepthSlope = FLAT) -> Layer:
        """Return a resolved layer of one tile without fragments, so that the kernels that use layers are compiled."""
        fragments = Fragments(
            np.zeros(1, np.int64), np.zeros(PIXELS, np.uint32), np.zeros(0, np.uint32), NOTHING, NOTHING,
            np.zeros(1, np.uint8), 1, STEP, 0, 1, 1, NOTHING, SLIGHT,
        )  # fmt: skip
        chains, none = np.zeros((1, 1), np.int64), np.zeros((0, 2), np.int64)
        segments = TileSegments(none, np.zeros(1, np.float32), none[:, 0].copy(), chains, chains, np.zeros(1, np.int64))
        marks, found = np.zeros(len(lines.screen), np.uint8), np.zeros(1, np.int64)
        resolve.resolve(lines, self.opacity, depth_slope, NO_SOLIDS, segments, 1, fragments, found, marks)
        return Layer(fragments, NO_LIGHT, 1, marks)

    def layers(
        self,
        lines: Polylines,
        screen: NDArray[np.float32],
        widths: NDArray[np.float32] | None,
        edges: Edges | None,
        workers: int,
        scratch: Scratch,
        depth_slope: DepthSlope = FLAT,
        rows: Rows | None = None,
    ) -> Iterator[Layer]:
        """Yield the layers of a picture from top to bottom; each is valid until the next is requested.

        screen (V, 3), widths (V,), or None for lines one sample wide: as in `ScreenLines`; edges: of the solids, if
        there are any; depth_slope: of the view, for the depth of wide strands, which are round; rows: that are drawn,
        None: all.

        Raises `RefusedError` if one row of pixels has more fragments than there is room for.
        """
        first, last = rows or (0, self.size[1])
        if first == 0:
            self.fragments = self.peak_bytes = 0
        marks = scratch.borrow("marks", len(screen), np.uint8)
        lit = None
        drawn = ScreenLines(lines.first, screen, widths)
        extents = extents_on_screen(lines.first, screen, widths, self.size[0], scratch)
        closed = scratch.borrow("closed", self.size[0] * self.size[1], np.uint8)
        closed.fill(0)
        windows = windows_of(edges, self.size)
        picture = Picture(drawn, extents, lines.stride, edges, windows, depth_slope, closed, scratch)
        if not self.rows.any():
            self.rows = self.estimate(drawn)
        pending = self._cuts(first, last)[::-1]
        while pending:
            top, bottom = pending.pop()
            marks.fill(0)
            layer, found = self._layer(picture, top, bottom, workers, marks)
            if layer is None:
                pending += self._finer(top, bottom, found)[::-1]
                continue
            if lit is not None:
                np.greater(marks, lit, out=marks.view(bool))
                lit |= marks
            elif bottom < last:
                lit = marks.copy()
            self.fragments += found
            yield layer

    def estimate(self, lines: ScreenLines) -> NDArray[np.float64]:
        """Return about how many fragments each row of the picture will have: those of a segment in the row in which it
        begins."""
        size, count = np.array(self.size, np.float32), len(lines.screen)
        total = np.zeros(self.size[1])
        for at in range(0, count - 1, AT_ONCE):
            screen = lines.screen[at : at + AT_ONCE + 1]
            places = np.clip(screen[:, :2], 0, size)
            begin, end = places[:-1], places[1:]
            beside = ((begin == end) & ((end == 0) | (end == size))).any(1)
            none = beside | (screen[:-1, 2] <= 0) | (screen[1:, 2] <= 0)
            low, high = np.searchsorted(lines.first, (at + 1, at + len(none) + 1))
            none[lines.first[low:high] - 1 - at] = True  # a strand's last vertex is no beginning
            cells = np.abs(end - begin).max(1)
            wide = np.float32(1) if lines.widths is None else lines.widths[at : at + len(begin)]
            # a ribbon has fragments of its own wherever it touches a pixel
            cells = np.where(wide > 1, (cells + 1) * (wide + 1), cells * (wide + RISE))
            cells[none] = 0
            rows = np.minimum(begin[:, 1], size[1] - 1).astype(np.int64)
            total += np.bincount(rows, cells, self.size[1])
        return UNSURE * total

    def _finer(self, top: int, bottom: int, found: int) -> list[Rows]:
        """Divide rows with too many fragments into ranges for which there is room.

        Raises `RefusedError` for a single row."""
        if bottom - top == 1:
            raise RefusedError(
                f"row {top} of the picture holds about {found:,} fragments of strands, and there is room for "
                f"{self.room:,} ({self.room * FRAGMENT_BYTES / 1e6:,.0f} MB): use fewer --strands, a smaller "
                "material.width, or image.resolver: zbuffer"
            )
        pieces = min(max(math.ceil(1.3 * found / self.room), 2), bottom - top)
        return list(pairwise(top + (bottom - top) * i // pieces for i in range(pieces + 1)))

    def _cuts(self, first: int, last: int) -> list[Rows]:
        """Divide rows into ranges for which there is room, by the last frame's fragments."""
        share = np.cumsum(self.rows[first:last]) * LAYER_ROOM / self.room
        cuts = [first, *(np.flatnonzero(np.diff(share.astype(np.int64))) + first + 1).tolist(), last]
        return list(pairwise(cuts))

    def _note(self, found: NDArray[np.int64], top: int, bottom: int) -> None:
        """Store the number of fragments in each row, from the numbers (tiles,) in each tile."""
        across = -(-self.size[0] // TILE_WIDTH)
        for i, count in enumerate(found.reshape(-1, across).sum(1)):
            here = slice(top + i * TILE_HEIGHT, min(top + (i + 1) * TILE_HEIGHT, bottom))
            self.rows[here] = count / (here.stop - here.start)

    def _layer(
        self, picture: Picture, top: int, bottom: int, workers: int, marks: NDArray[np.uint8]
    ) -> tuple[Layer | None, int]:
        """Return the layer of the rows top <= y < bottom, or None if there is no room, and about how many fragments it
        has."""
        blocks = self.room // tile_binning.BLOCK + 1
        # a single row gets all the room, with one worker
        workers = 1 if bottom - top == 1 else min(workers, max(blocks // 4, 1))
        segments = self._bins(picture, top, bottom, workers, blocks)
        used = segments.used
        if used.max() >= blocks // workers:
            return None, max(int(used.sum()), int(used.max()) * workers) * tile_binning.BLOCK
        # tasks with few fragments leave room unused; pages that are never touched take no memory
        tasks = 1 if workers == 1 else self._tasks * workers
        fragments = self._fragments(picture, top, bottom, self.room if workers == 1 else 2 * self.room)
        found = picture.scratch.borrow("found", len(fragments.begin), np.int64)
        edges = picture.edges
        solids = SolidPixels(edges.hides, edges.pixels, edges.depth, edges.cover) if edges is not None else NO_SOLIDS
        resolve.resolve(
            picture.lines, self.opacity, picture.depth_slope, solids, segments, tasks, fragments, found, marks
        )
        total = int(np.abs(found).sum())
        if found.min() < 0:
            if tasks > workers and total < self.room:  # there is room, but not in equal shares
                self._tasks = max(self._tasks // 4, 1)
                marks.fill(0)
                return self._layer(picture, top, bottom, workers, marks)
            return None, total
        self._note(found, top, bottom)
        self.peak_bytes = max(self.peak_bytes, total * SORTED_BYTES + int(used.sum()) * tile_binning.BLOCK * PART_BYTES)
        light = NO_LIGHT if edges is None else edges.light
        return Layer(fragments, light, TASKS_A_WORKER * workers, marks), total

    def _bins(self, picture: Picture, top: int, bottom: int, workers: int, blocks: int) -> TileSegments:
        """Return lists of the segments in each tile of the rows top <= y < bottom; blocks: of the pool."""
        tiles, borrow = self._tiles(top, bottom), picture.scratch.borrow
        segments = TileSegments(
            borrow("tile_segments", (blocks * tile_binning.BLOCK, 2), np.int64),
            borrow("tile_depths", blocks * tile_binning.BLOCK, np.float32), borrow("links", blocks, np.int64),
            borrow("heads", (workers, tiles), np.int64), borrow("fills", (workers, tiles), np.int64),
            np.zeros(workers, np.int64),
        )  # fmt: skip
        segments.fills.fill(0)
        tile_binning.bin_segments(
            picture.lines, picture.extents, top, bottom, self.size[0], workers, segments, picture.windows,
            picture.depth_slope,
        )  # fmt: skip
        return segments

    def _fragments(self, picture: Picture, top: int, bottom: int, room: int) -> Fragments:
        """Return arrays for so many fragments in the rows top <= y < bottom, not yet filled."""
        tiles, borrow, sparse = self._tiles(top, bottom), picture.scratch.borrow, picture.scratch.sparse
        place_bits = STEP - (picture.stride.bit_length() - 1)
        return Fragments(
            borrow("tiles_begin", tiles, np.int64), borrow("fragment_counts", tiles * PIXELS, np.uint32),
            sparse("fragment_vertices", room, np.uint32), sparse("fragment_weights", room, np.float32),
            sparse("fragment_along", room, np.float32), picture.closed, picture.stride, place_bits, top, bottom,
            self.size[0], borrow("tiles_widest", tiles, np.float32), SLIGHT,
        )  # fmt: skip

    def _tiles(self, top: int, bottom: int) -> int:
        """Return the number of tiles in the rows top <= y < bottom."""
        return -(-self.size[0] // TILE_WIDTH) * -(-(bottom - top) // TILE_HEIGHT)
