"""What strands that interact begin inside each other by, and how that is over by and by."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..rod.kernels.arrays import AXES, PACK
from .kernels.begin import INSIDE, Pace, find_overlap, find_shares, lead_apart
from .kernels.records import FULL, Lattice, Moving

RATE, LONGEST = 2.0, 1 / 24
"""Widths of what they fill at the start by which strands are led apart a second, where nothing holds them; and seconds:
longer steps go on no further."""
PRESSING = 900.0
"""Pressure over the metres in a cell that strands are led apart by at the most, as the acceleration that it hands to
them where there is none in the next cell, in cells a second². With half of it a bundle opens two thirds as far, with
more it moves faster."""
REACH = 0.5
"""Cells by which the grid takes strands beside themselves at the most, along each axis."""
PLASTIC = 1.2207440846057596
"""Root of x⁴ = x + 1: of multiples of its inverse powers, places in a cube are spread evenly (Roberts 2018)."""


class Overlap:
    """Which of the ``samples`` of so many ``packs`` of strands begin inside each other, and how far that is let
    be."""

    def __init__(self, packs: int, samples: int, dtype: Any) -> None:
        self._shape, self._kind = (packs, samples, PACK), np.dtype(dtype).type
        self.started = False
        """Whether there has been a step."""
        self.roots: NDArray[Any] | None = None
        """As `Moving.overlap`."""
        self._begun: NDArray[Any] | None = None
        """The same at the start."""
        self._offsets: NDArray[Any] | None = None

    @property
    def reach(self) -> float:
        """Cells by which samples may be beside strands."""
        return 0.0 if self.roots is None else REACH

    def begin(self, moving: Moving, lattice: Lattice, parts: Any, found: tuple[Any, ...] | None, work: Any) -> bool:
        """Where this is the first step, find what begins inside each other; return whether anything does. ``found``:
        the box, the grid, `Room.open`, the numbers of the step and what `donor_cells.settle` has left; None where
        nothing is too dense."""
        first, self.started = not self.started, True
        if not first or found is None:
            return False
        box, grid, open, numbers, homes, closed = found
        shares = np.empty(grid.shape[1], np.float32)
        find_shares(box, grid, open, numbers, homes, closed, shares)
        if float(shares.min()) == 1:
            return False
        self.roots = np.ones(self._shape, self._kind)
        find_overlap(moving, lattice, parts, box, shares, work, self.roots)
        self._begun = self.roots.copy()
        return True

    def taken(self, moving: Moving) -> Moving:
        """Return what kernels take of strands in a step."""
        if self.roots is None:
            return moving
        if self._offsets is None:
            self._offsets = offsets_of(self._shape[0]).astype(self._kind)
        return moving._replace(overlap=self.roots, offsets=self._offsets)

    def advance(self, moving: Moving, lattice: Lattice, parts: Any, found: tuple[Any, ...], work: Any) -> None:
        """Go on by a step, for as long as any does not count wholly. ``moving``: as `taken` returns it; ``found``: the
        box, the grid, pressure and the numbers of the step."""
        if self.roots is None:
            return
        box, grid, pressure, numbers = found
        step = min(float(lattice.step), LONGEST)
        limits = RATE * step, PRESSING * step**2 / numbers[FULL], INSIDE * numbers[FULL]
        pace = Pace(*map(self._kind, limits))
        if not lead_apart(moving, lattice, parts, box, grid, pressure, pace, work, self._begun, self.roots):
            self.roots = self._begun = self._offsets = None

    def state_arrays(self) -> dict[str, NDArray[Any]]:
        """Return what a step takes from those before."""
        known = [one.reshape(-1) for one in (self.roots, self._begun) if one is not None]
        both = np.concatenate(known) if known else np.empty(0, self._kind)
        return {"overlap": np.array([self.started]), "free overlap": both}

    def check(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Raise `ValueError` where that is of other strands."""
        if len(state["free overlap"]) not in (0, 2 * math.prod(self._shape)):
            raise ValueError("its overlap is not of its strands")

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Go on from that."""
        self.started, both = bool(state["overlap"][0]), state["free overlap"]
        self.roots, self._begun = np.array(both).reshape(2, *self._shape) if len(both) else (None, None)


def offsets_of(packs: int) -> NDArray[np.float64]:
    """Return (packs, 3 S) offsets of strands, each within `REACH` along each axis."""
    spread = (np.arange(1, packs * PACK + 1)[:, None] * PLASTIC ** -np.arange(1.0, 4.0)) % 1 - 0.5
    return (2 * REACH * spread).reshape(packs, PACK, 3).transpose(0, 2, 1).reshape(packs, AXES)
