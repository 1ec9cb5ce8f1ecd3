"""Arrays that are reused from frame to frame: to map fresh pages takes longer than to write to them."""

from __future__ import annotations

import math
import mmap
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray


class Scratch:
    """Named buffers that grow and never shrink. The contents of a borrowed array are undefined."""

    def __init__(self) -> None:
        self._buffers: dict[str, NDArray[Any]] = {}

    def borrow(self, name: str, shape: int | tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
        """Return an array of this shape and type. It is valid until the same name is borrowed again: both share
        memory."""
        shape = (shape,) if isinstance(shape, int) else shape
        size = math.prod(shape)
        buffer = self._buffers.get(name)
        if buffer is None or buffer.size < size or buffer.dtype != dtype:
            buffer = np.empty(size + size // 8, dtype)
            self._buffers[name] = buffer
        return buffer[:size].reshape(shape)

    def sparse(self, name: str, size: int, dtype: DTypeLike) -> NDArray[Any]:
        """Return an array (size,) as `borrow` does, of which only pages that are written to take memory. Of other large
        arrays NumPy has Linux take 2 MB at once wherever a byte is written."""
        buffer = self._buffers.get(name)
        if buffer is None or buffer.size < size or buffer.dtype != dtype:
            self._buffers[name] = buffer = _in_small_pages(size, dtype)
        return buffer[:size]

    def extend(self, name: str, size: int, dtype: DTypeLike, kept: int, likely: int) -> NDArray[Any]:
        """Return an array (size,) of this type whose first ``kept`` numbers are those of the last one of this name;
        likely: how long it will be in the end. Memory that is not written to is not taken."""
        buffer = self._buffers.get(name)
        if buffer is None or buffer.size < size or buffer.dtype != dtype:
            made = np.empty(max(size, likely) * 3 // 2, dtype)
            if buffer is not None and kept:
                made[:kept] = buffer[:kept]
            self._buffers[name] = buffer = made
        return buffer[:size]

    def arange(self, count: int) -> NDArray[np.int32]:
        """Return (count,) int32: 0, 1, … Do not write to it."""
        buffer = self._buffers.get("arange")
        if buffer is None or len(buffer) < count:
            buffer = self._buffers["arange"] = np.arange(count + count // 8, dtype=np.int32)
        return buffer[:count]


def _in_small_pages(size: int, dtype: DTypeLike) -> NDArray[Any]:
    """An array with undefined contents whose pages are as small as the system has them. Raises `MemoryError` as NumPy
    does."""
    if size == 0 or not hasattr(mmap, "MADV_NOHUGEPAGE"):
        return np.empty(size, dtype)
    try:
        memory = mmap.mmap(-1, size * np.dtype(dtype).itemsize, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    except OSError as error:
        raise MemoryError from error
    with suppress(OSError):  # of kernels without huge pages
        memory.madvise(mmap.MADV_NOHUGEPAGE)
    return np.frombuffer(memory, dtype)
