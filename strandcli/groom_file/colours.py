"""Colours that a file has for its strands, as a palette of a few, and widths."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..exchange.strands import WIDTHS, Offsets, Strands, spans
from ..groom.record import Widths
from .measure import box_of
from .rows import Rows, values_in

MOST = 256
"""Colours of a palette."""
GAMMA = 2.2
"""Of the encoding in which colours are compared."""
ALONG = 17
"""Places along a strand, evenly from root to tip, at which its colours are taken."""
Floats = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Colours:
    """Linear colours of strands: a palette (k, 3), k ≥ 2, of strands of one colour each, or (`ALONG`, k, 3) from root
    to tip, and of each strand (S,) its tone in [−1, 1], at which the palette's colours stand evenly."""

    palette: Floats
    tones: Floats

    @property
    def mean(self) -> tuple[float, float, float]:
        """The colour of all strands together."""
        rows = np.rint((self.tones + 1) * 0.5 * (self.palette.shape[-2] - 1)).astype(np.int64)
        whole = self.palette if self.palette.ndim == 2 else self.palette.mean(axis=0)
        red, green, blue = whole[rows].mean(axis=0, dtype=np.float64).tolist()
        return red, green, blue


def colours_of(strands: Strands, rows: Rows | None, most: int) -> Colours | None:
    """The colours of strands; None where the file has none, one grey for all that stands for none, or some that are
    none. Those of points count where they change along a strand. ``rows``: as of `rows_in`."""
    found = strands.attributes.get("colour")
    if found is None or found.domain == "groom" or found.values.ndim != 2 or found.values.shape[1] < 3:
        return None
    values = found.values[:, :3].astype(np.float32)
    if found.values.dtype == np.uint8:
        values /= 255
    if not values.size or (values == values[0, 0]).all() or not (np.isfinite(values) & (values >= 0)).all():
        return None
    values = np.minimum(values, 1)
    if found.domain == "point":
        changes = (values[1:] != values[:-1]).any(axis=1)
        changes[strands.first[1:-1] - 1] = False
        if changes.any():
            return _changing(strands, values, rows, most)
        values = values[strands.first[:-1]]
    palette, rows = _palette(values)
    if len(palette) == 1:
        palette = np.repeat(palette, 2, axis=0)
    return Colours(palette, _tones(rows, len(palette)))


def _tones(rows: NDArray[np.int64], count: int) -> Floats:
    """Tones (S,) of rows of a palette of so many colours."""
    return (2 * rows / (count - 1) - 1).astype(np.float32)


def _changing(strands: Strands, values: Floats, places: Rows | None, most: int) -> Colours:
    """The colours of strands whose points have colours (P, 3)."""
    profiles = along_of(strands, values, places, most).reshape(strands.count, -1)
    palette, rows = np.unique(profiles, axis=0, return_inverse=True)
    rows = rows.reshape(-1)
    if len(palette) > MOST:
        _, rows = _palette(profiles.reshape(strands.count, ALONG, 3).mean(axis=1))
        counts = np.bincount(rows)
        sums = np.stack([np.bincount(rows, column) for column in profiles.T], axis=1)
        palette = (sums / counts[:, None]).astype(np.float32)
    elif len(palette) == 1:
        palette = np.repeat(palette, 2, axis=0)
    table = np.ascontiguousarray(palette.reshape(len(palette), ALONG, 3).transpose(1, 0, 2))
    return Colours(table, _tones(rows, len(palette)))


def along_of(strands: Strands, values: Floats, places: Rows | None, most: int) -> Floats:
    """(S, ALONG, 3): values (P, 3) of points where the same share of the points that are drawn is nearer to the root,
    linear between points."""
    out = np.empty((strands.count, ALONG, 3), np.float32)
    for rows, part in spans(strands.first):
        first = strands.first[rows.start : rows.stop + 1] - part.start
        here = np.arange(part.stop - part.start) % most if places is None else places[part]
        out[rows] = _along(first, here / (most - 1), values[part])
    return out


