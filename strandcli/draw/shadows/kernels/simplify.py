"""Polylines of strands without the vertices at which they hardly bend, for opacity maps.

Each segment costs a map as much as about two of the texels that it passes, and many are no longer than that. A vertex
with an odd number in its strand is left out where the line between its neighbours passes near it, and every fourth one
where both of its neighbours are and the line between those two before and two behind it does.
"""

from __future__ import annotations

import numpy as np

from ....jit import device, inlined, parallel, prange
from ....simd import deinterleave, half_width_pointer, lane_count, load3, movemask, pointer
from ...common.kernels.numbers import ZERO
from ...geometry.kernels.curves import distance

TINY = np.float32(1e-30)
FLAT = np.float32(0.1**2)
"""Most that a vertex may be beside the line, as a share of its length, squared: segments are at most 2 % longer than
the line that stands for them."""
WORD = 16
"""Vertices of a word: a bit for each, whether the line between its neighbours passes near it, and as many, whether that
between those two before and two behind it does."""
WORDS = 64
"""Words a task."""
BESIDE = 2
"""Vertices before and behind those of a task that it looks at."""
ROW = WORDS * WORD + 2 * BESIDE + WORD
STRANDS = 256
"""Strands a task."""
ODD = np.array([0xAAAA, 0x5555], np.uint64)
"""Vertices of a word that may be left out by themselves, of a strand that begins with an even or an odd number."""
BETWEEN = np.array([0x4444, 0x8888, 0x1111, 0x2222], np.uint64)
"""Those between two of them, by the number that the strand begins with, modulo 4."""
NONE, ONE, BITS, LAST, ALL = np.uint64(0), np.uint64(1), np.uint64(WORD), np.uint64(WORD - 1), np.uint64(0xFFFF)


@inlined
def popcount(x):
    """Return the number of set bits of a uint64, by sums over pairs of bits, groups of four, bytes, and all bytes."""
    x -= (x >> np.uint64(1)) & np.uint64(0x5555555555555555)
    x = (x & np.uint64(0x3333333333333333)) + ((x >> np.uint64(2)) & np.uint64(0x3333333333333333))
    x = (x + (x >> np.uint64(4))) & np.uint64(0x0F0F0F0F0F0F0F0F)
    return (x * np.uint64(0x0101010101010101)) >> np.uint64(56)


