"""Rotations as matrices (3, 3) and as unit quaternions, whose real part is first; up axes, and turns between them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def of_quaternion(unit: Floats) -> Floats:
    """(3, 3) the rotation of a unit quaternion (4,)."""
    w, x, y, z = unit
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


def quaternion_of(rotation: Floats) -> Floats:
    """(4,) w, x, y, z of a rotation (3, 3), w ≥ 0: the eigenvector of the greatest eigenvalue of Bar-Itzhack's matrix
    (2000), without a singular case."""
    m = rotation
    k = np.array([
        [m[0, 0] + m[1, 1] + m[2, 2], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]],
        [m[2, 1] - m[1, 2], m[0, 0] - m[1, 1] - m[2, 2], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0]],
        [m[0, 2] - m[2, 0], m[0, 1] + m[1, 0], m[1, 1] - m[0, 0] - m[2, 2], m[1, 2] + m[2, 1]],
        [m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], m[2, 2] - m[0, 0] - m[1, 1]],
    ])  # fmt: skip
    found = np.linalg.eigh(k)[1][:, -1]
    return np.asarray(found if found[0] >= 0 else -found)


def xyz(vector: Floats) -> tuple[float, float, float]:
    """A vector (3,) as plain numbers."""
    x, y, z = vector.tolist()
    return x, y, z


AXES = ("x", "y", "z", "-x", "-y", "-z")


def axis(name: str) -> Floats:
    """The unit vector of one of `AXES`."""
    vector = np.zeros(3)
    vector["xyz".index(name[-1])] = -1.0 if name.startswith("-") else 1.0
    return vector


def turning(up: str, to: str) -> Floats:
    """The turn (3, 3) that takes one axis to another, by the lesser angle; its entries are whole."""
    a, b = axis(up), axis(to)
    if up == to:
        return np.eye(3)
    if (a == -b).all():  # half a turn about another axis
        other = np.roll(np.abs(a), 1)
        return 2 * np.outer(other, other) - np.eye(3)
    across = np.cross(a, b)
    return np.outer(b, a) - np.outer(a, b) + np.outer(across, across)
