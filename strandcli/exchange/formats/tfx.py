"""`.tfx` of TressFX 3 and 4 (https://github.com/GPUOpen-Effects/TressFX), read only.

Little-endian. Strands of equal length; the header has the offset of each array, 0 where it is absent. In version 3 the
followers of a guide are made by the program and are not stored.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..bounded import Bounded, opened
from ..files import ReadOptions
from ..strands import Attribute, Domain, Source, Strands, even_offsets, without_short

name = ".tfx"
suffixes = (".tfx",)


class Array(NamedTuple):
    """An array of a file: its attribute ("" for the points), what has a row of it, and numbers a row (f32)."""

    attribute: str
    domain: Domain
    width: int
    dtype: str = "<f4"


class Layout(NamedTuple):
    """A version's header: bytes of it, byte of the offsets, and the arrays in the order of their offsets."""

    header: int
    offsets: int
    arrays: tuple[Array, ...]


LAYOUTS = {
    3.0: Layout(296, 144, (
        Array("", "point", 3), Array("width", "point", 1), Array("uv", "strand", 2), Array("colour", "point", 4),
        Array("guide", "strand", 1, "<i4"), Array("vertex_uv", "point", 2),
    )),
    4.0: Layout(160, 12, (
        Array("", "point", 4), Array("uv", "strand", 2), Array("vertex_uv", "point", 2), Array("width", "point", 1),
        Array("colour", "point", 4),
    )),
}  # fmt: skip
AT_STRANDS, AT_VERTICES = 4, 8


def sniff(head: bytes, size: int) -> bool:
    """Whether it begins with a version that is known."""
    return len(head) >= 4 and struct.unpack_from("<f", head)[0] in LAYOUTS and size >= 160


def read(path: Path, options: ReadOptions) -> Strands:
    """The strands of a file; w of a position is the attribute ``movable``."""
    with opened(path, ".tfx file", options.lenient) as file:
        version = struct.unpack("<f", file.take("version", 4))[0]
        layout = LAYOUTS.get(version)
        if layout is None:
            raise file.fault(f"version: {version:.6g} is not known; .tfx files are of version 3 or 4", 0)
        header = struct.pack("<f", version) + file.take("header", layout.header - 4)
        strands, vertices = struct.unpack_from("<2I", header, AT_STRANDS)
        if strands and not vertices:  # of which there could be any number in no bytes
            raise file.damaged("vertices a strand: 0", AT_VERTICES)
        file.need("strands", strands * vertices, 4 * layout.arrays[0].width, AT_STRANDS)
        points, attributes, held = None, {}, layout.header
        for place, one in enumerate(layout.arrays):
            at = layout.offsets + 4 * place
            offset = struct.unpack_from("<I", header, at)[0]
            if offset == 0:
                continue
            values = _array(file, one, (strands, vertices), (offset, at), layout.header)
            held += values.nbytes
            if held > file.size:
                raise file.damaged(f"offset of {one.attribute}: {offset:,}, where another array is", at)
            if one.attribute:
                attributes[one.attribute] = Attribute(one.domain, values)
            else:
                points = values
        if points is None:
            raise file.damaged("offset of the positions: 0, there are none", layout.offsets)
    if points.shape[1] > 3:
        attributes["movable"] = Attribute("point", np.ascontiguousarray(points[:, 3]))
        points = np.ascontiguousarray(points[:, :3])
    return without_short(Strands(even_offsets(strands, vertices), points, attributes, Source(name, f"{version:.1f}")))


def _array(file: Bounded, one: Array, counts: tuple[int, int], offset: tuple[int, int], header: int) -> Any:
    """One array; ``offset``: byte where it begins, and the byte that says so."""
    strands, vertices = counts
    begin, at = offset
    label = one.attribute or "positions"
    if begin < header:
        raise file.damaged(f"offset of {label}: {begin:,} lies in the header", at)
    file.seek(f"offset of {label}", begin, at)
    rows = strands * vertices if one.domain == "point" else strands
    values = file.array(label, one.dtype, (rows, one.width) if one.width > 1 else (rows,), AT_STRANDS)
    file.finite(label, values, lambda row: begin + 4 * one.width * row)
    return values
