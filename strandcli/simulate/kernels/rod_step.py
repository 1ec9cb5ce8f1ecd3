"""The step of the rod solver over blocks of strands: predict, iterate, make lengths exact, take the new velocity.

As many threads as the driver likes take tickets, each with scratch of its own (`tickets.share_out`); lanes are
independent, so that the number of threads changes no bit. A vector of strands moves at once, from the first to the last
of a step.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...constants import W
from ...jit import device, function
from ...simd import any_lane, lane_count, load, load3, no_fma, pointer_at, sqrt, store, store3, vector_pointer_at, where
from . import rod, rod_curl, rod_newton, rod_start, rod_sweep
from .rod import AXES, FIRST, PACK, SEGMENT, SHIFT, E
from .rod_sweep import ROW
from .tickets import ALL, take

# places of a book: after the tickets numbers, and then an address for each array and a size for each kind of solids
SEGMENTS, ITERATIONS, SECOND, CURLED, SOLID, WHOLE, SCRATCH, SCRATCH_BYTES, AT = 2, 3, 4, 5, 6, 7, 8, 9, 10


def book_of(
    strands: int, segments: int, iterations: int, flags: tuple[bool, bool, bool, bool], scratch: NDArray[Any],
    arrays: tuple[NDArray[Any], ...], solids: tuple[NDArray[Any], ...],
) -> NDArray[np.int64]:  # fmt: skip
    """The book of a solver's steps. ``flags``, ``arrays`` and ``solids`` are those of `run`, in its order, scratch
    (workers, size); whoever keeps the book has to keep all arrays, for it knows no more than where they are. A fifth of
    ``solids`` is those of other packages."""
    assert all(one.flags.c_contiguous and one.dtype == scratch.dtype for one in (scratch, *arrays, *solids))
    numbers = [0, -(-strands // PACK), segments, iterations, *flags, scratch.ctypes.data, scratch.strides[0]]
    addresses = [one.ctypes.data for one in (*arrays, *solids[:4])]
    others = [number for one in solids[4:] for number in (one.ctypes.data, one.size, one.shape[1])]
    return np.array([*numbers, *addresses, *(one.size for one in solids[:4]), *others])


@device
def solids_of(kind, book):
    """Solids as `contact_shapes.nearest` takes them, of a floating type."""
    return (
        (pointer_at(kind, book[AT + 20]), book[AT + 24]),
        (pointer_at(kind, book[AT + 21]), book[AT + 25]),
        (pointer_at(kind, book[AT + 22]), book[AT + 26]),
        (pointer_at(kind, book[AT + 23]), book[AT + 27]),
    )


@device
def others_of(kind, book):
    """Solids of other packages: their rows, where the last ends, and numbers of each."""
    return pointer_at(kind, book[AT + 28]), book[AT + 29], book[AT + 30]


@function
def single(book, worker):
    """The step in single precision, as one of the threads; `work` has more of it."""
    work(np.float32, book, worker, solids_of)


@function
def double(book, worker):
    """The step in double precision."""
    work(np.float64, book, worker, solids_of)


@device
def work(kind, book, worker, solids_of):
    """Move strands by one step, in place, a pack to each ticket while there are any. ``book`` is what `book_of` makes,
    all of its arrays of the floating type ``kind``; ``solids_of`` gives the solids in it."""
    # there are flags where a None would have everything compiled once more
    scratch = vector_pointer_at(kind, book[SCRATCH] + worker * book[SCRATCH_BYTES])
    solids = solids_of(kind, book)
    ticket = take(book)
    while ticket < book[ALL]:
        coming = take(book)
        run(
            pointer_at(kind, book[AT]), pointer_at(kind, book[AT + 1]), pointer_at(kind, book[AT + 2]),
            pointer_at(kind, book[AT + 3]), pointer_at(kind, book[AT + 4]), pointer_at(kind, book[AT + 5]),
            pointer_at(kind, book[AT + 6]), pointer_at(kind, book[AT + 7]), pointer_at(kind, book[AT + 8]),
            pointer_at(kind, book[AT + 9]), pointer_at(kind, book[AT + 10]), pointer_at(kind, book[AT + 11]),
            pointer_at(kind, book[AT + 12]), pointer_at(kind, book[AT + 13]), pointer_at(kind, book[AT + 14]),
            pointer_at(kind, book[AT + 15]), pointer_at(kind, book[AT + 16]), pointer_at(kind, book[AT + 17]),
            pointer_at(kind, book[AT + 18]), pointer_at(kind, book[AT + 19]),
            book[ITERATIONS], book[SECOND] != 0, book[CURLED] != 0, book[SOLID] != 0, solids, book[WHOLE] != 0, scratch,
            ticket, coming, book[SEGMENTS],
        )  # fmt: skip
        ticket = coming


@device
def run(
    edges, velocity, before, moved, tension, push, touching, positions, lengths, stiffness, mass, joint, roots,
    directions, bends, twist, gust, residuals, pose, numbers, iterations, second, curled, solid, solids, whole, scratch,
    pack, coming, n,
):  # fmt: skip
    """The step of a ``pack`` of strands, a vector of them at a time; the next one is ``coming``.

    Of P packs of S = `PACK` strands: edges (P, N, 3 S): unit vectors; velocity (P, N, 3 S) m/s; for BDF2, that is where
    `second`, before: the same one step before, moved: the last displacement in metres, else (1, N, 3 S) and not
    touched; tension (P, N, S): force densities of the last step over h²; push (P, N, 3 S): acceleration of particles by
    contact, m/s², touching (P, S): 1 for strands that have any, (1, …) each where not `solid`; positions (blocks, N +
    2, 3 W) world, row 0 one segment before the root, row 1 the root; lengths (P, S) of a segment; stiffness (P, S): B /
    (ρ A ℓ⁴) in 1/s²; mass, joint (N,): a particle's mass, drag times step heavier, and the rigidity of the joint
    before an edge, relative (root joint 2, tip mass 1/2); roots, directions (P, 3 S) in the emitter's frame; bends (P,
    N + 1, 3 S): row 0 a unit vector across each direction, in the emitter's frame, then the rest value of c_j in the
    frame carried along the strand; twist (P, N, S): angles by which frames are turned besides; where not `curled`, both
    (1, …) and not read; gust (P, S): factor of the air's velocity; residuals (P, S): greatest
    | |e| − 1 | before lengths are made exact; pose (24,): the emitter's rotation by rows and its translation, and what
    each of them changed by in this step; numbers: [0] step in s, [1:4] gravity m/s², [4:7] velocity of the air, [7]
    drag 1/s, [8] material damping s, [9] 1/3 for BDF2 (0 for the Euler step that it starts with), [10] friction, [11]
    error of |e|² at which iterations stop, [12] that which is no more than rounding, [13] torsional over bending
    rigidity; solids: spheres, capsules, planes and boxes as in `contact_shapes`, `solid` whether there are any; whole:
    segments are caught too; scratch as `rod_tension.size_for` says.
    """
    for lane in range(0, PACK, lane_count(scratch)):
        strand = pack * PACK + lane
        tip = pack * n * PACK + lane
        edge = pack * n * AXES + lane
        place = rod_sweep.place_of(strand, n)
        place_root(scratch, pack * AXES + lane, place + ROW, roots, directions, pose, positions)
        touched = solid and any_lane(load(touching, strand) > 0.0)
        rod_start.start(
            scratch, n, edge, tip, strand, edges, tension, velocity, before, moved, push, lengths, stiffness, gust,
            numbers, second, touched,
        )  # fmt: skip
        if curled:
            rod_curl.recall(
                scratch, n, edge, pack * (n + 1) * AXES + lane, tip, edges, bends, twist, pose, joint,
                numbers[13], numbers[8] / numbers[0],
            )  # fmt: skip
        given = edge, velocity, before, moved, push, numbers[9], second, touched
        worst = rod_newton.iterate(scratch, n, mass, joint, iterations, numbers[11], given)
        # | |e| − 1 | from | |e|² − 1 |; where that is small it does not matter on which side
        store(residuals, strand, worst / (1.0 + sqrt(1.0 + where(worst > 1.0, worst, -worst))))
        if touched:
            rod.yield_to(scratch, n, edge, mass, push)
        rod_sweep.sweep(
            scratch, n, edge, tip, place, strand, coming, edges, velocity, before, moved, tension, push, touching,
            lengths, positions, numbers, second, solid, solids, whole, touched,
        )  # fmt: skip


@device
def rotated(turn, k, x, y, z):
    """A vector turned by a matrix, given by rows from place k on, to the bits that NumPy finds."""
    return (
        no_fma(turn[k] * x) + no_fma(turn[k + 1] * y) + no_fma(turn[k + 2] * z),
        no_fma(turn[k + 3] * x) + no_fma(turn[k + 4] * y) + no_fma(turn[k + 5] * z),
        no_fma(turn[k + 6] * x) + no_fma(turn[k + 7] * y) + no_fma(turn[k + 8] * z),
    )


@device
def place_root(s, local, place, roots, directions, pose, positions):
    """The root in the world, by how much it moved, and the clamped direction, which is the edge before the first."""
    x, y, z = load3(roots, local, PACK)
    px, py, pz = rotated(pose, 0, x, y, z)
    store3(positions, place, W, px + pose[9], py + pose[10], pz + pose[11])
    px, py, pz = rotated(pose, 12, x, y, z)
    store3(s, SHIFT, 1, px + pose[21], py + pose[22], pz + pose[23])
    x, y, z = load3(directions, local, PACK)
    x, y, z = rotated(pose, 0, x, y, z)
    store3(s, FIRST - SEGMENT + E, 1, x, y, z)
