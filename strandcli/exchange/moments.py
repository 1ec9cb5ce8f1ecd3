"""Strands that move: the moments of a file, or of numbered files, each a moment of its own."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import UsageError
from ..files.inputs import note
from ..files.numbered import file_of, is_numbered, numbered
from . import files as one_file
from .files import ReadOptions, format_of, read
from .strands import Strands, TimeSample

NEAR = 1e-5
"""Seconds, or numbers of files, by which times may differ that mean the same."""
USUAL = 24.0
"""Frames a second of files that say none."""
SPREAD = 0.01
"""Share by which the distances of times may differ that are meant to be equal."""


@dataclass(frozen=True, eq=False)
class Moments:
    """When strands are known, and how they are read then. ``clock`` (M,), rising: seconds, or numbers of files."""

    path: Path
    options: ReadOptions
    clock: npt.NDArray[np.float64]
    rate: float
    """Frames a second."""
    interpolates: bool
    """Whether the file itself tells what is between moments."""
    files: Mapping[int, Path]
    """Numbered files; none of a single file."""

    def at(self, seconds: float, fps: float, start: float | None = None) -> float:
        """The clock, within its range, so many seconds after frame 1 of a film of a rate, where it shows ``start``."""
        value = (self.clock[0] if start is None else start) + seconds * (fps if self.files else 1.0)
        return float(min(max(value, self.clock[0]), self.clock[-1]))

    def around(self, value: float) -> tuple[int, float]:
        """The last moment that is not after a value of the clock, and how far that is to the next one, in [0, 1)."""
        index = max(int(np.searchsorted(self.clock, value + NEAR, side="right")) - 1, 0)
        past = value - self.clock[index]
        if past <= NEAR or index + 1 == self.clock.size:
            return index, 0.0
        share = past / (self.clock[index + 1] - self.clock[index])
        return index, float(share)

    def read(self, value: float) -> Strands:
        """The strands at a value of the clock."""
        if self.files:
            return read(self.files[round(value)], self.options)
        return read(self.path, replace(self.options, at=value))

    def frames(self, fps: float, start: float | None = None) -> int:
        """How many frames a film of a rate has that shows all."""
        span = self.clock[-1] - (self.clock[0] if start is None else start)
        return max(round(span * (1.0 if self.files else fps)), 0) + 1

    def facts(self) -> dict[str, Any]:
        """What there is to know, for programs."""
        begin, end = self.clock[[0, -1]].tolist()
        return {
            "count": self.clock.size, "first": begin, "last": end, "unit": "file" if self.files else "s",
            "frames_a_second": self.rate, "missing": round(end - begin) + 1 - len(self.files) if self.files else 0,
        }  # fmt: skip

    def require(self, value: float) -> None:
        """Raise `UsageError` where a numbered file is missing that is shown at a value of the clock."""
        for number in (math.floor(value + NEAR), math.ceil(value - NEAR)) if self.files else ():
            if number not in self.files:
                raise UsageError(f"{file_of(self.path, number)}: there is no such file, which a frame is to show")


def files_of(path: Path) -> list[Path]:
    """The file that a path names, or all numbered ones. Raises `UsageError` where there is none of these."""
    found = list(numbered(path).values()) if is_numbered(path) else [path]
    if not found:
        raise UsageError(f"{path}: there is no file with a number in place of # or %04d")
    return found


def count_of(path: Path, strands: Strands) -> int:
    """How many moments there are of the strands that were read from a file, or from the first of numbered ones."""
    return len(files_of(path)) if is_numbered(path) else one_file.times_in(strands)


def moved_to(strands: Strands, path: Path, options: ReadOptions, number: int) -> Strands:
    """The strands at the moment with a number, from 1, of a file of which ``strands`` are those of the first moment, or
    of numbered files."""
    if number == 1:
        return strands
    if is_numbered(path):
        return read(files_of(path)[number - 1], options)
    return replace(strands, points=next(one_file.moments_of(path, options, (number,))).points)


def samples_of(path: Path, options: ReadOptions, numbers: Sequence[int]) -> Iterator[TimeSample]:
    """The points of the strands of a file, or of numbered ones, at the moments with these numbers, rising from 1; file
    N is that of frame N. Raises `UsageError` where strands come or go with time."""
    if not is_numbered(path):
        yield from one_file.moments_of(path, options, numbers)
        return
    files = list(numbered(path).items())
    counts = None
    for number in numbers:
        frame, file = files[number - 1]
        strands = read(file, options)
        counts = strands.counts() if counts is None else counts
        if not np.array_equal(strands.counts(), counts):
            raise UsageError(f"{file}: has other strands than the files before it; take one moment with --frames N")
        yield TimeSample(frame / USUAL, strands.points)


def read_first(path: Path, options: ReadOptions, start: float | None = None) -> tuple[Strands, Moments | None]:
    """The strands of a file, or of numbered ones, at their first moment or at a value of their clock; and the moments
    of those that have several. Raises `UsageError` for a value after the last one."""
    files = numbered(path) if is_numbered(path) else {}
    for one in (path, *files.values()) if files else ():  # those that may come, too
        note(one)
    strands = read(files_of(path)[0], options)
    times = tuple(map(float, files)) if files else strands.source.times
    if len(times) < 2:
        return strands, None
    clock = np.array(times)
    moments = Moments(
        path, options, clock, strands.source.rate or (USUAL if files else _rate(clock)),
        not files and getattr(format_of(path), "interpolates", False), files,
    )  # fmt: skip
    if start is None:
        return strands, moments
    if start > clock[-1] + NEAR:
        unit = "file" if files else "moment, in seconds,"
        raise UsageError(f"{path}: its last {unit} is {clock[-1]:.6g}, before emitter.groom.start, {start:.6g}")
    index, _ = moments.around(moments.at(0.0, 1.0, start))
    return moments.read(clock[index]), moments


def _rate(seconds: npt.NDArray[np.float64]) -> float:
    """Moments a second where they are at equal distances."""
    steps = np.diff(seconds)
    mean = float(steps.mean())
    return 1 / mean if np.abs(steps - mean).max() < SPREAD * mean else USUAL
