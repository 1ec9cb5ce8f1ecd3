"""Bands of rows of a picture, each with the strands that come to it, where all at once would take too much memory.

Strands are made, projected and thrown away again: once to learn which rows they come to, and once for each band. What
lies in a band is as it would be in the whole picture.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..constants import BAND_VERTICES, BANDS
from .coverage.coverage import Coverage, Rows
from .geometry.curves import Polylines
from .geometry.extent import extents_on_screen
from .geometry.kernels import bands as kernel
from .geometry.kernels.ribbon import GREATEST_Y, LEAST_Y, ScreenLines
from .strand_batches import StrandBatch, StrandBatches

Columns = dict[str, NDArray[np.float32]]
"""What vertices have, by the names of `Polylines` and `StrandBatch`."""


def bands(
    batches: StrandBatches, coverage: Coverage, lines: Polylines | None
) -> Iterator[tuple[StrandBatch, Rows]]:  # fmt: skip
    """Yield bands of rows of the picture, from top to bottom, each with the strands that come to it, valid until the
    next is requested; a single batch is the only band. lines: as in `StrandBatches.seen`."""
    width, height = coverage.size
    if len(batches.ranges) == 1:
        yield next(batches.seen(0.0, lines)), (0, height)
        return
    reach, rows = np.empty((2, batches.strands.count), np.float32), np.zeros(height, np.int64)
    foreseen = np.zeros(height)
    for batch in batches.seen(0.0):
        drawn = ScreenLines(batch.lines.first, batch.screen, batch.widths)
        found = extents_on_screen(*drawn, width, batches.scratch)
        reach[:, batch.begin : batch.end] = found[:, [LEAST_Y, GREATEST_Y]].T
        rows += np.bincount(np.clip(batch.screen[:, 1], 0, height - 1).astype(np.int64), minlength=height)
        if not coverage.rows.any():
            foreseen += coverage.estimate(drawn)
    if not coverage.rows.any():
        coverage.rows = foreseen
    for top, bottom in _cut(rows, batches.scene.image.supersample):
        counts, parts = [], []
        for begin, end in batches.ranges:
            shown = (reach[0, begin:end] < bottom) & (reach[1, begin:end] >= top)
            number, columns = np.zeros(end - begin, np.int64), {}
            if shown.any():
                batch = batches.on_screen(begin, end, batches.flatten(begin, end, shown), 0.0)
                columns = _within(batch, top, bottom, number)
            counts.append(number)
            if number.any():
                parts.append(columns)
        yield _joined(counts, parts, batches), (top, bottom)


def _cut(vertices: NDArray[np.int64], samples: int) -> list[Rows]:
    """Divide the rows of a picture, with so many ``vertices`` (height,), into at most `BANDS` bands, if that is enough
    with about `BAND_VERTICES` each; samples: along a side of a pixel, of which bands have whole ones."""
    below = np.cumsum(vertices.reshape(-1, samples).sum(1))
    band = below // max(BAND_VERTICES, below[-1] // BANDS + 1)
    cuts = samples * (np.flatnonzero(np.diff(band)) + 1)
    return list(pairwise([0, *cuts.tolist(), len(vertices)]))


def _within(batch: StrandBatch, top: int, bottom: int, counts: NDArray[np.int64]) -> Columns:
    """Return copies of what those vertices of a batch have that `kernels.bands.find` finds in rows of a picture; write
    their number of each strand to counts (strands,)."""
    lines = batch.lines
    begin = np.empty_like(counts)
    kernel.find(lines.first, batch.screen, batch.widths, np.float32(top), np.float32(bottom), begin, counts)
    first = _first_of(counts)
    along = lines.along
    if along is None:  # by number, vertices of a part of a strand would stand elsewhere
        each = np.diff(lines.first)
        along = (np.arange(len(batch.screen)) - np.repeat(lines.first[:-1], each)).astype(np.float32)
        along *= np.repeat(np.float32(1) / np.maximum(each - 1, 1).astype(np.float32), each)
    columns = {"world": lines.world, "along": along, "lost": lines.lost, "tangents": lines.tangents}
    columns |= {"screen": batch.screen, "widths": batch.widths}
    found = {}
    for name, column in columns.items():
        if column is not None:
            found[name] = np.empty((first[-1], *column.shape[1:]), np.float32)
            kernel.copy(begin, first, *(one if one.ndim > 1 else one[:, None] for one in (column, found[name])))
    return found


def _joined(counts: list[NDArray[np.int64]], parts: list[Columns], batches: StrandBatches) -> StrandBatch:
    """Return one batch of consecutive ones; counts (strands,): vertices of each strand; parts: what these have, taken
    away here."""
    first = _first_of(np.concatenate(counts))
    names = list(parts[0]) if parts else []
    column = {name: np.concatenate([one.pop(name) for one in parts]) for name in names}
    none, level, wide = np.zeros((0, 3), np.float32), batches.strands.level, batches.scene.material.width > 0
    screen, widths = column.get("screen", none), column.get("widths", none[:, 0] if wide else None)
    lines = Polylines(
        first, column.get("world", none), scale=None if level is None else level.scale,
        along=column.get("along", none[:, 0]), lost=column.get("lost"), tangents=column.get("tangents"),
    )  # fmt: skip
    return StrandBatch(
        0, len(first) - 1, lines, batches.strands.tones, screen, widths, batches.profiles(screen, widths)
    )


def _first_of(counts: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return `Polylines.first` of strands with so many vertices."""
    return np.concatenate([np.zeros(1, np.int64), np.cumsum(counts)])