@parallel
def find(world, bent, longest, words):
    """Write near which vertices lines pass.

    world (V, 3): metres; bent: how far a line may be from a vertex; longest: how long it may be, both squared, metres²;
    words (V / 16, rounded up) uint32 out: the first of 16 vertices has the lowest bit. Bits of a strand's first two and
    last two vertices mean nothing."""
    count = world.shape[0]
    for task in prange((words.shape[0] + WORDS - 1) // WORDS):
        work = np.zeros(3 * ROW, np.float32)
        begin = np.int64(task) * WORDS * WORD
        end = min(begin + WORDS * WORD, count)
        low, high = max(begin - BESIDE, 0), min(end + BESIDE, count)
        deinterleave(half_width_pointer(world), 3 * low, high - low, work, low - begin + BESIDE, ROW)
        rows = pointer(work)
        for at in range(begin, end, WORD):
            bits = NONE
            for k in range(0, WORD, lane_count(rows)):
                place = at - begin + k + BESIDE
                bits |= pass_near(rows, place, 1, bent, longest) << np.uint64(k)
                bits |= pass_near(rows, place, 2, bent, longest) << np.uint64(WORD + k)
            words[at // WORD] = np.uint32(bits)


@inlined
def pass_near(rows, place, reach, bent, longest):
    """Return bits of a vector of vertices: whether the line to that `reach` behind it from that before it passes near.

    rows: `pointer` to x, y and z, metres; place: of the first one; else as in `find`."""
    x0, y0, z0 = load3(rows, place - reach, ROW)
    x1, y1, z1 = load3(rows, place + reach, ROW)
    x, y, z = load3(rows, place, ROW)
    x1, y1, z1 = x1 - x0, y1 - y0, z1 - z0
    x, y, z = x - x0, y - y0, z - z0
    length = x1 * x1 + y1 * y1 + z1 * z1
    along = x1 * x + y1 * y + z1 * z
    beside = (x * x + y * y + z * z) * length - along * along  # the distance's square, times that of the length
    near = (beside <= bent * length) & (beside <= FLAT * length * length)
    return movemask(near & (along >= ZERO) & (along <= length) & (length <= longest))


@parallel
def keep_widths(world, lost, uneven, words):
    """Clear the bits of vertices where lines near them would be wider or narrower than the strand is.

    world, words: as in `find`, which has been called; lost (V,): share of its strand's width that each vertex is
    narrower; uneven: greatest difference."""
    count = np.int64(world.shape[0])
    for word in prange(words.shape[0]):
        bits = np.uint64(words[word])
        for k in range(WORD):
            v = np.int64(word) * WORD + k
            for reach in range(1, BESIDE + 1):
                if v >= reach and v + reach < count and off_line(world, lost, v, np.int64(reach)) > uneven:
                    bits &= ~(ONE << np.uint64((reach - 1) * WORD + k))
        words[word] = np.uint32(bits)


@device
def off_line(world, lost, v, reach):
    """Return by how much `lost` at vertex v differs from what it is on the line between those `reach` before and
    behind it."""
    before, after = distance(world, v - reach, v), distance(world, v, v + reach)
    t = before / max(before + after, TINY)
    return abs(lost[v] - (lost[v - reach] + t * (lost[v + reach] - lost[v - reach])))


@inlined
def kept(words, word, begin, last):
    """Return bits of the vertices of a word that stay, of those from `begin` to `last`, a strand's first and last."""
    alone = thinned(words, word, begin, last)
    before = thinned(words, max(word - 1, begin // WORD), begin, last) if word * WORD > begin else NONE
    after = thinned(words, word + 1, begin, last) if (word + 1) * WORD <= last else NONE
    about = (alone << ONE | before >> LAST) & (alone >> ONE | (after & ONE) << LAST)
    between = (np.uint64(words[word]) >> BITS) & BETWEEN[begin & 3] & about
    return within(word, begin, last) & ~(alone | between)


@inlined
def thinned(words, word, begin, last):
    """Return bits of the vertices of a word that are left out by themselves; arguments as in `kept`."""
    return np.uint64(words[word]) & ODD[begin & 1] & within(word, begin + 1, last - 1)


@inlined
def within(word, begin, last):
    """Return bits of the vertices of a word from number `begin` to `last`."""
    low, high = max(begin - word * WORD, 0), min(last - word * WORD, WORD - 1)
    return (ALL << np.uint64(low)) & (ALL >> np.uint64(WORD - 1 - high)) if low <= high else NONE


@parallel
def count(first, words, counts):
    """Write how many vertices of each strand stay, counts (S,) int64.

    first (S + 1,): first vertex of each strand, and the number of vertices; words: from `find`."""
    strands = first.shape[0] - 1
    for task in prange((strands + STRANDS - 1) // STRANDS):
        for s in range(np.int64(task) * STRANDS, min((np.int64(task) + 1) * STRANDS, strands)):
            begin, last, found = first[s], first[s + 1] - 1, NONE
            for word in range(begin // WORD, last // WORD + 1):
                found += popcount(kept(words, word, begin, last))
            counts[s] = np.int64(found)


@parallel
def write(first, world, along, words, out_first, out_world, out_along):
    """Write the vertices that stay.

    first, words: as in `count`; world (V, 3); along (V,): how far along its strand each vertex stands, None: evenly;
    out_first (S + 1,): where those of each strand begin; out_world (K, 3), out_along (K,) out."""
    strands = first.shape[0] - 1
    for task in prange((strands + STRANDS - 1) // STRANDS):
        for s in range(np.int64(task) * STRANDS, min((np.int64(task) + 1) * STRANDS, strands)):
            begin, last, at = first[s], first[s + 1] - 1, np.uint64(out_first[s])
            for word in range(begin // WORD, last // WORD + 1):
                bits = kept(words, word, begin, last)
                write_word(world, along, word * WORD, begin, last, bits, at, out_world, out_along)
                at += popcount(bits)


@device
def write_word(world, along, low, begin, last, bits, at, out_world, out_along):
    """Write the vertices of a word, from number `low` on, whose bits are set, from place `at` on; begin, last: first
    and last vertex of the strand; else as in `write`."""
    per = np.float32(1.0) / np.float32(max(last - begin, 1))
    while bits != NONE:  # and not vertex by vertex, of which the processor would have to guess whether they stay
        place = np.uint64(low) + popcount(bits ^ (bits - ONE)) - ONE
        bits &= bits - ONE
        out_world[at, 0], out_world[at, 1], out_world[at, 2] = world[place, 0], world[place, 1], world[place, 2]
        out_along[at] = np.float32(np.int64(place) - begin) * per if along is None else along[place]
        at += ONE
