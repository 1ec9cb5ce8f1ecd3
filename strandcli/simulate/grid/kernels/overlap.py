"""Strands that begin inside each other: what is too dense at the start is let be at first, and led apart by and by.

A sample of a strand that begins where strands are r times as dense as allowed counts as too dense by the share
c = 1 / r alone, so that there is no pressure at the start. The root of c grows as the width does that parallel strands
fill as they are led apart: the density that is allowed in a cell, its metres over those that count, goes to that of the
preset. What pressure may hasten strands by (`limit`) is less by the same share.

What cannot part, as strands do at their roots, would be pressed the more in each step without end, and turn the rest
like a lever: bundles would burst into balls, and tips boil. So the root of c grows the slower the more pressure there
is for each metre of strand, stands still where there is much, and goes back where there is more. Strands part like a
fan then, come to rest, and stay as dense at their roots as these are.

Those that coincide would move as one: the grid hands the same to all. While they do not count wholly it takes each up
to half a cell beside itself, in a direction of its own, both where it leaves its metres and where it reads what
pressure hands to it, so that sums of momentum stay.
"""

from __future__ import annotations

from ....jit import device, inlined
from ....simd import broadcast, load, load3, pointer, store, where
from ...rod.kernels.arrays import AXES, PACK
from .records import CELL, COUNTING, MASS, OVERLAP, RESULT


@device
def beside(overlap, moving, at, rows, place, counts):
    """Where the grid takes a sample to be, of the strands from lane ``at[2]`` of pack ``at[0]`` on, by its ``place``,
    both in cells; within the box, of so many cells along each axis, even where numbers are too coarse for cells. Set
    the share of it that counts, in `RESULT` of scratch."""
    if overlap is None:
        return place
    (pack, sample, lane), (x, y, z) = at, place
    root = load(pointer(overlap), (pack * overlap.shape[1] + sample) * PACK + lane)
    store(pointer(rows), RESULT * PACK + lane, root * root)
    u, v, w = load3(pointer(moving.offsets), pack * AXES + lane, PACK)
    rest = 1.0 - root * root
    wide, high, deep = counts
    return inside(x + rest * u, wide), inside(y + rest * v, high), inside(z + rest * w, deep)


@inlined
def inside(x, count):
    """The nearest places between the middles of the first and the last of so many cells."""
    return min(max(x, 0.0), broadcast(x, count - 1))


@device
def counting(overlap, metres, rows, found):
    """Of the metres of a sample of each strand those that count as too dense."""
    if overlap is None:
        return metres
    for k in range(PACK):
        found[(CELL + 3) * PACK + k] = rows[RESULT, k]
    return metres * load(pointer(found), (CELL + 3) * PACK)


@device
def allowed(at, free, cells, count, numbers):
    """The density that a vector of cells may have, over that of the preset, of which the share ``free`` is open."""
    if numbers[OVERLAP] == 0:
        return free
    some = load(cells, COUNTING * count + at)
    return where(some > 0.0, free * (load(cells, MASS * count + at) / some), free)
