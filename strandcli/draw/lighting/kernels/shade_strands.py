"""Shading of strands: all lights with their shadows of strands and solids, and ambient light.

Marked vertices are collected in batches of W, strand after strand, in an array of rows. Whatever needs no table is a
loop over a row, which LLVM vectorises; only look-ups in maps and tables go vertex by vertex.
"""

from __future__ import annotations

import numpy as np
from numba import types

from ....constants import W
from ....jit import device, inlined, parallel, prange
from ....jit.indices import places, task_at
from ....jit.pruned import by_type
from ....simd import floor, lane_count, load, load3, pointer, sqrt, store, store3
from ...common.kernels import batch as row
from ...common.kernels.approximations import exp_lanes
from ...common.kernels.batch import ARRIVES, COLOUR, EX, EXTRA, LX, RADIANCE, REACH, TX, X
from ...common.kernels.light_columns import (
    BIAS,
    CLEAR_ROW,
    FIRST_MAP,
    MAP_COUNT,
    MAP_LAYERS,
    PER_FALL,
    STRAND_WIDTH,
)  # fmt: skip
from ...common.kernels.numbers import HALF, ONE, ZERO
from ...common.kernels.view_columns import EYE_X, EYE_Y, EYE_Z, FORWARD_X, FORWARD_Y, FORWARD_Z, PERSPECTIVE
from ...coverage.kernels import width_profiles
from ...fibre.kernels.dual import diffuse_light, dual_scattering
from ...fibre.kernels.highlights import highlights
from ...fibre.kernels.lobes import ALL, mixed, mixed_pair, place_at, width_highlights
from ...shadows.kernels.solid_shadows import hard_shadows, soft_shadows
from ...shadows.kernels.strand_shadows import count_in_front, shade_by_minmax
from .light import aim, ambient_light

TINY = np.float32(1e-30)
NEXT = np.uint64(1)
LAST_TWO = np.int64(4)
"""The last two channels of a table of colours."""
STRANDS = 128
"""Strands a task."""


