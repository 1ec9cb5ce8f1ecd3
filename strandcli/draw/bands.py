"""Bands of rows of a picture, each with the strands that come to it, where all at once would take too much memory.

Strands are made, projected and thrown away again: once to learn which rows they come to, and once for each band. What
lies in a band is as it would be in the whole picture.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..constants import BAND_POINTS
from .coverage.coverage import Rows
from .geometry.curves import Polylines
from .geometry.extent import extents_on_screen
from .geometry.kernels.ribbon import GREATEST_Y, LEAST_Y, MARGIN
from .strand_batches import StrandBatch, StrandBatches

BESIDE = 2
"""Vertices of a strand before a band and behind it: those at its border have the light, the widths and the joints that
their neighbours give them."""


def bands(
    batches: StrandBatches, size: tuple[int, int], lines: Polylines | None
) -> Iterator[tuple[StrandBatch, Rows]]:  # fmt: skip
    """Yield bands of rows, from top to bottom, of a picture (width, height), samples, each with the strands that come
    to it, valid until the next is requested; a single batch is the only band. lines: as in `StrandBatches.seen`."""
    if len(batches.ranges) == 1:
        yield next(batches.seen(0.0, lines)), (0, size[1])
        return
    strands, samples = batches.strands, batches.scene.image.supersample
    reach, rows = np.empty((2, strands.count), np.float32), np.zeros(size[1], np.int64)
    for batch in batches.seen(0.0):
        found = extents_on_screen(batch.lines.first, batch.screen, batch.widths, size[0], batches.scratch)
        reach[:, batch.begin : batch.end] = found[:, [LEAST_Y, GREATEST_Y]].T
        rows += np.bincount(np.clip(batch.screen[:, 1], 0, size[1] - 1).astype(np.int64), minlength=size[1])
    for top, bottom in _cut(rows, samples):
        counts, parts = [], []
        for begin, end in batches.ranges:
            shown = (reach[0, begin:end] < bottom) & (reach[1, begin:end] >= top)
            batch = batches.on_screen(begin, end, batches.flatten(begin, end, shown), 0.0)
            there, stay = _within(batch, top, bottom)
            counts.append(there)
            if len(stay):
                parts.append({name: one[stay] for name, one in _columns(batch).items()})
        yield _joined(counts, parts, batches), (top, bottom)


def _cut(vertices: NDArray[np.int64], samples: int) -> list[Rows]:
    """Divide the rows of a picture, with so many ``vertices`` (height,), into bands with about `BAND_POINTS`;
    samples: along a side of a pixel, of which bands have whole ones."""
    band = np.cumsum(vertices.reshape(-1, samples).sum(1)) // BAND_POINTS
    cuts = samples * (np.flatnonzero(np.diff(band)) + 1)
    return list(pairwise([0, *cuts.tolist(), len(vertices)]))


def _within(batch: StrandBatch, top: int, bottom: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return how many vertices each strand has in rows of a picture, with `BESIDE` more before and behind them; and
    which vertices of the batch these are.

    A strand loses an even number of its first vertices, because light that counts little is that at vertices of even
    rank."""
    first, screen = batch.lines.first, batch.screen
    margin = MARGIN + (np.float32(1) if batch.widths is None else batch.widths)
    unseen = screen[:, 2] <= 0
    low = np.where(unseen, np.float32(np.inf), screen[:, 1] - margin)
    high = np.where(unseen, np.float32(-np.inf), screen[:, 1] + margin)
    there = (np.minimum(low[:-1], low[1:]) < bottom) & (np.maximum(high[:-1], high[1:]) >= top)
    last = first[1:-1] - 1  # from there a segment would go to the next strand
    there[last[(last >= 0) & (last < len(there))]] = False
    found = np.flatnonzero(there)
    own = np.searchsorted(first, found, side="right") - 1
    opens = np.flatnonzero(np.diff(own, prepend=-1))
    strands, ends = own[opens], found[np.append(opens[1:], len(own))[: len(opens)] - 1] + 1
    begin = np.maximum(found[opens] - BESIDE, first[strands])
    begin -= (begin - first[strands]) % 2
    some = np.minimum(ends + BESIDE + 1, first[strands + 1]) - begin
    counts = np.zeros(len(first) - 1, np.int64)
    counts[strands] = some
    return counts, np.repeat(begin - np.cumsum(some) + some, some) + np.arange(some.sum())


def _columns(batch: StrandBatch) -> dict[str, NDArray[np.float32]]:
    """Return what a batch has for each vertex, but for profiles."""
    lines = batch.lines
    along = lines.along
    if along is None:  # by number, vertices of a part of a strand would stand elsewhere
        counts = np.diff(lines.first)
        along = (np.arange(len(batch.screen)) - np.repeat(lines.first[:-1], counts)).astype(np.float32)
        along *= np.repeat(np.float32(1) / np.maximum(counts - 1, 1).astype(np.float32), counts)
    columns = {"world": lines.world, "along": along, "lost": lines.lost, "ways": lines.ways}
    columns |= {"screen": batch.screen, "widths": batch.widths}
    return {name: one for name, one in columns.items() if one is not None}


def _joined(
    counts: list[NDArray[np.int64]], parts: list[dict[str, NDArray[np.float32]]], batches: StrandBatches
) -> StrandBatch:
    """Return one batch of consecutive ones, of which ``parts``, with the columns of `_columns`, end here."""
    first = np.concatenate([[0], np.cumsum(np.concatenate(counts))])
    names = list(parts[0]) if parts else []
    column = {name: np.concatenate([one.pop(name) for one in parts]) for name in names}
    none, level, wide = np.zeros((0, 3), np.float32), batches.strands.level, batches.scene.material.width > 0
    screen, widths = column.get("screen", none), column.get("widths", none[:, 0] if wide else None)
    lines = Polylines(
        first, column.get("world", none), scale=None if level is None else level.scale,
        along=column.get("along", none[:, 0]), lost=column.get("lost"), ways=column.get("ways"),
    )  # fmt: skip
    return StrandBatch(
        0, len(first) - 1, lines, batches.strands.tones, screen, widths, batches.profiles(screen, widths)
    )
