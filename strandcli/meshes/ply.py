"""`.ply` with faces: text, or binary of either byte order; any polygons, every number of a vertex as an attribute."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..exchange.bounded import Bounded, Growing, opened
from ..exchange.ply_file import Element, NumbersOfText, read_header, whole_numbers
from .beside import Beside
from .kernels.lists import gather, walk, walk_text
from .make import RawMesh
from .mesh import fans_of_lists, linear

Numbers = npt.NDArray[Any]
FACES = ("vertex_indices", "vertex_index")
UV = (("u", "v"), ("s", "t"), ("texture_u", "texture_v"))
XYZ, NORMAL, RGB = ("x", "y", "z"), ("nx", "ny", "nz"), ("red", "green", "blue")
TEXTURE = "texturefile"
LONGEST_ROW = 4096
"""Bytes of a row of lists, at most, to be read with others at once."""
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
    """Rows with lists: at once where all are as long as those of the first row, else one by one."""
    begin = file.position
    data = np.frombuffer(file.take(f"element {element.name}", file.left), np.uint8)
    layout, big = _layout(element), order == ">"
    begins, lengths = (np.empty((min(element.count, 1), len(layout)), np.int64) for _ in range(2))
    size = int(walk(data, layout, big, begins, lengths))
    if 0 < size <= min(LONGEST_ROW, data.size // max(element.count, 1)):
        rows = data[: element.count * size].view(_record(element, order, lengths[0]))
        if all((rows[f"length {k}"] == lengths[0, k]).all() for k, one in enumerate(element.columns) if one[2]):
            file.seek(element.name, begin + element.count * size)
            whole = {name: rows[str(k)].reshape(-1) for k, (name, _, _) in enumerate(element.columns)}
            return _rows(element, whole, np.broadcast_to(lengths, (element.count, len(layout))))
    file.room(f"element {element.name}: lengths of its lists", element.count * len(layout), 16)
    begins, lengths = (np.empty((element.count, len(layout)), np.int64) for _ in range(2))
    size = int(walk(data, layout, big, begins, lengths))
    if size < 0:
        raise file.damaged(f"element {element.name}: row {-1 - size:,} goes beyond the end of the file", begin)
    file.seek(element.name, begin + size)
    items = {}
    for k, (name, kind, _) in enumerate(element.columns):
        values = np.empty(int(lengths[:, k].sum()), order + kind)
        gather(data, begins[:, k], lengths[:, k], values.itemsize, values.view(np.uint8))
        items[name] = values
    return _rows(element, items, lengths)


def _record(element: Element, order: str, lengths: npt.NDArray[np.int64]) -> np.dtype[Any]:
    """A row whose lists are so long."""
    fields: list[Any] = []
    for k, (_, kind, length) in enumerate(element.columns):
        if length:
            fields.append((f"length {k}", order + length))
        fields.append((str(k), order + kind, (int(lengths[k]),)))
    return np.dtype(fields)


def _rows(element: Element, items: Mapping[str, Numbers], lengths: npt.NDArray[np.int64]) -> Rows:
    """Rows of these items; lengths: (rows, properties)."""
    lists = {name: lengths[:, k] for k, (name, _, length) in enumerate(element.columns) if length}
    return Rows(element.count, items, lists)


def _layout(element: Element) -> npt.NDArray[np.int64]:
    return np.array([
        (np.dtype(kind).itemsize, np.dtype(length).itemsize if length else 0, length is not None and length[0] == "i")
        for _, kind, length in element.columns
    ], np.int64)  # fmt: skip


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
    layout, width, done = _layout(element), len(element.columns), 0
    items = [Growing(np.float64 if kind[0] == "f" else kind) for _, kind, _ in element.columns]
    counts = [Growing(np.int32) for _ in element.columns]
    while done < element.count:
        shape = min(element.count - done, numbers.waiting.size // width), width
        begins, lengths = np.empty(shape, np.int64), np.empty(shape, np.int64)
        size = int(walk_text(numbers.waiting, layout, begins, lengths))
        rows = shape[0] if size >= 0 else -1 - size
        for k, (name, kind, length) in enumerate(element.columns):
            values = np.empty(int(lengths[:rows, k].sum()))
            gather(numbers.waiting, begins[:rows, k], lengths[:rows, k], 1, values)
            numbers.check(element, name, kind, values)
            items[k].add(values if kind[0] == "f" else whole_numbers(values, kind))
            if length:
                counts[k].add(lengths[:rows, k])
        if rows:
            numbers.waiting = numbers.waiting[int(begins[rows - 1, -1] + lengths[rows - 1, -1]) :]
        done += rows
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
