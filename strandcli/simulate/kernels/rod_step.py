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
from ...jit import function, inner
from ...simd import get, get3, heap_at, lay_at, put, put3, root, rounded, some, spread, where, width
from . import rod, rod_curl, rod_newton, rod_sweep
from .rod import AXES, FIRST, HARD, PACK, SEGMENT, SHIFT, STIFF, C, D, E, R, T, aim
from .rod_sweep import ROW
from .tickets import ALL, take

HUGE = 1e18
FARTHEST = 1e10

# places of a book: after the tickets numbers, and then an address for each array and a size for each kind of solids
SEGMENTS, ITERATIONS, SECOND, CURLED, SOLID, WHOLE, SCRATCH, SCRATCH_BYTES, AT = 2, 3, 4, 5, 6, 7, 8, 9, 10


def book_of(
    strands: int, segments: int, iterations: int, flags: tuple[bool, bool, bool, bool], scratch: NDArray[Any],
    arrays: tuple[NDArray[Any], ...], solids: tuple[NDArray[Any], ...],
) -> NDArray[np.int64]:  # fmt: skip
    """The book of a solver's steps. ``flags``, ``arrays`` and ``solids`` are those of `run`, in its order, scratch
    (workers, size); whoever keeps the book has to keep all arrays, for it knows no more than where they are."""
    assert all(one.flags.c_contiguous and one.dtype == scratch.dtype for one in (scratch, *arrays, *solids))
    numbers = [0, -(-strands // PACK), segments, iterations, *flags, scratch.ctypes.data, scratch.strides[0]]
    addresses = [one.ctypes.data for one in (*arrays, *solids)]
    return np.array([*numbers, *addresses, *(one.size for one in solids)])


@function
def single(book, worker):
    """The step in single precision, as one of the threads; `work` has more of it."""
    work(np.float32, book, worker)


@function
def double(book, worker):
    """The step in double precision."""
    work(np.float64, book, worker)


@inner
def work(kind, book, worker):
    """Move strands by one step, in place, a pack to each ticket while there are any. ``book`` is what `book_of` makes,
    all of its arrays of the floating type ``kind``. There are flags where a None would have everything compiled once
    more."""
    scratch = heap_at(kind, book[SCRATCH] + worker * book[SCRATCH_BYTES])
    solids = (
        (lay_at(kind, book[AT + 20]), book[AT + 24]),
        (lay_at(kind, book[AT + 21]), book[AT + 25]),
        (lay_at(kind, book[AT + 22]), book[AT + 26]),
        (lay_at(kind, book[AT + 23]), book[AT + 27]),
    )
    ticket = take(book)
    while ticket < book[ALL]:
        coming = take(book)
        run(
            lay_at(kind, book[AT]), lay_at(kind, book[AT + 1]), lay_at(kind, book[AT + 2]),
            lay_at(kind, book[AT + 3]), lay_at(kind, book[AT + 4]), lay_at(kind, book[AT + 5]),
            lay_at(kind, book[AT + 6]), lay_at(kind, book[AT + 7]), lay_at(kind, book[AT + 8]),
            lay_at(kind, book[AT + 9]), lay_at(kind, book[AT + 10]), lay_at(kind, book[AT + 11]),
            lay_at(kind, book[AT + 12]), lay_at(kind, book[AT + 13]), lay_at(kind, book[AT + 14]),
            lay_at(kind, book[AT + 15]), lay_at(kind, book[AT + 16]), lay_at(kind, book[AT + 17]),
            lay_at(kind, book[AT + 18]), lay_at(kind, book[AT + 19]),
            book[ITERATIONS], book[SECOND] != 0, book[CURLED] != 0, book[SOLID] != 0, solids, book[WHOLE] != 0, scratch,
            ticket, coming, book[SEGMENTS],
        )  # fmt: skip
        ticket = coming


@inner
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
    for lane in range(0, PACK, width(scratch)):
        strand = pack * PACK + lane
        tip = pack * n * PACK + lane
        edge = pack * n * AXES + lane
        place = rod_sweep.place_of(strand, n)
        place_root(scratch, pack * AXES + lane, place + ROW, roots, directions, pose, positions)
        weigh(scratch, n, edge, tip, strand, edges, tension, lengths, stiffness, numbers)
        predict(scratch, n, edge, strand, velocity, before, moved, lengths, gust, numbers, second)
        if curled:
            rod_curl.recall(
                scratch, n, edge, pack * (n + 1) * AXES + lane, tip, edges, bends, twist, pose, joint,
                numbers[13], numbers[8] / numbers[0],
            )  # fmt: skip
        touched = solid and some(get(touching, strand) > 0.0)
        if touched:
            press(scratch, n, edge, strand, push, lengths, numbers)
        worst = rod_newton.iterate(scratch, n, mass, joint, iterations, numbers[11])
        # | |e| − 1 | from | |e|² − 1 |; where that is small it does not matter on which side
        put(residuals, strand, worst / (1.0 + root(1.0 + where(worst > 1.0, worst, -worst))))
        keep(scratch, n, tip, tension, numbers[0])
        if touched:
            yield_to(scratch, n, edge, mass, push)
        rod_sweep.sweep(
            scratch, n, edge, place, strand, coming, edges, velocity, before, moved, tension, push, touching, lengths,
            positions, numbers, second, solid, solids, whole, touched,
        )  # fmt: skip


@inner
def rotated(turn, k, x, y, z):
    """A vector turned by a matrix, given by rows from place k on, to the bits that NumPy finds."""
    return (
        rounded(turn[k] * x) + rounded(turn[k + 1] * y) + rounded(turn[k + 2] * z),
        rounded(turn[k + 3] * x) + rounded(turn[k + 4] * y) + rounded(turn[k + 5] * z),
        rounded(turn[k + 6] * x) + rounded(turn[k + 7] * y) + rounded(turn[k + 8] * z),
    )


@inner
def place_root(s, local, place, roots, directions, pose, positions):
    """The root in the world, by how much it moved, and the clamped direction, which is the edge before the first."""
    x, y, z = get3(roots, local, PACK)
    px, py, pz = rotated(pose, 0, x, y, z)
    put3(positions, place, W, px + pose[9], py + pose[10], pz + pose[11])
    px, py, pz = rotated(pose, 12, x, y, z)
    put3(s, SHIFT, 1, px + pose[21], py + pose[22], pz + pose[23])
    x, y, z = get3(directions, local, PACK)
    x, y, z = rotated(pose, 0, x, y, z)
    put3(s, FIRST - SEGMENT + E, 1, x, y, z)


@inner
def weigh(s, n, edge, tip, strand, edges, tension, lengths, stiffness, numbers):
    """Fill the scratch: the coefficients of the step, in units of a segment, and edges as they are when the root has
    moved and nothing else. Internal damping pulls each joint to the bend that it had."""
    h = numbers[0]
    damping = numbers[8] / h
    put(s, STIFF, get(stiffness, strand) * (h * h * (1 + damping)))
    share = damping / (1 + damping)
    x0, y0, z0 = get3(s, FIRST - SEGMENT + E, 1)
    for j in range(n):
        o = FIRST + j * SEGMENT
        put(s, o + T, get(tension, tip + j * PACK) * (h * h))
        x, y, z = get3(edges, edge + j * AXES, PACK)
        put3(s, o + E, 1, x, y, z)
        put3(s, o + C, 1, share * (x - x0), share * (y - y0), share * (z - z0))
        x0 = x
        y0 = y
        z0 = z
    over = 1.0 / get(lengths, strand)
    for c in range(3):
        put(s, FIRST + E + c, get(s, FIRST + E + c) - get(s, SHIFT + c) * over)


@inner
def predict(s, n, edge, strand, velocity, before, moved, lengths, gust, numbers, second):
    """u*: where particles would go alone, in units of a segment, and none further than `FARTHEST`.

    BDF2 is an Euler step of h = 2/3 Δt from extrapolated values: x̂ = x_n + (x_n − x_{n−1}) / 3, v̂ likewise.
    """
    h = numbers[0]
    third = numbers[9]
    drag = numbers[7] * h
    over = 1.0 / get(lengths, strand)
    rest = h / (1 + drag) * over
    for c in range(3):
        fall = h * numbers[1 + c] + drag * numbers[4 + c] * get(gust, strand)
        for j in range(n):
            row = edge + j * AXES + c * PACK
            v = get(velocity, row)
            if second:
                v += (v - get(before, row)) * third
                u = get(moved, row) * third * over + rest * (v + fall)
            else:
                u = rest * (v + fall)
            u = min(max(u, -FARTHEST), FARTHEST)
            put(s, FIRST + j * SEGMENT + D + c, u)
            put(s, aim(n, j) + c, u)


@inner
def keep(s, n, tip, tension, h):
    """τ / h² for the next step, which does not begin with compression that made H indefinite."""
    over = 1 / (h * h)
    least = where(get(s, HARD) > 0.0, spread(s, 0.0), -HUGE)
    for j in range(n):
        t = max(get(s, FIRST + j * SEGMENT + T), least)
        put(tension, tip + j * PACK, where(abs(t) < HUGE, t * over, 0.0))


@inner
def press(s, n, edge, strand, push, lengths, numbers):
    """Add the force of contact to u*, as it was in the step before."""
    f = rod_sweep.alone(numbers) / get(lengths, strand)
    for j in range(n):
        o = aim(n, j)
        x, y, z = get3(push, edge + j * AXES, PACK)
        ax, ay, az = get3(s, o, 1)
        x, y, z = ax + f * x, ay + f * y, az + f * z
        put3(s, o, 1, x, y, z)
        put3(s, FIRST + j * SEGMENT + D, 1, x, y, z)


@inner
def yield_to(s, n, edge, mass, push):
    """R := how far such forces move particles, as a share of how far they would move each alone: H⁻¹ M χ, with χ = 1
    where there are some."""
    for j in range(n):
        o = FIRST + j * SEGMENT
        x, y, z = get3(push, edge + j * AXES, PACK)
        put(s, o + R, where(abs(x) + abs(y) + abs(z) > 0.0, spread(s, mass[j]), 0.0))
    rod.respond(s, n)
