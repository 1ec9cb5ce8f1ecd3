"""PNG files: a fast encoder for frames, a checked reader, and the hash by which pictures are compared; pictures
with alpha over one colour, for what knows no alpha.

Pillow tries five filters on every row before it compresses, and that, not zlib, is what a frame waits for: 81 ms for
one of `headline` at 800x600. Here one filter for all rows, the difference from the pixel to the left, turns an even
background into zeros. ISA-L (the package `isal`) compresses them, in 2 ms; where it is not installed, zlib with Z_RLE,
which makes runs without searching for anything, in 9. Alpha is straight, not premultiplied, as the format has it.
"""

from __future__ import annotations

import hashlib
import struct
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from numpy.typing import NDArray

from ..common import srgb
from ..errors import RefusedError, UsageError
from ..files.picture_samples import opened, require_pixels, samples

Pixels = npt.NDArray[np.uint8]

SIGNATURE = b"\x89PNG\r\n\x1a\n"
LEVEL = 1
SCENE = "strandcli scene"
"""The keyword of the fingerprint of what a picture shows."""
SUB = 1  # filter type: each byte less that of the pixel to the left
COLOUR_TYPES = {1: 0, 3: 2, 4: 6}
"""By the number of channels."""
LARGEST_CHUNK = 1 << 20
"""Bytes of a PNG's chunk, which readers keep whole."""


def pixels_sha256(image: Pixels) -> str:
    """Hash of what a picture shows: its shape as little-endian 64-bit numbers, then its bytes, row by row.

    Never the hash of a PNG file: the same pixels may be compressed differently.
    """
    digest = hashlib.sha256(np.array(image.shape, dtype="<i8").tobytes())
    digest.update(np.ascontiguousarray(image).data)
    return digest.hexdigest()


def encode(image: npt.NDArray[Any], text: Mapping[str, str] | None = None) -> list[bytes]:
    """A PNG file, as pieces to be written one after the other, of ``image``: uint8, shape (height, width, 3), sRGB, or
    (height, width, 4) with alpha.

    Data that are no picture may be grey, (height, width), and may have 16 bits, uint16. ``text`` becomes tEXt
    chunks: Latin-1 keywords and values. Releases the GIL while it compresses.
    """
    deep = image.dtype == np.uint16
    grey = image.ndim == 2
    channels = 1 if grey else image.shape[-1]
    fits = grey or (image.ndim == 3 and channels in (3, 4))
    if not (deep or image.dtype == np.uint8) or not fits or 0 in image.shape:
        raise ValueError(f"a frame must be uint8 of shape (height, width, 3 or 4), not {image.dtype} {image.shape}")
    height, width = image.shape[:2]
    header = struct.pack(">IIBBBBB", width, height, 16 if deep else 8, COLOUR_TYPES[channels], 0, 0, 0)
    pieces = [SIGNATURE, *_chunk(b"IHDR", header), *([] if deep or grey else _chunk(b"sRGB", b"\0"))]
    for keyword, value in (text or {}).items():
        pieces += _chunk(b"tEXt", keyword.encode("latin-1") + b"\0" + value.encode("latin-1", "replace"))
    step = channels * image.itemsize
    flat = np.ascontiguousarray(image, ">u2" if deep else None).view(np.uint8).reshape(height, step * width)
    rows = np.empty((height, 1 + step * width), dtype=np.uint8)
    rows[:, 0] = SUB
    rows[:, 1 : 1 + step] = flat[:, :step]
    np.subtract(flat[:, step:], flat[:, :-step], out=rows[:, 1 + step :])  # modulo 256, as the format wants
    data = deflate(rows)
    for begin in range(0, len(data), LARGEST_CHUNK):
        pieces += _chunk(b"IDAT", data[begin : begin + LARGEST_CHUNK])
    return [*pieces, *_chunk(b"IEND", b"")]


