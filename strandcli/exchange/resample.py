"""Other points on the same strands: so many of each by arc length, or as few as a tolerance allows; and fewer strands:
those within bounds of length, or so many."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..common.counted import counted
from .edits import GOLDEN, Change, mixed
from .kernels import along
from .strands import Attribute, Offsets, Strands, even_offsets, spans

AT_ONCE = 1 << 20
"""Points that are made at once, of as many at most where strands are not longer."""


def resampled(strands: Strands, count: int) -> tuple[Strands, Change]:
    """Strands of ``count`` points each, at equal distances along them; roots and tips stay."""
    total = strands.count * count
    out = np.empty((strands.count, count, 3), np.float32)
    values = {
        name: np.empty((total, *one.values.shape[1:]), one.values.dtype)
        for name, one in strands.attributes.items() if one.domain == "point"
    }  # fmt: skip
    deviation = np.zeros(strands.count)
    for rows, first, points in _some(strands, count):
        low, share = np.empty(out[rows].shape[:2], np.int64), np.empty(out[rows].shape[:2], np.float32)
        along.resample(first, strands.points[points], low, share, out[rows], deviation[rows])
        for name, found in values.items():
            here = strands.attributes[name].values[points]
            found[rows.start * count : rows.stop * count] = _between(here, low.reshape(-1), share.reshape(-1))
    attributes = {name: Attribute(one.domain, values.get(name, one.values)) for name, one in strands.attributes.items()}
    changed = replace(
        strands, first=even_offsets(strands.count, count), points=out.reshape(-1, 3), attributes=attributes
    )
    return changed, _change("resample", f"resampled to {count} points a strand", strands, changed, deviation)


def _some(strands: Strands, count: int) -> Iterator[tuple[slice, Offsets, slice]]:
    """All strands, some at once, which get so many points each: which, their offsets, and which points are theirs."""
    some = max(1, AT_ONCE // count)
    for rows, _ in spans(strands.first, AT_ONCE):
        for begin in range(rows.start, rows.stop, some):
            end = min(begin + some, rows.stop)
            first = strands.first[begin : end + 1]
            yield slice(begin, end), first - first[0], slice(int(first[0]), int(first[-1]))


def simplified(strands: Strands, tolerance: float) -> tuple[Strands, Change]:
    """Strands without the points that lie within ``tolerance`` of the segment between those about them, as do the
    strand's edges there."""
    width = strands.attributes.get("width")
    widths = None if width is None or width.domain != "point" else width.values.astype(np.float32, copy=False)
    keep, deviation = np.zeros(strands.points.shape[0], np.bool_), np.zeros(strands.count)
    for rows, first, points in _some(strands, 1):
        own = None if widths is None else widths[points]
        along.simplify(first, strands.points[points], own, tolerance, keep[points], deviation[rows])
    changed = strands.thinned(keep)
    return changed, _change("simplify", f"simplified to {tolerance:g}", strands, changed, deviation)


def _between(values: npt.NDArray[Any], low: npt.NDArray[np.int64], share: npt.NDArray[np.float32]) -> Any:
    """Values between rows low and low + 1; whole numbers are those of the nearer row."""
    if values.dtype.kind != "f":
        return values[low + (share >= 0.5)]
    part = share.reshape(-1, *[1] * (values.ndim - 1)).astype(values.dtype)
    return (1 - part) * values[low] + part * values[low + 1]


def _change(
    edit: str, text: str, before: Strands, after: Strands, deviation: npt.NDArray[np.float64]
) -> Change:  # fmt: skip
    """``deviation`` (S,): the largest distance of an old point of each strand from the new one."""
    strand = int(np.argmax(deviation)) if deviation.size else 0
    most = float(deviation[strand]) if deviation.size else 0.0
    points = f"{before.points.shape[0]:,} points became {after.points.shape[0]:,}"
    where = f" (strand {strand:,})" if most > 0 else ""
    return Change(
        edit, f"{text}: {points}, largest deviation {most:.4g}{where}",
        {"points_before": before.points.shape[0], "points": after.points.shape[0], "deviation_max": most,
         "deviation_strand": strand if most > 0 else None},
    )  # fmt: skip


def between(strands: Strands, least: float, most: float) -> tuple[Strands, Change]:
    """The strands of a length from ``least`` to ``most``, in units of the points."""
    lengths = strands.lengths()
    short, long = int(np.count_nonzero(lengths < least)), int(np.count_nonzero(lengths > most))
    keep = (lengths >= least) & (lengths <= most)
    changed = strands.select(keep)
    text = f"{counted(short + long, 'strand')} left out by length: {short:,} too short, {long:,} too long"
    return changed, Change("length", text, {"too_short": short, "too_long": long, "kept": changed.count})


def some(strands: Strands, count: int, seed: int) -> tuple[Strands, Change]:
    """So many strands, those with the lowest dice, of which whether strand i stays depends on the seed and on i alone;
    fewer are part of more."""
    thrown = dice(strands.count, seed)
    if count < thrown.size:
        last = np.partition(thrown, count)[count]
        keep = thrown < last
        ties = np.flatnonzero(thrown == last)
        keep[ties[: count - np.count_nonzero(keep)]] = True
    else:
        keep = np.ones(strands.count, np.bool_)
    changed = strands.select(keep)
    text = f"{counted(changed.count, 'strand')} of {strands.count:,} selected"
    return changed, Change("subsample", text, {"strands": count, "seed": seed, "kept": changed.count})


def dice(count: int, seed: int) -> npt.NDArray[np.float64]:
    """A number of [0, 1) for each strand, from the seed and its number alone: SplitMix64 (Steele et al., 2014)."""
    with np.errstate(over="ignore"):
        z = np.arange(1, count + 1, dtype=np.uint64) + mixed(np.array([seed], np.uint64))
        return np.asarray((mixed(z * np.uint64(GOLDEN)) >> np.uint64(11)).astype(np.float64) * 2.0**-53)
