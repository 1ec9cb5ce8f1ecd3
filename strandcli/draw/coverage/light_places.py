"""Vertices at which the light of visible fragments is computed.

A fragment has the light of the lit vertices before and after it. One of a small weight (`kernels.tiles.FAINT`), of
which there are many behind each other, has that of the first and the last vertex of its group. Which vertices a group
has depends on the strands alone, so that a picture does not depend on how its rows are divided into layers.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..geometry.curves import Polylines
from .kernels.tiles import GROUP, GROUP_BITS

NO_GROUPS = np.zeros(0, np.uint8)
"""All fragments have light of the vertices next to them."""


def groups_of(lines: Polylines) -> NDArray[np.uint8]:
    """Return `Fragments.groups` of strands whose vertices are all lit."""
    groups = np.ones((max(len(lines.world) - 1, 0) >> GROUP_BITS) + 1, np.uint8)
    groups[(lines.first[1:] - 1) >> GROUP_BITS] = 0
    return groups


def marks_at_vertices(marks: NDArray[np.uint8], vertices: int, stride: int) -> NDArray[np.uint8]:
    """Return the marks of the vertices between which the light of marked vertices and groups is interpolated."""
    own, groups = marks[:vertices], marks[vertices:]
    own[stride:] |= own[:-stride]
    if len(groups):
        own[::GROUP] |= groups
        own[GROUP::GROUP] |= groups[: len(own[GROUP::GROUP])]
    return own
