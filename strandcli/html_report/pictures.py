"""Pictures small enough to stand inside a page, as data: addresses."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import StrandError
from ..files.picture_samples import opened
from ..output import png
from ..output.png import flattened

THUMBNAIL, LARGE, FILM = 288, 860, 480
"""Widths in pixels: of a frame on the sheet, of the one at the top, of an animation."""
QUALITIES = (86, 72, 55, 35)
MOST_FILM_FRAMES = 48
FILM_BYTES = 700_000
"""Of an animation; a larger one is made smaller."""


class Picture(NamedTuple):
    """An embedded picture: its address, bytes of the file in it, and its size in pixels."""

    address: str
    size: int
    width: int
    height: int


def chosen(items: Sequence[Any], most: int) -> list[Any]:
    """At most so many of some things, evenly, the first and the last among them."""
    if len(items) <= most:
        return list(items)
    if most == 1:
        return [items[len(items) // 2]]
    return [items[round(i * (len(items) - 1) / (most - 1))] for i in range(most)]


def embedded(path: Path, width: int, most_bytes: int) -> Picture | None:
    """The picture of a file, at most so wide, as JPEG of at most so many bytes; None where it cannot be read."""
    try:
        image = png.load(path)
    except StrandError:
        return None
    return _packed(_fitted(flattened(image), width), most_bytes)


def _fitted(image: Any, width: int) -> Any:
    from PIL import Image

    if image.width <= width:
        return image
    height = max(1, round(image.height * width / image.width))
    return image.resize((width, height), Image.Resampling.LANCZOS, reducing_gap=2.0)


def _packed(image: Any, most_bytes: int) -> Picture:
    """JPEG of the best quality that keeps under a size, of a smaller picture where none does."""
    while True:
        for quality in QUALITIES:
            out = io.BytesIO()
            image.save(out, "JPEG", quality=quality, optimize=True, subsampling=0 if quality == QUALITIES[0] else 2)
            if out.tell() <= most_bytes:
                return Picture(_address("jpeg", out.getvalue()), out.tell(), image.width, image.height)
        if max(image.size) <= 16:
            return Picture(_address("jpeg", out.getvalue()), out.tell(), image.width, image.height)
        image = image.resize((max(1, image.width // 2), max(1, image.height // 2)))


def film(path: Path) -> Picture | None:
    """An animation of a file, .gif or .webp, as it is where it is small, else smaller and of fewer frames; None where
    it cannot be read."""
    from PIL import Image, ImageSequence

    try:
        if path.stat().st_size <= FILM_BYTES:
            with opened(path) as image:
                size = image.size
            return Picture(_address(path.suffix[1:], path.read_bytes()), path.stat().st_size, *size)
        with opened(path) as image:
            step = -(-getattr(image, "n_frames", 1) // MOST_FILM_FRAMES)
            small: list[Any] = []
            times: list[int] = []
            for place, one in enumerate(ImageSequence.Iterator(image)):
                if place % step == 0:
                    small.append(_fitted(flattened(one), FILM))
                    times.append(0)
                times[-1] += int(one.info.get("duration", 40))
        for quality in (70, 45, 25):
            out = io.BytesIO()
            small[0].save(
                out, "WEBP", save_all=True, append_images=small[1:], duration=times, loop=0, quality=quality, method=0
            )
            if out.tell() <= FILM_BYTES:
                return Picture(_address("webp", out.getvalue()), out.tell(), *small[0].size)
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        return None
    return None


def _address(kind: str, data: bytes) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(data).decode('ascii')}"
