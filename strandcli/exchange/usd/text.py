"""Layers of USD that are text, whose long arrays are read here; runs in the worker.

Pixar's parser takes some 80 bytes of memory for each number of an array before it makes the array. So it is given the
text with a few numbers in place of each long array, which then gets its own.
"""

from __future__ import annotations

import re
import warnings
from typing import Any

import numpy as np
from pxr import Sdf, Tf, Vt

from ..bounded import Growing

MAGIC = b"#usda ", b"#sdf "
"""How texts begin."""
LONG = 1 << 16
"""Bytes of text from which on an array is long."""
SLICE = 1 << 22
"""Bytes of text that are looked at at once."""
KINDS: dict[bytes, tuple[str, int, Any]] = {
    b"int": ("i4", 1, Vt.IntArray), b"float": ("f4", 1, Vt.FloatArray),
    **dict.fromkeys((b"float2", b"texCoord2f"), ("f4", 2, Vt.Vec2fArray)),
    **dict.fromkeys((b"float3", b"point3f", b"vector3f", b"normal3f", b"color3f"), ("f4", 3, Vt.Vec3fArray)),
}  # fmt: skip
"""Types of arrays that are read here: that of numbers, how many a row has, and Pixar's."""
ARRAYS = {made for _, _, made in KINDS.values()}
DECLARED = re.compile(rb"(\w+)\[\]\s+[\w:]+(?:\.timeSamples)?\s*=")
NUMBERS = rb"0-9eE+\-.,()\sainf"
BEGIN, END = re.compile(rb"\[[" + NUMBERS + rb"]{%d}" % (LONG - 1)), re.compile(rb"[^" + NUMBERS + rb"]")
BLANK = bytes.maketrans(b"(),\n\r\t", b"      ")
PLACE = 271, 828, 182
"""Numbers that follow those of an array's own in its place."""


class OtherwiseError(Exception):
    """The text is not as it is expected to be: the library is to read all of it, and to say what is wrong."""


def layer_of_text(path: str) -> Sdf.Layer | None:
    """The layer of a file of text; None where it has no long arrays or is read by the library as well as by this."""
    if Sdf.Layer.Find(path) is not None:
        return None
    try:
        text, arrays = _apart(path)
        return _together(path, text, arrays) if arrays else None
    except (OtherwiseError, OSError):
        return None


class _Array:
    """The numbers of an array, as its text comes in."""

    def __init__(self, kind: bytes) -> None:
        if kind not in KINDS:
            raise OtherwiseError
        self.dtype, self.width, self.made = KINDS[kind]
        self._numbers, self._signs, self._rest = Growing(self.dtype), np.zeros(3, np.int64), b""

    def add(self, text: bytes) -> None:
        """Take in some text; what stands behind its last comma waits for more."""
        text = self._rest + text
        end = text.rfind(b",") + 1
        self._take(text[:end])
        self._rest = text[end:]

    def _take(self, text: bytes) -> None:
        self._signs += [text.count(sign) for sign in (b",", b"(", b")")]
        words = text.translate(BLANK)
        if not words.strip():
            return
        try:
            with warnings.catch_warnings(), np.errstate(over="ignore"):
                warnings.simplefilter("error", DeprecationWarning)
                found = np.fromstring(words, np.float64, sep=" ")
        except (ValueError, DeprecationWarning):
            raise OtherwiseError from None
        if self.dtype == "i4" and not (np.abs(found) < 2**31).all():
            raise OtherwiseError
        with np.errstate(over="ignore"):
            rounded = found.astype(self.dtype)
        if self.dtype == "i4" and not np.array_equal(rounded, found):
            raise OtherwiseError
        self._numbers.add(rounded)

    def end(self) -> Any:
        """Pixar's array of all of it. Raises `OtherwiseError` where commas and brackets do not fit the numbers."""
        self._take(self._rest)
        commas, opening, closing = (int(one) for one in self._signs)
        values = self._numbers.taken()
        brackets = values.size // self.width if self.width > 1 else 0
        if values.size % self.width or {opening, closing} != {brackets} or not 0 <= values.size - commas <= 1:
            raise OtherwiseError
        return self.made.FromNumpy(values if self.width == 1 else values.reshape(-1, self.width))


