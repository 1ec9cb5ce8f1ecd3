"""`.tfx` of TressFX 3 and 4 (https://github.com/GPUOpen-Effects/TressFX), read only.

Little-endian. Strands of equal length; the header has the offset of each array, 0 where it is absent. In version 3 the
followers of a guide are made by the program and are not stored.
"""

from __future__ import annotations

import itertools
import struct
from pathlib import Path

import numpy as np

from ..bounded import opened
from ..files import ReadOptions
from ..strands import Attribute, Domain, Source, Strands, even_offsets, without_short

name = ".tfx"
suffixes = (".tfx",)


LAYOUTS: dict[float, tuple[int, int, tuple[tuple[str, Domain, int, str], ...]]] = {
    3.0: (296, 144, (
        ("", "point", 3, "<f4"), ("width", "point", 1, "<f4"), ("uv", "strand", 2, "<f4"),
        ("colour", "point", 4, "<f4"), ("guide", "strand", 1, "<i4"), ("vertex_uv", "point", 2, "<f4"),
    )),
    4.0: (160, 12, (
        ("", "point", 4, "<f4"), ("uv", "strand", 2, "<f4"), ("vertex_uv", "point", 2, "<f4"),
        ("width", "point", 1, "<f4"), ("colour", "point", 4, "<f4"),
    )),
}  # fmt: skip
"""Of each version the bytes of the header, the byte of the offsets, and the arrays in the order of their offsets: the
attribute ("" for the points), what has a row of it, numbers a row, and their type."""
AT_STRANDS, AT_VERTICES = 4, 8


def sniff(head: bytes, size: int) -> bool:
    """Whether it begins with a version that is known."""
    return len(head) >= 4 and struct.unpack_from("<f", head)[0] in LAYOUTS and size >= 160


def read(path: Path, options: ReadOptions) -> Strands:
    """The strands of a file; w of a position is the attribute ``movable``."""
    with opened(path, ".tfx file", options.lenient) as file:
        version = struct.unpack("<f", file.take("version", 4))[0]
        if version not in LAYOUTS:
            raise file.fault(f"version: {version:.6g} is not known; .tfx files are of version 3 or 4", 0)
        size, begin, arrays = LAYOUTS[version]
        header = struct.pack("<f", version) + file.take("header", size - 4)
        strands, vertices = struct.unpack_from("<2I", header, AT_STRANDS)
        if strands and not vertices:  # of which there could be any number in no bytes
            raise file.damaged("vertices a strand: 0", AT_VERTICES)
        file.need("strands", strands * vertices, 4 * arrays[0][2], AT_STRANDS)
        points, attributes, read_so_far = None, {}, size
        for at, (attribute, domain, width, kind) in zip(itertools.count(begin, 4), arrays, strict=False):
            label = attribute or "positions"
            offset = struct.unpack_from("<I", header, at)[0]
            if offset == 0:
                continue
            if offset < size:
                raise file.damaged(f"offset of {label}: {offset:,} lies in the header", at)
            file.seek(f"offset of {label}", offset, at)
            rows = strands * vertices if domain == "point" else strands
            values = file.array(label, kind, (rows, width) if width > 1 else (rows,), AT_STRANDS)
            file.finite(label, values, lambda row, offset=offset, width=width: offset + 4 * width * row)  # type: ignore[misc]
            read_so_far += values.nbytes
            if read_so_far > file.size:
                raise file.damaged(f"offset of {label}: {offset:,}, where another array is", at)
            if attribute:
                attributes[attribute] = Attribute(domain, values)
            else:
                points = values
        if points is None:
            raise file.damaged("offset of the positions: 0, there are none", begin)
    if points.shape[1] > 3:
        attributes["movable"] = Attribute("point", np.ascontiguousarray(points[:, 3]))
        points = np.ascontiguousarray(points[:, :3])
    return without_short(Strands(even_offsets(strands, vertices), points, attributes, Source(name, f"{version:.1f}")))
