"""What readers and writers of Alembic archives share: marks, types of numbers, bits of headers; and Ogawa, the
container, as it is read: groups, whose children are groups or data, known by the byte where they begin.

Nothing is believed: every byte lies in the file, and what is read in all is bounded, since children may be shared.
"""

from __future__ import annotations

import io
import struct
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...errors import UsageError
from ..bounded import Bounded, amount

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
"""Bit: first and last changed sample are stored."""
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


SPARE = 1 << 25
"""Bytes that may be read beyond twice the file: samples that are the same are stored once."""
LARGEST_HEADERS = 1 << 22
"""Bytes of headers of an object or a compound property: one has some 30."""


class Group(NamedTuple):
    """A group: of ``size`` children, the word of the first at byte ``begin``."""

    begin: int
    size: int


class Child(NamedTuple):
    """A child of a group: its word, the byte of that, and its name for messages."""

    word: int
    at: int
    name: str


class Data(NamedTuple):
    """Data: bytes, and where they begin."""

    begin: int
    size: int


class Container:
    """The groups and data of a file."""

    def __init__(self, file: Bounded) -> None:
        """Read the header. Raises `UsageError` for what is no closed Ogawa file."""
        self.file = file
        self.room = 2 * file.size + SPARE
        magic, closed, version, root = HEADER.unpack(file.take("header", HEADER.size))
        if magic != MAGIC:
            if magic.startswith(b"\x89HDF"):
                raise UsageError(
                    f"{file.path}: is an Alembic file of the HDF5 back end; convert it with abcconvert -toOgawa"
                )
            raise file.damaged("does not begin with Ogawa", 0)
        if closed != CLOSED:
            raise file.fault("header: the program that wrote it did not finish; export it again", 5)
        if version != VERSION:
            raise file.fault(f"header: version {version:#06x} of Ogawa is not known", 6)
        self.root = Child(root, 8, "archive")

    def group(self, child: Child) -> Group:
        """A child that is a group."""
        if child.word & DATA:
            raise self.file.damaged(f"{child.name}: data where a group should be", child.at)
        if not child.word:
            return Group(0, 0)
        self._go(child.name, child.word, child.at)
        count = WORD.unpack(self.file.take(child.name, WORD.size))[0]
        self.file.need(child.name, count, WORD.size, child.word)
        return Group(child.word + WORD.size, count)

    def child(self, group: Group, index: int, name: str) -> Child:
        """A child of a group. Raises `UsageError` where there are fewer."""
        if not 0 <= index < group.size:
            raise self.file.damaged(f"{name}: child {index:,} of {group.size:,} is asked for", group.begin)
        at = group.begin + WORD.size * index
        self.file.seek(name, at)
        return Child(WORD.unpack(self.file.take(name, WORD.size))[0], at, name)

    def data(self, child: Child) -> Data:
        """A child that is data."""
        if not child.word & DATA:
            raise self.file.damaged(f"{child.name}: a group where data should be", child.at)
        position = child.word - DATA
        if not position:
            return Data(child.at, 0)
        self._go(child.name, position, child.at)
        size = WORD.unpack(self.file.take(child.name, WORD.size))[0]
        self.file.need(child.name, size, 1, position)
        return Data(position + WORD.size, size)

    def headers(self, child: Child) -> Cursor:
        """The bytes of a child that describes the rest."""
        data = self.data(child)
        if data.size > LARGEST_HEADERS:
            raise self.file.damaged(f"{child.name}: headers of {amount(data.size)}", data.begin)
        self.spend(child.name, data.size, data.begin)
        self.file.seek(child.name, data.begin)
        return Cursor(self.file, child.name, data.begin, self.file.take(child.name, data.size))

    def numbers(self, name: str, data: Data, dtype: str, extent: int) -> npt.NDArray[Any]:
        """The numbers (n, extent) of a sample, after its digest."""
        if not data.size:
            return np.zeros((0, extent), dtype)
        each = np.dtype(dtype).itemsize * extent
        size = data.size - DIGEST
        if size < 0 or size % each:
            raise self.file.damaged(f"{name}: {amount(size)} are no whole number of {each} bytes each", data.begin)
        self.spend(name, size, data.begin)
        self.file.seek(name, data.begin + DIGEST)
        return self.file.array(name, dtype, (size // each, extent), data.begin)

    def spend(self, name: str, size: int, at: int) -> None:
        """Count bytes that are about to be taken. Raises `UsageError` where they are too many for the file's size."""
        if size > self.room:
            raise self.file.fault(f"{name}: parts that are shared make more than is believed of a file of "
                                  f"{amount(self.file.size)}", at)  # fmt: skip
        self.room -= size

    def _go(self, name: str, position: int, at: int) -> None:
        if position < HEADER.size:
            raise self.file.damaged(f"{name}: begins at byte {position:,}, in the header", at)
        self.file.seek(name, position, at)


class Cursor(Bounded):
    """Bytes of headers, read from begin to end."""

    def __init__(self, file: Bounded, name: str, begin: int, content: bytes) -> None:
        """``begin``: byte of the file where they begin; ``name``: for messages."""
        super().__init__(file.path, io.BytesIO(content), begin + len(content), file.what)
        self.name, self.position = name, begin

    def number(self, field: str, form: str) -> Any:
        """The next number, of a form of `struct`."""
        return struct.unpack(form, self.take(f"{self.name}: {field}", struct.calcsize(form)))[0]

    def text(self, field: str, count: int) -> str:
        """The next letters."""
        return self.take(f"{self.name}: {field}", count).decode("utf-8", "replace")
