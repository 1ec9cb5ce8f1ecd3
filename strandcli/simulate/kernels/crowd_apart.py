"""Strands that are in no grid, for they are far from all others: what they hand to cells counts for nothing, and they
get nothing from them."""

from __future__ import annotations

from ...jit import device
from ...simd import broadcast, lane_count, load, load3, pointer, store3, where
from .crowd_records import OF_ROOT
from .rod_scratch import AXES, PACK


@device
def within(left_out, at, place):
    """Where the grid takes a sample to be, of the strands from lane ``at[2]`` of pack ``at[0]`` on, by its ``place``,
    both in cells: of strands that are left out, in the first cell of all, for no product of weights is to overflow."""
    if left_out is None:
        return place
    x, y, z = place
    out = load(pointer(left_out), at[0] * PACK + at[2]) > 0.0
    none = broadcast(pointer(left_out), 0.0)
    return where(out, none, x), where(out, none, y), where(out, none, z)


@device
def leave_alone(left_out, pack, rows, crowd):
    """Set the accelerations of a pack's strands that are left out to zero, ``crowd`` and `OF_ROOT` of scratch."""
    if left_out is None:
        return
    root, out = pointer(rows), pointer(crowd)
    for k in range(0, PACK, lane_count(out)):
        alone = load(pointer(left_out), pack * PACK + k) > 0.0
        none = broadcast(out, 0.0)
        x, y, z = load3(root, OF_ROOT * PACK + k, PACK)
        store3(root, OF_ROOT * PACK + k, PACK, where(alone, none, x), where(alone, none, y), where(alone, none, z))
        for j in range(crowd.shape[1]):
            at = (pack * crowd.shape[1] + j) * AXES + k
            x, y, z = load3(out, at, PACK)
            store3(out, at, PACK, where(alone, none, x), where(alone, none, y), where(alone, none, z))
