"""Archives of Alembic written and read from the description of their layout alone, as nested groups and data."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

Entry = tuple[bytes, int]
"""Of an object or a property: its header, and the word of its group."""
DATA = 2**63
POD = {"|b1": 0, "|u1": 1, "|i1": 2, "<i4": 6, "<u4": 5, "<i8": 8, "<f2": 9, "<f4": 10, "<f8": 11}
CURVES = "schema=AbcGeom_Curve_v2;schemaBaseType=AbcGeom_GeomBase_v1;schemaObjTitle=AbcGeom_Curve_v2:.geom"
XFORM = "schema=AbcGeom_Xform_v3;schemaObjTitle=AbcGeom_Xform_v3:.xform"
EVERY_SECOND = struct.pack("<IdId", 1, 1.0, 1, 0.0)
"""The first time sampling."""


FROM_BLENDER = Path(__file__).parent / "exchange" / "from_blender.abc"
"""What `test_blender.export` made."""


def rows_from_blender(counts: Any) -> list[int]:
    """The rows of its 16 points, those of object a first: Blender writes objects in any order."""
    return [*range(4, 16), *range(4)] if counts[0] == 2 else list(range(16))


class Builder:
    """An archive that grows; metadata stand in the headers."""

    def __init__(self) -> None:
        self.content = bytearray(b"Ogawa\xff\0\1" + bytes(8))

    def data(self, content: bytes) -> int:
        """Data, and their word."""
        word = len(self.content) | DATA if content else DATA
        self.content += struct.pack("<Q", len(content)) + content if content else b""
        return word

    def group(self, *words: int) -> int:
        """A group, and its word."""
        word = len(self.content) if words else 0
        self.content += struct.pack(f"<{len(words) + 1}Q", len(words), *words) if words else b""
        return word

    def sample(self, values: Any) -> int:
        """A sample's data."""
        content = np.ascontiguousarray(values).tobytes()
        return self.data(bytes(16) + content if content else b"")

    def array(self, name: str, *samples: Any, meta: str = "", sampling: int = 0, width: int = 0, scalar: bool = False,
              changes: tuple[int, int] | None = None, count: int = 0) -> Entry:  # fmt: skip
        """A property: of each sample an array; ``width`` of its header's numbers; ``changes``: first and last sample
        that is not the one before, of ``count``."""
        values = [np.asarray(one) for one in samples]
        form = "<" + "BHI"[width]
        extent = values[0].shape[1] if values[0].ndim > 1 else 1
        info = (1 if scalar else 2) | width << 2 | POD[values[0].dtype.str] << 4 | extent << 12 | 0xFF << 20
        info |= 0x100 * bool(sampling) | 0x200 * bool(changes) | 0x800 * (len(values) == 1)
        numbers = [count or len(values), *(changes or ()), *([sampling] if sampling else [])]
        header = struct.pack("<I", info) + b"".join(struct.pack(form, one) for one in numbers)
        header += b"".join(struct.pack(form, len(one)) + one.encode() for one in (name, meta))
        words = [self.sample(one) for one in values]
        return header, self.group(*(word for one in words for word in ([one] if scalar else [one, DATA])))

    def compound(self, name: str, members: Sequence[Entry], meta: str = "") -> Entry:
        """A property that holds others."""
        text = b"".join(struct.pack("<H", len(one)) + one.encode() for one in (name, meta))
        return struct.pack("<I", 0xFF << 20 | 1 << 2) + text, self.members(members)

    def members(self, members: Sequence[Entry]) -> int:
        """A group of properties."""
        return self.group(*(word for _, word in members), self.data(b"".join(one for one, _ in members)))

    def object(self, name: str, meta: str, members: Sequence[Entry] = (), children: Sequence[Entry] = ()) -> Entry:
        """An object, its properties, and those that it holds."""
        letters = name.encode()
        header = struct.pack("<I", len(letters)) + letters + struct.pack("<BI", 255, len(meta)) + meta.encode()
        headers = self.data(b"".join(one for one, _ in children) + bytes(32))
        return header, self.group(self.members(members), *(word for _, word in children), headers)

    def curves(self, name: str, points: Any, counts: Any, more: Sequence[Entry] = ()) -> Entry:
        """An object of curves."""
        told = [self.array("P", points), self.array("nVertices", np.asarray(counts, "<i4")), *more]
        return self.object(name, CURVES, [self.compound(".geom", told)])

    def xform(self, name: str, codes: Sequence[int], values: Any, children: Sequence[Entry], *, inherits: bool = True,
              sampling: int = 0) -> Entry:  # fmt: skip
        """A transform of operations, of which ``values`` (samples, numbers) are the numbers."""
        told = [
            self.array(".inherits", np.array([inherits]), scalar=True),
            self.array(".ops", np.array([codes], "u1") << 4, scalar=True),
            self.array(".vals", *(np.asarray([one], "<f8") for one in values), scalar=True, sampling=sampling),
        ]
        return self.object(name, XFORM, [self.compound(".xform", told)], children)

    def finish(self, *objects: Entry, samplings: bytes = EVERY_SECOND) -> bytes:
        """The archive."""
        top = self.object("", "", (), objects)[1]
        versions = [self.data(struct.pack("<i", one)) for one in (0, 10_709)]
        root = self.group(*versions, top, self.data(b"_ai_Application=made up"), self.data(samplings), DATA)
        self.content[8:16] = struct.pack("<Q", root)
        return bytes(self.content)


