"""Write Ogawa and what stands in it: groups, data, headers of objects and properties.

The same strands make the same bytes: nothing tells a date or a place. Alembic tells samples that are the same by
digests, which readers compare and do not compute again; theirs are MurmurHash3, these BLAKE2b.
"""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Sequence
from typing import Any, BinaryIO, NamedTuple

import numpy as np
import numpy.typing as npt

from ..written import raw
from . import layout


class Sample(NamedTuple):
    """A sample that was written: its word in a group, and its digest."""

    word: int
    digest: bytes


class Member(NamedTuple):
    """A property or an object that was written: header, word of its group, and digest."""

    header: bytes
    word: int
    digest: bytes


class Kind(NamedTuple):
    """What the numbers of a property are: Alembic's type, numbers an element, metadata."""

    type: str
    extent: int
    metadata: dict[str, str]


class Writer:
    """An archive that is written from its begin to its end."""

    def __init__(self, file: BinaryIO) -> None:
        """Begin a file, which must be empty and seekable."""
        self.file = file
        self.size = file.write(layout.HEADER.pack(layout.MAGIC, 0, layout.VERSION, 0))
        self.indexed: dict[str, int] = {}
        self.times = 1, 0
        """How many samples properties have, and the index of their times."""
        self.samples: dict[tuple[bytes, int], Sample] = {}

    def data(self, *pieces: Any) -> int:
        """Write data; returns their word."""
        size = sum(len(one) for one in pieces)
        if not size:
            return layout.DATA
        found = self.size
        for one in (layout.WORD.pack(size), *pieces):
            self.size += self.file.write(one)
        return found | layout.DATA

    def group(self, words: Sequence[int]) -> int:
        """Write a group of children; returns its word."""
        if not words:
            return 0
        found = self.size
        self.size += self.file.write(layout.WORD.pack(len(words)) + np.array(words, "<u8").tobytes())
        return found

    def sample(self, values: npt.NDArray[Any]) -> Sample:
        """Write numbers, once where they are the same."""
        content = raw(values, values.dtype.newbyteorder("<").str)
        digest = hashlib.blake2b(content, digest_size=layout.DIGEST).digest()
        key = digest, len(content)
        if key not in self.samples:
            self.samples[key] = Sample(self.data(digest, content) if len(content) else layout.DATA, digest)
        return self.samples[key]

    def metadata(self, entries: dict[str, str]) -> tuple[int, bytes]:
        """The index of metadata, and their text where they have none."""
        text = ";".join(f"{key}={entries[key]}" for key in sorted(entries))
        if not text:
            return 0, b""
        if text not in self.indexed:
            if len(text) > layout.LONGEST_INDEXED or len(self.indexed) >= layout.WRITTEN_OUT - 1:
                return layout.WRITTEN_OUT, text.encode()
            self.indexed[text] = len(self.indexed) + 1
        return self.indexed[text], b""

    def still(self, name: str, kind: Kind, values: npt.NDArray[Any], form: int = layout.ARRAY) -> Member:
        """A property that is the same at all times."""
        return self.property(name, form, kind, [self.sample(values)])

    def property(self, name: str, form: int, kind: Kind, samples: Sequence[Sample]) -> Member:
        """A property of arrays or of scalars: ``samples``, one where they are all the same, else as many as there are
        times."""
        count, sampling = self.times
        words = [word for one in samples for word in (one.word, layout.DATA)[: 1 + (form == layout.ARRAY)]]
        info = form | layout.NUMBER[kind.type] << layout.TYPE | layout.SAME_SIZE | kind.extent << layout.EXTENT
        info |= (layout.CONSTANT if len(samples) < 2 else 0) | (layout.SAMPLED if sampling else 0)
        header = self._header(info, name, kind.metadata, count, *([sampling] if sampling else []))
        return Member(header, self.group(words), _digest(header, *(one.digest for one in samples)))

    def compound(self, name: str, metadata: dict[str, str], members: Sequence[Member]) -> Member:
        """A property that holds properties."""
        header = self._header(layout.COMPOUND, name, metadata)
        return Member(header, self.properties(members), _digest(header, *(one.digest for one in members)))

    def _header(self, info: int, name: str, metadata: dict[str, str], *numbers: int) -> bytes:
        """The header of a property, whose numbers have the least width that they fit."""
        index, text = self.metadata(metadata)
        letters = name.encode()
        largest = max(len(letters), len(text), *numbers)
        hint = 0 if largest < 1 << 8 else 1 if largest < 1 << 16 else 2
        width = layout.WIDTHS[hint]
        words = b"".join(struct.pack(width, one) for one in (*numbers, len(letters)))
        info |= hint << layout.HINT | index << layout.INDEX
        return struct.pack("<I", info) + words + letters + self._written_out(index, text, width)

    def properties(self, members: Sequence[Member]) -> int:
        """The group of properties."""
        if not members:
            return 0
        headers = self.data(b"".join(one.header for one in members))
        return self.group([*(one.word for one in members), headers])

    def object(
        self, name: str, schema: str, members: Sequence[Member], children: Sequence[Member], base: str = ""
    ) -> Member:
        """An object of a schema, its properties, and the objects that it holds; ``base``: the schema's base."""
        entries = {"schema": schema, "schemaObjTitle": f"{schema}:{SCHEMAS[schema]}"}
        index, text = self.metadata(entries | ({"schemaBaseType": base} if base else {}))
        letters = name.encode()
        header = struct.pack("<I", len(letters)) + letters + struct.pack("<B", index)
        header += self._written_out(index, text, "<I")
        word = self.objects(members, children)
        return Member(header, word, _digest(header, *(one.digest for one in (*members, *children))))

    def objects(self, members: Sequence[Member], children: Sequence[Member]) -> int:
        """The group of an object."""
        digests = [_digest(*(one.digest for one in some)) if some else bytes(16) for some in (members, children)]
        headers = self.data(*(one.header for one in children), *digests)
        return self.group([self.properties(members), *(one.word for one in children), headers])

    def close(self, top: int, metadata: dict[str, str], samplings: bytes) -> None:
        """End the file: what concerns all of it, and the header."""
        versions = [self.data(struct.pack("<i", one)) for one in (layout.NEWEST_LAYOUT, layout.LIBRARY_WRITTEN)]
        text = ";".join(f"{key}={metadata[key]}" for key in sorted(metadata)).encode()
        indexed = b"".join(struct.pack("<B", len(one)) + one.encode() for one in self.indexed)
        root = self.group([*versions, top, self.data(text), self.data(samplings), self.data(indexed)])
        self.file.seek(0)
        self.file.write(layout.HEADER.pack(layout.MAGIC, layout.CLOSED, layout.VERSION, root))

    def _written_out(self, index: int, text: bytes, width: str) -> bytes:
        return struct.pack(width, len(text)) + text if index == layout.WRITTEN_OUT else b""


SCHEMAS = {layout.CURVES: ".geom", layout.XFORM: ".xform"}
"""Where objects of each schema have it."""


def _digest(*pieces: bytes) -> bytes:
    return hashlib.blake2b(b"".join(pieces), digest_size=layout.DIGEST).digest()


def sampling(count: int, cycle: float, times: Sequence[float]) -> bytes:
    """A time sampling: samples at most, seconds a cycle, and times in it."""
    return struct.pack("<IdI", count, cycle, len(times)) + np.array(times, "<f8").tobytes()
