"""What readers and writers of Alembic archives share: marks, types of numbers, bits of headers."""

from __future__ import annotations

import struct
from typing import NamedTuple

import numpy as np

MAGIC = b"Ogawa"
HEADER = struct.Struct("<5sBHQ")
"""The container: magic, whether it was closed, version (its bytes 0, 1), byte of the root group."""
CLOSED = 0xFF
VERSION = 0x0100
WORD = struct.Struct("<Q")
DATA = 1 << 63
"""Bit of a child's word that tells data from a group; the other bits are its byte, 0 where it is empty."""

VERSIONS, LIBRARY, TOP, METADATA, SAMPLINGS, INDEXED = range(6)
"""Children of the root group: version of the layout, of the library, top object, metadata, samplings, indexed."""
OLDEST_LIBRARY = 9999
LIBRARY_WRITTEN = 10800
"""Version of the library whose layout is written: 1.8.0."""
NEWEST_LAYOUT = 0
DIGEST = 16
"""Bytes in front of the numbers of a sample, which tell equal ones."""
DIGESTS = 32
"""Bytes at the end of an object's headers: digests of its properties and of its children."""

COMPOUND, SCALAR, ARRAY = range(3)
"""Kinds of properties; the bit of `SCALAR` beside that of `ARRAY` says that every sample has one element."""
KIND = 0x3
HINT = 2
"""Bit where the width of the numbers in a property's header begins, 2 bits: an index of `WIDTHS`."""
WIDTHS = ("<B", "<H", "<I")
TYPE = 4
"""Bit where the type begins, 4 bits: an index of `TYPES`."""
SAMPLED = 1 << 8
"""Bit: has a time sampling other than the first."""
RANGE = 1 << 9
"""Bit: first and last changed sample are told."""
SAME_SIZE = 1 << 10
"""Bit: all samples have the same size."""
CONSTANT = 1 << 11
"""Bit: all samples are the same."""
EXTENT = 12
"""Bit where the numbers an element begin, 8 bits."""
INDEX = 20
"""Bit where the index of the metadata begins, 8 bits: 0 for none."""
WRITTEN_OUT = 0xFF
"""Index of metadata that stand in the header itself."""
LONGEST_INDEXED = 255
"""Letters of metadata that may be indexed."""

ACYCLIC = np.finfo(np.float64).max / 32
"""Seconds a cycle of a time sampling that tells every time."""


class Type(NamedTuple):
    """A type of numbers: Alembic's name, and numpy's, "" for text."""

    name: str
    dtype: str


TYPES = (
    Type("bool_t", "?"), Type("uint8_t", "|u1"), Type("int8_t", "|i1"), Type("uint16_t", "<u2"), Type("int16_t", "<i2"),
    Type("uint32_t", "<u4"), Type("int32_t", "<i4"), Type("uint64_t", "<u8"), Type("int64_t", "<i8"),
    Type("float16_t", "<f2"), Type("float32_t", "<f4"), Type("float64_t", "<f8"), Type("string", ""),
    Type("wstring", ""),
)  # fmt: skip
NUMBER = {one.name: index for index, one in enumerate(TYPES)}

CURVES = "AbcGeom_Curve_v2"
BASE = "AbcGeom_GeomBase_v1"
XFORM = "AbcGeom_Xform_v3"
CUBIC, LINEAR, VARIABLE = range(3)
"""Types of curves."""
BASES = ("", "bezier", "bspline", "catmullRom", "hermite", "power")
SCOPES = {"con": "constant", "": "constant", "uni": "uniform", "var": "varying", "vtx": "vertex", "fvr": "varying"}
"""Geometry scopes, as USD calls them."""
NAMES = {"N": "normal", "groom_root_uv": "root_uv", "groom_color": "colour", "groom_width": "width"}
"""Names of attributes: Alembic's own, those of Unreal's *Alembic for Grooms*, and ours."""
SCALE, TRANSLATE, ROTATE, MATRIX, ROTATE_X, ROTATE_Y, ROTATE_Z = range(7)
"""Operations of a transform."""
CHANNELS = {SCALE: 3, TRANSLATE: 3, ROTATE: 4, MATRIX: 16, ROTATE_X: 1, ROTATE_Y: 1, ROTATE_Z: 1}
"""Numbers of each."""


def pairs(metadata: str) -> dict[str, str]:
    """Metadata by key: ``key=value;key=value``."""
    found = {}
    for one in metadata.split(";"):
        key, _, value = one.partition("=")
        found[key] = value
    return found
