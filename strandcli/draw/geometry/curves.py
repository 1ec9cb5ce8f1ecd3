"""Polylines of strands: number of pieces for each segment of a curve, and positions of the vertices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...constants import W
from ...scene.model import Curves
from ..common.scratch import Scratch
from ..view.camera import View
from .kernels import curves as kernel
from .kernels import piece_counts, thinning


@dataclass(frozen=True)
class Polylines:
    """Polylines of consecutive strands: strand s owns the vertices first[s] … first[s + 1] − 1."""

    first: NDArray[np.int64]
    """(strands + 1,)"""
    world: NDArray[np.float32]
    """(V, 3) metres."""
    error: float | None = None
    """Bound on the distance of the polyline from its curve, pixels; None if curves are neither adaptive nor thinned."""
    per: int = 0
    """Vertices a strand if all strands have the same number, else 0."""
    segment: float = 0.0
    """Rest length of the longest segment between particles, metres; 0 if `per` is."""
    pieces: int = 1
    """Pieces that each segment between particles is cut into, if `per` is not 0."""
    stride: int = 1
    """Only every stride-th vertex of a strand is lit: fine curves have `LIT_PIECES` lit vertices a segment."""
    scale: NDArray[np.float32] | None = None
    """(strands,) factor of each strand's width; None: 1."""
    along: NDArray[np.float32] | None = None
    """(V,) how far along its strand each vertex stands, 0 at the root to 1 at the tip; None: evenly."""
    lost: NDArray[np.float32] | None = None
    """(V,) share of its strand's width that is lost at each vertex; None: what the material's taper takes up to
    there."""
    tangents: NDArray[np.float32] | None = None
    """(V, 3) along the strand at each vertex, root to tip, of any length; None: from the vertex before to the next."""

    def tapered(self, taper: float) -> tuple[np.float32, NDArray[np.float32] | None]:
        """Return what share of its width a strand of a material of this taper loses where a number (V,) of a vertex is
        1, less in proportion to it; and these numbers, None: from 0 at the root evenly to 1 at the tip."""
        return (np.float32(taper), self.along) if self.lost is None else (np.float32(1.0), self.lost)

    @property
    def segments(self) -> int:
        """Number of straight segments of all polylines."""
        return int(len(self.world) - np.count_nonzero(np.diff(self.first)))


LIT_PIECES = 2
"""Lit vertices a segment between particles. The sorted picture of `strandcli bench` then differs by .3 % from one lit
at all four (root mean square over the mean), with one by .7 %. To skip lit vertices only where strands bend little
saves almost nothing: bends of less than four degrees are a fifth of all and make two thirds of that error, in the
preset `hair` 1.3 %."""

NO_PIECES = np.zeros((0, 0), np.uint16)
"""All segments have the same number of pieces. An empty array, because None would compile another variant."""
ALL_DRAWN = np.zeros(0, np.float32)
"""No strand is left out. Empty for the same reason."""
NOT_ALONG = np.zeros(0, np.float32)
"""Where vertices stand along their strands is not wanted. Empty for the same reason."""


STRAIGHT = ("off", "thinned")
"""Modes in which segments are straight."""


def greatest_pieces(curves: Curves) -> int:
    """Return the greatest number of pieces of a segment."""
    return 1 if curves.mode in STRAIGHT else 2**curves.level


