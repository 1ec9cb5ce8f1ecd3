"""The coat's pattern: each strand has the colour of the mesh where it grows.

Few colours stand for all, those of a palette that depends on the mesh alone, so that the colour of strand i depends on
the seed and on i alone. Each is followed by its shades, dark to pale, among which the material's spread of brightness
tells strands of one colour apart.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import UsageError
from ..files.inputs import cached
from ..mesh_file.maps import coloured, encoded
from ..mesh_file.read import KEPT, placed, placing
from ..scene.model import MeshShape
from .record import Anchors, Coat

MOST = 96
"""Colours of a palette."""
SHADES = 6
"""Of each."""
NEAR_CORNERS = np.full((3, 3), 0.2) + 0.4 * np.eye(3)
"""Barycentric coordinates of the points of a triangle that the palette is made of."""
AT_ONCE = 1 << 14
"""Strands that are compared with the palette at once, which bounds the memory."""


def coat(shape: MeshShape, anchors: Anchors, tones: NDArray[np.float32]) -> Coat | None:
    """Return the colours of strands at anchors, of tones (n,) in [−1, 1); None where they are the material's. Raises
    `UsageError` for a mesh without colours."""
    if shape.colours == "none":
        return None
    file, how = shape.file, placing(shape)
    palette = _palette(file, how)
    found = encoded(coloured(placed(file, how), anchors.triangles, anchors.shares)).astype(np.float32)
    codes = encoded(palette).astype(np.float32)
    rows = np.empty(len(found), np.int64)
    for begin in range(0, len(found), AT_ONCE):
        some = found[begin : begin + AT_ONCE]
        rows[begin : begin + AT_ONCE] = (((some[:, None] - codes) ** 2).sum(axis=2)).argmin(axis=1)
    shade = np.minimum((0.5 * (tones + 1) * SHADES).astype(np.int64), SHADES - 1)
    places = 2.0 * (rows * SHADES + shade) / (len(palette) * SHADES - 1) - 1.0
    return Coat(palette, SHADES, places.astype(np.float32))


@cached(KEPT)
def _palette(file: str, how: Any) -> NDArray[np.float32]:
    """Linear colours (k, 3), at most `MOST`, of a mesh by median cut over points of its triangles."""
    from PIL import Image

    mesh = placed(file, how)
    if mesh.colours is None and (mesh.texture is None or mesh.uv is None):
        raise UsageError(
            f"{file}: emitter.shape.colours: has neither vertex colours nor a texture; take a mesh that has, or "
            "colours: none"
        )
    triangles = np.repeat(np.arange(len(mesh.triangles)), len(NEAR_CORNERS))
    shares = np.tile(NEAR_CORNERS, (len(mesh.triangles), 1))
    light = coloured(mesh, triangles, shares)
    picked = Image.fromarray(encoded(light)[None]).quantize(MOST, method=Image.Quantize.MEDIANCUT)
    rows = np.unique(np.asarray(picked).reshape(-1), return_inverse=True)[1].reshape(-1)
    sums = np.stack([np.bincount(rows, light[:, c]) for c in range(3)], axis=1)
    return np.asarray(sums / np.bincount(rows)[:, None], np.float32)
