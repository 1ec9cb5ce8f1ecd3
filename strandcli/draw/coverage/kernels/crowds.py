"""Fragments that cannot be seen, because those in front of them let no light through, left out before they are sorted.

Of a pixel's fragments nearer than some depth, the light that they let through is at most the product of 1 − opacity:
parts of one surface, whose opacities add up (see `resolve.composite`), let less through. While fragments are found,
they are multiplied in the order in which they come: rows of segments come about nearest first (see `order_rows`), so
the farthest of them soon hides the rest. Compositing never reaches what is left out, and no picture depends on the
order in which fragments are found.
"""

from __future__ import annotations

import numpy as np

from ....jit import device, inlined
from ....simd import load, quadruple_pointer, store
from ...common.kernels.numbers import ONE
from .tile_binning import BLOCK
from .tiles import AT_DEPTH, AT_PLACE, NUMBERS, PIXELS

SAFE = np.float32(1 - 1e-6)
"""Factor of depth numbers and of transmittances, so that rounding hides nothing visible."""
ROUNDED = np.float32(0.999)
"""Factor of transmittances that are products of thousands of numbers."""
NEAREST = np.float32(np.inf)
"""Depth number in front of which nothing is."""
TINY = np.float32(1e-30)
ONE_MORE, FOUR = np.uint64(1), np.uint64(NUMBERS)
IN_PIXEL = np.int32(PIXELS - 1)
"""Mask of the pixel in the column `AT_PLACE`."""


@inlined
def count_visible(target, pixel, depth, alpha):
    """Return whether a fragment is in front of all that hides; if so, count it and its opacity `alpha` in its pixel.

    target: `cells.Target`. Once the product of 1 − opacity falls below `target.opaque`, nothing behind the farthest of
    the fragments in it is seen, and a product of nearer ones begins."""
    visible = depth >= target.occlusion_depth[pixel]
    through = target.through[pixel] * (ONE - alpha if visible else ONE)
    least = min(target.least[pixel], depth if visible else NEAREST)
    target.through[pixel] = through
    target.least[pixel] = least
    target.counts[pixel] += np.int64(visible)
    if through < target.opaque:  # seldom, so it is predicted
        target.occlusion_depth[pixel] = least
        target.through[pixel] = ONE
        target.least[pixel] = NEAREST
    return visible


@device
def list_by_pixel(fragments, n, counts, ends, depths, listed):
    """List a tile's n fragments by pixel, so that a pixel's are together in memory: those of a crowded tile do not fit
    into a core's own cache.

    fragments: columns of `tiles`; counts (PIXELS,): length of each pixel's list; ends (PIXELS,): written, index of the
    end of each list; depths, listed: written, depth numbers and the fragments themselves, list after list.
    """
    total = np.int64(0)
    for p in range(PIXELS):
        ends[p] = total
        total += counts[p]
    given, out = quadruple_pointer(fragments), quadruple_pointer(listed)
    for i in range(np.uint64(n)):
        p = np.uint64(fragments[i * FOUR + AT_PLACE] & IN_PIXEL)
        at = np.uint64(ends[p])
        ends[p] = np.int32(at + ONE_MORE)
        depths[at] = np.int32(fragments[i * FOUR + AT_DEPTH]).view(np.float32)
        store(out, at * FOUR, load(given, i * FOUR))


CROWDED = 384
"""Rows of a tile from which on they are ordered."""
SLICES = PIXELS - 1
SLICE_COUNT = np.float32(SLICES)


@device
def list_rows(segments, tile, slots):
    """Write where the rows of a tile are in the pool to slots (room,) int32, as many as there is room for; return how
    many there are. segments: `tile_binning.TileSegments`."""
    n = np.int64(0)
    room = slots.shape[0]
    for one in range(segments.heads.shape[0]):
        block, stop = segments.heads[one, tile], segments.fills[one, tile]
        while stop > 0:
            final = block == (stop - 1) // BLOCK
            begin, end = block * BLOCK, stop if final else block * BLOCK + BLOCK
            for slot in range(begin, min(end, begin + max(room - n, 0))):
                slots[n + slot - begin] = slot
            n += end - begin
            if final:
                break
            block = segments.links[block]
    return n


@device
def order_rows(row_depths, slots, listed, depths, begin):
    """Write listed rows (n,) to slots (n,), nearest first; row_depths: of `TileSegments`; depths (n or more,) float32,
    begin (PIXELS,) int32: scratch."""
    n = slots.shape[0]
    low, high = np.float32(np.inf), np.float32(-np.inf)
    for i in range(n):
        depth = row_depths[listed[i]]
        depths[i] = depth
        low, high = min(low, depth), max(high, depth)
    per = SLICE_COUNT / max(high - low, TINY)
    begin[:] = 0
    for i in range(n):
        begin[slice_of(depths[i], high, per) + 1] += 1
    for k in range(SLICES):
        begin[k + 1] += begin[k]
    for i in range(n):
        k = slice_of(depths[i], high, per)
        slots[begin[k]] = listed[i]
        begin[k] += 1


@device
def slice_of(depth, high, per):
    """Return the slice of a depth number; high: the greatest; per: slices for each unit of depth numbers."""
    return min(np.int64((high - depth) * per), SLICES - 1)
