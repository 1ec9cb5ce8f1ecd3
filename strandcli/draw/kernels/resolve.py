"""From fragments to the picture: into pixels, sorted by depth, and laid over what is there, front to back.

Fragments come as a stream, strand after strand (`coverage.walk`). A pixel's list holds 64-bit keys: the depth number,
complemented so that nearer is smaller, above the fragment's place in the stream. Places rise with the strand's index,
so the order of a list, ties included, depends neither on bands nor on threads.
"""

from __future__ import annotations

import numpy as np

from ...jit import function, parallel, prange
from .coverage import ONE, SHIFT, ZERO, walk

LOW = np.uint64(0xFFFFFFFF)
OPAQUE = np.float32(1 / 512)
"""What lies behind where less light than this gets through is left out."""
RUN = 24
"""Lists no longer than this are sorted by insertion."""
NO_LIMIT = np.int64(2**62)
ONE_MORE = np.uint32(1)


@function
def reach(first, screen, top, bottom, rows, margin, out):
    """The bands of `rows` rows, counted from row `top`, that each strand touches: as `raster.bands`, for the rows
    top <= y < bottom. out (S, 2) int32: first and last band, first > last for a strand that is not there."""
    last_band = (bottom - top - 1) // rows
    for s in range(first.shape[0] - 1):
        low = np.float32(np.inf)
        high = np.float32(-np.inf)
        for v in range(first[s], first[s + 1]):
            if screen[v, 2] > ZERO:
                low = min(low, screen[v, 1])
                high = max(high, screen[v, 1])
        low -= margin + np.float32(top)
        high += margin - np.float32(top)
        if low <= high and high >= ZERO and low < np.float32(bottom - top):
            out[s, 0] = int(max(low, ZERO)) // rows
            out[s, 1] = min(int(min(high, np.float32(bottom - top))) // rows, last_band)
        else:
            out[s, 0] = 1
            out[s, 1] = 0


@parallel
def collect(
    first, screen, widths, opacity, members, begin, top, bottom, width, rows, workers, limit, k,
    counts, ends, keys, pixels, stream, used,
):  # fmt: skip
    """Gather the fragments of the rows top <= y < bottom in the lists of their pixels.

    first, screen, widths, opacity, limit: as in `coverage.walk`; members (M,) int32: strands listed by bands of `rows`
    rows from `top` on, begin (bands + 1,) int64. The `workers` take the bands in turn and share pixels, stream and,
    without `k`, keys evenly.
    counts, ends (P,) uint32: length and end of each pixel's list in keys, P the pixels of these rows; keys uint64;
    pixels (F,) uint32, stream (F, 4) uint32: what keys point to.
    used (workers,) int64: how many fragments each worker found; where that is not less than its share, nothing else
    holds.
    k: None, or the greatest length of a list: pixel p then has the places k p … k p + k − 1 in keys, which point into
    `nearest`'s (P k, 4) `stream`, and a stream of one strand after the other is in `pixels` and the rest of `stream`.
    """
    share = pixels.shape[0] // workers
    for one in prange(workers):
        task = np.int64(one)  # the index is unsigned, and would make floats of what it is added to
        if k is None:
            used[task] = sort_bands(
                first, screen, widths, opacity, members, begin, top, bottom, width, rows, task, workers, limit,
                counts, ends, keys[task * share : (task + 1) * share], pixels[task * share : (task + 1) * share],
                stream[task * share : (task + 1) * share], task * share,
            )  # fmt: skip
        else:
            held = (bottom - top) * width * k
            used[task] = nearest_bands(
                first, screen, widths, opacity, members, begin, top, bottom, width, rows, task, workers, limit, k,
                counts, ends, keys, pixels[task * share : (task + 1) * share],
                stream[held + task * share : held + (task + 1) * share], stream,
            )  # fmt: skip


@function
def sort_bands(
    first, screen, widths, opacity, members, begin, top, bottom, width, rows, task, workers, limit,
    counts, ends, keys, pixels, stream, base,
):  # fmt: skip
    """What `collect` does for one worker, whose share of keys and stream begins at place `base`."""
    n = np.int64(0)
    for b in range(task, begin.shape[0] - 1, workers):
        above = top + b * rows
        under = min(above + rows, bottom)
        held = min(n, pixels.shape[0] - 1)
        _, more = walk(
            first, screen, widths, opacity, members, begin[b], begin[b + 1], above, under, width, limit,
            pixels[held:], stream[held:], NO_LIMIT,
        )  # fmt: skip
        n += more
        if n < pixels.shape[0]:
            here = slice((above - top) * width, (under - top) * width)
            share_out(pixels[held:n], stream[held:n], counts[here], ends[here], keys, held, base)
    return n


@function
def share_out(pixels, stream, counts, ends, keys, held, base):
    """Count the fragments of each pixel, add up where the lists begin, and fill them in the order of the stream.

    pixels (n,), stream (n, 4): fragments of one band, from place `held` of the worker's stream on, which begins at
    place `base` of all; counts, ends (P,): of the band's pixels; keys: the worker's.
    """
    counts[:] = 0
    for i in range(pixels.shape[0]):
        counts[pixels[i]] += ONE_MORE
    total = np.uint32(held)
    for p in range(counts.shape[0]):
        ends[p] = total
        total += counts[p]
    first = np.uint64(base + held)
    for i in range(pixels.shape[0]):
        p = pixels[i]
        slot = ends[p]
        ends[p] = slot + ONE_MORE
        keys[slot] = ((LOW - np.uint64(stream[i, 0])) << SHIFT) | (first + np.uint64(i))
    for p in range(counts.shape[0]):
        ends[p] += np.uint32(base)


@function
def nearest_bands(
    first, screen, widths, opacity, members, begin, top, bottom, width, rows, task, workers, limit, k,
    counts, ends, keys, pixels, stream, nearest,
):  # fmt: skip
    """What `collect` does for one worker where lists hold at most k fragments."""
    most = np.int64(pixels.shape[0] // 2)
    worst = np.int64(0)
    for b in range(task, begin.shape[0] - 1, workers):
        above = top + b * rows
        under = min(above + rows, bottom)
        base = (above - top) * width
        for p in range(base, base + (under - above) * width):
            counts[p] = 0
            ends[p] = np.uint32(p * k)
        m = begin[b]
        while m < begin[b + 1]:
            m, n = walk(
                first, screen, widths, opacity, members, m, begin[b + 1], above, under, width, limit,
                pixels, stream, most,
            )  # fmt: skip
            worst = max(worst, n)
            for i in range(min(n, pixels.shape[0] - 1)):
                insert(base + np.int64(pixels[i]), stream[i], k, counts, ends, keys, nearest)
    return worst


@function
def insert(p, fragment, k, counts, ends, keys, nearest):
    """Put one fragment into a pixel's list in the order of depth, behind those that are as deep. Where the list is full
    its last one takes in what falls out: opacities multiply as they would have behind one another."""
    n = np.int64(counts[p])
    begin = p * k
    depth = LOW - np.uint64(fragment[0])
    at = n
    while at > 0 and (keys[begin + at - 1] >> SHIFT) > depth:
        at -= 1
    if n < k:
        slot = begin + n
        counts[p] += ONE_MORE
        ends[p] += ONE_MORE
        lost = ZERO
    else:
        slot = np.int64(keys[begin + k - 1] & LOW)
        last = nearest[slot, 2] if at < k else fragment[2]
        lost = np.uint32(last).view(np.float32)
        n = k - 1
    if at < k:
        for i in range(n, at, -1):
            keys[begin + i] = keys[begin + i - 1]
        keys[begin + at] = (depth << SHIFT) | np.uint64(slot)
        for c in range(4):
            nearest[slot, c] = fragment[c]
    if lost > ZERO:
        slot = np.int64(keys[begin + k - 1] & LOW)
        alpha = np.uint32(nearest[slot, 2]).view(np.float32)
        nearest[slot, 2] = np.float32(alpha + lost * (ONE - alpha)).view(np.uint32)


@parallel
def weigh(counts, ends, keys, stream, most, ordered, per, stride, tasks, kept, marks):
    """Sort each pixel's list by depth, ties by index, and turn opacities into weights.

    counts, ends, keys, stream: as `collect` leaves them; most: greatest of counts; ordered: None, or anything where
    lists are sorted already; per, stride: as in `film.mark`, stride a power of two; the
    `tasks` share the pixels.
    kept (P,) uint32: of each list only so many at its head matter: what lies behind where less than `OPAQUE` gets
    through does not. Of these, stream becomes [1] the lit vertex before the fragment, [2] the bits of its weight, the
    share of the pixel's light that comes from it, [3] the bits of the place from that lit vertex to the next; marks
    (V,) uint8 is set at their lit vertices.

    Pieces that follow each other in their strand and in depth add up: they are parts of one surface. All else covers a
    pixel independently.
    """
    size = counts.shape[0]
    for one in prange(tasks):
        task = np.int64(one)
        spare = np.empty(most, np.uint64)
        for p in range(task * size // tasks, (task + 1) * size // tasks):
            n = np.int64(counts[p])
            begin = np.int64(ends[p]) - n
            kept[p] = weigh_pixel(keys[begin : begin + n], stream, ordered, per, stride, spare, marks) if n > 0 else 0


@function
def weigh_pixel(keys, stream, ordered, per, stride, spare, marks):
    """All that `weigh` does with one list; returns how many are kept."""
    n = keys.shape[0]
    if ordered is None:
        arrange(keys, spare, n)
    through = ONE
    front = ONE
    room = ONE
    before = np.int64(-9)
    m = 0
    while m < n:
        f = np.int64(keys[m] & LOW)
        identity = np.int64(stream[f, 1])
        alpha = np.uint32(stream[f, 2]).view(np.float32)
        t = np.uint32(stream[f, 3]).view(np.float32)
        if abs(identity - before) > 1:
            front = through
            room = ONE
        before = identity
        alpha = min(alpha, room)
        room -= alpha
        through = front * room
        if stride > 1:
            past = np.int64(np.uint32(identity) % np.uint32(per)) & (stride - 1)
            identity -= past
            t = (np.float32(past) + t) / np.float32(stride)
        marks[identity] = 1
        marks[identity + stride] = 1
        stream[f, 1] = np.uint32(identity)
        stream[f, 2] = np.float32(front * alpha).view(np.uint32)
        stream[f, 3] = np.float32(t).view(np.uint32)
        m += 1
        if through < OPAQUE:
            break
    return m


@function
def arrange(keys, spare, n):
    """Sort the first n keys: by insertion, beyond `RUN` in runs that are merged."""
    for low in range(0, n, RUN):
        for i in range(low + 1, min(low + RUN, n)):
            key = keys[i]
            j = i - 1
            while j >= low and keys[j] > key:
                keys[j + 1] = keys[j]
                j -= 1
            keys[j + 1] = key
    size = RUN
    while size < n:
        for low in range(0, n, 2 * size):
            middle = min(low + size, n)
            high = min(middle + size, n)
            i = low
            j = middle
            for o in range(low, high):
                take = i < middle and (j >= high or keys[i] < keys[j])
                spare[o] = keys[i] if take else keys[j]
                i += np.int64(take)
                j += np.int64(not take)
        for o in range(n):
            keys[o] = spare[o]
        size *= 2


@parallel
def compose(counts, ends, keys, stream, kept, stride, vertex, top, image):
    """Lay the fragments over the picture.

    counts, ends, keys, stream, kept, stride: as `weigh` leaves them; vertex (V, 3) radiance at lit vertices; image
    (height, width, 3), whose rows from `top` on these pixels are. Where less than `OPAQUE` of what is behind would show
    it does not, and the weights make up for it.
    """
    height = counts.shape[0] // image.shape[1]
    for one in prange(height):
        y = np.int64(one)
        compose_row(counts, ends, keys, stream, kept, stride, vertex, y * image.shape[1], image[top + y])


@function
def compose_row(counts, ends, keys, stream, kept, stride, vertex, first, image):
    """All that `compose` does in the row whose first pixel is number `first`."""
    for x in range(image.shape[0]):
        p = first + x
        n = np.int64(kept[p])
        if n == 0:
            continue
        begin = np.int64(ends[p]) - np.int64(counts[p])
        r = ZERO
        g = ZERO
        b = ZERO
        total = ZERO
        for i in range(begin, begin + n):
            f = np.int64(keys[i] & LOW)
            v = np.int64(stream[f, 1])
            w = np.uint32(stream[f, 2]).view(np.float32)
            t = np.uint32(stream[f, 3]).view(np.float32)
            o = v + stride
            r += w * (vertex[v, 0] + t * (vertex[o, 0] - vertex[v, 0]))
            g += w * (vertex[v, 1] + t * (vertex[o, 1] - vertex[v, 1]))
            b += w * (vertex[v, 2] + t * (vertex[o, 2] - vertex[v, 2]))
            total += w
        through = ONE - total
        if through < OPAQUE:
            scale = ONE / total
            r *= scale
            g *= scale
            b *= scale
            through = ZERO
        image[x, 0] = r + through * image[x, 0]
        image[x, 1] = g + through * image[x, 1]
        image[x, 2] = b + through * image[x, 2]
