"""Ogawa, the container of Alembic: groups, whose children are groups or data, told by the byte where they begin.

Nothing is believed: every byte lies in the file, and what is read in all is bounded, since children may be shared.
"""

from __future__ import annotations

import struct
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...errors import UsageError
from ..bounded import Bounded, amount
from . import layout

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
        magic, closed, version, root = layout.HEADER.unpack(file.take("header", layout.HEADER.size))
        if magic != layout.MAGIC:
            if magic.startswith(b"\x89HDF"):
                raise UsageError(
                    f"{file.path}: is an Alembic file of the HDF5 back end; convert it with abcconvert -toOgawa"
                )
            raise file.damaged("does not begin with Ogawa", 0)
        if closed != layout.CLOSED:
            raise file.fault("header: the program that wrote it did not finish; export it again", 5)
        if version != layout.VERSION:
            raise file.fault(f"header: version {version:#06x} of Ogawa is not known", 6)
        self.root = Child(root, 8, "archive")

    def group(self, child: Child) -> Group:
        """A child that is a group."""
        if child.word & layout.DATA:
            raise self.file.damaged(f"{child.name}: data where a group should be", child.at)
        if not child.word:
            return Group(0, 0)
        self._go(child.name, child.word, child.at)
        count = layout.WORD.unpack(self.file.take(child.name, layout.WORD.size))[0]
        self.file.need(child.name, count, layout.WORD.size, child.word)
        return Group(child.word + layout.WORD.size, count)

    def child(self, group: Group, index: int, name: str) -> Child:
        """A child of a group. Raises `UsageError` where there are fewer."""
        if not 0 <= index < group.size:
            raise self.file.damaged(f"{name}: child {index:,} of {group.size:,} is asked for", group.begin)
        at = group.begin + layout.WORD.size * index
        self.file.seek(name, at)
        return Child(layout.WORD.unpack(self.file.take(name, layout.WORD.size))[0], at, name)

    def data(self, child: Child) -> Data:
        """A child that is data."""
        if not child.word & layout.DATA:
            raise self.file.damaged(f"{child.name}: a group where data should be", child.at)
        position = child.word - layout.DATA
        if not position:
            return Data(child.at, 0)
        self._go(child.name, position, child.at)
        size = layout.WORD.unpack(self.file.take(child.name, layout.WORD.size))[0]
        self.file.need(child.name, size, 1, position)
        return Data(position + layout.WORD.size, size)

    def headers(self, child: Child) -> Cursor:
        """The bytes of a child that describes others."""
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
        size = data.size - layout.DIGEST
        if size < 0 or size % each:
            raise self.file.damaged(f"{name}: {amount(size)} are no whole number of {each} bytes each", data.begin)
        self.spend(name, size, data.begin)
        self.file.seek(name, data.begin + layout.DIGEST)
        return self.file.array(name, dtype, (size // each, extent), data.begin)

    def spend(self, name: str, size: int, at: int) -> None:
        """Count bytes that are about to be taken. Raises `UsageError` where they are too many for the file's size."""
        if size > self.room:
            raise self.file.fault(f"{name}: parts that are shared make more than is believed of a file of "
                                  f"{amount(self.file.size)}", at)  # fmt: skip
        self.room -= size

    def _go(self, name: str, position: int, at: int) -> None:
        if position < layout.HEADER.size:
            raise self.file.damaged(f"{name}: begins at byte {position:,}, in the header", at)
        self.file.seek(name, position, at)


class Cursor:
    """Bytes of headers, read from begin to end."""

    def __init__(self, file: Bounded, name: str, begin: int, content: bytes) -> None:
        """``begin``: byte of the file where they begin; ``name``: for messages."""
        self.file, self.name, self.begin, self.content = file, name, begin, content
        self.position = 0

    @property
    def left(self) -> int:
        """Bytes that were not read yet."""
        return len(self.content) - self.position

    @property
    def at(self) -> int:
        """Byte of the file that comes next."""
        return self.begin + self.position

    def take(self, field: str, count: int) -> bytes:
        """The next bytes."""
        if count > self.left:
            raise self.file.damaged(
                f"{self.name}: {field}: needs {amount(count)}, the headers hold {amount(self.left)} there", self.at
            )
        self.position += count
        return self.content[self.position - count : self.position]

    def number(self, field: str, form: str) -> Any:
        """The next number, of a form of `struct`."""
        return struct.unpack(form, self.take(field, struct.calcsize(form)))[0]

    def text(self, field: str, count: int) -> str:
        """The next letters."""
        return self.take(field, count).decode("utf-8", "replace")
