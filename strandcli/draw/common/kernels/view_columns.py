"""Columns of a view as kernels read it: (26,) float32, packed by `strandcli.draw.view.camera.View.pack`.

Three rows (right, up, forward), each a unit vector and a shift, transform world to view coordinates, metres
(`strandcli.draw.view.kernels.project.to_view`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

RIGHT_X, RIGHT_Y, RIGHT_Z, RIGHT_SHIFT = range(4)
UP_X, UP_Y, UP_Z, UP_SHIFT = range(4, 8)
FORWARD_X, FORWARD_Y, FORWARD_Z, FORWARD_SHIFT = range(8, 12)
PERSPECTIVE = 12
"""1: perspective, 0: orthographic."""
FOCAL = 13
"""Pixels a metre: at a depth of one metre (perspective) or anywhere (orthographic)."""
NEAR_PLANE = 14
"""Depth of the near plane, metres."""
AXIS_X, AXIS_Y = 15, 16
"""Pixel on the view's axis."""
SLANT_X, SLANT_Y = 17, 18
"""Distance by which the sides of the view volume move out horizontally for a margin of one perpendicular to them."""
DEPTH_RANGE = 19
"""Far − near, metres."""
EYE_X, EYE_Y, EYE_Z = 20, 21, 22
"""Position of the eye, metres."""
CORNER_STRETCH = 23
"""Factor by which lengths on the screen are greater in its corners than at its centre, at the same depth."""
SCREEN_WIDTH, SCREEN_HEIGHT = 24, 25
"""Pixels."""
SIZE = 26
"""Numbers of a view."""


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
