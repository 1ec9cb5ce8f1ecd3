"""What strands cover of each pixel, and in which order: the resolvers `sorted` and `kbuffer`.

A picture goes through in bands of rows, as few as keep the fragments within `FRAGMENTS`. Each band is a `Layer`: parts
of strands are shared out to tiles, and the fragments of each tile found and sorted; then the light is computed where
they can be seen; then they are laid over the picture. `kbuffer` goes the same way and keeps the nearest fragments of a
pixel alone, so that fewer places are lit and laid over the picture: the last one kept has the opacity of all behind it
too.
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
from ..solids.edges import Edges
from ..view.camera import FLAT, Nearer
from .kernels import resolve, tile_binning
from .kernels.column_light import BYTES, LINES
from .kernels.composite import MASKED
from .kernels.exposed import expose
from .kernels.tiles import PIXELS, PLACES, TILE_HEIGHT, TILE_WIDTH
from .kernels.width_profiles import over_fragments
from .masks import sides
from .width_profiles import Body

TASKS_A_WORKER = 16
NONE = np.zeros((0, 3), np.float32)
NOTHING = np.zeros(0, np.float32)
NOWHERE = np.zeros(0, np.int64)
NO_BITS = np.zeros(0, np.uint64)
LAST = 1 << 40
"""A fragment that no pixel has."""
BROAD = 16.0
"""Samples. No picture has been seen that takes minutes with strands that are no wider than that."""
PLACES_AT_MOST = 4e9
"""Pixels that wide pieces may be held against: some ten seconds of a core."""


@dataclass(frozen=True)
class Layer:
    """The strands in the rows top <= y < bottom of a picture, without their light, as `kernels.resolve` leaves them."""

    begin: NDArray[np.int64]
    kept: NDArray[np.uint32]
    place: NDArray[np.uint32]
    weight: NDArray[np.float32]
    along: NDArray[np.float32]
    seen: NDArray[np.uint64] | None
    """(F,) points of its sample that each fragment shows, where that is asked for."""
    light: NDArray[np.float32]
    """(E, 3) radiance of solids at their edges."""
    top: int
    bottom: int
    width: int
    stride: int
    tasks: int
    marks: NDArray[np.uint8]
    """(V,) not zero at the vertices that the light has to be known at and is not yet."""

    def compose(self, colours: NDArray[np.float32], image: NDArray[np.float32]) -> None:
        """Lay it over the picture (height, width, 3), with the radiance (V, 3) of all vertices marked so far."""
        resolve.compose(
            self.begin, self.kept, self.place, self.weight, self.along, self.stride, colours, self.light, self.top,
            self.bottom, self.tasks, image,
        )  # fmt: skip

    def shown(self, body: Body, scratch: Scratch) -> NDArray[np.uint64]:
        """(n, LINES): which places it shows of the pieces after the vertices that have a profile (see
        `kernels.traced.visibility`)."""
        bytes_ = scratch.take("shown", (body.profile.shape[1], LINES, BYTES), np.uint8)
        bytes_.fill(0)
        expose(
            self.begin, self.kept, self.place, self.along, *self._bits(),
            body.screen, body.widths, body.slots, self.top, self.width, bytes_,
        )  # fmt: skip
        return bytes_.view(np.uint64)[..., 0]

    def _bits(self) -> tuple[NDArray[np.uint64], NDArray[np.uint64]]:
        """Which points of its sample each fragment shows, and the table that tells; without points, all of them."""
        return (NO_BITS, NO_BITS) if self.seen is None else (self.seen, sides())

    def round_off(self, body: Body, image: NDArray[np.float32]) -> None:
        """Add how the light of wide strands departs from its average over their width."""
        over_fragments(
            self.begin, self.kept, self.place, self.weight, self.along, *self._bits(), self.stride, body.screen,
            body.widths, body.samples, body.start, body.full, body.slots, body.profile, body.shades, self.top, image,
        )  # fmt: skip


class Coverage:
    """Resolves frame after frame; expects the next one to hold about as many fragments as the last."""

    def __init__(self, size: tuple[int, int], opacity: float, nearest: int | None, room: int = FRAGMENTS) -> None:
        """``size`` in samples; ``opacity`` of the material; ``nearest``: greatest number of fragments a pixel keeps, or
        None for all of them; ``room``: fragments that memory has room for."""
        self.size = size
        self.opacity = np.float32(opacity)
        self.nearest = nearest
        self.room = room
        self._rows = np.zeros(size[1])
        """Fragments in each row of the last frame."""
        self.fragments = 0
        """In the last frame."""
        self._tasks = TASKS_A_WORKER
        """For each worker: fewer where strands crowd, for each task has an equal share of the room."""
        self.most = 0
        """Bytes that the fragments of its fullest layer took, with the parts of strands that they come from."""

    def nothing(self) -> Layer:
        """A layer of one row without a fragment."""
        return Layer(np.zeros(1, np.int64), np.zeros(PIXELS, np.uint32), np.zeros(0, np.uint32), NOTHING, NOTHING,
                     None, NONE, 0, 1, 1, 1, 1, np.zeros(1, np.uint8))  # fmt: skip

    def layers(
        self,
        lines: Polylines,
        screen: NDArray[np.float32],
        widths: NDArray[np.float32] | None,
        edges: Edges | None,
        workers: int,
        scratch: Scratch,
        exact: bool = False,
        nearer: Nearer = FLAT,
    ) -> Iterator[Layer]:
        """The picture's layers from top to bottom, each to be used before the next is asked for.

        screen (V, 3); widths (V,) pixels, or None for lines one pixel wide; edges: of the solids, where there are any;
        exact: whether light is wanted in each layer at all that it shows, and of wide opaque strands the points of a
        sample that each shows (see `kernels.masks`); nearer: of the view, for the depth of wide
        strands, which are round.
        Raises `RefusedError` where one row of pixels holds more fragments than there is room for, or strands are so
        wide that to see which pixels they cover would take minutes.
        """
        self.fragments = self.most = 0
        marks = scratch.take("marks", len(screen), np.uint8)
        lit = None
        widest = 1.0 if widths is None or not len(widths) else float(widths.max())
        if widths is not None and widest > BROAD:
            self._require_time(lines, screen, widths, widest)
        # what lets light through hides no point, and a k-buffer's last fragment stands for several
        wide = exact and widths is not None and widest > float(MASKED)
        masked = wide and self.nearest is None and float(self.opacity) == 1.0
        margin = 2.0 + widest  # a mitre reaches out by the square root of two
        rows = scratch.take("rows", (len(lines.first) - 1, 2), np.float32)
        tile_binning.spans(lines.first, screen, np.float32(margin), self.size[0], rows)
        ahead = self._cuts()[::-1]
        while ahead:
            top, bottom = ahead.pop()
            marks.fill(0)
            layer, found = self._layer(
                lines, screen, widths, rows, edges, top, bottom, workers, scratch, marks, nearer, masked
            )
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

    def _require_time(
        self, lines: Polylines, screen: NDArray[np.float32], widths: NDArray[np.float32], widest: float
    ) -> None:
        """Refuse what would take minutes: many strands that each cover much of the picture."""
        toil = np.empty(len(lines.first) - 1, np.float32)
        tile_binning.toil(lines.first, screen, widths, *self.size, toil)
        places = float(toil.sum(dtype=np.float64))
        if places > PLACES_AT_MOST:
            raise RefusedError(
                f"material.width: strands are up to {widest:,.0f} samples wide in the picture, and their pieces cover "
                f"about {places:.1e} pixels one by one, more than {PLACES_AT_MOST:.0e}: use a smaller material.width, "
                "or fewer --strands"
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
        self,
        lines: Polylines,
        screen: NDArray[np.float32],
        widths: NDArray[np.float32] | None,
        rows: NDArray[np.float32],
        edges: Edges | None,
        top: int,
        bottom: int,
        workers: int,
        scratch: Scratch,
        marks: NDArray[np.uint8],
        nearer: Nearer,
        masked: bool,
    ) -> tuple[Layer | None, int]:
        """The rows top <= y < bottom, or None where they hold too much, and about how many fragments they hold."""
        blocks = self.room // tile_binning.BLOCK + 1
        # where it is one row that has to fit, one worker has all the room
        workers = 1 if bottom - top == 1 else min(workers, max(blocks // 4, 1))
        tiles = -(-self.size[0] // TILE_WIDTH) * -(-(bottom - top) // TILE_HEIGHT)
        pool = scratch.take("parts", (blocks * tile_binning.BLOCK, 2), np.int64)
        links = scratch.take("links", blocks, np.int64)
        heads = scratch.take("heads", (workers, tiles), np.int64)
        fills = scratch.take("fills", (workers, tiles), np.int64)
        used = np.zeros(workers, np.int64)
        fills.fill(0)
        tile_binning.share_out(
            lines.first, screen, widths, rows, top, bottom, self.size[0], workers, pool, links, heads, fills, used
        )
        if used.max() >= blocks // workers:
            return None, max(int(used.sum()), int(used.max()) * workers) * tile_binning.BLOCK
        # tasks that come to less than others leave room unused, which is never touched
        tasks = 1 if workers == 1 else self._tasks * workers
        room = self.room if workers == 1 else 2 * self.room
        begin = scratch.take("tiles_begin", tiles, np.int64)
        kept = scratch.take("kept", tiles * PIXELS, np.uint32)
        found = scratch.take("found", tiles, np.int64)
        place = scratch.take("fragment_places", room, np.uint32)
        weight = scratch.take("fragment_weights", room, np.float32)
        along = scratch.take("fragment_along", room, np.float32)
        table = sides() if masked else None
        seen = scratch.take("fragment_points", room, np.uint64) if masked else None
        hides, pixels, depth, cover = NOTHING, NOWHERE, NOTHING, NOTHING
        if edges is not None:
            hides, pixels, depth, cover = edges.hides, edges.pixels, edges.depth, edges.cover
        resolve.resolve(
            lines.first, screen, widths, self.opacity, nearer, lines.stride, _bits(lines), hides, pixels, depth,
            cover, pool, links, heads, fills, self.nearest or LAST, table, top, bottom, self.size[0], tasks,
            begin, kept, found, place, weight, along, seen, marks,
        )  # fmt: skip
        held = int(np.abs(found).sum())
        if found.min() < 0:
            if tasks > workers and held < self.room:  # there is room, but not for each alike
                self._tasks = max(self._tasks // 4, 1)
                marks.fill(0)
                return self._layer(
                    lines, screen, widths, rows, edges, top, bottom, workers, scratch, marks, nearer, masked
                )
            return None, held
        marks[lines.stride :] |= marks[: -lines.stride]  # light comes from the lit vertex after a fragment as well
        self._note(found, top, bottom)
        each = SORTED_BYTES + (POINTS_BYTES if masked else 0)
        self.most = max(self.most, held * each + int(used.sum()) * tile_binning.BLOCK * PART_BYTES)
        light = NONE if edges is None else edges.light
        return Layer(
            begin, kept, place, weight, along, seen, light, top, bottom, self.size[0], lines.stride,
            TASKS_A_WORKER * workers, marks,
        ), held  # fmt: skip


def _bits(lines: Polylines) -> int:
    """Bits that tell the place along a piece, of those that tell it from a lit vertex to the next."""
    return PLACES - (lines.stride.bit_length() - 1)
