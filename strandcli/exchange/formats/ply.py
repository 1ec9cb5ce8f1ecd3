"""`.ply`: text, or binary of either byte order.

Strands are given by an element ``strand`` with the property ``nsegs`` (segments of each, as hairutil writes it), by an
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
from ..ply_file import Element, Rows, read_elements, read_header
from ..ply_file import is_mesh as is_mesh
from ..strands import (
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
        found = read_elements(file, order, elements)
        points = found["vertex"].columns(XYZ, np.float32)
        size = vertex.record(order).itemsize
        file.finite("vertex", points, (lambda row: begin + size * row) if order else (lambda row: begin))
        facts: dict[str, Any] = {"encoding": {"": "text", "<": "binary", ">": "binary, big-endian"}[order]}
        if comments:
            facts["comments"] = comments[:8]
        attributes = _attributes(file, found.pop("vertex"), begin)
        first = _first(file, vertex, found, options)
    unread = [one for one in vertex.properties if one not in {*XYZ, *RGB, *NUMBERS}]
    if unread:
        facts["properties_not_read"] = unread
    return without_short(Strands(first, points, attributes, Source(name, "1.0", facts)))


def _first(file: Bounded, vertex: Element, found: dict[str, Rows], options: ReadOptions) -> Offsets:
    """Where each strand begins."""
    count = vertex.count
    strand, edge = found.get("strand"), found.get("edge")
    if strand is not None and _are_whole(strand, "nsegs"):
        segments = strand.items["nsegs"]
        if segments.size and (segments.min() < 0 or segments.max() > count):
            raise file.damaged(f"strand: one has {segments.min():,} to {segments.max():,} segments", vertex.at)
        first = offsets(segments, 1)
        if first[-1] != count:
            raise file.damaged(f"vertex: {count:,} are declared, the strands have {first[-1]:,} points", vertex.at)
        return first
    if edge is not None and edge.count and _are_whole(edge, "vertex1", "vertex2"):
        return _joined(file, count, edge.items["vertex1"], edge.items["vertex2"])
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
    low, high = np.minimum(one, other).astype(np.int64), np.maximum(one, other).astype(np.int64)
    if low.min() < 0 or high.max() >= count or (high - low != 1).any():
        raise file.damaged("edge: joins vertices that do not follow each other; such strands are not read")
    begins = np.ones(count, np.bool_)
    begins[high] = False
    found = np.full(np.count_nonzero(begins) + 1, count, np.int64)
    found[:-1] = np.flatnonzero(begins)
    return found


def _are_whole(rows: Rows, *names: str) -> bool:
    """Whether there are properties of whole numbers of these names."""
    return all(name in rows.items and rows.items[name].dtype.kind in "iu" for name in names)


def _attributes(file: Bounded, vertex: Rows, begin: int) -> dict[str, Attribute]:
    """Colours and what `NUMBERS` names, each in memory of its own."""
    found = {}
    if set(RGB) <= vertex.items.keys():
        kinds = {vertex.items[name].dtype for name in RGB}
        found["colour"] = vertex.columns(RGB, np.uint8 if kinds == {np.dtype("u1")} else np.float32)
    for name in sorted(NUMBERS.keys() & vertex.items.keys()):
        values = vertex.items[name]
        kind = np.dtype("f4") if values.dtype.kind == "f" else values.dtype.newbyteorder("=")
        with np.errstate(over="ignore"):
            found[NUMBERS[name]] = values.astype(kind)
    for name, values in found.items():
        file.finite(name, values, lambda row: begin)
    return {name: Attribute("point", values) for name, values in found.items()}


def write(path: Path, strands: Strands, samples: Iterable[TimeSample] | None = None) -> list[str]:
    """Write a binary file of vertices, strands and edges; with the edges, viewers of meshes show it. Values of strands
    are written at each of their points."""
    strands = with_width_each(strands)
    counts = strands.counts(np.int32)
    kinds: list[tuple[str, str, Any]] = [(axis, "<f4", strands.points[:, i]) for i, axis in enumerate(XYZ)]
    retained = []
    for attribute, names in (("width", ("thickness",)), ("transparency", ("alpha",)), ("colour", RGB)):
        one = strands.attributes.get(attribute)
        if one is None or one.domain == "groom" or one.values.size != len(names) * one.values.shape[0]:
            continue
        kind = "|u1" if one.values.dtype == np.uint8 else "<f4"
        rows = one.values.reshape(-1, len(names))
        if one.domain == "strand":
            rows = np.repeat(rows, strands.counts(), axis=0)
        kinds += [(label, kind, rows[:, i]) for i, label in enumerate(names)]
        retained.append(attribute)
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
    parts = [records(kinds, strands.points.shape[0]), records(columns, strands.count)]
    write_pieces(path, chain(["\n".join(header).encode()], parts, edges_of(strands)))
    return left_out(strands, name, retained)
