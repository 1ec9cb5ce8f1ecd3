"""What strands cover of each pixel, and in which order: the resolvers `sorted` and `kbuffer`.

A picture goes through in bands of rows, as few as keep the fragments within `FRAGMENTS`. Each band is a `Layer`: its
fragments are gathered and sorted; then the light is computed where they can be seen; then they are laid over the
picture.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..constants import FRAGMENT_BYTES, FRAGMENTS
from ..errors import RefusedError
from .body import Body
from .curves import Polylines
from .kernels import raster as bands
from .kernels import resolve as kernel
from .kernels.body import over_fragments
from .scratch import Scratch

BANDS_A_WORKER = 8
TASKS_A_WORKER = 16


@dataclass(frozen=True)
class Lists:
    """The fragments of some rows, listed pixel by pixel, as `kernels.resolve` describes them."""

    counts: NDArray[np.uint32]
    ends: NDArray[np.uint32]
    keys: NDArray[np.uint64]
    stream: NDArray[np.uint32]
    held: int
    """Fragments in the lists."""


@dataclass(frozen=True)
class Layer:
    """The strands in some rows of a picture, from ``top`` on, without their light."""

    lists: Lists
    kept: NDArray[np.uint32]
    top: int
    stride: int
    marks: NDArray[np.uint8]
    """(V,) not zero at the vertices that the light has to be known at and is not yet."""

    def compose(self, colours: NDArray[np.float32], image: NDArray[np.float32]) -> None:
        """Lay it over the picture (height, width, 3), with the radiance (V, 3) of all vertices marked so far."""
        lists = self.lists
        kernel.compose(
            lists.counts, lists.ends, lists.keys, lists.stream, self.kept, self.stride, colours, self.top, image
        )

    def round_off(self, body: Body, image: NDArray[np.float32]) -> None:
        """Add how the light of wide strands departs from its average over their width."""
        lists = self.lists
        over_fragments(
            lists.counts, lists.ends, lists.keys, lists.stream, self.kept, self.stride, body.screen, body.widths,
            body.samples, body.slots, body.profile, self.top, image,
        )  # fmt: skip


class Coverage:
    """Resolves frame after frame; expects the next one to hold about as many fragments as the last."""

    def __init__(self, size: tuple[int, int], opacity: float, nearest: int | None, room: int = FRAGMENTS) -> None:
        """``size`` in samples; ``opacity`` of the material; ``nearest``: greatest number of fragments a pixel holds, or
        None for all of them; ``room``: fragments that memory has room for."""
        self.size = size
        self.opacity = np.float32(opacity)
        self.nearest = nearest
        self.room = room
        self._rows = np.zeros(size[1])
        """Fragments in each row of the last frame."""
        self.fragments = 0
        """In the last frame; with a bound on the fragments of a pixel, those that were held."""
        self.most = 0
        """Bytes that the fragments of its fullest layer took."""

    def nothing(self) -> Layer:
        """A layer of one row without a fragment."""
        none = np.zeros(self.size[0], np.uint32)
        lists = Lists(none, none, np.zeros(1, np.uint64), np.zeros((1, 4), np.uint32), 0)
        return Layer(lists, none, 0, 1, np.zeros(1, np.uint8))

    def layers(
        self,
        lines: Polylines,
        screen: NDArray[np.float32],
        widths: NDArray[np.float32] | None,
        limit: NDArray[np.uint64] | None,
        workers: int,
        scratch: Scratch,
    ) -> Iterator[Layer]:
        """The picture's layers from top to bottom, each to be used before the next is asked for.

        screen (V, 3); widths (V,) pixels, or None for lines one pixel wide; limit (height * width,): z-buffer of the
        solids, or None. Raises `RefusedError` where one row of pixels holds more fragments than there is room for.
        """
        self.fragments = self.most = 0
        marks = scratch.take("marks", len(screen), np.uint8)
        lit = None
        for top, bottom, lists in self._bands(lines, screen, widths, limit, workers, scratch):
            self.fragments += lists.held
            self.most = max(self.most, lists.held * FRAGMENT_BYTES)
            marks.fill(0)
            kept = scratch.take("kept", len(lists.counts), np.uint32)
            kernel.weigh(
                lists.counts, lists.ends, lists.keys, lists.stream, int(lists.counts.max()),
                None if self.nearest is None else 0, lines.per, lines.stride, TASKS_A_WORKER * workers, kept, marks,
            )  # fmt: skip
            if lit is not None:
                np.greater(marks, lit, out=marks.view(bool))
                lit |= marks
            elif bottom < self.size[1]:
                lit = marks.copy()
            yield Layer(lists, kept, top, lines.stride, marks)

    def _bands(
        self,
        lines: Polylines,
        screen: NDArray[np.float32],
        widths: NDArray[np.float32] | None,
        limit: NDArray[np.uint64] | None,
        workers: int,
        scratch: Scratch,
    ) -> Iterator[tuple[int, int, Lists]]:
        """Rows from top to bottom with their lists, cut finer where they hold too much."""
        ahead = self._cuts()[::-1]
        while ahead:
            top, bottom = ahead.pop()
            found = self._lists(lines, screen, widths, limit, top, bottom, workers, scratch)
            if isinstance(found, Lists):
                self._rows[top:bottom] = found.counts.reshape(bottom - top, -1).sum(1)
                yield top, bottom, found
            elif bottom - top > 1:
                parts = min(max(math.ceil(1.3 * found / self.room), 2), bottom - top)
                cuts = [top + (bottom - top) * i // parts for i in range(parts + 1)]
                ahead += list(pairwise(cuts))[::-1]
            else:
                raise RefusedError(
                    f"row {top} of the picture holds {found:,} fragments of strands, and there is room for "
                    f"{self.room:,} ({self.room * FRAGMENT_BYTES / 1e6:,.0f} MB): use fewer --strands, a smaller "
                    "material.width, or image.resolver: zbuffer"
                )

    def _cuts(self) -> list[tuple[int, int]]:
        """Rows from top to bottom that fit in memory as far as the last frame tells."""
        width, height = self.size
        load = self._rows if self.nearest is None else np.full(height, width * self.nearest)
        # a strand's own fragments need some room beside the lists of their pixels, and strands move
        share = np.cumsum(load) * (1.15 if self.nearest is None else 2.0) / self.room
        cuts = [0, *(np.flatnonzero(np.diff(share.astype(np.int64))) + 1).tolist(), height]
        return list(pairwise(cuts))

    def _lists(
        self,
        lines: Polylines,
        screen: NDArray[np.float32],
        widths: NDArray[np.float32] | None,
        limit: NDArray[np.uint64] | None,
        top: int,
        bottom: int,
        workers: int,
        scratch: Scratch,
    ) -> Lists | int:
        """The fragments of the rows top <= y < bottom, or how many there are where that is too many."""
        width = self.size[0]
        pixels = (bottom - top) * width
        k = self.nearest
        held = 0 if k is None else k * pixels
        room = self.room - held
        if room < 2:
            return held + 1
        if bottom - top == 1:
            workers = 1  # which then has all the room
        rows = bottom - top if workers == 1 else max((bottom - top) // (BANDS_A_WORKER * workers), 1)
        begin, members = self._members(lines, screen, widths, top, bottom, rows, scratch)
        counts = scratch.take("counts", pixels, np.uint32)
        ends = scratch.take("ends", pixels, np.uint32)
        keys = scratch.take("fragment_keys", self.room, np.uint64)
        stream = scratch.take("stream", (self.room, 4), np.uint32)
        used = np.zeros(workers, np.int64)
        kernel.collect(
            lines.first, screen, widths, self.opacity, members, begin, top, bottom, width, rows, workers, limit, k,
            counts, ends, keys, scratch.take("stream_pixels", self.room, np.uint32)[:room], stream, used,
        )  # fmt: skip
        if used.max() >= room // workers:
            return max(int(used.sum()), int(used.max()) * workers)
        return Lists(counts, ends, keys, stream, int(used.sum() if k is None else counts.sum(dtype=np.int64)))

    def _members(
        self,
        lines: Polylines,
        screen: NDArray[np.float32],
        widths: NDArray[np.float32] | None,
        top: int,
        bottom: int,
        rows: int,
        scratch: Scratch,
    ) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
        """Strands listed by bands of ``rows`` rows from ``top`` on: where each band's list begins, and the lists."""
        strands = len(lines.first) - 1
        if bottom - top == self.size[1] == rows:
            return np.array([0, strands]), scratch.arange(strands)
        # a mitre reaches out by the square root of two
        margin = 2.0 + (1.0 if widths is None or not len(widths) else float(widths.max()))
        ranges = scratch.take("ranges", (strands, 2), np.int32)
        kernel.reach(lines.first, screen, top, bottom, rows, np.float32(margin), ranges)
        begin = np.zeros(-(-(bottom - top) // rows) + 1, np.int64)
        bands.count(ranges, begin)
        members = scratch.take("members", int(begin[-1]), np.int32)
        bands.scatter(ranges, begin[:-1].copy(), members)
        return begin, members
