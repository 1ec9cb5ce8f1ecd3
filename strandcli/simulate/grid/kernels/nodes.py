"""Nodes: what the grid of strands that interact knows of each strand.

A node is a mean over neighbouring particles, or a particle, and samples are nodes or lie between two of them
(`samples`)."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device, inlined, parallel, prange
from ....simd import (
    any_lane,
    broadcast,
    lane_count,
    load3,
    pointer,
    prefetch3,
    reduce_max,
    store,
    store3,
    where,
)
from ...rod.kernels.arrays import AXES, PACK, ROW
from .records import FIRST, LAST, NODE

CHANGE = np.float32(0.25)
"""Share of what strands around have accelerated a strand by that this changes by from a step to the next, from which on
it is jolted: BDF2 would go on with that, and tips would never come to rest. Strands that hold each other off while they
swing together stay below."""
FARTHEST = np.float32(1e4)
"""Cells a step by which those around push a strand on at the most, for the next grid. Where it is too heavy to follow,
that would push it back by more, and so on without end."""
LONGEST = np.float32(1 / 60)
"""Seconds: of shorter steps both shares are less in proportion, for the same motion changes less in one of them. A
pressed layer would boil at 240 steps a second, by 35 mm/s."""
SLIGHT = np.float32(0.1)
"""Share of a strand's velocity against its tip by which that change at least changes velocities then."""


@parallel
def note(moving, lattice, parts):
    """Set the nodes and the ends of all strands."""
    for part in prange(len(parts)):
        for pack in range(parts[part, FIRST], parts[part, LAST]):
            note_pack(moving, lattice, pack)


@device
def note_pack(moving, lattice, pack):
    """Set `Moving.nodes` and `Moving.ends` of a pack."""
    positions, velocity, out = pointer(moving.positions), pointer(moving.velocity), pointer(moving.nodes)
    n, nodes = moving.velocity.shape[1], moving.nodes.shape[1]
    for lane in range(0, PACK, lane_count(positions)):
        none = broadcast(positions, 0.0)
        begin = pack * PACK // W * (n + 2) * ROW + ROW + pack * PACK % W + lane
        high, high_y, high_z = load3(positions, begin, W)
        low, low_y, low_z, wrong = -high, -high_y, -high_z, none
        for node in range(nodes):
            x, y, z, u, v, w = none, none, none, none, none, none
            for i in range(lattice.node_counts[node]):
                weight, particle = lattice.node_weights[node, i], lattice.node_first[node] + i
                a, b, c = load3(positions, begin + particle * ROW, W)
                high, high_y, high_z = max(high, a), max(high_y, b), max(high_z, c)
                low, low_y, low_z = max(low, -a), max(low_y, -b), max(low_z, -c)
                wrong += (a - a) + (b - b) + (c - c)
                x, y, z = x + weight * a, y + weight * b, z + weight * c
                if particle > 0:
                    a, b, c = load3(velocity, (pack * n + particle - 1) * AXES + lane, PACK)
                    u, v, w = u + weight * a, v + weight * b, w + weight * c
            place = (pack * nodes + node) * NODE * PACK + lane
            store3(out, place, PACK, x, y, z)
            store3(out, place + AXES, PACK, u, v, w)
        found = moving.ends[pack]
        if lane == 0:
            found[:] = -np.inf
        widen(found, 0, low, high)
        widen(found, 1, low_y, high_y)
        widen(found, 2, low_z, high_z)
        if any_lane(wrong != 0.0):
            found[:] = np.inf


@device
def widen(ends, axis, low, high):
    """Extend a pack's ends along an axis; ``low``: least coordinates times −1."""
    ends[axis] = max(ends[axis], reduce_max(low))
    ends[3 + axis] = max(ends[3 + axis], reduce_max(high))


@device
def keep_others(moving, lattice, packs, step, time, accelerations):
    """Set `Moving.others`, `Moving.pushed` and `Moving.jolted` of a pack of strands, whose accelerations are set.
    packs: that one, and the one that is prefetched; step: its length, seconds; time: `Lattice.seen` of that."""
    nodes, out, pushed = pointer(moving.nodes), pointer(moving.others), pointer(moving.pushed)
    count, pack = moving.nodes.shape[1], packs[0]
    ahead = (packs[1] - pack) * count * AXES
    most = FARTHEST / (lattice.inverse * step)
    share = min(step / LONGEST, 1.0)
    least, slight = share * CHANGE, share * SLIGHT
    for lane in range(0, PACK, lane_count(out)):
        past = broadcast(out, 0.0)
        changed, speed = past, past
        first, last = pack * count, pack * count + count - 1
        of_tip = load3(nodes, last * NODE * PACK + AXES + lane, PACK)
        for node in range(count):
            at = (first + node) * AXES + lane
            u, v, w = change_of_node(lattice, pack, node, lane, accelerations)
            a, b, c = load3(nodes, (first + node) * NODE * PACK + AXES + lane, PACK)
            d, e, f = within(time * u, most), within(time * v, most), within(time * w, most)
            store3(out, at, PACK, d + a, e + b, f + c)
            x, y, z = load3(pushed, at, PACK)
            prefetch3(pushed, at + ahead, PACK)
            store3(pushed, at, PACK, u, v, w)
            past += x * x + y * y + z * z
            changed += (u - x) * (u - x) + (v - y) * (v - y) + (w - z) * (w - z)
            if lattice.node_first[node] > 0:  # else a part of it is the root's velocity, which is not in it
                a, b, c = a - of_tip[0], b - of_tip[1], c - of_tip[2]
                speed += a * a + b * b + c * c
        much = (changed > least * least * past) & (step * step * changed > slight * slight * speed)
        store(pointer(moving.jolted), pack * PACK + lane, where(much, broadcast(out, 1.0), 0.0))


@inlined
def within(velocity, most):
    """A velocity along an axis, no more than ``most`` either way."""
    return min(max(velocity, -most), most)


@device
def change_of_node(lattice, pack, node, lane, accelerations):
    """What accelerates a node of strands from ``lane`` of a pack on, m/s²: the mean over its particles."""
    change, n = pointer(accelerations), accelerations.shape[1]
    u = broadcast(change, 0.0)
    v, w = u, u
    for i in range(lattice.node_counts[node]):
        weight, particle = lattice.node_weights[node, i], lattice.node_first[node] + i
        if particle > 0:
            a, b, c = load3(change, (pack * n + particle - 1) * AXES + lane, PACK)
            u, v, w = u + weight * a, v + weight * b, w + weight * c
    return u, v, w
