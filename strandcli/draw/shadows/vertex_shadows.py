"""Interface of shadows that a model computes at strand vertices."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.scratch import Scratch
from ..geometry.curves import Polylines
from ..geometry.extent import Thickness
from .kernels.strand_shadows import ShadowArrays


class StrandsInLight(NamedTuple):
    """Input of `ShadowModel.vertex_shadows`."""

    lines: Polylines
    """All strands of the exposure."""
    thickness: Thickness
    opacity: float
    """Opacity of a strand, 0 to 1."""
    bounds: NDArray[np.float64]
    """(2, 3) bounding box of all strands, metres."""
    workers: int
    """Number of threads; the result must not depend on it."""
    scratch: Scratch
    number: int
    """Index of the light among those whose model shades vertices."""
    lights: NDArray[np.float32]
    """(n, `light_columns.COLUMNS`) all lights that shine; `CLEAR_ROW` of this one is `number` + 1."""
    maps: ShadowArrays
    """Shadow maps of all lights, drawn."""


class VertexShadows:
    """The shadows of all strands in one light."""

    def visibility(
        self, lines: Polylines, marks: NDArray[np.uint8], screen: NDArray[np.float32], out: NDArray[np.float32]
    ) -> None:
        """Write the visibility of the light, 0 to 1, at the vertices with non-zero ``marks`` (V,) to out (V,); other
        entries are undefined. ``screen`` (V, 3): positions of the vertices in the camera's view, in samples."""
        raise NotImplementedError
