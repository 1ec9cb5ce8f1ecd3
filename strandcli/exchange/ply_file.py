"""PLY files: the header, which tells how many there are of each element and its properties, and the elements, which are
text or binary of either byte order, with lists or without."""

from __future__ import annotations

import struct
from array import array
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .bounded import SLICE, Bounded, Growing, numbers_of, opened

TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}  # fmt: skip
ENCODINGS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
MOST_LINES = 1000
"""Of a header: Gaussian splats have some 70."""
OF_NUMBER = 16
"""Bytes that a number of a text takes."""
AT_ONCE = 1 << 14
"""Lists that are gathered at once."""
Numbers = npt.NDArray[Any]


@dataclass(slots=True)
class Element:
    """An element: its name, how many there are, the byte that says so, types of its properties by name, those that are
    lists left out; ``columns``: of all properties in their order the name, the type, and of lists the type of their
    length, else None."""

    name: str
    count: int
    at: int
    properties: dict[str, str] = field(default_factory=dict)
    columns: list[tuple[str, str, str | None]] = field(default_factory=list)

    @property
    def lists(self) -> bool:
        """Whether some property is a list."""
        return len(self.columns) > len(self.properties)

    def record(self, order: str) -> np.dtype[Any]:
        """A row in the file, in a byte order."""
        return np.dtype([(name, order + kind) for name, kind in self.properties.items()])


def read_header(file: Bounded) -> tuple[str, dict[str, Element], list[str]]:
    """Byte order ("" for text), elements by name in their order, and comments. Raises `UsageError` for what is none."""
    if file.line("begin", 8).strip() != b"ply":
        raise file.damaged("does not begin with a line 'ply'", 0)
    order: str | None = None
    elements: dict[str, Element] = {}
    comments: list[str] = []
    current: Element | None = None
    for _ in range(MOST_LINES):
        at = file.position
        words = file.line("header").decode("utf-8", "replace").split()
        match words:
            case ["format", encoding, "1.0"] if encoding in ENCODINGS and order is None:
                order = ENCODINGS[encoding]
            case ["element", name, count] if count.isascii() and count.isdigit() and len(count) < 20:
                if name in elements:
                    raise file.damaged(f"element {name}: is there twice", at)
                current = elements[name] = Element(name, int(count), at)
            case ["property", "list", counts, items, name] if {counts, items} <= TYPES.keys() and current is not None:
                current.columns.append((name, TYPES[items], TYPES[counts]))
            case ["property", kind, name] if kind in TYPES and current is not None and name not in current.properties:
                current.properties[name] = TYPES[kind]
                current.columns.append((name, TYPES[kind], None))
            case ["comment" | "obj_info", *text]:
                comments.append(" ".join(text))
            case ["end_header"] if order is not None:
                return order, elements, comments
            case _:
                raise file.damaged(f"header: '{' '.join(words)[:60]}' means nothing there", at)
    raise file.damaged(f"header: does not end within {MOST_LINES:,} lines")


def is_mesh(path: Path) -> bool:
    """Whether a file has polygons."""
    with opened(path, ".ply file") as file:
        _, elements, _ = read_header(file)
    return "face" in elements and elements["face"].count > 0


@dataclass(frozen=True, slots=True)
class Rows:
    """Rows of an element: of each property by name its items, one after the other, and of lists how many each row
    has."""

    count: int
    items: Mapping[str, Numbers]
    lengths: Mapping[str, npt.NDArray[np.integer[Any]]]

    def columns(self, names: tuple[str, ...], kind: npt.DTypeLike | None = None) -> Numbers:
        """Numbers (n, k) of so many properties, in a type, or in one that holds them all."""
        kind = np.result_type(*(self.items[name].dtype for name in names)) if kind is None else kind
        found = np.empty((self.count, len(names)), kind)
        with np.errstate(over="ignore", invalid="ignore"):
            for k, name in enumerate(names):
                found[:, k] = self.items[name]
        return found


def read_elements(
    file: Bounded, order: str, elements: Mapping[str, Element], wanted: frozenset[str] = frozenset()
) -> dict[str, Rows]:
    """The elements of a file, which follow its header; up to the last one that is ``wanted``, or all, after which
    nothing may follow. Raises `UsageError` for what does not fit the header."""
    found: dict[str, Rows] = {}
    for one in () if order else elements.values():
        file.need(f"element {one.name}", one.count, 2 * len(one.columns), one.at)
    numbers = np.zeros(0) if order else _numbers(file)
    for one in (element for element in elements.values() if element.columns):
        if order:
            least = sum(np.dtype(counts or kind).itemsize for _, kind, counts in one.columns)
            file.need(f"element {one.name}", one.count, least, one.at)
            found[one.name] = _lists(file, one, order) if one.lists else _records(file, one, order)
        else:
            found[one.name], end = _of_text(file, one, numbers)
            numbers = numbers[end:]
        if wanted and found.keys() >= wanted:
            return found
    if numbers.size:
        raise file.damaged("more numbers than the header declares")
    file.end()
    return found


def _records(file: Bounded, element: Element, order: str) -> Rows:
    """Rows without lists of a binary file."""
    kind = element.record(order)
    record = np.frombuffer(file.take(f"element {element.name}", element.count * kind.itemsize), kind)
    return Rows(element.count, {name: record[name] for name in element.properties}, {})


