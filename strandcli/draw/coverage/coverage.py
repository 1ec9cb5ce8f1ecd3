"""What strands cover of each pixel, and in which order: the resolver `sorted`.

A picture goes through in bands of rows, as few as keep the fragments within `FRAGMENTS`. Each band is a `Layer`:
segments of strands are binned into tiles, and the fragments of each tile found and sorted; then the light is computed
where they can be seen; then they are laid over the picture.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ...constants import FRAGMENT_BYTES, FRAGMENTS, PART_BYTES, POINTS_BYTES, SORTED_BYTES
from ...errors import RefusedError
from ..common.scratch import Scratch
from ..geometry.curves import Polylines
from ..geometry.kernels.screen_lines import ScreenLines
from ..solids.edges import Edges
from ..view.kernels.depth_slope import FLAT, DepthSlope
from .kernels import resolve, strand_extents, tile_binning
from .kernels.column_light import BYTES, LINES
from .kernels.composite import MASKED
from .kernels.exposed import expose
from .kernels.fragments import SolidPixels
from .kernels.tile_binning import TileSegments
from .kernels.tiles import PIXELS, PLACES, TILE_HEIGHT, TILE_WIDTH, Fragments
from .kernels.width_profiles import Profiles, add_to_fragments
from .masks import sides

TASKS_A_WORKER = 16
NO_LIGHT = np.zeros((0, 3), np.float32)
NOTHING = np.zeros(0, np.float32)
NO_BITS = np.zeros(0, np.uint64)
NO_SOLIDS = SolidPixels(NOTHING, np.zeros(0, np.int64), NOTHING, NOTHING)
BROAD = 16.0
"""Samples. No picture has been seen that takes minutes with strands that are no wider than that."""
WIDE_PIXELS_AT_MOST = 4e9
"""Pixels that wide segments may be tested against: some ten seconds of a core."""


@dataclass(frozen=True)
class Layer:
    """The strands in some rows of a picture, without their light."""

    fragments: Fragments
    light: NDArray[np.float32]
    """(E, 3) radiance of solids at their edges."""
    tasks: int
    marks: NDArray[np.uint8]
    """(V,) not zero at the vertices that the light has to be known at and is not yet."""

    def compose(self, colours: NDArray[np.float32], image: NDArray[np.float32]) -> None:
        """Lay it over the picture (height, width, 3), with the radiance (V, 3) of all vertices marked so far."""
        resolve.compose(self.fragments, colours, self.light, self.tasks, image)

    def shown(self, profiles: Profiles, scratch: Scratch) -> NDArray[np.uint64]:
        """(n, LINES): which places it shows of the pieces after the vertices that have a profile (see
        `kernels.traced.visibility`)."""
        bytes_ = scratch.borrow("shown", (profiles.profile.shape[1], LINES, BYTES), np.uint8)
        bytes_.fill(0)
        expose(self.fragments, self._table(), profiles, bytes_)
        return bytes_.view(np.uint64)[..., 0]

    def _table(self) -> NDArray[np.uint64]:
        """What the points of a sample that a fragment shows are read by; anything where it shows all."""
        return sides() if len(self.fragments.seen) else NO_BITS

    def add_departures(self, profiles: Profiles, image: NDArray[np.float32]) -> None:
        """Add how the light of wide strands departs from its average over their width."""
        add_to_fragments(self.fragments, self._table(), profiles, image)


class Coverage:
    """Resolves frame after frame; expects the next one to hold about as many fragments as the last."""

    def __init__(self, size: tuple[int, int], opacity: float, room: int = FRAGMENTS) -> None:
        """``size`` in samples; ``opacity`` of the material; ``room``: fragments that memory has room for."""
        self.size = size
        self.opacity = np.float32(opacity)
        self.room = room
        self._rows = np.zeros(size[1])
        """Fragments in each row of the last frame."""
        self.fragments = 0
        """In the last frame."""
        self._tasks = TASKS_A_WORKER
        """For each worker: fewer where strands crowd, for each task has an equal share of the room."""
        self.most = 0
        """Bytes that the fragments of its fullest layer took, with the rows of segments that they come from."""

    def empty_layer(self, lines: ScreenLines, depth_slope: DepthSlope = FLAT) -> Layer:
        """A layer of one tile without a fragment, resolved, so that all kernels of a layer's end are compiled."""
        fragments = Fragments(
            np.zeros(1, np.int64), np.zeros(PIXELS, np.uint32), np.zeros(0, np.uint32), NOTHING, NOTHING, NO_BITS,
            1, PLACES, 0, 1, 1,
        )  # fmt: skip
        chains, none = np.zeros((1, 1), np.int64), np.zeros((0, 2), np.int64)
        segments = TileSegments(none, none[:, 0].copy(), chains, chains, np.zeros(1, np.int64))
        marks, found = np.zeros(len(lines.screen), np.uint8), np.zeros(1, np.int64)
        resolve.resolve(lines, self.opacity, depth_slope, NO_SOLIDS, segments, None, 1, fragments, found, marks)
        return Layer(fragments, NO_LIGHT, 1, marks)

    def layers(
        self,
        lines: Polylines,
        screen: NDArray[np.float32],
        widths: NDArray[np.float32] | None,
        edges: Edges | None,
        workers: int,
        scratch: Scratch,
        exact: bool = False,
        depth_slope: DepthSlope = FLAT,
    ) -> Iterator[Layer]:
        """The picture's layers from top to bottom, each to be used before the next is asked for.

        screen (V, 3); widths (V,) pixels, or None for lines one pixel wide; edges: of the solids, where there are any;
        exact: whether light is wanted in each layer at all that it shows, and of wide opaque strands the points of a
        sample that each shows (see `kernels.masks`); depth_slope: of the view, for the depth of wide strands, which
        are round.
        Raises `RefusedError` where one row of pixels holds more fragments than there is room for, or strands are so
        wide that to see which pixels they cover would take minutes.
        """
        self.fragments = self.most = 0
        marks = scratch.borrow("marks", len(screen), np.uint8)
        lit = None
        widest = 1.0 if widths is None or not len(widths) else float(widths.max())
        drawn = ScreenLines(lines.first, screen, widths)
        if widths is not None and widest > BROAD:
            self._require_time(drawn, widest)
        # what lets light through hides no point
        masked = exact and widths is not None and widest > float(MASKED) and float(self.opacity) == 1.0
        margin = 2.0 + widest  # a mitre reaches out by the square root of two
        rows = scratch.borrow("rows", (len(lines.first) - 1, 2), np.float32)
        strand_extents.spans(lines.first, screen, np.float32(margin), self.size[0], rows)
        picture = _Picture(drawn, rows, lines.stride, edges, depth_slope, masked, scratch)
        ahead = self._cuts()[::-1]
        while ahead:
            top, bottom = ahead.pop()
            marks.fill(0)
            layer, found = self._layer(picture, top, bottom, workers, marks)
            if layer is None:
                ahead += self._finer(top, bottom, found)[::-1]
                continue
            if exact:
                pass
            elif lit is not None:
                np.greater(marks, lit, out=marks.view(bool))
                lit |= marks
            elif bottom < self.size[1]:
                lit = marks.copy()
            self.fragments += found
            yield layer

    def _require_time(self, lines: ScreenLines, widest: float) -> None:
        """Refuse what would take minutes: many strands that each cover much of the picture."""
        pixels = np.empty(len(lines.first) - 1, np.float32)
        strand_extents.count_wide_pixels(lines, *self.size, pixels)
        total = float(pixels.sum(dtype=np.float64))
        if total > WIDE_PIXELS_AT_MOST:
            raise RefusedError(
                f"material.width: strands are up to {widest:,.0f} samples wide in the picture, and their pieces cover "
                f"about {total:.1e} pixels one by one, more than {WIDE_PIXELS_AT_MOST:.0e}: use a smaller "
                "material.width, or fewer --strands"
            )

    def _finer(self, top: int, bottom: int, found: int) -> list[tuple[int, int]]:
        """Rows that hold too many fragments, cut so that there is room."""
        if bottom - top == 1:
            raise RefusedError(
                f"row {top} of the picture holds about {found:,} fragments of strands, and there is room for "
                f"{self.room:,} ({self.room * FRAGMENT_BYTES / 1e6:,.0f} MB): use fewer --strands, a smaller "
                "material.width, or image.resolver: zbuffer"
            )
        pieces = min(max(math.ceil(1.3 * found / self.room), 2), bottom - top)
        return list(pairwise(top + (bottom - top) * i // pieces for i in range(pieces + 1)))

    def _cuts(self) -> list[tuple[int, int]]:
        """Rows from top to bottom that fit in memory as far as the last frame tells."""
        # strands move, workers do not find the same number, and the last block of a chain is not full
        share = np.cumsum(self._rows) * 1.2 / self.room
        cuts = [0, *(np.flatnonzero(np.diff(share.astype(np.int64))) + 1).tolist(), self.size[1]]
        return list(pairwise(cuts))

    def _note(self, found: NDArray[np.int64], top: int, bottom: int) -> None:
        """Note fragments by rows, from those (tiles,) of tiles."""
        across = -(-self.size[0] // TILE_WIDTH)
        for i, count in enumerate(found.reshape(-1, across).sum(1)):
            here = slice(top + i * TILE_HEIGHT, min(top + (i + 1) * TILE_HEIGHT, bottom))
            self._rows[here] = count / (here.stop - here.start)

    def _layer(
        self, picture: _Picture, top: int, bottom: int, workers: int, marks: NDArray[np.uint8]
    ) -> tuple[Layer | None, int]:
        """The rows top <= y < bottom, or None where they hold too much, and about how many fragments they hold."""
        blocks = self.room // tile_binning.BLOCK + 1
        # where it is one row that has to fit, one worker has all the room
        workers = 1 if bottom - top == 1 else min(workers, max(blocks // 4, 1))
        segments = self._bins(picture, top, bottom, workers, blocks)
        used = segments.used
        if used.max() >= blocks // workers:
            return None, max(int(used.sum()), int(used.max()) * workers) * tile_binning.BLOCK
        # tasks that come to less than others leave room unused, which is never touched
        tasks = 1 if workers == 1 else self._tasks * workers
        fragments = self._fragments(picture, top, bottom, self.room if workers == 1 else 2 * self.room)
        found = picture.scratch.borrow("found", len(fragments.begin), np.int64)
        edges, table = picture.edges, sides() if picture.masked else None
        solids = SolidPixels(edges.hides, edges.pixels, edges.depth, edges.cover) if edges is not None else NO_SOLIDS
        resolve.resolve(
            picture.lines, self.opacity, picture.depth_slope, solids, segments, table, tasks, fragments, found, marks
        )
        held = int(np.abs(found).sum())
        if found.min() < 0:
            if tasks > workers and held < self.room:  # there is room, but not for each alike
                self._tasks = max(self._tasks // 4, 1)
                marks.fill(0)
                return self._layer(picture, top, bottom, workers, marks)
            return None, held
        stride = picture.stride
        marks[stride:] |= marks[:-stride]  # light comes from the lit vertex after a fragment as well
        self._note(found, top, bottom)
        each = SORTED_BYTES + (POINTS_BYTES if picture.masked else 0)
        self.most = max(self.most, held * each + int(used.sum()) * tile_binning.BLOCK * PART_BYTES)
        light = NO_LIGHT if edges is None else edges.light
        return Layer(fragments, light, TASKS_A_WORKER * workers, marks), held

    def _bins(self, picture: _Picture, top: int, bottom: int, workers: int, blocks: int) -> TileSegments:
        """The segments in each tile of the rows top <= y < bottom."""
        tiles, take = self._tiles(top, bottom), picture.scratch.borrow
        segments = TileSegments(
            take("tile_segments", (blocks * tile_binning.BLOCK, 2), np.int64), take("links", blocks, np.int64),
            take("heads", (workers, tiles), np.int64), take("fills", (workers, tiles), np.int64),
            np.zeros(workers, np.int64),
        )  # fmt: skip
        segments.fills.fill(0)
        tile_binning.bin_segments(picture.lines, picture.rows, top, bottom, self.size[0], workers, segments)
        return segments

    def _fragments(self, picture: _Picture, top: int, bottom: int, room: int) -> Fragments:
        """Room for so many fragments in the rows top <= y < bottom; what they hold is anything."""
        tiles, take = self._tiles(top, bottom), picture.scratch.borrow
        # so many of the bits that tell the place from a lit vertex to the next tell the place along a segment
        place_bits = PLACES - (picture.stride.bit_length() - 1)
        return Fragments(
            take("tiles_begin", tiles, np.int64), take("kept", tiles * PIXELS, np.uint32),
            take("fragment_places", room, np.uint32), take("fragment_weights", room, np.float32),
            take("fragment_along", room, np.float32),
            take("fragment_points", room, np.uint64) if picture.masked else NO_BITS,
            picture.stride, place_bits, top, bottom, self.size[0],
        )  # fmt: skip

    def _tiles(self, top: int, bottom: int) -> int:
        """Tiles of the rows top <= y < bottom."""
        return -(-self.size[0] // TILE_WIDTH) * -(-(bottom - top) // TILE_HEIGHT)


@dataclass(frozen=True)
class _Picture:
    """What all layers of a picture are made of."""

    lines: ScreenLines
    rows: NDArray[np.float32]
    """(S, 2) as from `kernels.strand_extents.spans`."""
    stride: int
    """Every so-manieth vertex is lit."""
    edges: Edges | None
    depth_slope: DepthSlope
    masked: bool
    """Whether it is asked which points of a sample each fragment shows."""
    scratch: Scratch
