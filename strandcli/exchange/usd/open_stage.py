"""Stages of USD and the files that they are made of, of which long arrays of texts are read here; runs in the worker.

Pixar's parser takes some 80 bytes of memory for each number of an array before it makes the array. So it is given the
text with a few numbers in place of each long array, which then gets its own.
"""

from __future__ import annotations

import os
import re
import stat
from itertools import chain
from typing import Any

import numpy as np
from pxr import Ar, Sdf, Tf, Usd, UsdUtils, Vt

from ..bounded import Growing, numbers_of
from .process import RefusedFileError


def opened(path: str) -> Usd.Stage:
    """The stage of a file. Raises `RefusedFileError` and Tf.ErrorException."""
    layer = layer_of_text(path)
    if layer is None:
        known = Sdf.Layer.Find(path)
        layer = known or Sdf.Layer.FindOrOpen(path)
        if layer is None:
            raise RefusedFileError("is no USD that Pixar's library opens")
        if known is not None:
            known.Reload(force=True)
    named = _layers_named(layer)  # which are open until the stage has them
    stage = Usd.Stage.Open(layer, Usd.Stage.LoadAll)
    del named
    return stage


def _layers_named(root: Sdf.Layer) -> list[Sdf.Layer]:
    """The layer and those that it names, directly or not. Raises `RefusedFileError` where one of them names a pipe or a
    device, be it as a clip or a picture: Pixar's library would wait for who writes into it."""
    found, seen = [root], {root.identifier}
    for layer in found:
        for name in chain(*UsdUtils.ExtractExternalReferences(layer.identifier)):
            _is_file(layer.ComputeAbsolutePath(name), name)
        for name in layer.GetCompositionAssetDependencies():
            place = layer.ComputeAbsolutePath(name)
            if place not in seen and _is_file(place, name):
                seen.add(place)
                inner = layer_of_text(place) or Sdf.Layer.FindOrOpen(place)
                found += [] if inner is None else [inner]
    return found


def _is_file(place: str, name: str) -> bool:
    """Whether there is something at a place. Raises `RefusedFileError` for what is there and is no file."""
    file = Ar.SplitPackageRelativePathOuter(place.partition(":SDF_FORMAT_ARGS:")[0])[0]
    try:
        mode = os.stat(file).st_mode
    except (OSError, ValueError):  # which the stage tells
        return False
    if not stat.S_ISREG(mode):
        kind = "a folder" if stat.S_ISDIR(mode) else "no file but a pipe or a device"
        raise RefusedFileError(f"names {name[:80]}, which is {kind}")
    return True


def layers_of(stage: Usd.Stage) -> list[str]:
    """Paths of the files of a stage, and of those that it names and are not found."""
    layers = [layer.realPath.partition("[")[0] for layer in stage.GetUsedLayers(includeClipLayers=True)]
    errors = [getattr(error, "resolvedAssetPath", "") or "" for error in stage.GetCompositionErrors()]
    return sorted({path for path in (*layers, *errors) if path})


MAGIC = b"#usda ", b"#sdf "
"""How texts begin."""
LONG = 1 << 16
"""Bytes of text from which on an array is long."""
SLICE = 1 << 22
"""Bytes of text whose numbers are read at once."""
KINDS: dict[bytes, tuple[str, int, Any]] = {
    b"int": ("i4", 1, Vt.IntArray), b"float": ("f4", 1, Vt.FloatArray),
    **dict.fromkeys((b"float2", b"texCoord2f"), ("f4", 2, Vt.Vec2fArray)),
    **dict.fromkeys((b"float3", b"point3f", b"vector3f", b"normal3f", b"color3f"), ("f4", 3, Vt.Vec3fArray)),
}  # fmt: skip
"""Types of arrays that are read here: that of numbers, how many a row has, and Pixar's."""
ARRAYS = {made for _, _, made in KINDS.values()}
DECLARED = re.compile(rb"(\w+)\[\]\s+[\w:]+(?:\.timeSamples)?\s*=")
ARRAY = re.compile(rb"\[[0-9eE+\-.,()\sainf]{%d,}+\]" % (LONG - 1))
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


def _apart(path: str) -> tuple[bytes, list[Any]]:
    """The text with a few numbers in place of each long array, and these arrays; nothing of what is no text."""
    with open(path, "rb") as file:
        text = file.read(len(MAGIC[0]))
        text += file.read() if text.startswith(MAGIC) else b""
    parts: list[bytes] = []
    arrays: list[Any] = []
    kind, done = b"", 0
    for found in ARRAY.finditer(text):
        begin, end = found.start() + 1, found.end() - 1
        declared = DECLARED.findall(text, max(done, begin - LONG), begin)
        kind = declared[-1] if declared else kind
        if kind not in KINDS:
            raise OtherwiseError
        parts += [text[done:begin], _place(len(arrays), KINDS[kind][1])]
        arrays.append(_array(text, begin, end, *KINDS[kind]))
        done = end
    return b"".join([*parts, text[done:]]), arrays


def _array(text: bytes, begin: int, end: int, kind: str, width: int, made: Any) -> Any:
    """Pixar's array of numbers of a type in a part of a text, rows of so many of them. Raises `OtherwiseError` where
    commas and brackets do not fit the numbers."""
    numbers, signs = Growing(kind), np.zeros(3, np.int64)
    while begin < end:
        stop = end if end - begin <= SLICE else text.rfind(b",", begin, begin + SLICE) + 1 or end
        signs += [text.count(sign, begin, stop) for sign in (b",", b"(", b")")]
        words = text[begin:stop].translate(BLANK)
        begin = stop
        found = numbers_of(words)
        if found is None or (kind == "i4" and not (np.abs(found) < 2**31).all()):
            raise OtherwiseError
        with np.errstate(over="ignore"):
            rounded = found.astype(kind)
        if kind == "i4" and not np.array_equal(rounded, found):
            raise OtherwiseError
        numbers.add(rounded)
    commas, opening, closing = (int(one) for one in signs)
    values = numbers.taken()
    brackets = values.size // width if width > 1 else 0
    if values.size % width or {opening, closing} != {brackets} or not 0 <= values.size - commas <= 1:
        raise OtherwiseError
    return made.FromNumpy(values if width == 1 else values.reshape(-1, width))


def _place(number: int, width: int) -> bytes:
    """The numbers that stand for an array."""
    rows = [str(one) for one in (number % 1000, number // 1000, *PLACE)]
    return ", ".join(rows if width == 1 else [f"({', '.join([one] * width)})" for one in rows]).encode()


def _number(value: Any) -> int:
    """Which array some values stand for; -1 of the rest."""
    if type(value) not in ARRAYS or len(value) != 2 + len(PLACE):
        return -1
    rows = np.asarray(value).reshape(len(value), -1)
    if (rows != rows[:, :1]).any() or tuple(rows[2:, 0]) != PLACE:
        return -1
    return int(rows[0, 0]) + 1000 * int(rows[1, 0])


def _together(path: str, text: bytes, arrays: list[Any]) -> Sdf.Layer:
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
