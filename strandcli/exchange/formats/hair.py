"""`.hair`, Cem Yuksel's HAIR: http://www.cemyuksel.com/research/hairmodels.

Little-endian. A header of 128 bytes, then the arrays of which it has the flag: segments of each strand, points,
thickness, transparency, colour.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from ...common.counted import counted
from ...errors import UsageError
from ...output.files import write_pieces
from ..bounded import Bounded, opened
from ..files import ReadOptions
from ..strands import Attribute, Source, Strands, TimeSample, even_offsets, offsets, without_short
from ..written import left_out, raw, values_of

name = ".hair"
suffixes = (".hair",)

MAGIC = b"HAIR"
HEADER = struct.Struct("<4s4I5f88s")
SEGMENTS, POINTS, THICKNESS, TRANSPARENCY, COLOUR = (1 << bit for bit in range(5))
ARRAYS = (("width", THICKNESS, 1), ("transparency", TRANSPARENCY, 1), ("colour", COLOUR, 3))
"""Arrays after the points: our name, flag, numbers a point."""
AT_STRANDS, AT_POINTS, AT_FLAGS = 4, 8, 12
"""Bytes of the header's counts."""
MOST_SEGMENTS = 65_535
UNTOLD = 1.0
"""The header's thickness where none is set, in Yuksel's own library and here."""


def sniff(head: bytes, size: int) -> bool:
    """Whether it begins with HAIR."""
    return head.startswith(MAGIC)


def read(path: Path, options: ReadOptions) -> Strands:
    """The strands of a file. Defaults of the header are attributes of the whole groom."""
    with opened(path, ".hair file", options.lenient) as file:
        magic, strands, points, flags, default, *numbers, text = HEADER.unpack(file.take("header", HEADER.size))
        if magic != MAGIC:
            raise file.damaged("does not begin with HAIR", 0)
        _check_flags(file, flags)
        if flags & SEGMENTS:
            first = offsets(file.array("segments", "<u2", (strands,), AT_STRANDS), 1)
        else:
            file.need("points", points, 12, AT_POINTS)
            if strands * (default + 1) != points:
                raise file.damaged(
                    f"points: {points:,} are declared, {counted(strands, 'strand')} of {counted(default, 'segment')} "
                    f"have {strands * (default + 1):,}", AT_POINTS,
                )  # fmt: skip
            first = even_offsets(strands, default + 1)
        if first[-1] != points:
            raise file.damaged(f"points: {points:,} are declared, the strands have {first[-1]:,}", AT_POINTS)
        begin = file.position
        xyz = file.array("points", "<f4", (points, 3), AT_POINTS)
        file.finite("points", xyz, lambda row: begin + 12 * row)
        attributes = _attributes(file, flags, points, numbers)
        file.end()
    facts = {"info": text.rstrip(b"\0").decode("utf-8", "replace"), "default_segments": default}
    return without_short(Strands(first, xyz, attributes, Source(name, facts=facts)))


def _check_flags(file: Bounded, flags: int) -> None:
    known = SEGMENTS | POINTS | THICKNESS | TRANSPARENCY | COLOUR
    if flags & ~known:
        raise file.damaged(f"flags: {flags:#x} has bits of which nothing is known", AT_FLAGS)
    if not flags & POINTS:
        raise file.damaged("flags: declare no points", AT_FLAGS)


def _attributes(file: Bounded, flags: int, points: int, defaults: Sequence[float]) -> dict[str, Attribute]:
    """Arrays by name; where there is none, the default of the header, but for a thickness that was not set."""
    found = {}
    at = 0
    for attribute, flag, width in ARRAYS:
        shape = (width,) if width > 1 else ()
        if flags & flag:
            begin = file.position
            values = file.array(attribute, "<f4", (points, *shape), AT_POINTS)
            size = 4 * width
            file.finite(attribute, values, lambda row, begin=begin, size=size: begin + size * row)  # type: ignore[misc]
            found[attribute] = Attribute("point", values)
        else:
            values = np.array(defaults[at : at + width], "<f4").reshape(1, *shape)
            file.finite(f"default {attribute}", values, lambda row, at=at: 20 + 4 * at)  # type: ignore[misc]
            if flag != THICKNESS or values[0] != UNTOLD:
                found[attribute] = Attribute("groom", values)
        at += width
    return found


def write(path: Path, strands: Strands, samples: Iterable[TimeSample] | None = None) -> list[str]:
    """Write a file. Raises `UsageError` where a strand has more segments than it can tell."""
    equal = strands.equal()
    counts = np.array([equal]) if equal else strands.counts(np.int32)
    counts -= 1
    if counts.size and counts.max() > MOST_SEGMENTS:
        worst = int(np.argmax(counts))
        raise UsageError(
            f"{path}: strand {worst:,} has {counts[worst]:,} segments, .hair at most {MOST_SEGMENTS:,}; "
            "write fewer with --resample or --simplify"
        )
    flags, defaults, arrays = POINTS, [], []
    for attribute, flag, width in ARRAYS:
        values = values_of(strands, attribute, width)
        default = [0.0 if attribute == "transparency" else 1.0] * width
        if values is not None and values.shape[0] == 1:
            default = values.reshape(-1).tolist()
        elif values is not None:
            flags |= flag
            arrays.append(values)
        defaults += default
    if not equal:
        flags |= SEGMENTS
    text = str(strands.source.facts.get("info", "")).encode("utf-8")[:88] if strands.source.format == name else b""
    header = HEADER.pack(
        MAGIC, strands.count, strands.points.shape[0], flags, equal - 1 if equal else 0, *defaults, text
    )
    segments = [] if equal else [raw(counts, "<u2")]
    write_pieces(path, [header, *segments, raw(strands.points, "<f4"), *(raw(one, "<f4") for one in arrays)])
    return left_out(strands, name, [attribute for attribute, _, _ in ARRAYS])
