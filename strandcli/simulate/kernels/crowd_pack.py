"""What interaction has to do with one pack of strands in the step of rods that moves it: accelerations before it, and
nodes of the next step after it. What these read comes from memory once.

A descriptor, an int64 array, has addresses of arrays and their sizes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...jit import device, function
from ...simd import array_at
from .crowd_forces import accelerate_pack
from .crowd_momentum import note_handed
from .crowd_nodes import keep_others, note_pack
from .crowd_records import BOX, CELL, FOUND, HANDED, NODE, ROWS, Lattice, Moving
from .rod_scratch import AXES, PACK

POSITIONS, VELOCITY, NODES, OTHERS, PUSHED, JOLTED, ENDS, ROOTS = range(8)
"""Columns: addresses of `Moving`,"""
BEGIN, COUNTS, WEIGHTS, NODE_BEGIN, NODE_COUNTS, NODE_WEIGHTS, FIRST_NODE, BLEND = range(8, 16)
"""of `Lattice`,"""
NUMBERS_OF, WHOLE, TARGETS, SHARES, CROWD = range(16, 21)
"""and of the rest."""
PACKS, SEGMENTS, BLOCKS, NODE_COUNT, NODE_MOST, SAMPLES, MOST, BLENDED = range(21, 29)
"""Sizes: `NODE_MOST` and `MOST` are of particles that a node and a sample are a mean of, `BLENDED` of nodes."""
SCRATCH, SINGLE = 29, 30
"""Addresses of what `crowd_grid.deposit` has as ``work``, for each worker."""
ORIGIN = 31
"""Address of the last row of `Lattice.origins`."""
MASS_OF, HANDED_OF = 32, 33
"""Addresses of `Moving.mass`, and of what strands have been handed, as `HANDED` says."""
INVERSE, AGAIN, STEP, TIME, NUMBERS = 0, 1, 2, 3, 4
"""Numbers: `Lattice.inverse`, `Lattice.again`, `Lattice.step`, and `Lattice.seen` of it; and how many."""


def descriptor_of(
    moving: Moving, lattice: Lattice, whole: NDArray[np.int64], targets: NDArray[np.float32],
    work: tuple[NDArray[Any], ...], shares: NDArray[Any], numbers: NDArray[Any], crowd: NDArray[Any],
) -> NDArray[np.int64]:  # fmt: skip
    """What the kernels below are given, with the ``numbers`` set; the caller keeps all arrays alive."""
    numbers[:] = lattice.inverse, lattice.again, lattice.step, lattice.seen * lattice.step
    arrays = (
        moving.positions, moving.velocity, moving.nodes, moving.others, moving.pushed, moving.jolted, moving.ends,
        moving.roots,
        lattice.first, lattice.counts, lattice.weights, lattice.node_first, lattice.node_counts, lattice.node_weights,
        lattice.begin, lattice.blend, numbers, whole, targets, shares, crowd,
    )  # fmt: skip
    sizes = (
        *moving.velocity.shape[:2], len(moving.positions), *lattice.node_weights.shape, *lattice.weights.shape,
        lattice.blend.shape[1],
    )  # fmt: skip
    last = *work[:2], lattice.origins[-1], moving.mass, work[2]
    return np.array([*(one.ctypes.data for one in arrays), *sizes, *(one.ctypes.data for one in last)])


@function
def single(descriptor, pack, next, worker):
    """Set the accelerations of a pack, in single precision, as one of the threads."""
    accelerate_one(np.float32, 4, descriptor, pack, next, worker)


@function
def double(descriptor, pack, next, worker):
    """The same in double precision."""
    accelerate_one(np.float64, 8, descriptor, pack, next, worker)


@function
def single_after(descriptor, pack, next, worker):
    """Set the nodes of a pack, in single precision."""
    moving, lattice = moving_of(np.float32, descriptor), lattice_of(np.float32, descriptor)
    note_pack(moving, lattice, pack)


@function
def double_after(descriptor, pack, next, worker):
    """The same in double precision."""
    moving, lattice = moving_of(np.float64, descriptor), lattice_of(np.float64, descriptor)
    note_pack(moving, lattice, pack)


@device
def moving_of(kind, descriptor):
    """`Moving` without what no pack's step takes."""
    packs, n, nodes = descriptor[PACKS], descriptor[SEGMENTS], descriptor[NODE_COUNT]
    return Moving(
        array_at(kind, descriptor[POSITIONS], (descriptor[BLOCKS], n + 2, 1)),
        array_at(kind, descriptor[VELOCITY], (packs, n, AXES)),
        array_at(kind, descriptor[NODES], (packs, nodes, NODE * PACK)),
        array_at(kind, descriptor[OTHERS], (packs, nodes, AXES)),
        array_at(kind, descriptor[PUSHED], (packs, nodes, AXES)),
        array_at(kind, descriptor[JOLTED], (packs, PACK)), array_at(kind, descriptor[ENDS], (packs, 6)),
        array_at(kind, descriptor[ROOTS], (packs, AXES)), None, array_at(kind, descriptor[MASS_OF], (n,)),
        None, None,
    )  # fmt: skip


