"""Momentum that strands hand to each other, and the size of what they have: see `strandcli.simulate.momentum`."""

from __future__ import annotations

from ....jit import device, parallel, prange
from ....simd import broadcast, lane_count, load, load3, pointer, sqrt, store, store3, where
from ...rod.kernels.arrays import AXES, PACK
from .records import HANDED, OF_ROOT


@device
def note_handed(pack, step, rows, mass, accelerations, handed):
    """Add what the ``accelerations`` of a pack's particles (P, N, 3 S), and what ``rows`` of scratch have of
    their roots, do to the momentum of its strands in a step, ``handed``."""
    read, change, out = pointer(rows), pointer(accelerations), pointer(handed)
    n = accelerations.shape[1]
    for k in range(0, PACK, lane_count(change)):
        first = mass[0] * step
        u, v, w = load3(read, OF_ROOT * PACK + k, PACK)
        u, v, w = first * u, first * v, first * w
        for j in range(n):
            m = mass[j] * step
            a, b, c = load3(change, (pack * n + j) * AXES + k, PACK)
            u, v, w = u + m * a, v + m * b, w + m * c
        at = pack * HANDED * PACK + k
        a, b, c = load3(out, at, PACK)
        store3(out, at, PACK, a + u, b + v, c + w)
        store(out, at + AXES, load(out, at + AXES) + sqrt(u * u + v * v + w * w))


@device
def pushed_back(at, sides, apertures, pressure):
    """What solids push back: the pressure of a vector of cells on what solids close of their faces, along x, y and z.
    It is what remains of the sum over all faces, of which each has the difference of two cells as far as it is open."""
    p = load(pressure, at) * load(apertures, at)
    x, y = back_along(at, sides[0], apertures, p), back_along(at, sides[1], apertures, p)
    return x, y, back_along(at, sides[2], apertures, p)


@device
def back_along(at, sides, apertures, p):
    """The same along an axis. Beside the box there is no pressure."""
    (before, after, _, _), (a, b, _, _) = sides
    past, next = where(a, load(apertures, at + before), 1.0), where(b, load(apertures, at + after), 1.0)
    return p * (next - past)


@parallel
def carried(velocity, mass, out):
    """Set the sums over particles of relative mass times speed, m/s, of each strand: out (P, S). ``velocity``: (P, N,
    3 S) m/s; ``mass`` (N,)."""
    read, found = pointer(velocity), pointer(out)
    n = velocity.shape[1]
    for pack in prange(len(velocity)):
        for k in range(0, PACK, lane_count(read)):
            sums = broadcast(read, 0.0)
            for j in range(n):
                u, v, w = load3(read, (pack * n + j) * AXES + k, PACK)
                sums += mass[j] * sqrt(u * u + v * v + w * w)
            store(found, pack * PACK + k, sums)