def archive(strands: Sequence[Any]) -> bytes:
    """An archive of strands alone."""
    made = Builder()
    points = np.concatenate([*strands, np.zeros((0, 3))]).astype("<f4")
    return made.finish(made.curves("hair", points, [len(one) for one in strands]))


class Told(NamedTuple):
    """A property as `tree` finds it: bits of its header, number of samples, metadata, and what each stored sample has
    behind its digest."""

    info: int
    samples: int
    metadata: str
    stored: list[bytes]


class Tree:
    """All that is in an archive: objects' metadata and properties by path. Every byte is told by one group or data."""

    def __init__(self, content: bytes) -> None:
        self.content, self.spans = content, {(0, 16)}
        self.objects: dict[str, str] = {}
        self.properties: dict[str, Told] = {}
        assert content[:8] == b"Ogawa\xff\0\1"
        versions, library, top, metadata, samplings, indexed = self.group(self.number("<Q", 8))
        assert self.data(versions) == bytes(4)
        assert struct.unpack("<i", self.data(library))[0] >= 9999
        self.metadata = self.data(metadata).decode()
        self.samplings = self.data(samplings)
        self.indexed, rest = [""], self.data(indexed)
        while rest:
            self.indexed.append(rest[1 : 1 + rest[0]].decode())
            rest = rest[1 + rest[0] :]
        self.object("", top)

    def number(self, form: str, at: int) -> Any:
        return struct.unpack_from(form, self.content, at)[0]

    def group(self, word: int) -> tuple[int, ...]:
        assert word < DATA
        if not word:
            return ()
        count = self.number("<Q", word)
        self.spans.add((word, word + 8 + 8 * count))
        return struct.unpack_from(f"<{count}Q", self.content, word + 8)

    def data(self, word: int) -> bytes:
        assert word >= DATA
        at = word - DATA
        if not at:
            return b""
        size = self.number("<Q", at)
        self.spans.add((at, at + 8 + size))
        return self.content[at + 8 : at + 8 + size]

    def object(self, path: str, word: int) -> None:
        properties, *children, headers = self.group(word)
        self.compound(path, properties)
        rest = self.data(headers)[:-32]
        for child in children:
            size = struct.unpack_from("<I", rest)[0]
            name = f"{path}/{rest[4 : 4 + size].decode()}"
            self.objects[name] = self.indexed[rest[4 + size]]
            rest = rest[5 + size :]
            self.object(name, child)
        assert not rest

    def compound(self, path: str, word: int) -> None:
        *children, headers = self.group(word) or (DATA,)
        rest = self.data(headers)
        for child in children:
            info, form = struct.unpack_from("<I", rest)[0], "<" + "BHI"[rest[0] >> 2 & 3]
            told = 0 if not info & 3 else 1 + bool(info & 0x100) + 2 * bool(info & 0x200)
            step = struct.calcsize(form)
            numbers = [struct.unpack_from(form, rest, 4 + step * place)[0] for place in range(told + 1)]
            rest = rest[4 + step * (told + 1) :]
            name, rest = f"{path}/{rest[: numbers[-1]].decode()}", rest[numbers[-1] :]
            if info & 3:
                words = self.group(child)
                samples = [self.data(one)[16:] for one in (words if info & 3 == 1 else words[::2])]
                self.properties[name] = Told(info, numbers[0], self.indexed[info >> 20], samples)
            else:
                self.properties[name] = Told(info, 0, self.indexed[info >> 20], [])
                self.compound(name, child)
        assert not rest

    def whole(self) -> bool:
        """Whether groups and data cover the file, each byte once."""
        at = 0
        for begin, end in sorted(self.spans):
            if begin != at:
                return False
            at = end
        return at == len(self.content)


def rich(strands: Sequence[Any]) -> bytes:
    """An archive of two objects of the same strands: one is held by a transform that moves, one moves itself; with
    attributes, some by index."""
    made = Builder()
    points, counts = np.concatenate(strands).astype("<f4"), np.array([len(one) for one in strands], "<i4")
    rows = np.arange(len(strands), dtype="<u4")
    indexed = [made.array(".vals", np.ones((len(strands), 2), "<f4")), made.array(".indices", rows[::-1])]
    added = [made.array("id", rows, meta="geoScope=uni"), made.array("colour", points, meta="geoScope=vtx", width=2)]
    more = [
        made.array("width", points[:, 0], meta="geoScope=vtx"), made.compound("uv", indexed, "geoScope=uni"),
        made.array("N", points, meta="geoScope=vtx"), made.compound(".arbGeomParams", added),
        made.array("curveBasisAndType", np.array([[1, 0, 0, 0]], "u1"), scalar=True),
    ]  # fmt: skip
    held = made.xform("a", [1, 6, 3], [[1, 2, 3, 90, *np.eye(4).reshape(-1)], [4, 5, 6, 30, *np.eye(4).reshape(-1)]],
                      [made.curves("b", points, counts, more)], sampling=1)  # fmt: skip
    told = [made.array("P", points, points + 1, points + 2, sampling=2), made.array("nVertices", counts)]
    samplings = EVERY_SECOND + struct.pack("<IdId", 2, 0.5, 1, 1.0)
    samplings += struct.pack("<IdI3d", 3, np.finfo(float).max / 32, 3, 0.25, 0.5, 1.5)
    return made.finish(held, made.object("c", CURVES, [made.compound(".geom", [*told, *more])]), samplings=samplings)
