"""How many bytes the grid of the rule interaction takes.

Grids of usual cells take some megabytes, which other figures of `memory` hold. For fine ones the box of strands as they
are emitted is measured; it is seldom larger later, when they hang.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

from ..files.inputs import cached

if TYPE_CHECKING:
    from ..scene.model import Emitter, Scene

EACH = 180
"""Bytes of a cell: 101 of its own, and 32 in each box of a part of the strands that reaches it, 2.4 on average as
measured with `hair`."""
USUAL = 64_000_000
"""Bytes up to which strands are not emitted for it."""
STRANDS, LANES = 2000, 16
"""Strands that are emitted for it at the most; rows have so many cells, or a multiple of it."""
MOST = 4_000_000
"""Cells of the box at the most, with more of which no run begins."""


def grid_bytes(scene: Scene, strands: int) -> int:
    """Return the bytes of the grid of so many rods, 0 without the rule or for usual cells. Of strands from a file,
    which is not read for it, 0."""
    cell = next((use.parameters.cell for use in scene.rules if use.name == "interaction"), None)
    emitter = scene.emitter
    if cell is None or scene.solver != "rod" or strands < 1 or emitter.groom is not None:
        return 0
    if EACH * min(2 * emitter.length / cell, 1e6) ** 3 < USUAL:
        return 0
    few = dataclasses.replace(emitter, strands=min(strands, STRANDS), particles=2)
    return EACH * min(_cells(few, scene.seed, cell), MOST)


@cached(4)
def _cells(emitter: Emitter, seed: int, cell: float) -> int:
    """Return the cells of the box about straight strands."""
    import numpy as np

    from ..groom.emit import emit

    groom = emit(emitter, seed)
    ends = np.concatenate([groom.roots, groom.roots + groom.directions * groom.lengths[:, None]])
    wide, high, deep = (float(one) for one in np.minimum(np.ceil(np.ptp(ends, 0) / cell) + 2, 1e6))
    return int(-(-wide // LANES) * LANES * high * deep)