def flatten(
    positions: NDArray[np.float32],
    lengths: NDArray[np.float32] | None,
    strands: int,
    curves: Curves,
    view: View,
    keep_off_screen: bool,
    scratch: Scratch,
    fade: NDArray[np.float32] | None = None,
    radii: NDArray[np.float32] | None = None,
) -> Polylines:
    """Return the polylines of the first ``strands`` strands, in arrays borrowed from ``scratch``.

    positions (blocks, n + 1, 3 W), metres; lengths (blocks, W): of the segments of each strand, or None if they differ
    within a strand: then each segment has the length of its chord, and tangents are those of the circle through three
    particles. ``keep_off_screen``: keep strands off the screen, coarsely, because a shadow map needs them, and those
    off a crop window as the whole picture has them, so that their shadows are the same; otherwise adaptive curves
    leave them out. ``fade`` (strands,): strands with 0 are always left out. ``radii`` (strands, n), metres: at the
    points, where widths too decide which of them are left out.
    """
    if curves.mode == "thinned":
        return _thinned(positions, strands, curves, view, scratch, fade, radii)
    n = positions.shape[1] - 1
    first = scratch.borrow("first", strands + 1, np.int64)
    first[0] = 0
    most = greatest_pieces(curves)
    pieces = NO_PIECES
    error = None
    printed = curves.tangents == "printed"
    if curves.mode == "adaptive":
        pieces = scratch.borrow("pieces", (strands, n - 1), np.uint16)
        bound = scratch.borrow("curve_error", strands, np.float32)
        sizes = scratch.borrow("sizes", strands, np.int64)
        piece_counts.count(
            positions, lengths, strands, (view.whole if keep_off_screen else view).pack(),
            piece_counts.Splitting(
                most, np.float32(curves.tolerance), int(keep_off_screen), ALL_DRAWN if fade is None else fade, printed
            ),
            pieces, sizes, bound,
        )  # fmt: skip
        np.cumsum(sizes, out=first[1:])
        error = float(bound.max())
    elif fade is not None:
        np.cumsum(np.where(fade > 0, (n - 1) * most + 1, 0), out=first[1:])
    else:
        first[:] = np.arange(strands + 1, dtype=np.int64) * ((n - 1) * most + 1)
    world = scratch.borrow("world", (int(first[-1]), 3), np.float32)
    # pieces differ from segment to segment: by number, vertices would stand elsewhere along the strand in each view
    along = NOT_ALONG if error is None else scratch.borrow("along", len(world), np.float32)
    kernel.flatten(positions, lengths, strands, pieces, most, printed, first, world, along)
    if error is not None or fade is not None:
        return Polylines(first, world, error, along=None if error is None else along)
    longest = _longest_segment(positions) if lengths is None else lengths.max()
    return Polylines(first, world, None, (n - 1) * most + 1, float(longest), most, max(most // LIT_PIECES, 1))


def _longest_segment(positions: NDArray[np.float32]) -> float:
    """Return the length of the longest segment of positions (blocks, n + 1, 3 W), metres."""
    squares = ((np.diff(block[1:], axis=0) ** 2).reshape(-1, 3, W).sum(1).max() for block in positions)
    return float(np.sqrt(max(squares)))


def _thinned(
    positions: NDArray[np.float32], strands: int, curves: Curves, view: View, scratch: Scratch,
    fade: NDArray[np.float32] | None, radii: NDArray[np.float32] | None,
) -> Polylines:  # fmt: skip
    """Return polylines of those particles alone that the rest are within the tolerance of; arguments as in
    `flatten`."""
    rows = scratch.borrow("chosen_rows", (strands, positions.shape[1] - 1), np.uint16)
    sizes, off = scratch.borrow("sizes", strands, np.int64), scratch.borrow("curve_error", strands, np.float32)
    left = ALL_DRAWN if fade is None else fade
    thinning.choose(positions, strands, view.whole.pack(), np.float32(curves.tolerance), left, radii, rows, sizes, off)
    first = scratch.borrow("first", strands + 1, np.int64)
    first[0] = 0
    np.cumsum(sizes, out=first[1:])
    world = scratch.borrow("world", (int(first[-1]), 3), np.float32)
    along = scratch.borrow("along", int(first[-1]), np.float32)
    tangents = scratch.borrow("tangents", world.shape, np.float32)
    thinning.write(positions, rows, first, world, along, tangents)
    return Polylines(first, world, float(off.max()), along=along, tangents=tangents)
