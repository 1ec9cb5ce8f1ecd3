"""Copies of some strands of polylines, for maps of lights that matter little (see `strandcli.draw.shadows.shares`)."""

from __future__ import annotations

import numpy as np

from ....jit import parallel, prange

STRANDS = 256
"""Strands a task."""


@parallel
def copy(first, world, along, chosen, out_first, out_world, out_along):
    """Copy the vertices of the strands with the numbers `chosen` (C,).

    first (S + 1,), world (V, 3), along (V,) or None: of `Polylines`; out_first (C + 1,): first vertex of each of them;
    out_world (K, 3), out_along (K,) out, the latter not where `along` is None."""
    count = chosen.shape[0]
    for task in prange((count + STRANDS - 1) // STRANDS):
        for k in range(np.int64(task) * STRANDS, min((np.int64(task) + 1) * STRANDS, count)):
            begin, at = np.uint64(first[chosen[k]]), np.uint64(out_first[k])
            for v in range(np.uint64(out_first[k + 1]) - at):
                for c in range(np.uint64(3)):
                    out_world[at + v, c] = world[begin + v, c]
                if along is not None:
                    out_along[at + v] = along[begin + v]
