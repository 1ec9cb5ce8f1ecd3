"""PLY files: the header, which tells how many there are of each element, and its properties; and numbers of a text."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import UsageError
from .bounded import SLICE, Bounded, opened

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


def is_mesh(path: Path) -> bool:
    """Whether a file has polygons."""
    with opened(path, ".ply file") as file:
        _, elements, _ = read_header(file)
    return "face" in elements and elements["face"].count > 0


class NumbersOfText:
    """The numbers of a text, some at once: those that are waiting to be taken."""

    def __init__(self, file: Bounded) -> None:
        self.file, self.waiting, self._rest = file, np.zeros(0), b""

    def more(self) -> bool:
        """Whether there are others, which wait then, too. Raises `UsageError` for what is no number."""
        if not self.file.left:
            return False
        begin = self.file.position - len(self._rest)
        text = self._rest + self.file.take("content", min(SLICE, self.file.left))
        end = max(text.rfind(b"\n"), text.rfind(b" ")) + 1 if self.file.left else len(text)
        text, self._rest = text[:end], text[end:]
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                found = np.fromstring(text, np.float64, sep=" ") if text.strip() else np.zeros(0)
            except (ValueError, DeprecationWarning):
                raise self.file.damaged("has more than numbers, unlike its header", begin) from None
        self.waiting = np.concatenate([self.waiting, found])
        return True

    def rows(self, element: Element) -> Iterator[npt.NDArray[np.float64]]:
        """The rows (k, properties) of an element without lists, some at once. Raises `UsageError` where there are
        fewer, or a whole number is none."""
        width, done = len(element.columns), 0
        while done < element.count:
            count = min(element.count - done, self.waiting.size // width)
            found, self.waiting = self.waiting[: count * width].reshape(count, width), self.waiting[count * width :]
            for (name, kind, _), values in zip(element.columns, found.T, strict=True):
                self.check(element, name, kind, values)
            done += count
            yield found
            if done < element.count and not self.more():
                raise self.ended(element, done)

    def check(self, element: Element, name: str, kind: str, values: npt.NDArray[np.float64]) -> None:
        """Raise `UsageError` where numbers that are to be whole ones are not finite."""
        if kind[0] != "f" and not np.isfinite(values).all():
            raise self.file.damaged(f"element {element.name}: {name} is not a number everywhere", element.at)

    def ended(self, element: Element, row: int) -> UsageError:
        """The error of a text that ends before a row."""
        return self.file.damaged(f"element {element.name}: row {row:,} goes beyond the end of the file", element.at)

    def end(self) -> None:
        """Raise `UsageError` where something follows."""
        if self.waiting.size:
            raise self.file.damaged("more numbers than the header declares")


def whole_numbers(values: npt.NDArray[Any], kind: str) -> npt.NDArray[Any]:
    """Finite numbers as whole ones of a type."""
    most = np.iinfo(kind)
    return np.clip(values, most.min, most.max).astype(kind)