@device
def lattice_of(kind, descriptor):
    """`Lattice` without what no pack's step takes."""
    samples, nodes = descriptor[SAMPLES], descriptor[NODE_COUNT]
    numbers = array_at(kind, descriptor[NUMBERS_OF], (NUMBERS,))
    return Lattice(
        array_at(np.int64, descriptor[BEGIN], (samples,)), array_at(np.int64, descriptor[COUNTS], (samples,)),
        array_at(kind, descriptor[WEIGHTS], (samples, descriptor[MOST])), None,
        array_at(np.int64, descriptor[NODE_BEGIN], (nodes,)), array_at(np.int64, descriptor[NODE_COUNTS], (nodes,)),
        array_at(kind, descriptor[NODE_WEIGHTS], (nodes, descriptor[NODE_MOST])),
        array_at(np.int64, descriptor[FIRST_NODE], (samples,)),
        array_at(kind, descriptor[BLEND], (samples, descriptor[BLENDED])), numbers[INVERSE],
        array_at(kind, descriptor[ORIGIN], (1, 3)), None, numbers[AGAIN], None,
    )  # fmt: skip


@device
def accelerate_one(kind, bytes, descriptor, pack, next, worker):
    """Set the accelerations of a pack as `crowd_forces.accelerate` does."""
    moving, lattice = moving_of(kind, descriptor), lattice_of(kind, descriptor)
    rows = (
        array_at(kind, descriptor[SCRATCH] + worker * (ROWS * PACK * bytes), (ROWS, PACK)),
        array_at(np.float32, descriptor[SINGLE] + worker * (FOUND * PACK * 4), (FOUND * PACK,)),
    )
    targets = array_at(np.float32, descriptor[TARGETS], (CELL,))
    shares = array_at(kind, descriptor[SHARES], (descriptor[SAMPLES], descriptor[MOST]))
    shift = (worker - pack) * descriptor[SEGMENTS] * AXES * bytes
    crowd = array_at(kind, descriptor[CROWD] + shift, (descriptor[PACKS], descriptor[SEGMENTS], AXES))
    box = array_at(np.int64, descriptor[WHOLE], (BOX,))
    accelerate_pack(moving, lattice, (pack, next), box, targets, rows, shares, crowd)
    numbers = array_at(kind, descriptor[NUMBERS_OF], (NUMBERS,))
    handed = array_at(kind, descriptor[HANDED_OF], (descriptor[PACKS], HANDED * PACK))
    note_handed(pack, numbers[STEP], rows[0], moving.mass, crowd, handed)
    keep_others(moving, lattice, (pack, next), numbers[STEP], numbers[TIME], crowd)
