"""Environment light from a lat-long picture: PNG of 8 or 16 bits and JPEG (taken as sRGB), or Radiance .hdr.

Rows go from +y down to −y, columns from −z by +x, +z and −x round to −z again. The first nine spherical harmonics are
stored (Ramamoorthi & Hanrahan 2001: the mean error on a surface is below .1 %), convolved with the cosine of surfaces
or the sine of strands, so that a kernel evaluates nine terms. `strandcli.draw.lighting.occlusion` computes how much of
this light is occluded.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...common import srgb
from ...errors import UsageError, about, said
from ...files.inputs import content
from ...files.picture_samples import MOST, opened, samples

if TYPE_CHECKING:
    from ...scene.model import Scene

TOO_MANY = f"more than {MOST:,} pixels (such as 8192 x 8192); scale it down, nine numbers are stored of it"
MOST_IN_A_BYTE = 16
"""Pixels of a Radiance picture: two bytes hold at most 127 times one of four channels."""
AT_ONCE = 65_536
"""Pixels that are made linear together: all at once would take four times the memory."""
FORMATS = ("PNG", "JPEG", "MPO")
"""Pillow's names; MPO is the JPEG of cameras that keep further pictures behind the first."""
COSINE = (1.0, 2.0 / 3.0, 0.25)
"""Zonal coefficients of max(cos, 0) / π, for a Lambertian surface of albedo 1."""
SINE = (1.0, 0.0, -0.125)
"""Zonal coefficients of sin / π², for a strand, which light along its direction does not reach."""
ORDERS = (0, 1, 1, 1, 2, 2, 2, 2, 2)


def sky_of(scene: Scene) -> NDArray[np.float32] | None:
    """Return the coefficients (2, 9, 3) of `basis` for the radiance of a white strand by its tangent, and of a white
    surface by its normal; None without an environment. Raises `UsageError` if its picture cannot be read."""
    environment = scene.environment
    if environment is None:
        return None
    return coefficients(read(environment.image), environment.rotation) * np.float32(environment.intensity)


def read(image: str) -> NDArray[np.floating]:
    """Return the linear picture (height, width, 3) of a file. Raises `UsageError` if it cannot be read."""
    path = Path(image)
    try:
        with about("picture", image):
            return read_hdr(path) if path.suffix.lower() == ".hdr" else _read_picture(path)
    except (OSError, ValueError) as error:
        remedy = "give a lat-long picture, PNG, JPEG or Radiance .hdr"
        raise UsageError(f"environment.image: {path}: {said(error)}; {remedy}") from None


def coefficients(picture: NDArray[np.floating], rotation: float = 0.0) -> NDArray[np.float32]:
    """Return the coefficients (2, 9, 3), as in `sky_of`, of a linear picture (height, width, 3) that is rotated by
    ``rotation`` degrees about +y."""
    height, width, _ = picture.shape
    polar = (np.arange(height) + 0.5) * (np.pi / height)
    around = (np.arange(width) + 0.5) * (2.0 * np.pi / width) - math.radians(rotation)
    # exact solid angles of pixels
    edges = np.cos(np.arange(height + 1) * (np.pi / height))
    area = 2.0 * np.pi / width * (edges[:-1] - edges[1:])
    found = np.zeros((9, 3))
    for row in range(height):
        directions = np.stack(
            [
                math.sin(polar[row]) * np.sin(around),
                np.full(width, math.cos(polar[row])),
                -math.sin(polar[row]) * np.cos(around),
            ]
        )
        found += area[row] * (basis(directions) @ picture[row].astype(np.float64))
    # ∫ L(ω) w(ω·n) dω = Σ λ_l (4π / norm) f_i B_i(n), for basis functions B that are not normalised
    found *= (np.array(NORMS) / (4.0 * np.pi))[:, None]
    return np.stack([found * np.array([zonal[order] for order in ORDERS])[:, None] for zonal in (SINE, COSINE)]).astype(
        np.float32
    )


NORMS = (1.0, 3.0, 3.0, 3.0, 15.0, 15.0, 1.25, 15.0, 3.75)
"""4π over the integral of each basis function's square."""


