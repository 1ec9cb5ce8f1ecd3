"""Interpolation of children, the drawn strands, from guides, the simulated ones; W children at a time, in vectors.

Guides are particles g (G, m + 1, 3), subdivided if waves need it; row 0 is one segment before the root, row j + 1 is
particle j. A child at the share u of its guides' length lies at

    c(u) = root + Σ w_k (g_k(u) − g_k(0)),

each clump moves it toward the child at its centre, c += w(u) (c_centre(u) − c), and each wave displaces the result
perpendicular to the path. Segment lengths are restored, root to tip, after clumps and after waves: after clumps,
segments turn toward the displaced particles, so that the tips of a clump still meet; after waves they keep their
directions, so that a wave is not smoothed. Last, particles are moved out of solids.
Paths along guides and clumps are computed child by child, a vector of the numbers of a row at a time; all else in rows
of W numbers, of which each lane has those of one child.
"""

from __future__ import annotations

import numpy as np

from ...constants import VECTOR, W
from ...jit import device, inlined, parallel, prange
from ...jit.indices import FIRST
from ...simd import broadcast, lane_count, line_pointer, load, load_triple, pointer, store
from ...solids.kernels.outside import count as count_solids
from .child_waves import FIRST_WAVE, TURNING, load_children, write_strands

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
ONE_PLACE = np.uint64(1)
TWO_PLACES = np.uint64(2)


@parallel
def refine(positions, steps, out):
    """Write guides (blocks, n + 1, 3 W), subdivided into `steps` parts a segment on cubic Hermite curves with central
    differences, to out (G, S) as `Guides.offsets`."""
    n = positions.shape[1] - 1
    per = ONE / np.float32(steps)
    for s in prange(out.shape[0]):
        block, row = positions[s // W], out[s]
        lane = s % W
        for k in range(((n - 1) * steps + 2) * 3, row.shape[0]):
            row[k] = ZERO
        for c in range(3):
            k = c * W + lane
            root = block[1, k]
            a = ZERO
            row[c] = (block[0, k] - root) * per
            row[3 + c] = ZERO
            first = HALF * (block[2, k] - block[0, k])
            for i in range(1, n):
                b = block[i + 1, k] - root
                last = HALF * (block[i + 2, k] - root - a) if i + 1 < n else b - a
                e = b - a
                at = (1 + (i - 1) * steps) * 3 + c
                for j in range(1, steps):
                    t = np.float32(j) * per
                    bend = (first + last - e - e) * t + (e + e + e - first - first - last)
                    row[at + 3 * j] = a + t * (first + t * bend)
                row[at + 3 * steps] = b
                first = last
                a = b


@parallel
def write_paths(guides, following, numbers, out):
    """Write the paths of children by their numbers (K,) int32, along their guides, to out (K, S), as
    `Clumps.paths`."""
    for c in prange(out.shape[0]):
        write_path(guides, following, np.uint64(numbers[c]), pointer(out), np.int64(c) * out.shape[1])


@parallel
def grow(guides, own, following, clumps, waves, solids, out, lengths):
    """Write children of `Guides` to out (blocks, m + 1, 3 W), metres, and their segment lengths to lengths (blocks, W).

    own (N,) int32: numbers of the children to write; `Following`, `Clumps` and `Waves` hold all A children; solids:
    packed `Solids`. The last block is padded with copies of the last child.
    """
    for block in prange(out.shape[0]):
        b = np.int64(block)  # the index is unsigned, and would have functions compiled twice
        scratch = np.empty((FIRST_WAVE + waves.forms.shape[0] * TURNING) * W, np.float32)
        load_children(guides, following, waves, own, b * W, scratch, lengths[b])
        size = guides.offsets.shape[1]
        work = np.empty((lane_count(pointer(scratch)) + 1) * size + VECTOR, np.float32)
        paths = line_pointer(work)
        for k in range(0, W, lane_count(paths)):
            for lane in range(lane_count(paths)):
                i = np.uint64(own[min(b * W + k + lane, own.shape[0] - 1)])
                write_path(guides, following, i, paths, lane * size)
                pull_path(clumps, i, paths, lane * size)
            write_strands(waves, solids, count_solids(solids) > 0, paths, size, scratch, out, b, k)
        work[0] = ZERO  # an array that is not named any more is freed, and `paths` does not name it


@device
def write_path(guides, following, i, rows, o):
    """Write the path of child i along its guides to rows from place o on, as a row of `Guides.offsets`, in metres from
    the origin."""
    step = lane_count(rows)
    a, b, c = load_triple(pointer(following.roots), np.int64(i) * 3)
    write_third(guides, following, i, rows, o, FIRST, a)
    write_third(guides, following, i, rows, o, step, b)
    write_third(guides, following, i, rows, o, 2 * step, c)


@inlined
def write_third(guides, following, i, rows, o, begin, root):
    """`write_path` of every third vector from place ``begin`` of the row on; root: the child's root in these."""
    every = pointer(guides.offsets)
    size, step = guides.offsets.shape[1], 3 * lane_count(rows)
    first = np.int64(following.parents[i, np.uint64(0)]) * size
    second = np.int64(following.parents[i, ONE_PLACE]) * size
    third = np.int64(following.parents[i, TWO_PLACES]) * size
    u = broadcast(rows, following.weights[i, np.uint64(0)])
    v = broadcast(rows, following.weights[i, ONE_PLACE])
    w = broadcast(rows, following.weights[i, TWO_PLACES])
    for k in range(begin, size, step):
        x = root + u * load(every, first + k) + v * load(every, second + k) + w * load(every, third + k)
        store(rows, o + k, x)


@device
def pull_path(clumps, i, rows, o):
    """Pull the path of child i, in rows from place o on, to the paths at the centres of its clumps, from the narrowest
    to the widest."""
    centres, ramps, size = pointer(clumps.paths), pointer(clumps.ramps), clumps.paths.shape[1]
    for level in range(clumps.centres.shape[1] - 1, -1, -1):
        pull = broadcast(rows, clumps.pulls[i, np.uint64(level)])
        centre, ramp = np.int64(clumps.centres[i, np.uint64(level)]) * size, level * size
        for k in range(0, size, lane_count(rows)):
            x = load(rows, o + k)
            store(rows, o + k, x + pull * load(ramps, ramp + k) * (load(centres, centre + k) - x))
