"""Textures of meshes: a picture and its halves, quarters and so on, each the mean of four pixels (Williams 1983,
"Pyramidal parametrics")."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import UsageError, about
from ..files.inputs import content
from ..files.picture_samples import MOST, pixels

CODES = np.arange(256) / 255.0
LINEAR = np.where(CODES <= 0.04045, CODES / 12.92, ((CODES + 0.055) / 1.055) ** 2.4).astype(np.float32)
"""(256,) linear light of the codes of sRGB."""


class Pyramid(NamedTuple):
    """A picture in levels, the whole one first."""

    texels: NDArray[np.uint8]
    """(n, 3) sRGB, row by row from the top, level after level."""
    levels: NDArray[np.int64]
    """(L, 3) the first texel of each level, its width and its height."""


def picture(path: str) -> NDArray[np.uint8]:
    """(h, w, 3) sRGB, the first row at the top. Raises `UsageError` for what is no picture."""
    with about("picture", path):
        data = content(path)
        try:
            return pixels(data)
        except MemoryError:
            raise
        except Exception:  # whatever a damaged picture raises
            raise UsageError(
                f"{path}: is no picture that can be read, of up to {MOST:,} pixels; take a PNG or a JPEG"
            ) from None


def pyramid(image: NDArray[np.uint8]) -> Pyramid:
    """The levels of a picture (h, w, 3) down to one pixel."""
    light = LINEAR[image]
    parts, levels, first = [image.reshape(-1, 3)], [(0, image.shape[1], image.shape[0])], 0
    while max(light.shape[:2]) > 1:
        first += light.shape[0] * light.shape[1]
        light = _halved(_halved(light, 0), 1)
        parts.append(encoded(light).reshape(-1, 3))
        levels.append((first, light.shape[1], light.shape[0]))
    return Pyramid(np.ascontiguousarray(np.concatenate(parts)), np.array(levels, np.int64))


def _halved(light: NDArray[np.float32], axis: int) -> NDArray[np.float32]:
    """Means of pairs along an axis; of an odd number the last is in two halves."""
    count = light.shape[axis]
    if count == 1:
        return light
    even = np.take(light, range(0, count - 1, 2), axis)
    odd = np.take(light, range(1, count, 2), axis)
    found = np.float32(0.5) * (even + odd)
    if count % 2:
        tail = np.take(light, [count - 1], axis)
        last = np.take(found, [found.shape[axis] - 1], axis)
        found = np.concatenate([np.take(found, range(found.shape[axis] - 1), axis), (2 * last + tail) / 3], axis)
    return np.ascontiguousarray(found, np.float32)


def encoded(light: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Codes of sRGB whose light is nearest."""
    middles = 0.5 * (LINEAR[1:] + LINEAR[:-1])
    return np.searchsorted(middles, light).astype(np.uint8)
