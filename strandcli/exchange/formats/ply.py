"""`.ply`: text, or binary of either byte order.

Strands are told by an element ``strand`` with the property ``nsegs`` (segments of each, as hairutil writes it), by an
element ``edge`` that joins successive vertices, or not at all: then all strands have as many points, which
`ReadOptions.stride` tells.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ...errors import UsageError
from ...output.files import write_pieces
from ..bounded import Bounded, opened
from ..files import ReadOptions
from ..ply_file import Element, NumbersOfText, read_header, whole_numbers
from ..ply_file import is_mesh as is_mesh
from ..strands import (
    CHUNK,
    WIDTHS,
    Attribute,
    Offsets,
    Source,
    Strands,
    TimeSample,
    even_offsets,
    offsets,
    without_short,
)
from ..written import edges_of, left_out, records, with_width_each

name = ".ply"
suffixes = (".ply",)

NUMBERS = {"alpha": "transparency", **{name: name for name in WIDTHS}, "thickness": "width"}
"""Properties of a vertex that become attributes of one number."""
MOST_POINTS = 4096
"""Of a strand, as messages propose them."""
XYZ, RGB = ("x", "y", "z"), ("red", "green", "blue")
Columns = dict[str, npt.NDArray[Any]]


def sniff(head: bytes, size: int) -> bool:
    """Whether it begins with a line 'ply'."""
    return head.startswith((b"ply\n", b"ply\r"))


def read(path: Path, options: ReadOptions) -> Strands:
    """The strands of a file."""
    with opened(path, ".ply file", options.lenient) as file:
        order, elements, comments = read_header(file)
        vertex = elements.get("vertex")
        if vertex is None or not set(XYZ) <= vertex.properties.keys():
            raise file.damaged("header: declares no element vertex with x, y and z", 0)
        if elements.get("face", Element("face", 0, 0)).count:
            raise file.fault("element face: this is a mesh, not strands", elements["face"].at)
        begin = file.position
        found = _elements(file, order, elements)
        points = found["vertex"].pop("xyz")
        size = vertex.record(order).itemsize
        file.finite("vertex", points, (lambda row: begin + size * row) if order else (lambda row: begin))
        facts: dict[str, Any] = {"encoding": {"": "text", "<": "binary", ">": "binary, big-endian"}[order]}
        if comments:
            facts["comments"] = comments[:8]
        first = _first(file, vertex, found, options)
        attributes = _attributes(file, found["vertex"], begin)
    unread = [one for one in vertex.properties if one not in {*XYZ, *RGB, *NUMBERS}]
    if unread:
        facts["properties_not_read"] = unread
    return without_short(Strands(first, points, attributes, Source(name, "1.0", facts)))


def _elements(file: Bounded, order: str, elements: dict[str, Element]) -> dict[str, Columns]:
    """Columns of vertices, strands and edges; other elements are passed over."""
    found: dict[str, Columns] = {}
    numbers = NumbersOfText(file)
    for one in () if order else elements.values():
        file.need(f"element {one.name}", one.count, 2 * len(one.columns), one.at)
    for one in elements.values():
        if one.lists and one.count:
            if {"vertex", "strand", "edge"} - found.keys() & elements.keys():
                raise file.fault(f"element {one.name}: lists are not read; leave it out of the file", one.at)
            return found
        columns: Columns = {}
        wanted: dict[str, Any] = {}
        if not one.properties:
            continue
        if order:  # numbers of which there is no byte yet are not made room for
            file.need(f"element {one.name}", one.count, one.record(order).itemsize, one.at)
        if one.name == "vertex":
            columns["xyz"] = np.empty((one.count, 3), np.float32)
            wanted |= {name: columns["xyz"][:, axis] for axis, name in enumerate(XYZ)}
            if set(RGB) <= one.properties.keys():
                whole = all(one.properties[colour] == "u1" for colour in RGB)
                columns["rgb"] = np.empty((one.count, 3), np.uint8 if whole else np.float32)
                wanted |= {name: columns["rgb"][:, axis] for axis, name in enumerate(RGB)}
        for name in NUMBERS.keys() | {"nsegs", "vertex1", "vertex2"}:
            kind = one.properties.get(name, "")
            if kind and (name in NUMBERS or kind[0] in "iu"):
                columns[name] = np.empty(one.count, np.float32 if kind == "f8" else kind)
                wanted[name] = columns[name]
        if order:
            plain = list(one.properties.items()) == [(axis, "f4") for axis in XYZ] and order == "<"
            if plain and one.name == "vertex":
                file.fill(columns["xyz"].reshape(-1).view(np.uint8).data)
            else:
                with np.errstate(over="ignore", invalid="ignore"):
                    file.columns(f"element {one.name}", one.record(order), one.count, wanted)
        else:
            row, places = 0, {name: place for place, name in enumerate(one.properties)}
            for rows in numbers.rows(one):
                for name, values in wanted.items():
                    own, kind = rows[:, places[name]], one.properties[name]
                    with np.errstate(over="ignore"):
                        values[row : row + len(rows)] = own if kind[0] == "f" else whole_numbers(own, kind)
                row += len(rows)
        found[one.name] = columns
    numbers.end()
    file.end()
    return found


def _first(file: Bounded, vertex: Element, found: dict[str, Columns], options: ReadOptions) -> Offsets:
    """Where each strand begins."""
    count = vertex.count
    if "nsegs" in found.get("strand", {}):
        segments = found["strand"].pop("nsegs")
        if segments.size and (segments.min() < 0 or segments.max() > count):
            raise file.damaged(f"strand: one has {segments.min():,} to {segments.max():,} segments", vertex.at)
        first = offsets(segments, 1)
        if first[-1] != count:
            raise file.damaged(f"vertex: {count:,} are declared, the strands have {first[-1]:,} points", vertex.at)
        return first
    edges = found.pop("edge", {})
    if {"vertex1", "vertex2"} <= edges.keys() and edges["vertex1"].size:
        return _joined(file, count, edges["vertex1"], edges["vertex2"])
    stride = options.stride or 0
    if stride < 1 or count % stride:
        divisors = [one for one in range(2, min(count, MOST_POINTS) + 1) if count % one == 0]
        known = ", ".join(map(str, divisors[:40]))
        why = f"{stride} does not divide them" if stride else "the file does not say how many make a strand"
        raise UsageError(
            f"{file.path}: vertices alone, {count:,} of them, and {why}; give it with --stride N"
            + (f" (they divide into strands of {known})" if known else "")
            + ", or to draw it with --set emitter.groom.stride=N"
        )
    return even_offsets(count // stride, stride)


def _joined(file: Bounded, count: int, one: npt.NDArray[Any], other: npt.NDArray[Any]) -> Offsets:
    """Strands of vertices that edges join, each with the one after it."""
    begins = np.ones(count, np.bool_)
    for begin in range(0, one.size, CHUNK):
        ends = [values[begin : begin + CHUNK].astype(np.int64) for values in (one, other)]
        low, high = np.minimum(*ends), np.maximum(*ends)
        if low.min() < 0 or high.max() >= count or (high - low != 1).any():
            raise file.damaged("edge: joins vertices that do not follow each other; such strands are not read")
        begins[high] = False
    found = np.full(np.count_nonzero(begins) + 1, count, np.int64)
    found[:-1] = np.flatnonzero(begins)
    return found


def _attributes(file: Bounded, columns: Columns, begin: int) -> dict[str, Attribute]:
    found = {}
    for column, values in columns.items():
        attribute = "colour" if column == "rgb" else NUMBERS[column]
        if column == "rgb" and not file.lenient:
            file.finite("colour", values, lambda row: begin)
        elif column != "rgb":
            file.finite(column, values, lambda row: begin)
        found[attribute] = Attribute("point", values)
    return found


def write(path: Path, strands: Strands, samples: Iterable[TimeSample] | None = None) -> list[str]:
    """Write a binary file of vertices, strands and edges; with the edges, viewers of meshes show it. Values of strands
    are written at each of their points."""
    strands = with_width_each(strands)
    counts = strands.counts(np.int32)
    kinds: list[tuple[str, str, Any]] = [(axis, "<f4", strands.points[:, i]) for i, axis in enumerate(XYZ)]
    kept = []
    for attribute, names in (("width", ("thickness",)), ("transparency", ("alpha",)), ("colour", RGB)):
        one = strands.attributes.get(attribute)
        if one is None or one.domain == "groom" or one.values.size != len(names) * one.values.shape[0]:
            continue
        kind = "|u1" if one.values.dtype == np.uint8 else "<f4"
        rows = one.values.reshape(-1, len(names))
        if one.domain == "strand":
            rows = np.repeat(rows, strands.counts(), axis=0)
        kinds += [(label, kind, rows[:, i]) for i, label in enumerate(names)]
        kept.append(attribute)
    counts -= 1
    segments = "<u2" if not counts.size or counts.max() <= 65_535 else "<i4"
    words = {"<f4": "float", "|u1": "uchar", "<u2": "ushort", "<i4": "int"}
    columns: list[tuple[str, str, Any]] = [("nsegs", segments, counts)]
    edges = strands.points.shape[0] - strands.count
    header = [
        "ply", "format binary_little_endian 1.0",
        f"element vertex {strands.points.shape[0]}",
        *(f"property {words[kind]} {label}" for label, kind, _ in kinds),
        f"element strand {strands.count}", f"property {words[segments]} nsegs",
        f"element edge {edges}", "property int vertex1", "property int vertex2", "end_header", "",
    ]  # fmt: skip
    write_pieces(path, chain(
        ["\n".join(header).encode()], records(kinds, strands.points.shape[0]), records(columns, strands.count),
        edges_of(strands),
    ))  # fmt: skip
    return left_out(strands, name, kept)
