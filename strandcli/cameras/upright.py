"""Which way is up in the world of cameras that another program placed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .pinhole import Floats, Pinhole

UP = (0.0, 1.0, 0.0)
LEAST = 0.3
"""Length of the mean of the cameras' up axes below which they agree on no direction."""
NEAR = 0.77
"""Cosine of the angle to an axis from which on that axis is taken: 40°, as far as cameras look up or down."""


def above(views: Sequence[Pinhole]) -> tuple[float, float, float]:
    """The unit vector that is up in the pictures of views, on average: the axis of the world near to it, or itself
    where none is; y where views do not agree, or there are none."""
    if not views:
        return UP
    mean = -np.mean([view.rotation[1] for view in views], axis=0)
    size = float(np.linalg.norm(mean))
    if size < LEAST:
        return UP
    mean /= size
    most = int(np.argmax(np.abs(mean)))
    if abs(mean[most]) < NEAR:
        return float(mean[0]), float(mean[1]), float(mean[2])
    x, y, z = (float(np.sign(mean[most])) * (axis == most) for axis in range(3))
    return x, y, z


def upright(up: tuple[float, float, float]) -> Floats:
    """The turn (3, 3) that takes y to a unit vector, by the shorter way; half a turn is about x."""
    across, cosine = np.cross(np.array(UP), np.array(up)), float(np.dot(UP, up))
    if cosine < -1 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    x, y, z = across
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + cross + cross @ cross / (1 + cosine))
