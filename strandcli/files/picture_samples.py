"""The samples of a picture's file, of 8 or 16 bits: Pillow clips 16-bit grey to white and cuts 16-bit colour to 8.

All pictures are opened here: Pillow left to itself tries decoders that run programs.
"""

from __future__ import annotations

import io
import logging
import os
import stat
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from .inputs import READ

STEP = 257.0
"""Steps of 16 bits in one of 8: 65535 / 255."""

FORMATS = ("PNG", "JPEG", "GIF", "BMP", "TGA", "PPM", "PCX", "TIFF", "WEBP")
"""Pillow's names of formats that are read, JPEG with the MPO of cameras: of its forty more some run programs, or take
what memory a file names."""
MOST_IN_A_BYTE = {"raw": 8} | dict.fromkeys(("packbits", "tiff_lzw", "tiff_adobe_deflate", "tiff_deflate", ""), 8300)
"""Pixels by how a TIFF is packed, and of other formats. deflate packs at most 1032 bytes in one (zlib's technical
details), of 8 pixels each; the rest pack less."""
FLAT = 2**23
"""Pixels of a WebP that may be in a file however small: of one colour it has a hundred bytes."""
MOST = 2**26
"""Pixels of a texture or a sky, at most: 8192 x 8192."""
AT_ONCE = 1 << 20
"""Pixels that are converted at once."""

# what it logs of damaged files would be printed by Python's handler of last resort, beside the line that refuses them
logging.getLogger("PIL").addHandler(logging.NullHandler())


@contextmanager
def opened(source: Path | str | bytes, *, any_size: bool = False) -> Iterator[Any]:
    """The Pillow image of a file or of a file's content, not decoded yet, without Pillow's warnings, which name no
    remedy; its ``content`` is the file that it is read from.

    With ``any_size`` it must be a PNG, and Pillow's limit of pixels does not count.
    Raises ``ValueError`` for a pipe or a device, of which nothing is read, and what Pillow raises for broken files.
    """
    with io.BytesIO(source) if isinstance(source, bytes) else _file(source) as file, _image(file, any_size) as image:
        yield image


def _file(path: Path | str) -> BinaryIO:
    """A regular file; `ValueError` for anything else."""
    descriptor = os.open(path, READ)
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise ValueError("it is no file")
    return open(descriptor, "rb")


@contextmanager
def _image(file: BinaryIO, any_size: bool = False) -> Iterator[Any]:
    """The image at a file's begin."""
    from PIL import Image, UnidentifiedImageError
    from PIL.PngImagePlugin import PngImageFile

    _require_whole_chunks(file)
    file.seek(0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:  # the limit is in Image.open alone
            image = PngImageFile(file) if any_size else Image.open(file, formats=FORMATS)
        except UnidentifiedImageError:
            raise ValueError("it is no picture, or of a format that is not read") from None
        with image:
            image.content = file  # type: ignore[attr-defined]
            yield image


def _size(file: BinaryIO) -> int:
    """Bytes of a file, whose place stays."""
    place = file.tell()
    size = file.seek(0, os.SEEK_END)
    file.seek(place)
    return size


def require_pixels(image: Any) -> Any:
    """The `opened` image, not decoded. Raises ``ValueError`` for one whose file cannot hold as many pixels as it says,
    for which no memory is to be taken."""
    packing = image.info.get("compression") if image.format == "TIFF" else ""
    if packing not in MOST_IN_A_BYTE:
        raise ValueError(f"a TIFF packed by {packing} is not read; save it as PNG")
    flat = FLAT if image.format == "WEBP" else 0
    if image.width * image.height > max(MOST_IN_A_BYTE[packing] * _size(image.content), flat):
        raise ValueError(f"it ends long before its {image.width} x {image.height} pixels")
    return image


def _require_whole_chunks(file: BinaryIO) -> None:
    """Raise ``ValueError`` for a PNG that ends within a chunk: Pillow takes memory for the length that one tells."""
    left = _size(file) - 8
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


def pixels(source: Path | str | bytes) -> npt.NDArray[np.uint8]:
    """(height, width, 3) of a file or of a file's content, at most `MOST` pixels. Raises `ValueError` for what cannot
    be read. Rows are converted some at once: Pillow takes four bytes a pixel beside the result, and no more."""
    try:
        with opened(source) as image:
            if image.width * image.height > MOST:
                raise ValueError(f"{image.width} x {image.height} pixels are more than {MOST:,}; scale it down")
            require_pixels(image)
            deep = _is_grey_of_16(image)
            image.load()
            found = np.empty((image.height, image.width, 3), np.uint8)
            step = max(1, AT_ONCE // image.width)
            for row in range(0, image.height, step):
                part = image.crop((0, row, image.width, min(row + step, image.height)))
                if deep:
                    found[row : row + step] = np.rint(np.asarray(part)[..., None] / STEP)
                else:
                    found[row : row + step] = np.asarray(part.convert("RGB"))
            return found
    except (MemoryError, ValueError):
        raise
    except Exception as error:  # whatever a damaged picture raises
        raise ValueError(str(error)) from None


def is_transparent(path: str) -> bool:
    """Whether a picture has pixels that are not opaque; false where it cannot be read. One without alpha is not
    decoded."""
    try:
        with opened(path) as image:
            if not image.has_transparency_data or image.width * image.height > MOST:
                return False
            return bool(require_pixels(image).convert("RGBA").getextrema()[3][0] < 255)
    except MemoryError:
        raise
    except Exception:  # whatever a damaged picture raises, which is reported where it is read
        return False


def samples(image: Any) -> npt.NDArray[Any]:
    """(height, width, 3), or 4 where there is transparency, of an `opened` image, 0 … 255: uint8, or float64 in steps
    of 1/257 where the file has 16 bits. Raises ``ValueError`` for kinds that would lose some of them, and what Pillow
    raises for broken files."""
    require_pixels(image)
    if _is_grey_of_16(image):
        return np.repeat(np.asarray(image, np.float64)[..., None] / STEP, 3, axis=2)
    raw = _raw_mode(image)
    if image.mode in ("P", "PA") and image.palette is None:
        raise ValueError("it has colours of a palette, and no palette")
    if ";16" not in raw:
        return np.asarray(image.convert("RGBA" if image.has_transparency_data else "RGB"))
    if image.format != "PNG":
        raise ValueError("16 bits a sample are read of PNG alone; save it as that")
    if raw not in ("RGB;16B", "RGBA;16B"):
        raise ValueError("grey of 16 bits with alpha; save it without alpha, or in colour")
    # taken as if the low byte came first, Pillow's upper bytes are the lower ones
    image.load()
    with _image(image.content) as again:
        again.tile = [(*again.tile[0][:3], raw[:-1] + "L")]
        low = np.asarray(again)
    return (np.asarray(image).astype(np.float64) * 256.0 + low) / STEP


def _is_grey_of_16(image: Any) -> bool:
    """Whether an image that is not decoded has one sample of 16 bits a pixel. Raises ``ValueError`` for one of 32."""
    if image.mode.startswith("I;16") or (image.mode == "I" and _raw_mode(image).startswith("I;16")):
        return True
    if image.mode in ("I", "F"):
        raise ValueError("its samples have 32 bits; save it with 8 or 16, as PNG")
    return False


def _raw_mode(image: Any) -> str:
    """How Pillow's decoder takes the file's samples, such as ``RGB;16B``; empty where it does not say."""
    if not image.tile:
        return ""
    arguments = image.tile[0][3]
    found = arguments[0] if isinstance(arguments, tuple) and arguments else arguments
    return found if isinstance(found, str) else ""
