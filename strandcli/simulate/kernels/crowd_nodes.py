"""Nodes: what the grid of strands that interact knows of each strand, found while a step has it in the caches.

A node is a mean over neighbouring particles, or a particle, and samples are nodes or lie between two of them
(`crowd_samples`). A step ends by setting the nodes of the next one, pack by pack, which that would have to fetch three
arrays of all particles for; where something else has moved strands, `note` sets all of them.
"""

from __future__ import annotations

import numpy as np

from ...constants import W
from ...jit import device, function, parallel, prange
from ...simd import any_lane, broadcast, lane_count, load, load3, no_fma, pointer, reduce_max, store, store3
from .crowd_records import FIRST, LAST, NODE
from .records import ROTATION, TRANSLATION
from .rod_scratch import AXES, PACK

ROW = 3 * W
"""Numbers of a row of positions."""


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
def keep_others(moving, lattice, pack, time, crowd):
    """Set `Moving.others` of a pack of strands, whose accelerations are set."""
    nodes, change, out = pointer(moving.nodes), pointer(crowd), pointer(moving.others)
    n, count = crowd.shape[1], moving.nodes.shape[1]
    for lane in range(0, PACK, lane_count(out)):
        for node in range(count):
            u = broadcast(out, 0.0)
            v, w = u, u
            for i in range(lattice.node_counts[node]):
                weight, particle = lattice.node_weights[node, i], lattice.node_first[node] + i
                if particle > 0:
                    a, b, c = load3(change, (pack * n + particle - 1) * AXES + lane, PACK)
                    u, v, w = u + weight * a, v + weight * b, w + weight * c
            at = pack * count + node
            a, b, c = load3(nodes, at * NODE * PACK + AXES + lane, PACK)
            store3(out, at * AXES + lane, PACK, time * u + a, time * v + b, time * w + c)


@function
def move_roots(change, drift, duration, roots, velocity):
    """Set the velocity of roots (P, 3 S) that the emitter takes along, m/s, from their places in its frame ``roots``
    and the ``change`` of its pose in a step of ``duration`` seconds, as `Forcing.pose` begins. ``drift``: as
    `Forcing` has it, or no rows."""
    base, out = pointer(roots), pointer(velocity)
    for pack in range(len(roots)):
        for lane in range(pack * AXES, pack * AXES + PACK, lane_count(out)):
            x, y, z = load3(base, lane, PACK)
            for c in range(3):
                k = ROTATION + 3 * c
                way = no_fma(change[k] * x) + no_fma(change[k + 1] * y) + no_fma(change[k + 2] * z)
                way += change[TRANSLATION + c]
                if len(drift) == len(roots):
                    way += load(pointer(drift), lane + c * PACK)
                store(out, lane + c * PACK, way / duration)
