"""Messages between two processes: what is told as JSON, and arrays behind it."""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Callable, Sequence
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from ..written import raw

SIZE = struct.Struct("<Q")
"""Bytes of the JSON, before it."""
LONGEST = 1 << 26
"""Bytes of the JSON, at most."""

Fill = Callable[[memoryview], None]
"""Fills memory with the bytes that come next."""
Message = tuple[dict[str, Any], list[npt.NDArray[Any]]]


class RefusedFileError(Exception):
    """A file is none that can be read; the message says why."""


def send(stream: BinaryIO, header: dict[str, Any], arrays: Sequence[npt.NDArray[Any]] = ()) -> None:
    """Send a message. Raises `OSError` where nobody listens any more."""
    text = json.dumps({**header, "arrays": [[one.dtype.str, list(one.shape)] for one in arrays]}).encode()
    stream.write(SIZE.pack(len(text)) + text)
    for one in arrays:
        if one.size:
            stream.write(raw(one, one.dtype.str))
    stream.flush()


def receive(fill: Fill, room: int | None = None) -> Message:
    """The next message and its arrays, for which at most ``room`` bytes are taken. Raises what ``fill`` does, and
    `OverflowError` for more."""
    head = bytearray(SIZE.size)
    fill(memoryview(head))
    size = SIZE.unpack(head)[0]
    if size > LONGEST:
        raise OverflowError
    text = bytearray(size)
    fill(memoryview(text))
    header: dict[str, Any] = json.loads(bytes(text))
    arrays = []
    for kind, shape in header.pop("arrays"):
        dtype = np.dtype(kind)
        needs = math.prod(shape) * dtype.itemsize
        if room is not None:
            if needs > room:
                raise OverflowError
            room -= needs
        values = np.empty(shape, dtype)
        if values.size:
            fill(values.reshape(-1).view(np.uint8).data)
        arrays.append(values)
    return header, arrays
