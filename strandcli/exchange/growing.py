"""Arrays of which nobody knows how long they become."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

FIRST, SHARE = 1 << 12, 8
"""Rows that there is room for at first; and as many more as this share of them where it ends."""


class Growing:
    """Rows of an array to which others are added. It grows in its place, so that memory never holds it twice."""

    def __init__(self, kind: npt.DTypeLike, *shape: int) -> None:
        """``shape``: of a row."""
        self._held: npt.NDArray[Any] = np.empty((FIRST, *shape), kind)
        self.size = 0

    def add(self, rows: npt.ArrayLike) -> None:
        """Append rows."""
        more = np.asarray(rows)
        end = self.size + len(more)
        if end > len(self._held):
            self._resize(end + end // SHARE)
        self._held[self.size : end] = more
        self.size = end

    @property
    def rows(self) -> npt.NDArray[Any]:
        """The rows so far, valid until others are added."""
        return self._held[: self.size]

    def taken(self) -> npt.NDArray[Any]:
        """All rows, of which none may be added afterwards."""
        self._resize(self.size)
        return self._held

    def _resize(self, rows: int) -> None:
        self._held.resize((rows, *self._held.shape[1:]), refcheck=False)
