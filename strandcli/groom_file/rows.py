"""Strands of a file in blocks of lanes, all with as many points: shorter ones get points on their segments."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..blocks import aligned
from ..constants import W
from ..exchange.edit.resample import resampled
from ..exchange.strands import Attribute, Offsets, Points, Strands, offsets
from .kernels import rows as kernel

PADDED = 4
"""Points that all strands together may have in memory, over those of the file, where they are more than `ENOUGH`."""
ENOUGH = 1 << 24


def most_points(counts: Offsets) -> int:
    """Points that strands of so many each (S,) all get: as many as the longest has, or fewer where that would take too
    much memory."""
    longest, total = int(counts.max()), int(counts.sum())
    return max(min(longest, max(PADDED * total, ENOUGH) // counts.shape[0]), 2)


def with_at_most(strands: Strands, most: int) -> tuple[Strands, int, float]:
    """Strands of at most so many points each, and their widths: those with more get that many at equal distances along
    them. Returns how many these are, and how far they are off at most, too."""
    counts = strands.counts()
    over = counts > most
    if not over.any():
        return strands, 0, 0.0
    fewer, change = resampled(strands.select(over), most)
    after = offsets(np.minimum(counts, most))
    points = np.empty((int(after[-1]), 3), np.float32)
    of_points = np.repeat(over, np.minimum(counts, most))
    points[of_points] = fewer.points
    points[~of_points] = strands.points[np.repeat(~over, counts)]
    kept = {name: one for name, one in strands.attributes.items() if one.domain != "point"}
    width = strands.attributes.get("width")
    if width is not None and width.domain == "point":
        values = np.empty(of_points.shape[0], width.values.dtype)
        values[of_points] = fewer.attributes["width"].values
        values[~of_points] = width.values[np.repeat(~over, counts)]
        kept["width"] = Attribute("point", values)
    found = replace(strands, first=after, points=points, attributes=kept)
    return found, int(over.sum()), float(change.facts["deviation_max"])


def packed(first: Offsets, points: Points, order: NDArray[np.int32], most: int) -> NDArray[np.float32]:
    """(blocks, most + 1, 3 W): strands in an ``order`` (S,), row 0 a segment before the root, as `strandcli.blocks` has
    it. Of strands with fewer points than ``most`` each point keeps its bits; between them others are put, on the
    straight segments, so many to each as its length asks for."""
    strands = order.shape[0]
    blocks = -(-strands // W)
    out = aligned((blocks, most + 1, 3 * W))
    if (np.diff(first) == most).all():
        kernel.pack(first, points, order, out)
        return out
    for block in range(blocks):
        some = order[block * W : (block + 1) * W]
        here = filled(first, points, some, most)
        wide = out[block].reshape(most + 1, 3, W)
        wide[1:, :, : some.shape[0]] = here.transpose(1, 2, 0)
        wide[1:, :, some.shape[0] :] = here[-1, :, :, None]
    out.reshape(blocks, most + 1, 3, W)[:, 0] = _before(out)
    return out


def _before(packed_rows: NDArray[np.float32]) -> NDArray[np.float32]:
    """(blocks, 3, W): a segment before the roots of (blocks, n + 1, 3 W)."""
    wide = packed_rows.reshape(*packed_rows.shape[:2], 3, W)
    return np.asarray(2 * wide[:, 1] - wide[:, 2])


def filled(first: Offsets, points: Points, some: NDArray[np.int32], most: int) -> Points:
    """(k, most, 3): the strands ``some`` (k,), with ``most`` points each."""
    counts = first[some + 1] - first[some]
    if (counts == most).all():
        return points[first[some][:, None] + np.arange(most)]
    out = np.empty((some.shape[0], most, 3), np.float32)
    for count in np.unique(counts):
        rows = np.flatnonzero(counts == count)
        out[rows] = lengthened(points[first[some[rows]][:, None] + np.arange(count)], most)
    return out


def rows_of(
    first: Offsets, points: Points, values: NDArray[np.float32], order: NDArray[np.int32], most: int
) -> NDArray[np.float32]:
    """(S, most): values (P,) of the points of strands in an ``order`` (S,), at the points that `packed` gives them."""
    if (np.diff(first) == most).all():
        return values.reshape(-1, most)[order].astype(np.float32, copy=False)
    out = np.empty((order.shape[0], most), np.float32)
    for begin in range(0, order.shape[0], W):
        some = order[begin : begin + W]
        counts = first[some + 1] - first[some]
        for count in np.unique(counts):
            here = np.flatnonzero(counts == count)
            rows = first[some[here]][:, None] + np.arange(count)
            own = np.concatenate([points[rows], values[rows][..., None]], axis=2, dtype=np.float32)
            out[begin + here] = lengthened(own, most)[..., 3]
    return out


def lengthened(points: NDArray[np.float32], most: int) -> NDArray[np.float32]:
    """Strands (k, n, 3) with ``most`` points each, those that they have among them in every bit; further columns, too.

    After point j of n the share of its arc length of the points that are added has been placed, rounded.
    """
    strands, n, _ = points.shape
    if n == most:
        return points
    own = np.arange(n) + np.rint(_shares(points) * (most - n)).astype(np.int64)
    """(k, n): the row of each point."""
    rows = np.arange(most)
    segment = np.empty((strands, most), np.int64)
    for s in range(strands):
        segment[s] = np.searchsorted(own[s], rows, side="right") - 1
    segment = np.minimum(segment, n - 2)
    begin, end = np.take_along_axis(own, segment, 1), np.take_along_axis(own, segment + 1, 1)
    t = ((rows - begin) / (end - begin))[..., None]
    a = np.take_along_axis(points, segment[..., None], 1).astype(np.float64)
    b = np.take_along_axis(points, segment[..., None] + 1, 1).astype(np.float64)
    out = (a + t * (b - a)).astype(np.float32)
    out[np.arange(strands)[:, None], own] = points
    return out


def _shares(points: Points) -> NDArray[np.float64]:
    """(k, n): the share of its strand's length before each point of strands (k, n, 3 or more); by number where they
    have no length."""
    n = points.shape[1]
    steps = np.linalg.norm(np.diff(points[..., :3].astype(np.float64), axis=1), axis=2)
    along = np.concatenate([np.zeros((points.shape[0], 1)), np.cumsum(steps, axis=1)], axis=1)
    whole = along[:, -1:]
    return np.asarray(np.where(whole > 0, along / np.where(whole > 0, whole, 1.0), np.arange(n) / (n - 1)))


def places_of(first: Offsets, points: Points, most: int) -> NDArray[np.float64]:
    """(P,) in [0, 1]: of each point of strands the share of the ``most`` points that all get which are before it."""
    counts, found = np.diff(first), np.empty(points.shape[0])
    for count in np.unique(counts):
        n = int(count)
        rows = first[:-1][counts == count][:, None] + np.arange(n)
        if n == most:
            found[rows] = np.arange(n) / (n - 1)
        elif n > most:
            found[rows] = _shares(points[rows])
        else:
            found[rows] = (np.arange(n) + np.rint(_shares(points[rows]) * (most - n))) / (most - 1)
    return found
