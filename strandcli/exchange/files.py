"""Read and write a file of strands of any format.

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

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..common.registry import Registry
from ..errors import UsageError, about
from ..files.inputs import reading
from .bounded import opened
from .objects import only
from .strands import Layer, Strands, TimeSample

FORMATS = Registry(
    "format of strands", "strandcli.groom_formats", "exchange.formats", "hair", ("name", "suffixes", "sniff", "read")
)
HEAD = 64
"""Bytes that a format is told by."""


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
