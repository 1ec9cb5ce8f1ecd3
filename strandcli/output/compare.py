"""How far two images are apart, in numbers and as a picture."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import MismatchError
from . import png
from .files import write_pieces
from .png import over

Samples = NDArray[Any]


@dataclass(frozen=True, slots=True)
class Comparison:
    """Differences of two images of one size. Units are those of 8-bit images, 0 … 255, over all channels;
    those of 16 bits differ by parts of one.

    ``over`` counts the pixels of which some channel differs by more than ``threshold``. ``psnr_db`` is None for equal
    images, whose ratio is infinite. ``rmse_relative`` is the RMSE over the root mean square of the first image, and
    None if that is black.
    """

    width: int
    height: int
    threshold: int
    over: int
    over_fraction: float
    max_difference: float
    rmse: float
    rmse_relative: float | None
    psnr_db: float | None

    @property
    def equal(self) -> bool:
        """Whether every pixel is the same."""
        return self.max_difference == 0

    def as_dict(self) -> dict[str, Any]:
        """The same for JSON."""
        return {**asdict(self), "equal": self.equal}

    def __str__(self) -> str:
        if self.equal:
            return "the same pixels"
        total = self.width * self.height
        counted = "differ" if self.threshold == 0 else f"differ by more than {self.threshold}/255"
        return (
            f"{self.over} of {total} pixels ({100 * self.over_fraction:.3g} %) {counted}, "
            f"the most by {self.max_difference:.4g}/255; RMSE {self.rmse:.3g}/255"
        )


def compare(first: Samples, second: Samples, threshold: int = 0) -> Comparison:
    """Compare images of shape (height, width, channels), uint8 or `samples` of 16 bits. Of those with alpha, colours
    are premultiplied first: what shows nothing is alike whatever its colour.

    Raises ``MismatchError`` if their shapes differ.
    """
    if first.shape != second.shape:
        raise MismatchError(f"sizes differ: {size_of(first)} against {size_of(second)}")
    first, second = _associated(first), _associated(second)
    difference = _difference(first, second)
    worst = difference.max(axis=2)
    over = int(np.count_nonzero(worst > threshold))
    square = float(np.mean(np.square(difference, dtype=np.float64)))
    level = float(np.mean(np.square(first, dtype=np.float64)))
    return Comparison(
        width=first.shape[1], height=first.shape[0], threshold=threshold, over=over, over_fraction=over / worst.size,
        max_difference=worst.max().item(), rmse=math.sqrt(square),
        rmse_relative=math.sqrt(square / level) if level else None,
        psnr_db=10 * math.log10(255.0**2 / square) if square else None,
    )  # fmt: skip


def compare_files(first: Path, second: Path, threshold: int = 0) -> tuple[Comparison, Samples, Samples, str]:
    """Compare two files; returns both images, too, and what was taken for granted. Alpha counts if either image has
    some; the other is then taken as opaque.

    Raises ``UsageError`` if one cannot be read and ``MismatchError``, naming both, if their sizes differ.
    """
    (width, height), (wide, high) = png.size_of(first), png.size_of(second)
    if (width, height) != (wide, high):  # before gigabytes are decoded
        raise MismatchError(f"{first} and {second}: sizes differ: {width}x{height} against {wide}x{high}")
    images = png.read_samples(first), png.read_samples(second)
    channels = max(image.shape[2] for image in images)
    padding = [(0, 0), (0, 0), (0, 1)]
    one, two = (
        image if image.shape[2] == channels else np.pad(image, padding, constant_values=255) for image in images
    )
    opaque = [path for path, image in zip((first, second), images, strict=True) if image.shape[2] < channels]
    note = f"{opaque[0]} has no alpha, as the other has: taken as opaque" if opaque else ""
    try:
        return compare(one, two, threshold), one, two, note
    except MismatchError as error:
        raise MismatchError(f"{first} and {second}: {error}") from None


def difference_image(first: Samples, second: Samples) -> png.Pixels:
    """Where two images differ, to be looked at: the first in dark grey, and over it each differing pixel on a scale
    red, yellow, white, stretched so that the greatest difference is white. Each is spread over its 8 neighbours, so
    that a single one is seen."""
    worst = _difference(_associated(first), _associated(second)).max(axis=2).astype(np.float64)
    spread = _spread(worst)
    grey = _shown(first).astype(np.float64) @ np.array([0.2126, 0.7152, 0.0722]) * 0.3
    picture = np.repeat(grey[..., None], 3, axis=2)
    if worst.max() > 0:
        heat = 0.25 + 0.75 * spread / worst.max()
        scale = np.clip(np.stack([3 * heat, 3 * heat - 1, 3 * heat - 2], axis=2), 0, 1) * 255
        picture = np.where(spread[..., None] > 0, scale, picture)
    return np.rint(picture).astype(np.uint8)


def side_by_side(expected: png.Pixels, found: png.Pixels) -> png.Pixels:
    """Expected, found and difference in one image, a white line between them."""
    line = np.full((expected.shape[0], 2, 3), 255, dtype=np.uint8)
    parts = [_shown(expected), line, _shown(found), line, difference_image(expected, found)]
    return np.concatenate(parts, axis=1)


def write_image(path: Path, image: png.Pixels) -> None:
    """Write a picture as PNG, whole or not at all."""
    write_pieces(path, png.encode(image))


def _shown(image: Samples) -> Samples:
    """An image over grey, if it has alpha."""
    return image if image.shape[2] == 3 else over(np.rint(image).astype(np.uint8))


def _associated(image: Samples) -> Samples:
    """The image with colours that are multiplied by its alpha, if it has any."""
    if image.shape[2] == 3:
        return image
    return np.dstack([image[..., :3] * (image[..., 3:] / 255.0), image[..., 3:]])


def _difference(first: Samples, second: Samples) -> Any:
    kind = np.int16 if first.dtype == second.dtype == np.uint8 else np.float64
    return np.abs(first.astype(kind) - second.astype(kind))


def _spread(values: Any) -> Any:
    """The greatest value among each pixel and its 8 neighbours."""
    padded = np.pad(values, 1)
    height, width = values.shape
    shifted = [padded[y : y + height, x : x + width] for y in range(3) for x in range(3)]
    return np.maximum.reduce(shifted)


def size_of(image: Samples) -> str:
    """Width and height in words, and whether there is alpha."""
    return f"{image.shape[1]}x{image.shape[0]}{' with alpha' if image.shape[2] == 4 else ''}"
