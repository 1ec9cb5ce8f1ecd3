"""What strands that interact begin inside each other by, and how that is over by and by."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .kernels import crowd_begin
from .kernels.crowd_records import Lattice, Moving
from .kernels.rod_scratch import AXES, PACK

DURATION = 1.0
"""Seconds in which strands that begin inside each other are led apart: in half of that curls that begin 28 times too
dense move by 2.2 cells a frame (nearly all of them) in place of 2."""
REACH = 0.5
"""Cells by which the grid takes strands beside themselves at the most, along each axis."""
PLASTIC = 1.2207440846057596
"""Root of x⁴ = x + 1: of multiples of its inverse powers, places in a cube are spread evenly (Roberts 2018)."""


class Overlap:
    """Which of the ``samples`` of so many ``packs`` of strands begin inside each other, and since when that is let
    be."""

    def __init__(self, packs: int, samples: int, dtype: Any) -> None:
        self._shape, self._kind = (packs, samples, PACK), np.dtype(dtype).type
        self.time = math.nan
        """Seconds since strands began inside each other; NaN before the first step."""
        self.roots: NDArray[Any] | None = None
        """As `Moving.overlap`."""
        self._offsets: NDArray[Any] | None = None

    @property
    def reach(self) -> float:
        """Cells by which samples may be beside strands."""
        return 0.0 if self.roots is None else REACH

    def begin(self, moving: Moving, lattice: Lattice, parts: Any, found: tuple[Any, ...] | None, work: Any) -> bool:
        """Where this is the first step, find what begins inside each other; return whether anything does. ``found``:
        the box, the grid, `Room.open`, the numbers of the step and what `crowd_homes.settle` has left; None where
        nothing is too dense."""
        first, self.time = math.isnan(self.time), max(0.0, self.time)
        if not first or found is None:
            return False
        box, grid, open, numbers, homes, closed = found
        shares = np.empty(grid.shape[1], np.float32)
        crowd_begin.find_shares(box, grid, open, numbers, homes, closed, shares)
        if float(shares.min()) == 1:
            return False
        self.roots = np.empty(self._shape, self._kind)
        crowd_begin.find_overlap(moving, lattice, parts, box, shares, work, self.roots)
        return True

    def taken(self, moving: Moving, lattice: Lattice, dt: float) -> tuple[Moving, Lattice]:
        """Return what kernels take of strands in a step of ``dt`` seconds."""
        if self.roots is None:
            return moving, lattice
        if self._offsets is None:
            self._offsets = offsets_of(self._shape[0]).astype(self._kind)
        x = min((self.time + dt) / DURATION, 1.0)
        parted = self._kind(x * x * (3 - 2 * x))
        return moving._replace(overlap=self.roots, offsets=self._offsets), lattice._replace(parted=parted)

    def advance(self, dt: float) -> None:
        """Go on by a step of ``dt`` seconds, for as long as anything is let be."""
        if self.roots is None:
            return
        self.time += dt
        if self.time > DURATION - dt / 2:  # times do not add up to the last digit
            self.roots = self._offsets = None

    def state_arrays(self) -> dict[str, NDArray[Any]]:
        """Return what a step takes from those before."""
        roots = np.empty(0, self._kind) if self.roots is None else self.roots.reshape(-1)
        return {"overlap": np.array([self.time]), "free overlap": roots}

    def check(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Raise `ValueError` where that is of other strands."""
        if len(state["free overlap"]) not in (0, math.prod(self._shape)):
            raise ValueError("its overlap is not of its strands")

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Go on from that."""
        self.time, roots = float(state["overlap"][0]), state["free overlap"]
        self.roots = np.array(roots).reshape(self._shape) if len(roots) else None


def offsets_of(packs: int) -> NDArray[np.float64]:
    """Return (packs, 3 S) offsets of strands, each within `REACH` along each axis."""
    spread = (np.arange(1, packs * PACK + 1)[:, None] * PLASTIC ** -np.arange(1.0, 4.0)) % 1 - 0.5
    return (2 * REACH * spread).reshape(packs, PACK, 3).transpose(0, 2, 1).reshape(packs, AXES)
