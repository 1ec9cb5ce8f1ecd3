"""Shadows of strands on strands that are told vertex by vertex."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.scratch import Scratch
from ..coverage.kernels.column_light import LINES, PLACES
from ..geometry.curves import Polylines
from ..geometry.extent import Thickness
from ..view.camera import View

EVENLY = np.array(
    [
        [
            sum(1 << i for i in range(PLACES) if ((i + 1) * k + shift) // PLACES > (i * k + shift) // PLACES)
            for shift in range(0, PLACES, PLACES // LINES)
        ]
        for k in range(PLACES + 1)
    ],
    np.uint64,
)
"""(`PLACES` + 1, LINES) words of which so many bits are set, evenly along each line and from line to line."""


class StrandsInLight(NamedTuple):
    """What a model knows when it is asked for the shadows in one light."""

    lines: Polylines
    """All strands of the exposure."""
    thickness: Thickness
    opacity: float
    """Of a strand, 0 to 1."""
    bounds: NDArray[np.float64]
    """(2, 3) the box about all strands, metres."""
    workers: int
    """Threads that may be used; what is found must not depend on them."""
    scratch: Scratch
    number: int
    """Of the light among those whose model shades vertices."""


class VertexShadows:
    """The shadows of all strands in one light."""

    @property
    def nbytes(self) -> int:
        """Bytes that it takes."""
        return 0

    def visibility(
        self, lines: Polylines, marks: NDArray[np.uint8], screen: NDArray[np.float32], out: NDArray[np.float32]
    ) -> None:
        """Into out (V,): the share of the light, 0 to 1, that strands leave at the vertices with ``marks`` (V,), which
        a camera sees at ``screen`` (V, 3), in samples. Others may be left as they are."""
        raise NotImplementedError

    def across(
        self, lines: Polylines, marks: NDArray[np.uint8], screen: NDArray[np.float32], out: NDArray[np.float32],
        eye: View, slots: NDArray[np.int32], shown: NDArray[np.uint64] | None, shades: NDArray[np.uint64],
    ) -> None:  # fmt: skip
        """As `visibility`, and into shades (n, LINES): what is dark across the pieces after the vertices that have
        ``slots`` (V,) ≥ 0, a bit for each of `PLACES` places along each line. Here evenly."""
        wide = slots >= 0
        found = np.ones_like(out)
        self.visibility(lines, ((marks != 0) | wide).astype(np.uint8), screen, found)
        dark = np.rint(PLACES * np.clip(1.0 - found[wide], 0.0, 1.0)).astype(np.int64)
        shades[slots[wide]] = EVENLY[dark]
        np.copyto(out, found, where=marks != 0)
