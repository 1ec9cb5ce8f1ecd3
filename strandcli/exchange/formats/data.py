"""`.data` of USC-HairSalon, Hair20k and others, and `.bin` of CT2Hair.

Little-endian: i32 number of strands; of each strand i32 number of points, then for each point xyz as f32, in `.bin`
with four more. Nothing but the size of the file tells the two apart.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.counted import counted
from ...output.files import write_pieces
from ..bounded import Bounded, opened
from ..files import ReadOptions
from ..strands import SHORT, SHORTEST, Attribute, Offsets, Source, Strands, TimeSample, even_offsets, offsets, spans
from ..written import left_out, raw

name = ".data"
suffixes = (".data", ".bin")

PLAIN, MORE = 3, 7
"""Numbers a point."""
NAMES = {PLAIN: ".data", MORE: ".bin"}
EXTRA = "extra"
"""The attribute of a point's four numbers more, of which the format says nothing."""

AT_ONCE = 1 << 16
"""Points that are gathered at once."""


def sniff(head: bytes, size: int) -> bool:
    """Never: it begins with a count."""
    return False


def read(path: Path, options: ReadOptions) -> Strands:
    """The strands of a file; those of one point are bald roots, and are skipped."""
    with opened(path, "file of counted points", options.lenient) as file:
        if file.size < 4 or file.size % 4:
            raise file.damaged(f"the file has {file.size:,} bytes, no whole number of 4-byte numbers")
        words = file.array("file", "<i4", (file.size // 4,))
        found = _layout(file, words)
        begins, first = found.begins, found.first
        numbers, count = words.view("<f4"), int(first[-1])
        points, more = numbers[: PLAIN * count].reshape(count, PLAIN), np.empty((0, MORE - PLAIN), "<f4")
        if found.width == MORE:
            points, more = np.empty_like(points), np.empty((count, MORE - PLAIN), "<f4")
        _gather(numbers, found, (points, more))

        def byte(row: int) -> int:
            strand = int(np.searchsorted(first, row, side="right")) - 1
            return int(4 * (begins[strand] + found.width * (row - first[strand])))

        file.finite("points", points, byte)
        file.finite(EXTRA, more, byte)
    attributes = {EXTRA: Attribute("point", more)} if found.width == MORE else {}
    skipped = {SHORT: found.skipped} if found.skipped else {}
    return Strands(first, points, attributes, Source(NAMES[found.width], skipped=skipped))


class _Layout(NamedTuple):
    """Numbers a point; of strands of at least two points the first word, and the first point (S + 1,); how many others
    there are; and whether all have as many points."""

    width: int
    begins: Offsets
    first: Offsets
    skipped: int
    even: bool = False


def _layout(file: Bounded, words: npt.NDArray[np.int32]) -> _Layout:
    """Where the strands are. Raises `UsageError` where the size of the file agrees with neither of the two layouts."""
    order = (MORE, PLAIN) if file.path.suffix.lower() == ".bin" else (PLAIN, MORE)
    faults = []
    for width in order:
        found = _walk(words, width)
        if isinstance(found, _Layout):
            return found
        faults.append(found)
    at, message = faults[0]
    raise file.damaged(message, 4 * at)


def _walk(words: npt.NDArray[np.int32], width: int) -> _Layout | tuple[int, str]:
    """Where the strands are, from count to count; or at which word that fails, and why."""
    view = words.data
    size, strands, at = len(view), view[0], 1
    begins, counts = array("q"), array("q")
    if not 0 <= strands < size:
        return 0, f"strands: {strands:,}, with a count each; the file has {counted(size - 1, 'number')}"
    each = 1 + width * view[1] if strands else 0
    if each > SHORTEST * width and strands * each == size - 1 and (words[1::each] == view[1]).all():
        begins_of_all = even_offsets(strands - 1, each)
        begins_of_all += 2
        return _Layout(width, begins_of_all, even_offsets(strands, view[1]), 0, even=True)
    for strand in range(strands):
        if at >= size:
            return at, f"points of strand {strand:,} of {strands:,}: the file ends before"
        points = view[at]
        step = 1 + width * points
        if points < 0 or step > size - at:
            left = (size - at - 1) // width
            return at, f"points of strand {strand:,}: {points:,}, the file has {left:,} more"
        if points >= SHORTEST:
            begins.append(at + 1)
            counts.append(points)
        at += step
    if at != size:
        return at, f"{4 * (size - at):,} bytes follow the {strands:,} strands that the file declares"
    first = offsets(np.frombuffer(counts, np.int64))
    return _Layout(width, np.frombuffer(begins, np.int64), first, strands - len(begins))


def _gather(
    numbers: npt.NDArray[np.float32],
    found: _Layout,
    out: tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]],
) -> None:
    """Copy what lies between the counts. ``out``: the points, and the numbers more; points alone may take the place of
    the words from the first on, which is never behind that of what is still to be copied."""
    _, begins, first, _, even = found
    at, width = 0, found.width
    while at < begins.size:  # some strands at once: an index for each number would take more than the file
        stop = max(at + 1, int(np.searchsorted(first, first[at] + AT_ONCE, side="right")) - 1)
        low, high = int(first[at]), int(first[stop])
        step = int(begins[at + 1] - begins[at]) if stop > at + 1 else 0
        if stop == at + 1:
            rows = numbers[begins[at] : begins[at] + width * (high - low)]
        elif even or ((np.diff(begins[at:stop]) == step).all() and high - low == (step - 1) // width * (stop - at)):
            heads = numbers[begins[at] - 1 : begins[at] - 1 + step * (stop - at)]  # all with as many points
            rows = heads.reshape(stop - at, step)[:, 1:]
            if width == PLAIN:
                out[0][low:high].reshape(rows.shape)[:] = rows
                at = stop
                continue
        else:
            shift = begins[at:stop] - width * first[at:stop]
            places_in = np.arange(width * low, width * high)
            rows = numbers[places_in + np.repeat(shift, width * np.diff(first[at : stop + 1]))]
        rows = rows.reshape(high - low, width)
        out[0][low:high] = rows[:, :PLAIN]
        if width == MORE:
            out[1][low:high] = rows[:, PLAIN:]
        at = stop


def write(path: Path, strands: Strands, samples: Iterable[TimeSample] | None = None) -> list[str]:
    """Write a file: `.data` the points alone, `.bin` with the four numbers that were read, or 0."""
    width = MORE if path.suffix.lower() == ".bin" else PLAIN
    write_pieces(path, _words(strands, width))
    return left_out(strands, NAMES[width], [EXTRA] if width == MORE else [])


def _words(strands: Strands, width: int) -> Iterable[Any]:
    """The words of a file of so many numbers a point, some strands at once."""
    yield np.int32(strands.count).astype("<i4").tobytes()
    extra = strands.attributes.get(EXTRA)
    known = extra is not None and extra.values.shape == (strands.points.shape[0], MORE - PLAIN)
    for rows, points in spans(strands.first):
        numbers = np.zeros((points.stop - points.start, width), "<f4")
        numbers[:, :PLAIN] = strands.points[points]
        if width == MORE and known and extra is not None:
            numbers[:, PLAIN:] = extra.values[points]
        begins, counts = strands.first[rows] - points.start, np.diff(strands.first[rows.start : rows.stop + 1])
        here = begins >= 0  # a strand in parts has its count before the first
        yield raw(np.insert(numbers.view("<i4").reshape(-1), width * begins[here], counts[here]), "<i4")
