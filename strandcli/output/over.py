"""Pictures with alpha over one colour, for what knows no alpha."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .png import Pixels

Rgb = tuple[int, int, int]

GREY: Rgb = (118, 118, 118)
"""Reflects 18 %, the mid grey of photographers: dark and blond hair are seen before it."""


def over(image: Pixels, colour: Rgb = GREY) -> Pixels:
    """Return a picture (height, width, 3) of 8-bit sRGB: one with straight alpha (height, width, 4) over a colour, in
    linear light (Porter and Duff 1984); one without as it is."""
    if image.shape[2] == 3:
        return image
    ground = np.array(colour, np.uint8)
    alpha = image[..., 3]
    found = np.where(alpha[..., None] == 255, image[..., :3], ground)
    some = (alpha > 0) & (alpha < 255)
    share = alpha[some, None] / 255
    found[some] = _encoded(share * _linear(image[some, :3]) + (1 - share) * _linear(ground))
    return found


def flattened(image: Any, colour: Rgb = GREY) -> Any:
    """Return a Pillow image without alpha, as `over`."""
    from PIL import Image

    if not image.has_transparency_data:
        return image.convert("RGB")
    return Image.fromarray(over(np.asarray(image.convert("RGBA")), colour))


def _linear(levels: Pixels) -> NDArray[np.float64]:
    """8-bit sRGB to linear light (IEC 61966-2-1)."""
    share = levels / 255
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


def _encoded(linear: NDArray[np.float64]) -> Pixels:
    """Linear light in [0, 1] to 8-bit sRGB."""
    share = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.rint(255 * share).astype(np.uint8)
