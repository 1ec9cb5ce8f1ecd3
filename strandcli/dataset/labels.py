"""Labels of a view, of the layers that come with its picture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..cameras.pinhole import Pinhole

LAYERS = ("depth", "mask", "solid", "tangent")
"""Of `strandcli.draw.film.aovs`, that labels are made of."""
COVERED = 0.5
"""Share of a pixel above which it is hair, or a solid."""
END_ON = 1e-4
"""Sine of the angle to the line of sight under which a strand has no direction in the picture."""


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
