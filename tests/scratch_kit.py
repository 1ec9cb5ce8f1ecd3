"""Scratch of a rod's step, as NumPy and as kernels see it: vectors of lanes in double precision."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from strandcli.constants import VECTOR
from strandcli.groom.blocks import aligned
from strandcli.jit import device
from strandcli.simd import fused_vector_pointer
from strandcli.simulate.rod.kernels.scratch import AFTER, BEFORE, SIZES, Scratch, scratch_at, vectors_for

LANES = VECTOR // 8
Floats = NDArray[np.float64]


class Rows:
    """Scratch of ``n`` segments: every field by its name, (n, vectors, `LANES`)."""

    def __init__(self, n: int) -> None:
        self.n, self.all = n, aligned((vectors_for(n), LANES), np.float64)

    def __getattr__(self, name: str) -> Floats:
        place = Scratch._fields.index(name)
        start = sum(SIZES[:place]) * (self.n + BEFORE + AFTER) + BEFORE * SIZES[place]
        rows: Floats = self.all[start : start + self.n * SIZES[place]].reshape(self.n, SIZES[place], LANES)
        return rows

    def before(self, name: str) -> Floats:
        """(vectors, `LANES`) the row of a field before the first segment."""
        place = Scratch._fields.index(name)
        start = sum(SIZES[:place]) * (self.n + BEFORE + AFTER)
        return self.all[start : start + SIZES[place]]


@device
def scratch(rows: Floats, n: int) -> Any:
    """The `Scratch` that `Rows` has in ``all``."""
    return scratch_at(fused_vector_pointer(rows), n)
