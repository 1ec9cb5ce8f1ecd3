"""Shadows of the nearest strands exactly, and of the rest by a map (`shadow: {model: nearby}`).

Most strands of a groom lie behind others that leave hardly any light. An opacity map tells which: what lies behind an
optical depth of `LIMIT` gets what the map leaves, and casts no shadow, for what is behind it is dark as well. Only the
others are in the lists of `traced`, and are shaded by them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...scene.model import Light
from ..common.kernels.light_columns import CLEAR_ROW
from ..coverage.kernels.column_light import LINES, PLACES
from ..geometry.curves import Polylines
from ..view.camera import View
from .kernels import nearby as kernel
from .traced import Grid, grid_of
from .vertex_shadows import EVENLY, StrandsInLight, VertexShadows

LIMIT = np.float32(4.0)
"""Optical depth; e^-4 is 2 % of the light."""

TOGETHER = LINES // 2
"""Lines across a strand that share one computed shadow, on either side of the middle that the camera sees. All lines by
one are a sixth sooner, but .034 of the light off in `hair` in place of .030."""


@dataclass(frozen=True)
class NearbyShadows(VertexShadows):
    """Strands in one light, those that it reaches sorted into cells."""

    grid: Grid
    depth: NDArray[np.float32]
    """(V,) optical depth in front of each vertex."""
    buried: NDArray[np.uint8]
    """(V,) 1 for vertices that the map shades."""

    @property
    def nbytes(self) -> int:
        """Bytes of its arrays."""
        return self.grid.nbytes + self.depth.nbytes + self.buried.nbytes

    def visibility(
        self, lines: Polylines, marks: NDArray[np.uint8], screen: NDArray[np.float32], out: NDArray[np.float32]
    ) -> None:
        """See `VertexShadows.visibility`."""
        self.grid.visibility(lines, self._open_to_light(marks), screen, out)
        self._shade_by_map(marks, out)

    def visibility_across(
        self, lines: Polylines, marks: NDArray[np.uint8], screen: NDArray[np.float32], out: NDArray[np.float32],
        eye: View, slots: NDArray[np.int32], shown: NDArray[np.uint64] | None, shades: NDArray[np.uint64],
    ) -> None:  # fmt: skip
        """See `VertexShadows.visibility_across`; what the map leaves is the same across a strand."""
        wide = np.flatnonzero(slots >= 0)
        kept = np.exp(-self.depth[wide])
        shades[slots[wide]] = EVENLY[np.rint(PLACES * (1 - kept)).astype(np.int64)]  # those below are written over
        self.grid.visibility_across(lines, self._open_to_light(marks), screen, out, eye, slots, shown, shades)
        self._shade_by_map(marks, out)

    def _open_to_light(self, marks: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the marks of vertices that are not buried."""
        return ((marks != 0) & (self.buried == 0)).astype(np.uint8)

    def _shade_by_map(self, marks: NDArray[np.uint8], out: NDArray[np.float32]) -> None:
        """Write what the map leaves at the marked vertices that are buried."""
        dark = np.flatnonzero((marks != 0) & (self.buried != 0))
        out[dark] = np.exp(-self.depth[dark].astype(np.float64))


def nearby_of(light: Light, strands: StrandsInLight) -> NearbyShadows:
    """Return the shadows of strands in a light that has opacity maps."""
    lines, scratch, number = strands.lines, strands.scratch, strands.number
    depth = scratch.borrow(f"nearby_depth_{number}", len(lines.world), np.float32)
    buried = scratch.borrow(f"nearby_buried_{number}", len(lines.world), np.uint8)
    row = np.flatnonzero(strands.lights[:, CLEAR_ROW] == number + 1)[0]
    kernel.depths(lines.world, strands.lights, np.int64(row), strands.maps, depth)
    kernel.bury(lines.first, depth, LIMIT, buried)
    grid = grid_of(
        light, lines, strands.thickness, strands.opacity, strands.bounds, strands.workers, scratch, number,
        left_out=buried,
    )  # fmt: skip
    return NearbyShadows(replace(grid, together=TOGETHER), depth, buried)
