"""The header of a PLY file: which elements it has, how many of each, and their properties."""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .bounded import Bounded, opened
from .strands import OBJECT

TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}  # fmt: skip
ENCODINGS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
MOST_LINES = 1000
"""Of a header: Gaussian splats have some 70."""


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


def object_names(comments: list[str]) -> tuple[tuple[str, ...], list[str]]:
    """Names of objects that comments tell, as `object_comment` makes them, and the other comments."""
    names, others = [], []
    for one in comments:
        text = None
        if one.startswith(f'{OBJECT} "'):
            with suppress(ValueError):
                text = json.loads(one[len(OBJECT) :])
        if isinstance(text, str):
            names.append(text)
        else:
            others.append(one)
    return tuple(names), others


def object_comment(name: str) -> str:
    """The line of a header that names an object: text of JSON, of ASCII and without spaces, which are not kept."""
    text = json.dumps(name).replace(" ", "\\u0020")
    return f"comment {OBJECT} {text}"


def is_mesh(path: Path) -> bool:
    """Whether a file has polygons."""
    with opened(path, ".ply file") as file:
        _, elements, _ = read_header(file)
    return "face" in elements and elements["face"].count > 0