def deflate(rows: Pixels) -> bytes:
    """A zlib stream of rows with their filter types."""
    try:
        from isal import isal_zlib
    except ImportError:
        packed = zlib.compressobj(LEVEL, zlib.DEFLATED, 15, 9, zlib.Z_RLE)
        return packed.compress(rows.data) + packed.flush()
    return bytes(isal_zlib.compress(rows.data, LEVEL))  # at once: a twentieth sooner than part by part


def _chunk(kind: bytes, body: bytes) -> tuple[bytes, bytes, bytes]:
    try:
        from isal.isal_zlib import crc32  # ten times zlib's speed
    except ImportError:
        from zlib import crc32
    return struct.pack(">I", len(body)) + kind, body, struct.pack(">I", crc32(body, crc32(kind)))


def read(path: Path) -> Pixels:
    """Decode the picture at ``path`` as uint8, (height, width, 3), or (height, width, 4) where it has alpha.

    Raises ``UsageError`` if there is none or it cannot be read, ``RefusedError`` if it is too big.
    """
    image = load(path)
    return np.asarray(image.convert("RGBA" if image.has_transparency_data else "RGB"))


def load(path: Path) -> Any:
    """The wholly decoded Pillow image at ``path``, with the errors of :func:`read`."""
    return _decoded(path, lambda image: require_pixels(image).copy())


def load_frame(path: Path, size: tuple[int, int]) -> Any | None:
    """The wholly decoded Pillow image at ``path``, a PNG of (width, height) ``size``; None for one of another size.

    Frames may be larger than pictures from elsewhere, so Pillow's limit of pixels does not count. Raises the errors of
    :func:`read`.
    """
    return _decoded(path, lambda image: require_pixels(image).copy() if image.size == size else None, any_size=True)


def size_of(path: Path) -> tuple[int, int]:
    """Width and height of the picture at ``path``, which is not decoded, with the errors of :func:`read`."""
    width, height = _decoded(path, lambda image: image.size)
    return width, height


def read_samples(path: Path) -> npt.NDArray[Any]:
    """The `samples` of the picture at ``path``, with the errors of :func:`read`."""
    return np.asarray(_decoded(path, samples))


def _decoded(path: Path, decode: Callable[[Any], Any], *, any_size: bool = False) -> Any:
    from PIL import Image

    try:
        with opened(path, any_size=any_size) as image:
            return decode(image)
    except FileNotFoundError:
        raise UsageError(f"{path}: no such image") from None
    except PermissionError:
        raise RefusedError(f"{path}: no permission to read it") from None
    except Image.DecompressionBombError:
        most = 2 * (Image.MAX_IMAGE_PIXELS or 0)
        raise RefusedError(f"{path}: more than {most:,} pixels; too big to be read") from None
    except MemoryError:
        raise
    except Exception as error:  # Pillow's decoders raise what their struct, index and lookup errors are
        raise UsageError(f"{path}: not an image that can be read: {_plain(error)}") from None


def keyword(path: Path, name: str) -> str | None:
    """The text that the PNG at ``path`` has under a name, None where it has none or cannot be read; its pixels are
    not looked at."""
    try:
        with opened(path, any_size=True) as image:
            found = image.info.get(name)
    except Exception:  # whatever a broken file makes of Pillow
        return None
    return found if isinstance(found, str) else None


def _plain(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__


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
    found[some] = np.rint(
        255 * srgb.encoded(share * linear_light(image[some, :3]) + (1 - share) * linear_light(ground))
    )
    return found


def flattened(image: Any, colour: Rgb = GREY) -> Any:
    """Return a Pillow image without alpha, as `over`."""
    from PIL import Image

    if not image.has_transparency_data:
        return image.convert("RGB")
    return Image.fromarray(over(np.asarray(image.convert("RGBA")), colour))


def linear_light(levels: NDArray[Any]) -> NDArray[np.float64]:
    """sRGB from 0 to 255 as linear light, 0 to 1 (IEC 61966-2-1)."""
    return srgb.decoded(levels / 255)