def basis(direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (9, …) the basis functions 1, x, y, z, xy, yz, 3z² − 1, xz, x² − y² of unit vectors (3, …)."""
    x, y, z = direction
    return np.stack([np.ones_like(x), x, y, z, x * y, y * z, 3.0 * z * z - 1.0, x * z, x * x - y * y])


def _read_picture(path: Path) -> NDArray[np.float64]:
    from PIL import Image

    try:
        with opened(content(path)) as image:
            if image.format not in FORMATS or image.mode == "CMYK":
                kind = f"{image.format} picture" if image.mode != "CMYK" else f"CMYK {image.format}"
                raise ValueError(f"a {kind} is not read")
            if image.format == "PNG" and getattr(image, "is_animated", False):
                raise ValueError("an animation has no one sky")
            _require_size(image.width, image.height)
            encoded = samples(image)
    except SyntaxError as error:  # Pillow's word for a broken PNG
        raise ValueError(str(error)) from None
    except Image.DecompressionBombError:
        raise ValueError(TOO_MANY) from None
    found = np.empty((*encoded.shape[:2], 3))
    rows = max(1, AT_ONCE // found.shape[1])
    for row in range(0, len(found), rows):
        found[row : row + rows] = srgb.decoded(encoded[row : row + rows, :, :3].astype(np.float64) / 255.0)
    return found


def _require_size(width: int, height: int) -> None:
    if not 0 < width * height <= MOST:
        raise ValueError(f"{width} x {height} pixels: {TOO_MANY}" if width * height else "it has no pixels")


def read_hdr(path: Path) -> NDArray[np.float32]:
    """Return the linear picture (height, width, 3) of a Radiance file whose rows go down and columns to the right.
    Raises `OSError`, and `ValueError` for any other file."""
    data = content(path)
    head, _, rest = data.partition(b"\n\n")
    if not head.startswith(b"#?") or b"32-bit_rle_rgbe" not in head:
        raise ValueError("not a Radiance picture in rgbe")
    line, _, body = rest.partition(b"\n")
    words = line.split()
    if len(words) != 4 or words[0] != b"-Y" or words[2] != b"+X" or not (words[1].isdigit() and words[3].isdigit()):
        raise ValueError("its rows must go down and its columns to the right (-Y … +X …)")
    height, width = int(words[1]), int(words[3])
    _require_size(width, height)
    if width * height > MOST_IN_A_BYTE * len(body):
        raise ValueError("the file ends before its last row")
    at = 0
    rgbe = np.empty((height, 4, width), np.uint8)
    for row in range(height):
        if body[at : at + 4] == bytes([2, 2, width >> 8, width & 255]) and 8 <= width < 32768:
            at = _row(body, at + 4, width, rgbe[row])
        else:
            flat = np.frombuffer(body[at : at + 4 * width], np.uint8)
            if len(flat) < 4 * width:
                raise ValueError("the file ends before its last row")
            rgbe[row] = flat.reshape(width, 4).T
            at += 4 * width
    exponent = rgbe[:, 3].astype(np.int32)
    scale = np.where(exponent > 0, np.ldexp(1.0, exponent - 136), 0.0)
    return np.ascontiguousarray(np.moveaxis(rgbe[:, :3] * scale[:, None], 1, 2), np.float32)


def _row(body: bytes, at: int, width: int, out: NDArray[np.uint8]) -> int:
    """Decode one row, channel by channel, into out; return the next index. A count above 128 repeats the byte after it
    count − 128 times; any other count is followed by that many bytes."""
    for channel in out:
        x = 0
        while x < width:
            if at + 1 >= len(body):
                raise ValueError("the file ends before its last row")
            count = body[at]
            repeated = count > 128
            count -= 128 if repeated else 0
            piece = body[at + 1 : at + 2] if repeated else body[at + 1 : at + 1 + count]
            if count == 0 or x + count > width or len(piece) < (1 if repeated else count):
                raise ValueError("a run of bytes is longer than its row")
            channel[x : x + count] = np.frombuffer(piece, np.uint8)
            x += count
            at += 1 + len(piece)
    return at
