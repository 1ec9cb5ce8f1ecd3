"""Arrays that are used again from frame to frame: fresh pages cost more than the numbers that are written to them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray


class Scratch:
    """Named buffers that grow and never shrink. What an array holds when it is handed out is anything."""

    def __init__(self) -> None:
        self._buffers: dict[str, NDArray[Any]] = {}

    def take(self, name: str, shape: int | tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
        """An array of this shape; the same memory as the last one of this name where that was large enough."""
        wanted = (shape,) if isinstance(shape, int) else shape
        size = math.prod(wanted)
        have = self._buffers.get(name)
        if have is None or have.size < size or have.dtype != dtype:
            have = np.empty(size + size // 8, dtype)
            self._buffers[name] = have
        return have[:size].reshape(wanted)

    def arange(self, count: int) -> NDArray[np.int32]:
        """(count,) int32: 0, 1, … Not to be written to."""
        have = self._buffers.get("arange")
        if have is None or len(have) < count:
            have = self._buffers["arange"] = np.arange(count + count // 8, dtype=np.int32)
        return have[:count]
