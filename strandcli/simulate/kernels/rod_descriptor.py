"""What the step of rods is given: a row of numbers and addresses, and the records that its kernel makes of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...jit import device
from ...simd import pointer_at
from .records import Flags, Forcing, Material, State
from .rod_scratch import PACK

# columns of a descriptor after those of the work queue: numbers, what `call_beside` takes, an address for each array,
# and solids: addresses of the four kinds, their sizes, and where there are any, address, size and columns of solids
# without kernels of their own, and the address and shape of each array of their data
SEGMENTS, ITERATIONS, CURLED, ANY_SOLIDS, WHOLE, DEFORMING = range(2, 8)
SETTLED = 4
"""Flags that are tested at run time."""
SCRATCH, SCRATCH_BYTES, BEFORE, AFTER, BESIDE, CROWD, CROWD_BYTES, STATE = range(8, 16)
MATERIAL = STATE + len(State._fields)
FORCING = MATERIAL + len(Material._fields)
SOLIDS = FORCING + len(Forcing._fields)
SIZES = SOLIDS + 4
OTHERS, OTHERS_SIZE, OTHERS_COLUMNS, DATA = SIZES + 4, SIZES + 5, SIZES + 6, SIZES + 7


def descriptor_of(
    strands: int, segments: int, iterations: int, flags: Flags, scratch: NDArray[Any],
    arrays: tuple[State, Material, Forcing], solids: tuple[NDArray[Any], ...], data: Sequence[NDArray[Any]] = (),
) -> NDArray[np.int64]:  # fmt: skip
    """(columns,) int64, what the kernel is given: numbers and addresses. The caller keeps all arrays alive.

    ``scratch`` is (workers, size), of the same floating type as all arrays; ``solids`` are rows of spheres, capsules,
    planes and boxes, and perhaps a fifth array of solids without kernels of their own, whose ``data`` are arrays of any
    type.
    """
    flat = [one for part in arrays for one in part]
    assert all(one.flags.c_contiguous and one.dtype == scratch.dtype for one in (scratch, *flat, *solids))
    head = [0, -(-strands // PACK), segments, iterations, *flags[:SETTLED]]
    numbers = [*head, scratch.ctypes.data, scratch.strides[0], *[0] * 5]
    addresses = [one.ctypes.data for one in (*flat, *solids[:4])]
    others = [number for one in solids[4:] for number in (one.ctypes.data, one.size, one.shape[1])]
    others += data_numbers(data)
    return np.array([*numbers, *addresses, *(one.size for one in solids[:4]), *others])


def data_numbers(data: Sequence[NDArray[Any]]) -> list[int]:
    """What a descriptor has from `DATA` on: address and shape of each array."""
    return [number for one in data for number in (one.ctypes.data, *one.shape)]


@device
def state_of(kind, descriptor, rows=0):
    """Pointers to the arrays of `State`, of a floating type. ``rows``: by how many those of accelerations by the
    strands around are shifted, for the code that is run before a pack leaves them in a worker's row of scratch."""
    return State(
        pointer_at(kind, descriptor[STATE]), pointer_at(kind, descriptor[STATE + 1]),
        pointer_at(kind, descriptor[STATE + 2]), pointer_at(kind, descriptor[STATE + 3]),
        pointer_at(kind, descriptor[STATE + 4]), pointer_at(kind, descriptor[STATE + 5]),
        pointer_at(kind, descriptor[STATE + 6]), pointer_at(kind, descriptor[STATE + 7]),
        pointer_at(kind, descriptor[STATE + 8]), pointer_at(kind, descriptor[CROWD] + rows * descriptor[CROWD_BYTES]),
        pointer_at(kind, descriptor[STATE + 10]), pointer_at(kind, descriptor[STATE + 11]),
        pointer_at(kind, descriptor[STATE + 12]), pointer_at(kind, descriptor[STATE + 13]),
        pointer_at(kind, descriptor[STATE + 14]),
    )  # fmt: skip


@device
def material_of(kind, descriptor):
    """Pointers to the arrays of `Material`."""
    return Material(
        pointer_at(kind, descriptor[MATERIAL]), pointer_at(kind, descriptor[MATERIAL + 1]),
        pointer_at(kind, descriptor[MATERIAL + 2]), pointer_at(kind, descriptor[MATERIAL + 3]),
        pointer_at(kind, descriptor[MATERIAL + 4]),
    )  # fmt: skip


@device
def forcing_of(kind, descriptor):
    """Pointers to the arrays of `Forcing`."""
    return Forcing(
        pointer_at(kind, descriptor[FORCING]), pointer_at(kind, descriptor[FORCING + 1]),
        pointer_at(kind, descriptor[FORCING + 2]), pointer_at(kind, descriptor[FORCING + 3]),
        pointer_at(kind, descriptor[FORCING + 4]), pointer_at(kind, descriptor[FORCING + 5]),
        pointer_at(kind, descriptor[FORCING + 6]), pointer_at(kind, descriptor[FORCING + 7]),
    )  # fmt: skip


@device
def flags_of(descriptor, crowded):
    """`Flags` as booleans, ``crowded`` as it is given."""
    return Flags(
        descriptor[CURLED] != 0, descriptor[ANY_SOLIDS] != 0, descriptor[WHOLE] != 0, descriptor[DEFORMING] != 0,
        crowded,
    )  # fmt: skip


@device
def solids_of(kind, descriptor):
    """Solids as `contact_shapes.nearest` takes them, of a floating type."""
    return (
        (pointer_at(kind, descriptor[SOLIDS]), descriptor[SIZES]),
        (pointer_at(kind, descriptor[SOLIDS + 1]), descriptor[SIZES + 1]),
        (pointer_at(kind, descriptor[SOLIDS + 2]), descriptor[SIZES + 2]),
        (pointer_at(kind, descriptor[SOLIDS + 3]), descriptor[SIZES + 3]),
    )


@device
def others_of(kind, descriptor):
    """Solids without kernels of their own: their rows, the size of all rows, and columns of each."""
    return pointer_at(kind, descriptor[OTHERS]), descriptor[OTHERS_SIZE], descriptor[OTHERS_COLUMNS]
