"""The solid that is nearest to a segment among those that a search has considered, and the next one."""

from __future__ import annotations

from ....constants import W
from ....jit import device, inlined
from ....simd import any_lane, broadcast, load, load3, store, store3, where

FAR = 1e18
"""A gap where there is no solid near, metres."""


@inlined
def place(a, b, share):
    """A place on the segment from a to b."""
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2])


@device
def consider(s, j, near, gap, normal, share):
    """Take a solid into account at a place with a ``share``; mark in `Scratch.nearer` where it is the nearest. Returns
    True. ``near``: whether there has been one before."""
    one = broadcast(gap, 1.0)
    if not near:
        store(s.gap, j, gap)
        store3(s.normal, 3 * j, 1, normal[0], normal[1], normal[2])
        store(s.place, j, share)
        store(s.second_gap, j, FAR)
        store3(s.second_normal, 3 * j, 1, 0.0, 0.0, 0.0)
        store(s.nearer, j, one)
        return True
    best, second = load(s.gap, j), load(s.second_gap, j)
    nearer, next = gap < best, gap < second
    for k in range(3):
        past = load(s.normal, 3 * j + k)
        store(s.second_normal, 3 * j + k, where(nearer, past, where(next, normal[k], load(s.second_normal, 3 * j + k))))
        store(s.normal, 3 * j + k, where(nearer, normal[k], past))
    store(s.second_gap, j, min(max(gap, best), second))
    store(s.gap, j, min(gap, best))
    store(s.place, j, where(nearer, share, load(s.place, j)))
    store(s.nearer, j, where(nearer, one, 0.0))
    return True


@inlined
def with_slip(s, j, near, at, motion, past, moves):
    """Set by how much the place has moved on the solid that was considered last, where it is the nearest, if solids
    touch some lane. ``motion``: its rows, and the column where its motion begins; ``moves``: whether it has moved.
    Returns ``near``."""
    if any_lane((load(s.active, j) > 0.0) | (load(s.gap, j) < 0.0)):
        x, y, z = load3(past.positions, past.place, W)
        share = load(s.place, j)
        u, v, w = load3(past.positions, past.place - 3 * W, W)
        u, v, w = u - past.shift[0], v - past.shift[1], w - past.shift[2]
        x, y, z = u + share * (x - u), v + share * (y - v), w + share * (z - w)
        if moves:
            rows, m = motion
            u = rows[m] * x + rows[m + 1] * y + rows[m + 2] * z + rows[m + 9]
            v = rows[m + 3] * x + rows[m + 4] * y + rows[m + 5] * z + rows[m + 10]
            w = rows[m + 6] * x + rows[m + 7] * y + rows[m + 8] * z + rows[m + 11]
            x, y, z = u, v, w
        nearer = load(s.nearer, j) > 0.0
        u, v, w = load3(s.slip, 3 * j, 1)
        store3(s.slip, 3 * j, 1, where(nearer, at[0] - x, u), where(nearer, at[1] - y, v), where(nearer, at[2] - z, w))
    return near
