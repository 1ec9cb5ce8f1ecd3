"""Interface of shadows that a model computes at strand vertices."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.scratch import Scratch
from ..coverage.kernels.column_light import LINES, PLACES
from ..geometry.curves import Polylines
from ..geometry.extent import Thickness
from ..view.camera import View
from .kernels.shadow_arrays import ShadowArrays

_k, _shift, _i = np.ogrid[: PLACES + 1, : PLACES : PLACES // LINES, :PLACES]
_set = ((_i + 1) * _k + _shift) // PLACES > (_i * _k + _shift) // PLACES
EVENLY = (_set.astype(np.uint64) << _i.astype(np.uint64)).sum(2)
"""(`PLACES` + 1, LINES) words: row k has k bits set in each word, spread evenly along each line and between lines."""


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

    @property
    def nbytes(self) -> int:
        """Bytes of its arrays."""
        return 0

    def visibility(
        self, lines: Polylines, marks: NDArray[np.uint8], screen: NDArray[np.float32], out: NDArray[np.float32]
    ) -> None:
        """Write the visibility of the light, 0 to 1, at the vertices with non-zero ``marks`` (V,) to out (V,); other
        entries are undefined. ``screen`` (V, 3): positions of the vertices in the camera's view, in samples."""
        raise NotImplementedError

    def visibility_across(
        self, lines: Polylines, marks: NDArray[np.uint8], screen: NDArray[np.float32], out: NDArray[np.float32],
        eye: View, slots: NDArray[np.int32], shown: NDArray[np.uint64] | None, shades: NDArray[np.uint64],
    ) -> None:  # fmt: skip
        """Compute `visibility`, and write shadows across strands to shades (n, LINES).

        The segment after each vertex with ``slots`` (V,) ≥ 0 has one row: a word for each line, a bit for each of
        `PLACES` places along it, set where it is in shadow. This default spreads the shadow evenly."""
        wide = slots >= 0
        found = np.ones_like(out)
        self.visibility(lines, ((marks != 0) | wide).astype(np.uint8), screen, found)
        dark = np.rint(PLACES * np.clip(1.0 - found[wide], 0.0, 1.0)).astype(np.int64)
        shades[slots[wide]] = EVENLY[dark]
        np.copyto(out, found, where=marks != 0)
