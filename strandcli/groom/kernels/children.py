"""Interpolation of children, the drawn strands, from guides, the simulated ones; W children at a time, in vectors.

Guides are particles g (G, m + 1, 3), subdivided if waves need it; row 0 is one segment before the root, row j + 1 is
particle j. A child at the share u of its guides' length lies at

    c(u) = root + Σ w_k (g_k(u) − g_k(0)),

each clump moves it toward the child at its centre, c += w(u) (c_centre(u) − c), and each wave displaces the result
perpendicular to the path. Segment lengths are restored, root to tip, after clumps and after waves: after clumps,
segments turn toward the displaced particles, so that the tips of a clump still meet; after waves they keep their
directions, so that a wave is not smoothed. Last, particles are moved out of solids.
"""

from __future__ import annotations

import numpy as np

from ...constants import W
from ...jit import parallel, prange
from ...simd import lane_count, pointer
from ...solids.kernels.outside import count as count_solids
from .child_path import follow_guides, restore_lengths
from .child_scratch import TURNING, first_wave, load_children
from .child_waves import write_strands

HALF = np.float32(0.5)
ONE = np.float32(1.0)


@parallel
def refine(positions, steps, out):
    """Write guides (blocks, n + 1, 3 W), subdivided into `steps` parts a segment on cubic Hermite curves with central
    differences, to out (G, (n − 1) steps + 2, 3)."""
    n = positions.shape[1] - 1
    per = ONE / np.float32(steps)
    for s in prange(out.shape[0]):
        block = positions[s // W]
        lane = s % W
        for c in range(3):
            k = c * W + lane
            a = block[1, k]
            out[s, 0, c] = a + (block[0, k] - a) * per
            out[s, 1, c] = a
            first = HALF * (block[2, k] - block[0, k])
            for i in range(1, n):
                b = block[i + 1, k]
                last = HALF * (block[i + 2, k] - a) if i + 1 < n else b - a
                e = b - a
                for j in range(1, steps):
                    t = np.float32(j) * per
                    bend = (first + last - e - e) * t + (e + e + e - first - first - last)
                    out[s, 1 + (i - 1) * steps + j, c] = a + t * (first + t * bend)
                out[s, 1 + i * steps, c] = b
                first = last
                a = b


@parallel
def grow(guides, own, following, clumps, waves, solids, out, lengths):
    """Write children of `Guides` to out (blocks, m + 1, 3 W), metres, and their segment lengths to lengths (blocks, W).

    own (N,) int32: numbers of the children to write; `Following`, `Clumps` and `Waves` hold all A children; solids:
    packed `Solids`. The last block is padded with copies of the last child.
    """
    for block in prange(out.shape[0]):
        b = np.int64(block)  # the index is unsigned, and would have functions compiled twice
        first = first_wave(clumps)
        scratch = np.empty(first + waves.forms.shape[0] * TURNING * W, np.float32)
        load_children(guides, following, clumps, waves, own, b * W, scratch, lengths[b])
        x = pointer(out)
        for k in range(0, W, lane_count(x)):
            follow_guides(guides, clumps, pointer(scratch), x, b, k)
            restore_lengths(pointer(scratch), x, b, k, out.shape[1])
            write_strands(waves, solids, count_solids(solids) > 0, scratch, first, out, b, k)
