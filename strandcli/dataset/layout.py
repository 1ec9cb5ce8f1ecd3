"""Labels of a view, of the layers that come with its picture; and what a layout makes of them: files of a view, and of
all views together.

Orientation of strands as reconstructions from photographs have it: the angle at which a bank of Gabor filters
answers most, and the variance of its answers.

The angle is counted from the vertical, in degrees, half a turn in all: 0 is upright, 45 falls to the right, 90 is
level, 135 falls to the left. So count the filters of SamsungLabs/NeuralHaircut
(preprocess_custom_data/calc_orientation_maps.py) and of eth-ait/GaussianHaircut (src/preprocessing, the same name): 180
angles θ, each a wave across a line along (sin θ, cos θ), right and down; and so does `project_orient_to_camera` of the
former. The variance is in radians², weighed by the answers of all angles.
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..cameras.pinhole import Floats, Pinhole
from ..output import png

Pieces = Iterable[bytes]
LAYERS = ("depth", "mask", "solid", "tangent")
"""Of `strandcli.draw.film.aovs`, that labels are made of."""
COVERED = 0.5
"""Share of a pixel above which it is hair, or a solid."""
END_ON = 1e-4
"""Sine of the angle to the line of sight under which a strand has no direction in the picture."""
DEGREES = 180
"""Angles that are distinguished."""
LEAST = 0.09
"""Radians²: what the bank finds in straight waves of its own length, its best."""
UNKNOWN = math.pi**2 / 12
"""Radians²: that of angles all alike likely, where there is no hair."""
WINDOW = 5
"""Pixels along a side: most of what a filter weighs lies within its deviation of 2."""


@dataclass(frozen=True, eq=False)
class Labels:
    """A picture and what is seen in each of its pixels. Depth and direction are those of the strand
    that most of the pixel's light comes from."""

    view: Pinhole
    image: NDArray[np.uint8]
    """(height, width, 3) sRGB."""
    hair: NDArray[np.bool_]
    """(height, width) strands cover more than half of the pixel."""
    body: NDArray[np.bool_]
    """(height, width) hair, or what solids cover, whether hair is in front of it or not."""
    depth: NDArray[np.float32]
    """(height, width) metres along the camera's axis; infinite where nothing is."""
    direction: NDArray[np.float32]
    """(height, width, 2) unit vector in the picture, right and down, from root to tip; 0 where there is no hair, and
    where it is seen end on."""


def labels_of(image: NDArray[np.uint8], layers: Mapping[str, NDArray[Any]], view: Pinhole) -> Labels:
    """The labels of a picture and its `LAYERS`."""
    hair = layers["mask"] > COVERED
    body = hair | (layers["solid"] > COVERED)
    direction = np.zeros((*hair.shape, 2), np.float32)
    rows, columns = np.nonzero(hair)
    direction[rows, columns] = directions(layers["tangent"][rows, columns], rows, columns, view)
    return Labels(view, image, hair, body, layers["depth"], direction)


def directions(
    tangents: NDArray[np.float32], rows: NDArray[np.int64], columns: NDArray[np.int64], view: Pinhole
) -> NDArray[np.float32]:
    """(k, 2) unit vectors in the picture, right and down, of unit vectors (k, 3) of the world that are seen in so many
    pixels; 0 of those that are seen end on.

    In perspective a step t at (x, y, z) moves the pixel by (t_x − t_z x / z, t_y − t_z y / z) · focal / z.
    """
    right, down, ahead = (tangents @ view.rotation.T.astype(np.float32)).T
    if view.perspective:
        right = right - ahead * ((columns + 0.5 - view.centre[0]) / view.focal).astype(np.float32)
        down = down - ahead * ((rows + 0.5 - view.centre[1]) / view.focal).astype(np.float32)
    length = np.hypot(right, down)
    seen = length > END_ON
    scale = np.where(seen, 1 / np.where(seen, length, 1), 0)
    return np.stack([right * scale, down * scale], 1)