class _Parter:
    """Takes long arrays out of a text that comes in some at once."""

    def __init__(self) -> None:
        self.text = bytearray()
        """The text so far, with a few numbers in place of each long array."""
        self.arrays: list[Any] = []
        """Those, as Pixar has them."""
        self.now: _Array | None = None
        """The one that the text is in."""
        self._kind = b""

    def feed(self, text: bytes) -> bytes:
        """Take in text; returns what is left to stand before more."""
        while text:
            if self.now is None:
                begin = BEGIN.search(text)
                text = self._outside(text, begin.start() + 1 if begin else max(len(text) - LONG, 0))
                if begin is None:
                    return text
                self.now = _Array(self._kind)
            else:
                text = self._inside(self.now, text)
        return b""

    def _outside(self, text: bytes, size: int) -> bytes:
        declared = DECLARED.findall(self.text[-LONG:] + text[:size])
        self._kind = declared[-1] if declared else self._kind
        self.text += text[:size]
        return text[size:]

    def _inside(self, array: _Array, text: bytes) -> bytes:
        end = END.search(text)
        if end is None:
            array.add(text)
            return b""
        if end[0] != b"]":
            raise OtherwiseError
        array.add(text[: end.start()])
        self.text += _place(len(self.arrays), array.width)
        self.arrays.append(array.end())
        self.now = None
        return text[end.start() :]


def _apart(path: str) -> tuple[bytearray, list[Any]]:
    """The text with a few numbers in place of each long array, and these arrays; nothing of what is no text."""
    parter, rest = _Parter(), b""
    with open(path, "rb") as file:
        more = file.read(SLICE)
        if not more.startswith(MAGIC):
            return parter.text, []
        while more:
            rest = parter.feed(rest + more)
            more = file.read(SLICE)
    if parter.now is not None:
        raise OtherwiseError
    return parter.text + rest, parter.arrays


def _place(number: int, width: int) -> bytes:
    """The numbers that stand for an array."""
    rows = [str(one) for one in (number % 1000, number // 1000, *PLACE)]
    return ", ".join(rows if width == 1 else [f"({', '.join([one] * width)})" for one in rows]).encode()


def _number(value: Any) -> int:
    """Which array some values stand for; -1 of others."""
    if type(value) not in ARRAYS or len(value) != 2 + len(PLACE):
        return -1
    rows = np.asarray(value).reshape(len(value), -1)
    if (rows != rows[:, :1]).any() or tuple(rows[2:, 0]) != PLACE:
        return -1
    return int(rows[0, 0]) + 1000 * int(rows[1, 0])


def _together(path: str, text: bytearray, arrays: list[Any]) -> Sdf.Layer:
    """The layer of a file, of its text without long arrays, and of these, which are let go."""
    layer = Sdf.Layer.New(Sdf.FileFormat.FindByExtension(path), path)
    try:
        layer.ImportFromString(text.decode())
    except (UnicodeDecodeError, Tf.ErrorException):
        raise OtherwiseError from None
    left = dict(enumerate(arrays))
    arrays.clear()

    def of(value: Any) -> Any:
        array = left.pop(_number(value), None)
        if array is not None and type(array) is not type(value):
            raise OtherwiseError
        return array

    places: list[Sdf.Path] = []
    layer.Traverse(Sdf.Path.absoluteRootPath, places.append)
    for place in places:
        attribute = layer.GetAttributeAtPath(place) if place.IsPropertyPath() else None
        if attribute is None:
            continue
        array = of(attribute.default)
        if array is not None:
            attribute.default = array
        for time in layer.ListTimeSamplesForPath(place):
            array = of(layer.QueryTimeSample(place, time))
            if array is not None:
                layer.SetTimeSample(place, time, array)
    if left:
        raise OtherwiseError
    return layer
