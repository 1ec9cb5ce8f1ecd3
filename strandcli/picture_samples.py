"""The samples of a picture's file, of 8 or 16 bits: Pillow clips 16-bit grey to white and cuts 16-bit colour to 8."""

from __future__ import annotations

import logging
import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

STEP = 257.0
"""Steps of 16 bits in one of 8: 65535 / 255."""


FORMATS = ("PNG", "JPEG", "GIF", "BMP", "TGA", "PPM", "PCX", "TIFF", "WEBP")
"""Pillow's names of formats that are read, JPEG with the MPO of cameras: of its forty others some run programs, or take
what memory a file names."""
MOST_IN_A_BYTE = {"raw": 8} | dict.fromkeys(("packbits", "tiff_lzw", "tiff_adobe_deflate", "tiff_deflate", ""), 8300)
"""Pixels by how a TIFF is packed, and of other formats. deflate packs at most 1032 bytes in one (zlib's technical
details), of 8 pixels each; the others pack less."""
FLAT = 2**23
"""Pixels of a WebP that may be in a file however small: of one colour it has a hundred bytes."""

# what it logs of damaged files would be told by Python's handler of last resort, beside the line that refuses them
logging.getLogger("PIL").addHandler(logging.NullHandler())


@contextmanager
def opened(path: Path | str, *, any_size: bool = False) -> Iterator[Any]:
    """The Pillow image at ``path``, not decoded yet, without Pillow's warnings, which name no remedy.

    With ``any_size`` it must be a PNG, and Pillow's limit of pixels does not count.
    Raises ``ValueError`` for a pipe or a device, of which nothing is read, and what Pillow raises for broken files.
    """
    from PIL import Image
    from PIL.PngImagePlugin import PngImageFile

    if os.path.exists(path) and not os.path.isfile(path):
        raise ValueError("it is no file")
    _require_whole_chunks(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        # the limit is in Image.open alone
        with PngImageFile(path) if any_size else Image.open(path, formats=FORMATS) as image:
            yield image


def require_pixels(image: Any) -> Any:
    """The `opened` image, not decoded. Raises ``ValueError`` for one whose file cannot hold as many pixels as it says,
    for which no memory is to be taken."""
    packing = image.info.get("compression") if image.format == "TIFF" else ""
    if packing not in MOST_IN_A_BYTE:
        raise ValueError(f"a TIFF packed by {packing} is not read; save it as PNG")
    flat = FLAT if image.format == "WEBP" else 0
    if image.width * image.height > max(MOST_IN_A_BYTE[packing] * os.path.getsize(image.filename), flat):
        raise ValueError(f"it ends long before its {image.width} x {image.height} pixels")
    return image


def _require_whole_chunks(path: Path | str) -> None:
    """Raise ``ValueError`` for a PNG that ends within a chunk: Pillow takes memory for the length that one tells."""
    with open(path, "rb") as file:
        left = os.fstat(file.fileno()).st_size - 8
        if file.read(8) != b"\x89PNG\r\n\x1a\n":
            return
        while left > 0:
            head = file.read(8)
            length = int.from_bytes(head[:4], "big") + 12
            if len(head) < 8 or length > left:
                raise ValueError("it ends in the middle of a chunk")
            if head[4:] == b"IEND":
                return
            file.seek(length - 8, os.SEEK_CUR)
            left -= length


def samples(image: Any) -> npt.NDArray[Any]:
    """(height, width, 3), or 4 where there is transparency, of an `opened` image, 0 … 255: uint8, or float64 in steps
    of 1/257 where the file has 16 bits. Raises ``ValueError`` for kinds that would lose some of them, and what Pillow
    raises for broken files."""
    require_pixels(image)
    raw = _raw_mode(image)
    if image.mode.startswith("I;16") or (image.mode == "I" and raw.startswith("I;16")):
        return np.repeat(np.asarray(image, np.float64)[..., None] / STEP, 3, axis=2)
    if image.mode in ("I", "F"):
        raise ValueError("its samples have 32 bits; save it with 8 or 16, as PNG")
    if image.mode in ("P", "PA") and image.palette is None:
        raise ValueError("it has colours of a palette, and no palette")
    if ";16" not in raw:
        return np.asarray(image.convert("RGBA" if image.has_transparency_data else "RGB"))
    if image.format != "PNG":
        raise ValueError("16 bits a sample are read of PNG alone; save it as that")
    if raw not in ("RGB;16B", "RGBA;16B"):
        raise ValueError("grey of 16 bits with alpha; save it without alpha, or in colour")
    # taken as if the low byte came first, Pillow's upper bytes are the lower ones
    with opened(image.filename) as again:
        again.tile = [(*again.tile[0][:3], raw[:-1] + "L")]
        low = np.asarray(again)
    return (np.asarray(image).astype(np.float64) * 256.0 + low) / STEP


def _raw_mode(image: Any) -> str:
    """How Pillow's decoder takes the file's samples, such as ``RGB;16B``; empty where it does not say."""
    if not image.tile:
        return ""
    arguments = image.tile[0][3]
    found = arguments[0] if isinstance(arguments, tuple) and arguments else arguments
    return found if isinstance(found, str) else ""
