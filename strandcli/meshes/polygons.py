"""Polygons to triangles, and colours as files have them to linear ones."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt


def fans(faces: npt.NDArray[Any]) -> npt.NDArray[np.int64]:
    """Triangles (T, 3) of polygons (F, k), each a fan about its first corner."""
    if faces.ndim != 2 or faces.shape[1] < 3:
        return np.zeros((0, 3), np.int64)
    count = faces.shape[1]
    if count == 3:
        return faces.astype(np.int64, copy=False)
    return np.stack([faces[:, (0, k, k + 1)] for k in range(1, count - 1)], axis=1).reshape(-1, 3).astype(np.int64)


def fans_of_lists(lengths: npt.NDArray[np.integer[Any]], values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Values (T, 3, …) at the corners of triangles; values: (n, …) of corners of polygons that stand one after the
    other, of so many corners each. Those of fewer than three make no triangle."""
    if (lengths == 3).all():
        return values.reshape(-1, 3, *values.shape[1:])
    kind: Any = np.int32 if values.shape[0] < 2**31 else np.int64
    begins: npt.NDArray[Any] = np.cumsum(lengths, dtype=kind)
    np.subtract(begins, lengths, out=begins, casting="unsafe")
    enough = lengths >= 3
    if not enough.all():  # a byte of a file may be a polygon without corners, for which no more is to be taken
        begins, lengths = begins[enough], lengths[enough]
    many = (lengths - 2).astype(kind)
    first: npt.NDArray[Any] = np.repeat(begins, many)
    turn: npt.NDArray[Any] = np.arange(1, 1 + first.size, dtype=kind)
    turn -= np.repeat(np.cumsum(many, dtype=kind) - many, many)
    turn += first
    found = np.empty((first.size, 3, *values.shape[1:]), values.dtype)
    found[:, 0], found[:, 1] = values[first], values[turn]
    turn += 1
    found[:, 2] = values[turn]
    return found


def linear(colours: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
    """Linear colours (n, 3) from sRGB ones (n, 3 or more), whole numbers to 255 or others to 1."""
    values = colours[:, :3]
    shown = values.astype(np.float64) / (255.0 if values.dtype.kind in "iu" else 1.0)
    shown = np.clip(np.nan_to_num(shown), 0.0, 1.0)
    found: npt.NDArray[np.float64] = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)
    return found.astype(np.float32)
