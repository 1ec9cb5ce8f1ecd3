"""`.data` of USC-HairSalon, Hair20k and more, and `.bin` of CT2Hair.

Little-endian: i32 number of strands; of each strand i32 number of points, then for each point xyz as f32, in `.bin`
with four more, of which nothing is known. Nothing but the size of the file tells the two apart.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ...common.counted import counted
from ...output.files import write_pieces
from ..bounded import opened
from ..files import ReadOptions
from ..strands import Offsets, Source, Strands, TimeSample, offsets, spans, without_short
from ..written import left_out, raw

name = ".data"
suffixes = (".data", ".bin")

PLAIN, MORE = 3, 7
"""Numbers a point."""
NAMES = {PLAIN: ".data", MORE: ".bin"}


def sniff(head: bytes, size: int) -> bool:
    """Never: it begins with a count."""
    return False


def read(path: Path, options: ReadOptions) -> Strands:
    """The strands of a file; those of one point are bald roots, and are skipped."""
    with opened(path, "file of counted points", options.lenient) as file:
        if file.size < 4 or file.size % 4:
            raise file.damaged(f"the file has {file.size:,} bytes, no whole number of 4-byte numbers")
        words = file.array("file", "<i4", (file.size // 4,))
        order = (MORE, PLAIN) if path.suffix.lower() == ".bin" else (PLAIN, MORE)
        faults = []
        for width in order:
            counts = _counts(words, width)
            if isinstance(counts, array):
                break
            faults.append(counts)
        else:
            at, message = faults[0]
            raise file.damaged(message, 4 * at)
        first = offsets(np.frombuffer(counts, np.int32))
        numbers = _numbers(words, first, width)
        del words
        points = numbers if width == PLAIN else np.ascontiguousarray(numbers[:, :PLAIN])

        def byte(row: int) -> int:
            return 4 * (1 + int(np.searchsorted(first, row, side="right")) + width * row)

        file.finite("points", points, byte)
    return without_short(Strands(first, points, {}, Source(NAMES[width])))


def _counts(words: npt.NDArray[np.int32], width: int) -> array[int] | tuple[int, str]:
    """How many points of so many numbers each strand has; or at which word that fails, and why."""
    view = words.data
    size, strands, at = len(view), view[0], 1
    counts = array("i")
    if not 0 <= strands < size:
        return 0, f"strands: {strands:,}, with a count each; the file has {counted(size - 1, 'number')}"
    for strand in range(strands):
        if at >= size:
            return at, f"points of strand {strand:,} of {strands:,}: the file ends before"
        points = view[at]
        step = 1 + width * points
        if points < 0 or step > size - at:
            left = (size - at - 1) // width
            return at, f"points of strand {strand:,}: {points:,}, the file has {left:,} more"
        counts.append(points)
        at += step
    if at != size:
        return at, f"{4 * (size - at):,} bytes follow the {strands:,} strands that the file declares"
    return counts


def _numbers(words: npt.NDArray[np.int32], first: Offsets, width: int) -> npt.NDArray[np.float32]:
    """The numbers (P, width) of all points, which stand between the counts."""
    inner = np.ones(words.size, np.bool_)
    inner[0] = False
    heads = first[:-1] * width
    heads += np.arange(1, first.size)
    inner[heads] = False
    return words.view("<f4")[inner].reshape(-1, width)


def write(path: Path, strands: Strands, samples: Iterable[TimeSample] | None = None) -> list[str]:
    """Write a file: `.data` the points alone, `.bin` with four times 0."""
    width = MORE if path.suffix.lower() == ".bin" else PLAIN
    write_pieces(path, _words(strands, width))
    return left_out(strands, NAMES[width], [])


def _words(strands: Strands, width: int) -> Iterable[Any]:
    """The words of a file of so many numbers a point, some strands at once."""
    yield np.int32(strands.count).astype("<i4").tobytes()
    for rows, points in spans(strands.first):
        numbers = np.zeros((points.stop - points.start, width), "<f4")
        numbers[:, :PLAIN] = strands.points[points]
        begins, counts = strands.first[rows] - points.start, np.diff(strands.first[rows.start : rows.stop + 1])
        yield raw(np.insert(numbers.view("<i4").reshape(-1), width * begins, counts), "<i4")
