"""Strands as polylines: how many pieces, and where their vertices are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...scene.model import Curves
from ..common.scratch import Scratch
from ..view.camera import View
from .kernels import curves as kernel


@dataclass(frozen=True)
class Polylines:
    """Polylines of consecutive strands: strand s owns the vertices first[s] … first[s + 1] − 1."""

    first: NDArray[np.int64]
    """(strands + 1,)"""
    world: NDArray[np.float32]
    """(V, 3) metres."""
    error: float | None = None
    """Greatest distance of a piece from its curve in pixels; None where it was not asked for."""
    per: int = 0
    """Vertices a strand where all have the same number, else 0."""
    segment: float = 0.0
    """Rest length of the longest segment between particles, metres; only where all strands have the same number."""
    pieces: int = 1
    """Pieces a segment there."""
    stride: int = 1
    """Only every stride-th vertex of a strand is shaded: fine curves have `LIT_PIECES` shaded vertices a segment."""
    scale: NDArray[np.float32] | None = None
    """(strands,) factor of each strand's width; None: 1."""

    @property
    def segments(self) -> int:
        """Line pieces in all."""
        return int(len(self.world) - np.count_nonzero(np.diff(self.first)))


LIT_PIECES = 2
"""Of a segment. The sorted picture of `strandcli bench` is then .3 % off one that is lit at all four (root mean square
over the mean), and .7 % with one. To light every other place only where strands bend little saves next to nothing: what
bends by less than four degrees is a fifth of all and makes two thirds of that error, in the preset `hair` 1.3 %."""

NO_PIECES = np.zeros((0, 0), np.uint16)
NONE_LEFT_OUT = np.zeros(0, np.float32)
"""What kernels are handed where it is not asked for: None would have them compiled anew."""


def greatest_pieces(curves: Curves) -> int:
    """Pieces that a segment can become."""
    return 1 if curves.mode == "off" else 2**curves.level


def flatten(
    positions: NDArray[np.float32],
    lengths: NDArray[np.float32] | None,
    strands: int,
    curves: Curves,
    view: View,
    keep_unseen: bool,
    scratch: Scratch,
    kept: NDArray[np.float32] | None = None,
) -> Polylines:
    """Polylines of the first ``strands`` strands.

    positions (blocks, n + 1, 3 W), lengths (blocks, W), or None where segments of a strand differ: then each has the
    length of its chord, and tangents are those of the circle through three particles. ``keep_unseen``: strands off the
    screen are kept, coarsely, because a light's shadow map needs them; otherwise adaptive curves leave them out.
    ``kept`` (strands,): strands with 0 are left out in any case.
    """
    n = positions.shape[1] - 1
    first = scratch.take("first", strands + 1, np.int64)
    first[0] = 0
    most = greatest_pieces(curves)
    pieces = NO_PIECES
    error = None
    printed = curves.tangents == "printed"
    if curves.mode == "adaptive":
        pieces = scratch.take("pieces", (strands, n - 1), np.uint16)
        bound = scratch.take("curve_error", strands, np.float32)
        sizes = scratch.take("sizes", strands, np.int64)
        kernel.count(
            positions, lengths, strands, view.pack(),
            kernel.Splitting(
                most, np.float32(curves.tolerance), int(keep_unseen), NONE_LEFT_OUT if kept is None else kept, printed
            ),
            pieces, sizes, bound,
        )  # fmt: skip
        np.cumsum(sizes, out=first[1:])
        error = float(bound.max())
    elif kept is not None:
        np.cumsum(np.where(kept > 0, (n - 1) * most + 1, 0), out=first[1:])
    else:
        first[:] = np.arange(strands + 1, dtype=np.int64) * ((n - 1) * most + 1)
    world = scratch.take("world", (int(first[-1]), 3), np.float32)
    kernel.flatten(positions, lengths, strands, pieces, most, printed, curves.mode == "off", first, world)
    if error is not None or kept is not None:
        return Polylines(first, world, error)
    longest = kernel.longest(positions) if lengths is None else lengths.max()
    return Polylines(first, world, None, (n - 1) * most + 1, float(longest), most, max(most // LIT_PIECES, 1))
