"""`.ply` with faces: text, or binary of either byte order; any polygons, every number of a vertex as an attribute."""

from __future__ import annotations

import struct
from array import array
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..exchange.beside import Beside
from ..exchange.bounded import Bounded, Growing, opened
from ..exchange.ply_file import Element, NumbersOfText, read_header, whole_numbers
from .make import RawMesh
from .mesh import SLICE, fans_of_lists, linear

Numbers = npt.NDArray[Any]
FACES = ("vertex_indices", "vertex_index")
UV = (("u", "v"), ("s", "t"), ("texture_u", "texture_v"))
XYZ, NORMAL, RGB = ("x", "y", "z"), ("nx", "ny", "nz"), ("red", "green", "blue")
TEXTURE = "texturefile"
OF_NUMBER = 14
"""Bytes that a number of a text takes."""


@dataclass(frozen=True, slots=True)
class Rows:
    """Rows of an element: of each property by name its items, one after the other, and of lists how many each row
    has."""

    count: int
    items: Mapping[str, Numbers]
    lengths: Mapping[str, npt.NDArray[np.integer[Any]]]


def read_ply(path: Path, beside: Beside) -> list[RawMesh]:
    """What a file holds. Raises `UsageError`."""
    with opened(path, ".ply mesh") as file:
        order, elements, comments = read_header(file)
        vertex, face = elements.get("vertex"), elements.get("face")
        if vertex is None or not set(XYZ) <= vertex.properties.keys() or vertex.lists:
            raise file.damaged("header: declares no element vertex with x, y and z", 0)
        if face is None or not face.count:
            raise file.fault("header: declares no element face; a surface is needed, not points or strands", vertex.at)
        if not any(name in FACES and counts and kind[0] != "f" for name, kind, counts in face.columns):
            raise file.fault("element face: has no list vertex_indices", face.at)
        found = _binary(file, elements, order) if order else _text(file, elements)
    names = [line.split(None, 1)[1] for line in comments if line.lower().startswith(TEXTURE + " ")]
    return [_mesh(found["vertex"], found["face"], beside.picture(names[0]) if names else None)]


def _binary(file: Bounded, elements: dict[str, Element], order: str) -> dict[str, Rows]:
    """The elements of a binary file, up to the last one that is wanted."""
    found: dict[str, Rows] = {}
    for one in elements.values():
        if not one.columns:
            continue
        least = sum(np.dtype(counts or kind).itemsize for _, kind, counts in one.columns)
        file.need(f"element {one.name}", one.count, least, one.at)
        if one.lists:
            found[one.name] = _lists(file, one, order)
        else:
            record = np.frombuffer(file.take(f"element {one.name}", one.count * least), one.record(order))
            found[one.name] = Rows(one.count, {name: record[name] for name in one.properties}, {})
        if found.keys() >= {"vertex", "face"}:
            break
    return found


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
    for begin in range(0, len(begins), SLICE):
        some = slice(begin, begin + SLICE)
        low, high = int(first[begin]), int(first[min(begin + SLICE, len(begins))])
        places = np.repeat(begins[some] - step * first[:-1][some], lengths[some]) + step * np.arange(low, high)
        found[low:high] = values[places]
    return found


def _text(file: Bounded, elements: dict[str, Element]) -> dict[str, Rows]:
    """The elements of a text."""
    for one in elements.values():
        file.need(f"element {one.name}", one.count, 2 * len(one.columns), one.at)
    numbers = NumbersOfText(file)
    found: dict[str, Rows] = {}
    for one in elements.values():
        if one.columns:
            found[one.name] = _text_rows(file, one, numbers)
        if found.keys() >= {"vertex", "face"}:
            break
    return found


def _text_rows(file: Bounded, element: Element, numbers: NumbersOfText) -> Rows:
    """The rows of an element, some at once."""
    width, done = len(element.columns), 0
    sizes = [(1, int(length is not None)) for _, _, length in element.columns]
    items = [Growing(np.float64 if kind[0] == "f" else kind) for _, kind, _ in element.columns]
    counts = [Growing(np.int32) for _ in element.columns]
    while done < element.count:
        values = numbers.waiting

        def length_at(column: int, at: int, values: Numbers = values) -> int:
            return int(values[at]) if 0 <= values[at] <= values.size else -1

        most = min(element.count - done, values.size // width)
        begins, lengths, end = _walk(values, sizes, most, length_at)
        for k, (name, kind, length) in enumerate(element.columns):
            own = _gathered(values, begins[k], lengths[k], 1)
            numbers.check(element, name, kind, own)
            items[k].add(own if kind[0] == "f" else whole_numbers(own, kind))
            if length:
                counts[k].add(lengths[k])
        numbers.waiting, done = values[end:], done + len(lengths[0])
        if done < element.count and not numbers.more():
            raise numbers.ended(element, done)
        file.room("numbers", sum(one.size for one in items), OF_NUMBER)
    lists = {name: counts[k].taken() for k, (name, _, length) in enumerate(element.columns) if length}
    return Rows(element.count, {name: items[k].taken() for k, (name, _, _) in enumerate(element.columns)}, lists)


def _mesh(vertex: Rows, face: Rows, texture: npt.NDArray[np.uint8] | None) -> RawMesh:
    """Vertices and faces as a mesh."""
    name = next(name for name in FACES if name in face.lengths)
    lengths = face.lengths[name]
    triangles = fans_of_lists(lengths, face.items[name])
    uv = None
    of_vertex = next((names for names in UV if set(names) <= vertex.items.keys()), None)
    of_corner = face.lengths.get("texcoord")
    if of_corner is not None and np.array_equal(of_corner, 2 * lengths):
        uv = fans_of_lists(lengths, face.items["texcoord"].reshape(-1, 2))
    elif of_vertex is not None and not ((triangles < 0) | (triangles >= vertex.count)).any():
        uv = _columns(vertex, of_vertex)[triangles]
    known = {*XYZ, *NORMAL, *RGB, "alpha", *(of_vertex or ())}
    return RawMesh(
        _columns(vertex, XYZ), triangles, _columns(vertex, NORMAL) if set(NORMAL) <= vertex.items.keys() else None, uv,
        linear(np.stack([vertex.items[one] for one in RGB], axis=1)) if set(RGB) <= vertex.items.keys() else None,
        {name.lower(): one.astype(np.float32) for name, one in vertex.items.items() if name not in known},
        texture,
    )  # fmt: skip


def _columns(rows: Rows, names: tuple[str, ...]) -> Numbers:
    """Numbers (n, k) of so many properties, in a type that holds them all."""
    found = np.empty((rows.count, len(names)), np.result_type(*(rows.items[name].dtype for name in names)))
    for k, name in enumerate(names):
        found[:, k] = rows.items[name]
    return found