def _lists(file: Bounded, element: Element, order: str) -> Rows:
    """Rows with lists of a binary file."""
    begin = file.position
    data = np.frombuffer(file.take(f"element {element.name}", file.left), np.uint8)
    sizes = [(np.dtype(kind).itemsize, np.dtype(of).itemsize if of else 0) for _, kind, of in element.columns]
    readers = [struct.Struct((order or "<") + np.dtype(length or "u1").char) for _, _, length in element.columns]

    def length_at(column: int, at: int) -> int:
        return int(readers[column].unpack_from(data.data, at)[0])

    file.room(f"element {element.name}: lengths of its lists", element.count * len(sizes), 16)
    begins, lengths, size = _walk(data, sizes, element.count, length_at)
    if len(lengths[0]) < element.count:
        row = len(lengths[-1])
        raise file.damaged(f"element {element.name}: row {row:,} goes beyond the end of the file", begin)
    file.seek(element.name, begin + size)
    items = {}
    for k, (name, kind, _) in enumerate(element.columns):
        each = np.dtype(kind).itemsize
        every = np.ndarray((max(len(data) - each + 1, 0),), order + kind, data, strides=(1,))
        items[name] = _gathered(every, begins[k], lengths[k], each)
    lists = {name: lengths[k] for k, (name, _, length) in enumerate(element.columns) if length}
    return Rows(element.count, items, lists)


def _walk(
    data: Numbers, sizes: list[tuple[int, int]], count: int, length_at: Callable[[int, int], int]
) -> tuple[list[Numbers], list[Numbers], int]:
    """Where the items of each property of rows begin, how many there are, and where the rows end; of fewer rows where
    they do not fit. ``sizes``: of each property what an item takes, and the length of a list, 0 where it is none."""
    begins, lengths, size = _one_by_one(data.size, sizes, min(count, 1), length_at)
    whole = min(count, data.size // max(size, 1))
    rows = data[: whole * size].reshape(whole, size)
    heads = [slice(int(one[0]) - wide, int(one[0])) for one, (_, wide) in zip(begins, sizes, strict=True) if len(one)]
    if size and all((rows[:, head] == rows[0, head]).all() for head in heads):  # rows are alike
        every = size * np.arange(whole)
        return [one[0] + every for one in begins], [np.repeat(one, whole) for one in lengths], whole * size
    return _one_by_one(data.size, sizes, count, length_at)


def _one_by_one(
    end: int, sizes: list[tuple[int, int]], count: int, length_at: Callable[[int, int], int]
) -> tuple[list[Numbers], list[Numbers], int]:
    """`_walk` of rows of any lengths, in data that end there."""
    begins, lengths = ([array("q") for _ in sizes] for _ in range(2))
    at = done = 0
    for _ in range(count):
        place = at
        for k, (size, of_length) in enumerate(sizes):
            many = 1
            if of_length:
                many = length_at(k, place) if place + of_length <= end else -1
                place += of_length
            if many < 0 or place + many * size > end:
                place = -1
                break
            begins[k].append(place)
            lengths[k].append(many)
            place += many * size
        if place < 0:
            break
        at, done = place, done + 1
    found = [[np.frombuffer(one, np.int64)[:done] for one in some] for some in (begins, lengths)]
    return found[0], found[1], at


def _gathered(values: Numbers, begins: Numbers, lengths: Numbers, step: int) -> Numbers:
    """Items (n,) of runs, one after the other: so many each, that begin there among ``values``, a step apart."""
    first = np.concatenate([[0], np.cumsum(lengths)])
    found = np.empty(int(first[-1]), values.dtype)
    for begin in range(0, len(begins), AT_ONCE):
        some = slice(begin, begin + AT_ONCE)
        low, high = int(first[begin]), int(first[min(begin + AT_ONCE, len(begins))])
        places = np.repeat(begins[some] - step * first[:-1][some], lengths[some]) + step * np.arange(low, high)
        found[low:high] = values[places]
    return found


def _numbers(file: Bounded) -> Numbers:
    """All numbers of a text. Raises `UsageError` for what is no number."""
    found, begin = Growing(np.float64), file.position
    for text in file.blocks("a number", SLICE, SLICE, lambda text: max(text.rfind(b"\n"), text.rfind(b" ")) + 1):
        numbers = numbers_of(text)
        if numbers is None:
            raise file.damaged("has more than numbers, unlike its header", begin)
        found.add(numbers)
        begin += len(text)
        file.room("numbers", found.size, OF_NUMBER)
    return found.taken()


def _of_text(file: Bounded, element: Element, values: Numbers) -> tuple[Rows, int]:
    """The rows of an element with which the numbers of a text begin, and how many of these they have."""
    width = len(element.columns)
    count = min(element.count, values.size // width)
    if element.lists:
        begins, lengths, end = _walk(
            values, [(1, int(length is not None)) for _, _, length in element.columns], count,
            lambda column, at: int(values[at]) if 0 <= values[at] <= values.size else -1,
        )  # fmt: skip
        count = len(lengths[0])
        columns = [_gathered(values, *one, 1) for one in zip(begins, lengths, strict=True)]
    else:
        lengths, end = [], count * width
        columns = list(values[:end].reshape(count, width).T)
    if count < element.count:
        raise file.damaged(f"element {element.name}: row {count:,} goes beyond the end of the file", element.at)
    items = {}
    for (name, kind, _), own in zip(element.columns, columns, strict=True):
        if kind[0] != "f":
            if not np.isfinite(own).all():
                raise file.damaged(f"element {element.name}: {name} is not a number everywhere", element.at)
            own = np.clip(own, np.iinfo(kind).min, np.iinfo(kind).max).astype(kind)
        items[name] = own
    lists = {name: lengths[k] for k, (name, _, length) in enumerate(element.columns) if length}
    return Rows(element.count, items, lists), end
