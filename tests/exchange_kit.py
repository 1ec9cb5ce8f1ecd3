"""Files of strands written from the formats' descriptions alone, and made-up strands."""

from __future__ import annotations

import struct
import tempfile
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import strategies as st

import mesh_kit
from strandcli.errors import UsageError
from strandcli.exchange.files import ReadOptions, read, read_first
from strandcli.exchange.strands import Attribute, Strands, TimeSample, offsets

Strand = npt.NDArray[np.float32]

lists_of_strands = st.builds(
    lambda counts, seed: [
        np.random.default_rng(seed).normal(size=(count, 3)).astype(np.float32) * np.float32(10.0 ** (seed % 7 - 3))
        for count in counts
    ],
    st.lists(st.integers(2, 9), min_size=1, max_size=9), st.integers(0, 999),
)  # fmt: skip
"""Some strands of 2 to 9 points."""


def of(strands: Sequence[Strand]) -> Strands:
    """Strands as they are held."""
    counts = np.array([len(one) for one in strands], np.int64)
    return Strands(offsets(counts), np.concatenate([*strands, np.zeros((0, 3), np.float32)]).astype(np.float32))


def attributes(strands: int, points: int) -> dict[str, Attribute]:
    """One of each kind that .abc and .usd hold."""
    generator = np.random.default_rng(strands + points)
    return {
        "width": Attribute("point", generator.random(points, np.float32)),
        "uv": Attribute("strand", generator.random((strands, 2), np.float32)),
        "normal": Attribute("point", generator.random((points, 3), np.float32)),
        "root_uv": Attribute("strand", generator.random((strands, 2), np.float32)),
        "colour": Attribute("strand", generator.random((strands, 3), np.float32)),
        "clump": Attribute("strand", np.arange(strands, dtype=np.int32)),
        "number": Attribute("strand", np.arange(strands) - 2**40),
        "kind": Attribute("point", np.arange(points, dtype=np.uint8)),
        "transparency": Attribute("groom", np.array([0.5], np.float32)),
    }


def read_bytes(content: bytes | str, suffix: str, options: ReadOptions | None = None) -> Strands:
    """The strands of a file that holds this."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"a{suffix}")
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return read(path, options)


def refused(content: bytes | str, suffix: str, message: str) -> None:
    """Fail unless a file that holds this is refused in a line that says so."""
    with pytest.raises(UsageError) as error:
        read_bytes(content, suffix)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def moments(path: Path, options: ReadOptions | None = None) -> list[TimeSample]:
    """The points at all moments of a file."""
    strands, moving = read_first(path, options or ReadOptions())
    if moving is None:
        return [TimeSample(next(iter(strands.source.times), 0.0), strands.points)]
    return list(moving.samples(range(1, moving.clock.size + 1)))


def hair(strands: Sequence[Strand], *, segments: bool = True, more: bytes = b"", flags: int = 0) -> bytes:
    """`.hair`; ``more``: the arrays behind the points, of which ``flags`` tells."""
    points = sum(len(one) for one in strands)
    default = 0 if segments else len(strands[0]) - 1
    header = b"HAIR" + struct.pack("<4I", len(strands), points, 2 | segments | flags, default)
    header += struct.pack("<5f", 0.5, 0.25, 0.75, 0.5, 0.125) + b"made up".ljust(88, b"\0")
    counts = b"".join(struct.pack("<H", len(one) - 1) for one in strands) if segments else b""
    return header + counts + b"".join(one.astype("<f4").tobytes() for one in strands) + more


def data(strands: Sequence[Strand], more: int = 0) -> bytes:
    """`.data`, or with four numbers ``more`` a point `.bin`."""
    found = struct.pack("<i", len(strands))
    for one in strands:
        found += struct.pack("<i", len(one))
        for point in one:
            found += struct.pack("<3f", *point) + struct.pack(f"<{more}f", *range(more))
    return found


def obj(strands: Sequence[Strand], segments: bool = False, back: bool = False) -> bytes:
    """`.obj` of lines, one a strand or one a segment; with rows counted ``back`` from each line."""
    text, count = "# made up\n", 0
    for k, one in enumerate(strands):
        text += f"o strand{k}\n" + "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in one.tolist())
        count += len(one)
        rows = list(range(-len(one), 0)) if back else list(range(count - len(one) + 1, count + 1))
        pairs = pairwise(rows) if segments else [rows]
        text += "".join(f"l {' '.join(map(str, pair))}\n" for pair in pairs)
    return text.encode()


def gltf(strands: Sequence[Strand], mode: int = 3, index: str = "<u2", **node: object) -> tuple[dict[str, Any], bytes]:
    """The tree of a glTF of lines and its buffer: strips (3), pairs (1) or loops (2), a primitive a strand."""
    maker = mesh_kit.Maker()
    maker.tree["nodes"] = [{"mesh": 0, **node}]
    for one in strands:
        rows = np.arange(len(one))
        rows = np.stack([rows[:-1], rows[1:]], 1) if mode == 1 else rows
        indices = maker.accessor(rows.reshape(-1, 1).astype(index))
        maker.primitive({"POSITION": maker.accessor(one.astype("<f4"))}, mode=mode, indices=indices)
    return maker.whole()


def tfx4(strands: Sequence[Strand], uv: bool = True) -> bytes:
    """`.tfx` of version 4."""
    each = len(strands[0])
    points = b"".join(struct.pack("<4f", *p, float(j > 1)) for one in strands for j, p in enumerate(one))
    texture = b"".join(struct.pack("<2f", i, 0.5) for i in range(len(strands))) if uv else b""
    places = (160, 160 + len(points) if uv else 0, 0, 0, 0)
    return struct.pack("<f2I5I32I", 4.0, len(strands), each, *places, *[0] * 32) + points + texture


def tfx3(strands: Sequence[Strand], followers: int = 3) -> bytes:
    """`.tfx` of version 3."""
    each = len(strands[0])
    points = b"".join(one.astype("<f4").tobytes() for one in strands)
    header = struct.pack("<f4I31I", 3.0, len(strands), each, followers, 1, *[0] * 31)
    return header + struct.pack("<6I32I", 296, 0, 0, 0, 0, 0, *[0] * 32) + points + b""


def ply(strands: Sequence[Strand], order: str = "<", *, told: str = "strand", kind: str = "float") -> bytes:
    """`.ply`; ``order``: "<", ">" or "" for text; ``told``: strand, edge or nothing; ``kind`` of the coordinates."""
    encoding = {"<": "binary_little_endian", ">": "binary_big_endian", "": "ascii"}[order]
    pairs, begin = [], 0
    for one in strands:
        pairs += [(begin + j, begin + j + 1) for j in range(len(one) - 1)]
        begin += len(one)
    header = f"ply\nformat {encoding} 1.0\ncomment made up\nelement vertex {begin}\n"
    header += "".join(f"property {kind} {axis}\n" for axis in "xyz") + "property uchar quality\n"
    rows = [(f"3{'f' if kind == 'float' else 'd'}B", (*map(float, point), 7)) for one in strands for point in one]
    if told == "strand":
        header += f"element strand {len(strands)}\nproperty ushort nsegs\n"
        rows += [("H", (len(one) - 1,)) for one in strands]
    elif told == "edge":
        header += f"element edge {len(pairs)}\nproperty int vertex1\nproperty int vertex2\n"
        rows += [("2i", pair) for pair in pairs]
    header += "end_header\n"
    if order:
        return header.encode() + b"".join(struct.pack(order + form, *row) for form, row in rows)
    return (header + "".join(" ".join(map(repr, row)) + "\n" for _, row in rows)).encode()