def angles(labels: Labels) -> NDArray[np.uint8]:
    """(height, width) degrees of the hair, 0 to 179; 0 elsewhere."""
    right, down = labels.direction[..., 0], labels.direction[..., 1]
    degrees = np.rint(np.degrees(np.arctan2(right, down))).astype(np.int16) % DEGREES
    return degrees.astype(np.uint8)


def variances(labels: Labels) -> NDArray[np.float16]:
    """(height, width) radians²: how far the directions of the hair about a pixel turn from its own.

    A label has no error of its own; reported is where directions differ so near to each other that a filter, or a
    reader that interpolates, would mix them: `LEAST`, and the mean of sin² of the angle to the hair within the window.
    """
    x, y = labels.direction[..., 0], labels.direction[..., 1]
    there = ((x != 0) | (y != 0)).astype(np.float32)
    double = np.stack([x * x - y * y, 2 * x * y, there])  # cos and sin of twice the angle
    cosine, sine, count = _summed(double)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = (double[0] * cosine + double[1] * sine) / count
    found = np.where(there > 0, np.float32(LEAST) + np.clip(0.5 - 0.5 * mean, 0, 1), np.float32(UNKNOWN))
    return np.minimum(found, np.float32(UNKNOWN)).astype(np.float16)


def _summed(planes: NDArray[np.float32]) -> NDArray[np.float32]:
    """(k, height, width) sums over a window about each pixel; beyond the picture there is nothing."""
    half = WINDOW // 2
    for axis in (1, 2):
        padded = np.pad(planes, [(half, half) if one == axis else (0, 0) for one in range(3)])
        size = planes.shape[axis]
        planes = sum(np.take(padded, range(step, step + size), axis) for step in range(WINDOW))  # type: ignore[assignment]
    return planes


@dataclass(frozen=True, eq=False)
class Cloud:
    """Strands as a whole, for layouts that want a scene's size or some of its points."""

    points: Floats
    """(k, 3) metres; some points of the strands."""
    middle: Floats
    """(3,) of the box about all."""
    radius: float
    """Metres; of a ball about the middle that holds all."""


class Layout:
    """A layout; one of another package has the same names. A driver overrides what differs from this.

    `paths` of a view hold ``{}`` for its name, and `encode` gives the contents in the same order. Every file is written
    whole or not at all, and those of a view before it counts as done.
    """

    name = ""
    perspective = True
    """Else views are orthographic."""
    square = False
    """Whether only square pictures are read."""
    centred = False
    """Whether the principal point is taken to be the middle of the picture."""
    own_light = False
    """Whether each view has a light and colour of its own; else a set has one, as photographs of a person have."""
    size = (512, 512)
    paths: tuple[str, ...] = ()

    def encode(self, labels: Labels) -> Sequence[Pieces]:
        """The files of a view."""
        raise NotImplementedError

    def index(self, views: Sequence[Pinhole], cloud: Cloud) -> dict[str, Pieces]:
        """The files of all views together, by their paths."""
        raise NotImplementedError

    def links(self) -> dict[str, str]:
        """Folders under a second name, which point to the first."""
        return {}


class PhotographLayout(Layout):
    """One of what reconstructions from photographs read: square pictures, masks of hair and of the whole body,
    orientations and their variances; `paths` has a place for each."""

    square = True

    def encode(self, labels: Labels) -> Sequence[Pieces]:
        return (
            png.encode(labels.image), mask_png(labels.hair), mask_png(labels.body), png.encode(angles(labels)),
            npy(variances(labels)),
        )  # fmt: skip


def mask_png(mask: NDArray[np.bool_]) -> list[bytes]:
    """A mask as a PNG of one channel, 0 and 255."""
    return png.encode(np.where(mask, np.uint8(255), np.uint8(0)))


def npy(array: NDArray[Any]) -> list[bytes]:
    """An array as a .npy file."""
    file = io.BytesIO()
    np.lib.format.write_array(file, np.ascontiguousarray(array), allow_pickle=False)
    return [file.getvalue()]
