"""Orientation of strands as reconstructions from photographs have it: the angle at which a bank of Gabor filters
answers most, and the variance of its answers.

The angle is counted from the vertical, in degrees, half a turn in all: 0 is upright, 45 falls to the right, 90 is
level, 135 falls to the left. So count the filters of SamsungLabs/NeuralHaircut
(preprocess_custom_data/calc_orientation_maps.py) and of eth-ait/GaussianHaircut (src/preprocessing, the same name): 180
angles θ, each a wave across a line along (sin θ, cos θ), right and down; and so does `project_orient_to_camera` of the
former. The variance is in radians², weighed by the answers of all angles.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .labels import Labels

DEGREES = 180
"""Angles that are told apart."""
LEAST = 0.09
"""Radians²: what the bank finds in straight waves of its own length, its best."""
UNKNOWN = math.pi**2 / 12
"""Radians²: that of angles all alike likely, where there is no hair."""
WINDOW = 5
"""Pixels along a side: most of what a filter weighs lies within its deviation of 2."""


def angles(labels: Labels) -> NDArray[np.uint8]:
    """(height, width) degrees of the hair, 0 to 179; 0 elsewhere."""
    right, down = labels.direction[..., 0], labels.direction[..., 1]
    degrees = np.rint(np.degrees(np.arctan2(right, down))).astype(np.int16) % DEGREES
    return degrees.astype(np.uint8)


def variances(labels: Labels) -> NDArray[np.float16]:
    """(height, width) radians²: how far the directions of the hair about a pixel turn from its own.

    A label has no error of its own; what is told is where directions differ so near to each other that a filter, or a
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
