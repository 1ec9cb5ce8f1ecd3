"""Read and write a file of strands of any format, and the moments of those that move: of one file, or of numbered
files, each a moment of its own.

A format is a module in `formats/`, or an entry point of another package (group ``strandcli.groom_formats``), with

- ``name``, as messages have it; ``suffixes`` of its files, with the dot;
- ``sniff(head, size)``: whether the first bytes of a file, of so many bytes in all, say that it is one;
- ``read(path, options) -> Strands``;
- ``write(path, strands, samples) -> lines``, where it can be written: the file whole or not at all, and a line for what
  it cannot hold. ``moving``: whether it takes ``samples``, the points at several times. ``staged``: whether it takes
  ``beside`` of `write` below;
- ``interpolates``: whether ``read``, which obeys ``options.at`` where `Source.times` are several, tells what is between
  these times.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..common.registry import Registry
from ..errors import UsageError, about
from ..files.inputs import note, reading
from ..files.numbered import file_of, is_numbered, numbered
from .bounded import opened
from .objects import only
from .strands import Layer, Strands, TimeSample

FORMATS = Registry(
    "format of strands", "strandcli.groom_formats", "exchange.formats", "hair", ("name", "suffixes", "sniff", "read")
)
HEAD = 64
"""Bytes that a format is known by."""


@dataclass(frozen=True, slots=True)
class ReadOptions:
    """How a file is read: points a strand, and name of the array, where it does not say them; ``lenient`` lets in
    numbers that are not finite; ``objects``: names of those whose strands are wanted, () of all; ``at``: the last
    moment that is not after so many seconds, None for the first one."""

    stride: int | None = None
    array: str | None = None
    lenient: bool = False
    objects: tuple[str, ...] = ()
    at: float | None = None


def read(path: Path, options: ReadOptions | None = None) -> Strands:
    """The strands of a file. Raises `UsageError` for what is no such file, in one line."""
    options = options or ReadOptions()
    with about("strands", path), reading(path):
        strands: Strands = format_of(path).read(path, options)
        return only(strands, options.objects, path).with_width()


def write(
    path: Path, strands: Strands, samples: Iterable[TimeSample] | None = None, beside: Layer | None = None
) -> list[str]:
    """Write strands in the format that the name ends in, whole or not at all; returns a line for all that this format
    does not hold. ``samples``: their points at several times; ``beside``: what else goes into a stage of USD, and
    nowhere else."""
    driver = writer_of(path)
    if samples is not None and not getattr(driver, "moving", False):
        moving = [one.name for one in drivers() if getattr(one, "moving", False)]
        where = f"; write {' or '.join(moving)}" if moving else ""
        raise UsageError(f"{path}: {driver.name} has one moment only{where}")
    if getattr(driver, "staged", False):
        return list(driver.write(path, strands, samples, beside))
    return list(driver.write(path, strands, samples))


def drivers() -> list[Any]:
    """All formats."""
    return [FORMATS[name] for name in FORMATS.names()]


def format_of(path: Path) -> Any:
    """The format of a file: by its first bytes, and by the end of its name where those do not tell."""
    with opened(path, "file of strands") as file:
        head, size = file.take("begin", min(HEAD, file.size)), file.size
    suffix = path.suffix.lower()
    sniffed = [one for one in drivers() if one.sniff(head, size)]
    named = [one for one in drivers() if suffix in one.suffixes]
    both = [one for one in sniffed if one in named]
    found = both or sniffed or named
    if not found:
        raise UsageError(f"{path}: is no file of strands that is known; read are {_listed(drivers())}")
    return found[0]


def writer_of(path: Path) -> Any:
    """The format that a name to be written ends in. Raises `UsageError` where there is none that can be written."""
    writers = [one for one in drivers() if hasattr(one, "write")]
    for one in writers:
        if path.suffix.lower() in one.suffixes:
            return one
    raise UsageError(f"{path}: cannot be written; let the name end in one of {_listed(writers)}")


def _listed(formats: list[Any]) -> str:
    return ", ".join(suffix for one in formats for suffix in one.suffixes)


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

    def samples(self, numbers: Iterable[int]) -> Iterator[TimeSample]:
        """The points at the moments with these numbers, from 1; file N is that of frame N. Raises `UsageError` where
        strands come or go."""
        counts = None
        for value in (float(self.clock[number - 1]) for number in numbers):
            strands = self.read(value)
            counts = strands.counts() if counts is None else counts
            if not np.array_equal(strands.counts(), counts):
                where = self.files[round(value)] if self.files else f"{self.path}: at {value:g} s"
                raise UsageError(f"{where}: has other strands than before; take one moment with --frames N")
            yield TimeSample(value / USUAL if self.files else value, strands.points)

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
