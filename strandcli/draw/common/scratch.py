"""Arrays that are reused from frame to frame: to map fresh pages takes longer than to write to them."""

from __future__ import annotations

import math
import mmap
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

POSITIONS = ("children", "combed", "followers", "pieces", "chosen_rows")
"""Names of arrays that are needed until there are polylines,"""
IN_LIGHT = (
    "light_screen", "map_vertices", "map_parts", "map_order", "map_places", "map_costs", "map_coarse_world", "sketch",
    "sketch_nearest", "sketch_deep", "spread_extents", "rows_of_cells",
)  # fmt: skip
"""until shadow maps are drawn,"""
IN_PICTURE = ("world", "along", "lost", "screen", "widths", "slots", "colours")
"""and until the exposure ends: see `Scratch.release`."""
LINE = 64
"""Bytes of a line of the processor's cache, at which memory begins, as vectors do: one that lies across two lines takes
two loads."""


class Scratch:
    """Named buffers that grow and never shrink. The contents of a borrowed array are undefined."""

    def __init__(self) -> None:
        self._buffers: dict[str, NDArray[Any]] = {}
        self._memory: dict[str, NDArray[np.uint8]] = {}
        """Of borrowed arrays."""
        self._released: dict[str, NDArray[np.uint8]] = {}
        """Memory that no array is in, by the name that had it last."""
        self._sharing: set[str] = set()

    def borrow(self, name: str, shape: int | tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
        """Return an array of this shape and type. It is valid until the same name is borrowed again, when both share
        memory, or released."""
        shape = (shape,) if isinstance(shape, int) else shape
        size = math.prod(shape) * np.dtype(dtype).itemsize
        memory = self._memory.get(name)
        if memory is None or len(memory) < size:
            memory = self._memory[name] = self._found(name, size) if name in self._sharing else _aligned(size)
        return memory[:size].view(dtype).reshape(shape)

    def release(self, *names: str) -> None:
        """End the use of borrowed arrays: others that have been released once, or are now, may take their memory."""
        self._sharing.update(names)
        for name in names:
            memory = self._memory.pop(name, None)
            if memory is not None:
                self._released[name] = memory

    def let_go(self) -> None:
        """Give back the memory that no array is in."""
        self._released.clear()

    def _found(self, name: str, size: int) -> NDArray[np.uint8]:
        """Return memory of at least so many bytes, of which no more than half is left over if another name had it."""
        released = self._released
        fit = [
            one for one, memory in released.items() if size <= len(memory) and (one == name or len(memory) <= 2 * size)
        ]
        if fit:
            return released.pop(name if name in fit else min(fit, key=lambda one: len(released[one])))
        # new memory can serve in the place of what is a little too small, too
        small = [one for one, memory in released.items() if size <= 2 * len(memory) < 2 * size]
        if small:
            del released[max(small, key=lambda one: len(released[one]))]
        return _aligned(size)

    def sparse(self, name: str, size: int, dtype: DTypeLike) -> NDArray[Any]:
        """Return an array (size,) as `borrow` does, of which only pages that are written to take memory. Of other large
        arrays NumPy has Linux take 2 MB at once wherever a byte is written."""
        buffer = self._buffers.get(name)
        if buffer is None or buffer.size < size or buffer.dtype != dtype:
            self._buffers[name] = buffer = _in_small_pages(size, dtype)
        return buffer[:size]

    def extend(self, name: str, size: int, dtype: DTypeLike, retained: int, likely: int) -> NDArray[Any]:
        """Return an array (size,) of this type whose first ``retained`` numbers are those of the last one of this name;
        likely: how long it will be in the end. Memory that is not written to is not taken."""
        buffer = self._buffers.get(name)
        if buffer is None or buffer.size < size or buffer.dtype != dtype:
            made = np.empty(max(size, likely) * 3 // 2, dtype)
            if buffer is not None and retained:
                made[:retained] = buffer[:retained]
            self._buffers[name] = buffer = made
        return buffer[:size]


def _aligned(size: int) -> NDArray[np.uint8]:
    """Return memory of so many bytes and an eighth more, which begins with a line of the cache."""
    memory = np.empty(size + size // 8 + LINE, np.uint8)
    return memory[-memory.ctypes.data % LINE :]


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