@parallel
def strands(vertices, paint, surround, tables, dual, lights, shadows, solids, wide, out):
    """Write the radiance toward the camera at the marked vertices to out (V, 3).

    vertices, paint, surround, lights, wide: `Vertices`, `StrandColour`, `Surround`, `Lights` and `WidthProfiles` of
    `inputs`; tables: arrays of a fibre model, None without highlights; dual: `DualArrays`, None without dual
    scattering; shadows: `ShadowArrays`; solids: `Solids`; wide: None where no strand is wide.

    Features that cost next to nothing are switched off by arrays without rows; each combination of None has its own
    compiled kernel.
    """
    count = vertices.first.shape[0] - 1
    tasks = np.int64((count + STRANDS - 1) // STRANDS)
    for turn in prange(places(tasks)):
        task = task_at(np.int64(turn), tasks)
        work = np.empty(row.ROWS * W, np.float32)
        work[row.EXTRA : row.EXTRA + 3 * W] = ZERO
        which = np.empty(W, np.int64)
        marked = np.empty(longest(vertices.first, task * STRANDS, min((task + 1) * STRANDS, count)), np.int64)
        n = np.int64(0)  # with a literal, Numba would compile the functions below twice
        for s in range(np.uint64(task * STRANDS), np.uint64(min((task + 1) * STRANDS, count))):
            begin, end = np.uint64(vertices.first[s]), np.uint64(vertices.first[s + NEXT])
            per = ONE / np.float32(max(np.int64(end - begin) - 1, 1))
            for at in range(find_marked(vertices.marks, begin, end, marked)):
                v = np.uint64(marked[at])
                load_vertex(vertices, s, v, begin, end, per, work, np.uint64(n))
                if wide is not None:
                    width_profiles.clear(wide.profile, wide.slots[v])
                which[np.uint64(n)] = v
                n += 1
                if n == W:
                    light = tables, dual, lights, shadows, solids, wide
                    shade(work, n, which, paint, vertices.camera, surround, light, out)
                    n = np.int64(0)
        shade(work, n, which, paint, vertices.camera, surround, (tables, dual, lights, shadows, solids, wide), out)


@device
def shade(work, n, which, paint, camera, surround, light, out):
    """Shade the first n items of a batch, and store their radiance at their vertices `which` in out (V, 3); light:
    tables, dual, lights, shadows, solids and wide of `strands`."""
    tables, dual, lights, shadows, solids, wide = light
    load_colours(paint, work, n)
    frames(work, n, camera)
    ambient_light(work, n, surround)
    batch(work, n, which, paint.diffuse, tables, dual, lights, shadows, solids, wide)
    for k in range(np.uint64(n)):
        v = np.uint64(which[k])
        for c in range(np.uint64(3)):
            out[v, c] = work[np.uint64(row.RADIANCE) + c * np.uint64(W) + k]


@inlined
def load_vertex(vertices, s, v, begin, end, per, work, k):
    """Store position and tangent, not normalised, of vertex v of strand s, which has begin … end − 1, as item k of a
    batch, and in the first two rows of `COLOUR` how far along its strand it is, 0 to 1, and the strand's tone; per: 1
    over the strand's pieces. No place is negative."""
    world, tangents, along = vertices.world, vertices.tangents, vertices.along
    low = v - NEXT if v > begin else v
    high = v + NEXT if v + NEXT < end else v
    for c in range(np.uint64(3)):
        at = c * np.uint64(W) + k
        work[np.uint64(row.X) + at] = world[v, c]
        work[np.uint64(row.TX) + at] = world[high, c] - world[low, c] if tangents.shape[0] == 0 else tangents[v, c]
    work[np.uint64(row.COLOUR) + k] = np.float32(np.int64(v - begin)) * per if along.shape[0] == 0 else along[v]
    work[np.uint64(row.COLOUR + W) + k] = vertices.tones[s]


@device
def load_colours(paint, work, n):
    """Store colour and absorption of the first n vertices of a batch, by what `load_vertex` left."""
    tint = paint.tint
    if tint.shape[0] == 0:
        for c in range(3):
            for k in range(n):
                work[row.COLOUR + c * W + k] = paint.colour[c]
        return
    for k in range(n, W):  # the unused lanes of the last vector must read valid entries
        work[row.COLOUR + k] = work[row.COLOUR + W + k] = ZERO
    rows = pointer(work)
    for k in range(0, n, lane_count(rows)):
        a = load(rows, row.COLOUR + k) * np.float32(tint.shape[0] - 1)
        b = (load(rows, row.COLOUR + W + k) + ONE) * HALF * np.float32(tint.shape[1] - 1)
        i, j = min(floor(a), np.float32(tint.shape[0] - 2)), min(floor(b), np.float32(tint.shape[1] - 2))
        place = place_at(i, j, a - i, b - j)
        red, green, blue, extra_red = mixed(tint, ALL, place)
        extra_green, extra_blue = mixed_pair(tint, LAST_TWO, place)
        store3(rows, row.COLOUR + k, W, red, green, blue)
        store3(rows, row.EXTRA + k, W, extra_red, extra_green, extra_blue)


@device
def batch(work, n, which, diffuse, tables, dual, lights, shadows, solids, wide):
    """Add the light of all lights to the first n vertices of a batch, and to the profiles of wide ones among them."""
    rows = lights.rows
    for i in range(rows.shape[0]):
        aim(work, n, rows, i)
        past_solids(work, n, rows, i, solids, lights.skin, lights.sized)
        m = lit_first(work, n, which)
        if m > 0:
            add_light(work, m, which, i, diffuse, tables, dual, lights, shadows, wide)
    if wide is not None:
        for k in range(n):
            if wide.slots[which[k]] >= 0:
                width_profiles.integrate_columns(wide.profile, wide.slots[which[k]])


@device
def add_light(work, n, which, i, diffuse, tables, dual, lights, shadows, wide):
    """Add the light of light number i to the first n vertices of a batch; arguments as in `batch`."""
    rows = lights.rows
    past_strands(work, n, lights, i, shadows, dual)
    if lights.clear.shape[0] > 0 and rows[i, CLEAR_ROW] > ZERO:
        for k in range(n):
            work[row.ARRIVES + k] *= lights.clear[np.int64(rows[i, CLEAR_ROW]) - 1, which[k]]
    if wide is not None:
        for k in range(3 * W):
            work[row.BEFORE + k] = work[row.RADIANCE + k]
    if dual is not None and rows[i, MAP_LAYERS] > ZERO:
        dual_scattering(work, n, rows, i, dual)
    elif diffuse > ZERO:
        diffuse_light(work, n, rows, i, diffuse)
    if wide is not None:
        width_profiles.add_cosine_lobe(work, n, which, wide.slots, wide.profile)
    if tables is not None:
        highlights(work, n, rows, i, tables)
        if wide is not None:
            width_highlights(work, n, which, rows, i, tables, wide, wide.columns)


@by_type
def past_solids(work, n, lights, i, solids, skin, sized):
    """Multiply the rows `ARRIVES` by the visibility of light number i past solids; sized: None for hard shadows."""
    if isinstance(sized, types.NoneType):
        return lambda work, n, lights, i, solids, skin, sized: hard_shadows(work, n, solids, skin)
    return lambda work, n, lights, i, solids, skin, sized: soft_shadows(work, n, lights, i, solids, skin)


@device
def past_strands(work, n, lights, i, shadows, dual):
    """Multiply the rows `ARRIVES` by the transmittance of light number i in its maps. Opacity maps also give the
    optical depth in front of each vertex, and with dual scattering behind it."""
    rows = lights.rows
    bias = rows[i, BIAS]
    if rows[i, MAP_LAYERS] == ZERO:
        for one in range(int(rows[i, FIRST_MAP]), int(rows[i, FIRST_MAP] + rows[i, MAP_COUNT])):
            shade_by_minmax(work, n, shadows, one, bias)
        return
    for k in range(n):
        work[row.PASSED + k] = ZERO
        work[row.LEFT + k] = ZERO
    layers = np.int64(rows[i, MAP_LAYERS])
    width = rows[i, STRAND_WIDTH]
    over = rows[i, PER_FALL]
    for one in range(int(rows[i, FIRST_MAP]), int(rows[i, FIRST_MAP] + rows[i, MAP_COUNT])):
        count_in_front(work, n, shadows, one, layers, bias, width, over, dual)
    blocked = lights.clear.shape[0] == 0 or rows[i, CLEAR_ROW] == ZERO
    batch_rows = pointer(work)
    for k in range(0, n, lane_count(batch_rows)):
        arrives = load(batch_rows, row.ARRIVES + k)
        store(batch_rows, row.UNBLOCKED + k, arrives)
        if blocked:
            store(batch_rows, row.ARRIVES + k, arrives * exp_lanes(-load(batch_rows, row.PASSED + k)))


@device
def frames(work, n, view):
    """Normalise the tangents, and store unit directions to the eye."""
    perspective = view[PERSPECTIVE]
    straight = perspective - ONE  # for an orthographic view the direction is −forward
    rows = pointer(work)
    for k in range(0, n, lane_count(rows)):
        x, y, z = unit(load3(rows, row.TX + k, W))
        store3(rows, row.TX + k, W, x, y, z)
        x, y, z = load3(rows, row.X + k, W)
        x = perspective * (view[EYE_X] - x) + straight * view[FORWARD_X]
        y = perspective * (view[EYE_Y] - y) + straight * view[FORWARD_Y]
        z = perspective * (view[EYE_Z] - z) + straight * view[FORWARD_Z]
        x, y, z = unit((x, y, z))
        store3(rows, row.EX + k, W, x, y, z)


@inlined
def unit(vector):
    """Return vectors scaled to length one; 0 for zero vectors."""
    x, y, z = vector
    size = ONE / sqrt(max(x * x + y * y + z * z, TINY))
    return x * size, y * size, z * size


THREES = (X, TX, EX, COLOUR, EXTRA, RADIANCE, LX)
"""The first of three rows each that hold what is known of a vertex and the current light."""


@device
def lit_first(work, n, which):
    """Reorder the first n vertices of a batch so that those where light arrives come first; return how many they are.

    work: rows of `batch`, those before `REACH` and the light's own; which (n,): numbers of the vertices, reordered too.
    """
    k = np.int64(0)
    end = n
    while True:
        while k < end and work[ARRIVES + k] > ZERO:
            k += 1
        while k < end and not work[ARRIVES + end - 1] > ZERO:
            end -= 1
        if k >= end:
            return k
        end -= 1
        which[k], which[end] = which[end], which[k]
        for first in THREES:
            for at in range(first, first + 3 * W, W):
                work[at + k], work[at + end] = work[at + end], work[at + k]
        for at in (REACH, ARRIVES):
            work[at + k], work[at + end] = work[at + end], work[at + k]
        k += 1


@device
def longest(first, begin, end):
    """Return the number of vertices of the longest of the strands begin … end − 1."""
    most = np.int64(0)
    for s in range(begin, end):
        most = max(most, first[s + 1] - first[s])
    return most


@inlined
def find_marked(marks, begin, end, marked):
    """Write the marked vertices from begin … end − 1 to ``marked``, without branches; return how many they are."""
    n = np.uint64(0)
    for v in range(begin, end):
        marked[n] = v
        n += np.uint64(marks[v] != 0)
    return n