def _along(first: Offsets, places: NDArray[np.float64], values: Floats) -> Floats:
    """The same of some strands, of whose points (P,) shares are before ``places``."""
    strand = np.arange(first.shape[0] - 1)
    targets = (2.0 * strand[:, None] + np.linspace(0, 1, ALONG)).reshape(-1)
    keys = places + 2.0 * np.repeat(strand, np.diff(first))
    low, high = (np.repeat(ends, ALONG) for ends in (first[:-1], first[1:] - 2))
    begin = np.clip(np.searchsorted(keys, targets, side="right") - 1, low, high)
    span = keys[begin + 1] - keys[begin]
    share = np.clip((targets - keys[begin]) / np.where(span > 0, span, 1.0), 0, 1)[:, None]
    found = values[begin] * (1 - share) + values[begin + 1] * share
    return np.asarray(found.reshape(strand.shape[0], ALONG, 3), np.float32)


def _palette(values: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """At most `MOST` colours (k, 3) for (S, 3), and of each strand (S,) the row of its own."""
    palette, rows = np.unique(values, axis=0, return_inverse=True)
    if len(palette) <= MOST:
        return palette, rows.reshape(-1)
    from PIL import Image

    encoded = np.rint(255 * values ** (1 / GAMMA)).astype(np.uint8)
    picked = Image.fromarray(encoded[None]).quantize(MOST, method=Image.Quantize.MEDIANCUT)
    used, rows = np.unique(np.asarray(picked).reshape(-1), return_inverse=True)
    counts = np.bincount(rows)
    means = np.stack([np.bincount(rows, values[:, c]) / counts for c in range(3)], axis=1)
    return means[: len(used)].astype(np.float32), rows.reshape(-1)


LEAST_COVER, MOST_COVER = 0.02, 200.0
"""How often strands of a believable width cover the box about them, on average."""
FINEST = 2e-5
"""Width over length from which on strands are believed that cover less of it, because they are few."""


@dataclass(frozen=True, eq=False)
class FileWidths:
    """Widths of a file's strands. S: strands."""

    greatest: NDArray[np.float64]
    """(S,) metres, of each strand where it is widest."""
    vary: bool
    """Whether any strand is not as wide at all its points."""

    @property
    def mean(self) -> float:
        """Of the greatest, metres."""
        return float(self.greatest.mean())

    def packed(self, strands: Strands, factor: float, rows: Rows | None, order: NDArray[np.int32], most: int) -> Widths:
        """As factors of the mean, in an ``order`` (S,), at ``most`` points of each strand. ``strands``, ``factor``: as
        of `widths_of`; ``rows``: of `rows_in`."""
        own = self.greatest[order]
        scale = (own / self.mean).astype(np.float32)
        if not self.vary:
            return Widths(scale)
        shares = values_in(strands.first, strands.attributes["width"].values, rows, order, most)
        per = np.divide(factor, own, out=np.zeros_like(own), where=own > 0).astype(np.float32)
        np.minimum(np.multiply(shares, per[:, None], out=shares), 1, out=shares)
        return Widths(scale, shares)


def widths_of(strands: Strands, factor: float, lengths: NDArray[np.float64], notes: list[str]) -> FileWidths | None:
    """The widths of strands that are so long each (S,), metres; ``factor``: metres a unit of the file's widths. None
    where the file has none, or none that could be meant, which is noted."""
    found = strands.attributes.get("width")
    if found is None:
        if not WIDTHS.keys().isdisjoint(strands.source.facts.get("attributes_not_read", ())):
            notes.append("widths of the file are left out: not all of its curves have them, or not a number each")
        return None
    values, vary = found.values, False
    if found.domain == "point":
        each = np.maximum.reduceat(values, strands.first[:-1])
        vary = bool((values != np.repeat(each, strands.counts())).any())
        sound = bool(np.isfinite(each).all() and (values >= 0).all())
    else:
        each = np.broadcast_to(values, strands.count)
        sound = bool((np.isfinite(each) & (each >= 0)).all())
    greatest = factor * each.astype(np.float64)
    mean = float(greatest.mean()) if sound else 0.0
    if not sound or not _believable(strands, mean, lengths):
        why = f"at {mean:.3g} m strands would be a blob, or nothing" if sound else "some are negative or not finite"
        notes.append(f"widths of the file are left out: {why}")
        return None
    return FileWidths(greatest, vary)


def _believable(strands: Strands, width: float, lengths: NDArray[np.float64]) -> bool:
    """Whether strands that are so long each (S,) may be so wide, metres."""
    low, high = box_of(strands.points)
    x, y, z = high - low + width
    length = float(lengths.mean())
    times = 3 * width * float(lengths.sum()) / max(x * y + y * z + z * x, 1e-30)
    return 0 < width <= length and times <= MOST_COVER and (times >= LEAST_COVER or width >= FINEST * length)
