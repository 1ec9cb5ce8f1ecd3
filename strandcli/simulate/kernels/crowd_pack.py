"""Accelerations by interaction of one pack of strands, in the step of rods that is about to move it: what both read of
it comes from memory once.

A descriptor, an int64 array, has addresses of arrays and their sizes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...jit import device, function
from ...simd import array_at
from .crowd_forces import accelerate_pack, keep_others
from .crowd_records import BOX, CELL, FOUND, ROWS, Lattice, Moving
from .rod_scratch import PACK

POSITIONS, VELOCITY, OTHERS, ROOTS, BEGIN, COUNTS, WEIGHTS, NUMBERS_OF, WHOLE, TARGETS, SHARES, CROWD = range(12)
"""Columns: addresses."""
PACKS, SEGMENTS, SAMPLES, MOST = range(12, 16)
"""Sizes; the last is of particles that a sample is a mean of."""
SCRATCH, SINGLE = 16, 17
"""Addresses of what `crowd_grid.deposit` has as ``work``, for each worker."""
INVERSE, AGAIN, TIME, ORIGIN = 0, 1, 2, 3
"""Numbers: `Lattice.inverse`, `Lattice.again`, `Lattice.seen` of `Lattice.step`, and an origin (3)."""


def descriptor_of(
    moving: Moving, lattice: Lattice, whole: NDArray[np.int64], targets: NDArray[np.float32],
    work: tuple[NDArray[Any], ...], shares: NDArray[Any], numbers: NDArray[Any], crowd: NDArray[Any],
) -> NDArray[np.int64]:  # fmt: skip
    """What the kernels below are given, with the ``numbers`` set; the caller keeps all arrays alive."""
    numbers[:] = lattice.inverse, lattice.again, lattice.seen * lattice.step, *lattice.origins[-1]
    arrays = (
        moving.positions, moving.velocity, moving.others, moving.roots, lattice.first, lattice.counts, lattice.weights,
        numbers, whole, targets, shares, crowd,
    )  # fmt: skip
    sizes = *moving.velocity.shape[:2], *lattice.weights.shape
    return np.array([*(one.ctypes.data for one in arrays), *sizes, *(one.ctypes.data for one in work)])


@function
def single(descriptor, pack, worker):
    """Set the accelerations of a pack, in single precision, as one of the threads."""
    accelerate_one(np.float32, 4, descriptor, pack, worker)


@function
def double(descriptor, pack, worker):
    """The same in double precision."""
    accelerate_one(np.float64, 8, descriptor, pack, worker)


@device
def accelerate_one(kind, bytes, descriptor, pack, worker):
    """Set the accelerations of a pack as `crowd_forces.accelerate` does."""
    packs, n, samples = descriptor[PACKS], descriptor[SEGMENTS], descriptor[SAMPLES]
    moving = Moving(
        array_at(kind, descriptor[POSITIONS], (1, 1, 1)), array_at(kind, descriptor[VELOCITY], (packs, n, 3 * PACK)),
        array_at(kind, descriptor[OTHERS], (packs, n, 3 * PACK)), array_at(kind, descriptor[ROOTS], (packs, 3 * PACK)),
        None, None,
    )  # fmt: skip
    numbers = array_at(kind, descriptor[NUMBERS_OF], (ORIGIN + 3,))
    lattice = Lattice(
        array_at(np.int64, descriptor[BEGIN], (samples,)), array_at(np.int64, descriptor[COUNTS], (samples,)),
        array_at(kind, descriptor[WEIGHTS], (samples, descriptor[MOST])), None, numbers[INVERSE],
        array_at(kind, descriptor[NUMBERS_OF] + ORIGIN * bytes, (1, 3)), None, numbers[AGAIN], None,
    )  # fmt: skip
    rows = (
        array_at(kind, descriptor[SCRATCH] + worker * (ROWS * PACK * bytes), (ROWS, PACK)),
        array_at(np.float32, descriptor[SINGLE] + worker * (FOUND * PACK * 4), (FOUND * PACK,)),
    )
    targets = array_at(np.float32, descriptor[TARGETS], (CELL,))
    shares = array_at(kind, descriptor[SHARES], (samples, descriptor[MOST]))
    crowd = array_at(kind, descriptor[CROWD], (packs, n, 3 * PACK))
    box = array_at(np.int64, descriptor[WHOLE], (BOX,))
    accelerate_pack(moving, lattice, pack, box, targets, rows, shares, crowd)
    keep_others(moving, pack, numbers[TIME], crowd)
