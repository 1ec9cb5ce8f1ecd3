"""Growth of depth numbers toward the eye."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class DepthSlope(NamedTuple):
    """Growth of a view's depth number q over the length of a pixel toward the eye: per_depth · q + constant."""

    per_depth: np.float32
    """Tangent of the angle that a pixel next to the view's axis spans; 0 for an orthographic view."""
    constant: np.float32
    """0 for a perspective view."""
    axis_x: np.float32
    axis_y: np.float32
    """Pixel on the view's axis."""


FLAT = DepthSlope(np.float32(0), np.float32(0), np.float32(0), np.float32(0))
"""Slope 0: wide strands are flat bands with the depth of their axis."""
