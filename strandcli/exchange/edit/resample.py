"""Other points on the same strands: so many of each by arc length, or as few as a tolerance allows."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..change import Change
from ..kernels import along
from ..kernels import simplify as thinning
from ..strands import Attribute, Strands, even_offsets, offsets


def resampled(strands: Strands, count: int) -> tuple[Strands, Change]:
    """Strands of ``count`` points each, at equal distances along them; roots and tips stay."""
    out = np.empty((strands.count, count, 3), np.float32)
    low, share = np.empty(out.shape[:2], np.int64), np.empty(out.shape[:2], np.float32)
    deviation = np.zeros(strands.count)
    along.resample(strands.first, strands.points, low, share, out, deviation)
    attributes = {
        name: Attribute(one.domain, _between(one.values, low.reshape(-1), share.reshape(-1)))
        if one.domain == "point" else one
        for name, one in strands.attributes.items()
    }  # fmt: skip
    changed = replace(
        strands, first=even_offsets(strands.count, count), points=out.reshape(-1, 3), attributes=attributes
    )
    return changed, _change("resample", f"resampled to {count} points a strand", strands, changed, deviation)


def simplified(strands: Strands, tolerance: float) -> tuple[Strands, Change]:
    """Strands without the points that lie within ``tolerance`` of the segment between those about them, as do the
    strand's edges there."""
    width = strands.attributes.get("width")
    widths = None if width is None or width.domain != "point" else width.values.astype(np.float32, copy=False)
    keep, deviation = np.zeros(strands.points.shape[0], np.bool_), np.zeros(strands.count)
    thinning.simplify(strands.first, strands.points, widths, tolerance, keep, deviation)
    counts = np.add.reduceat(keep.astype(np.int64), strands.first[:-1]) if strands.count else strands.counts()
    attributes = {
        name: Attribute(one.domain, one.values[keep]) if one.domain == "point" else one
        for name, one in strands.attributes.items()
    }
    changed = replace(strands, first=offsets(counts), points=strands.points[keep], attributes=attributes)
    return changed, _change("simplify", f"simplified to {tolerance:g}", strands, changed, deviation)


def _between(values: npt.NDArray[Any], low: npt.NDArray[np.int64], share: npt.NDArray[np.float32]) -> Any:
    """Values between rows low and low + 1; whole numbers are those of the nearer row."""
    if values.dtype.kind != "f":
        return values[low + (share >= 0.5)]
    part = share.reshape(-1, *[1] * (values.ndim - 1)).astype(values.dtype)
    return (1 - part) * values[low] + part * values[low + 1]


def _change(edit: str, text: str, before: Strands, after: Strands, deviation: npt.NDArray[np.float64]) -> Change:
    worst = int(np.argmax(deviation)) if deviation.size else 0
    largest = float(deviation[worst]) if deviation.size else 0.0
    points = f"{before.points.shape[0]:,} points became {after.points.shape[0]:,}"
    where = f" (strand {worst:,})" if largest > 0 else ""
    return Change(
        edit, f"{text}: {points}, largest deviation {largest:.4g}{where}",
        {"points_before": before.points.shape[0], "points": after.points.shape[0], "deviation_max": largest,
         "deviation_strand": worst if largest > 0 else None},
    )  # fmt: skip
