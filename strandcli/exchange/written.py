"""What writers share."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import UsageError
from .strands import CHUNK, Attribute, Strands, TimeSample, spans


def raw(values: npt.NDArray[Any], dtype: str) -> Any:
    """The bytes of an array in a type, without a copy where it has that type already."""
    return np.ascontiguousarray(values, dtype).reshape(-1).view(np.uint8).data


def values_of(strands: Strands, attribute: str, width: int) -> npt.NDArray[np.float32] | None:
    """An attribute of so many numbers: a row for each point, or one for the groom; None where there is none such.

    Values of strands become values of their points, and bytes 0 to 255 numbers from 0 to 1.
    """
    found = strands.attributes.get(attribute)
    if found is None or found.values[:1].size != width * min(found.values.shape[0], 1):
        return None
    values = found.values
    if values.dtype == np.uint8:
        values = values.astype(np.float32) / np.float32(255)
    if found.domain == "strand":
        values = np.repeat(values, strands.counts(), axis=0)
    return values.astype(np.float32, copy=False)


def with_width_each(strands: Strands) -> Strands:
    """The strands with a width of each of them where one holds for all."""
    one = strands.attributes.get("width")
    if one is None or one.domain != "groom":
        return strands
    each = Attribute("strand", np.broadcast_to(one.values, (strands.count, *one.values.shape[1:])))
    return replace(strands, attributes={**strands.attributes, "width": each})


def left_out(strands: Strands, format: str, retained: Iterable[str]) -> list[str]:
    """A line for the attributes that a format does not hold, or none."""
    lost = [attribute for attribute in strands.attributes if attribute not in set(retained)]
    return [f"{format} cannot store {', '.join(lost)}: left out"] if lost else []


def records(columns: list[tuple[str, str, Any]], count: int) -> Any:
    """The bytes of rows of columns, each of a name, a type and values (count,)."""
    found = np.empty(count, [(label, kind) for label, kind, _ in columns])
    for label, _, values in columns:
        found[label] = values
    return found.view(np.uint8).data


def edges_of(strands: Strands) -> Iterator[Any]:
    """Pairs of points that strands join, as bytes, some at once."""
    for rows, points in spans(strands.first):
        low = np.arange(points.start, points.stop)
        low = np.delete(low, strands.first[rows.start + 1 : rows.stop + 1] - 1 - points.start)
        yield raw(np.stack([low, low + 1], axis=1), "<i4")


def checked(path: Path, strands: Strands, samples: Iterable[TimeSample] | None, format: str) -> Iterator[TimeSample]:
    """The samples, or the strands' own points where there are none. Raises `UsageError` where they do not fit the
    strands, or their times do not rise."""
    last = None
    for one in [TimeSample(0.0, strands.points)] if samples is None else samples:
        if one.points.shape != strands.points.shape:
            raise UsageError(
                f"{path}: {one.points.shape[0]:,} points at {one.seconds:g} s, the strands have "
                f"{strands.points.shape[0]:,}; {format} is written of strands that stay the same in number"
            )
        if last is not None and not one.seconds > last:
            raise UsageError(f"{path}: {one.seconds:g} s comes after {last:g} s; times must rise")
        last = one.seconds
        yield one
    if last is None:
        raise UsageError(f"{path}: there is no moment to be written")


def box_of(points: npt.NDArray[Any], most: float) -> npt.NDArray[np.float64]:
    """Low and high corner (2, 3) of points, of those that are finite; ``most`` and less than nothing of none."""
    low, high = np.full(3, most), np.full(3, -most)
    for begin in range(0, points.shape[0], CHUNK):
        part = points[begin : begin + CHUNK]
        low, high = np.fmin(low, part.min(axis=0)), np.fmax(high, part.max(axis=0))
    return np.stack([low, high])
