"""Layers beside the picture, read from the z-buffer's keys (see `strandcli.draw.film.aovs`)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....constants import W
from ....jit import device, parallel, prange
from ...common.kernels import view_columns as at
from ...common.kernels.batch import ARRIVES, ROWS, X, set_vector, vector_at
from ...common.kernels.keys import EMPTY, FIRST, LOW, SHIFT
from ...common.kernels.light_columns import POWER_B, POWER_G, POWER_R
from ...common.kernels.numbers import HALF, INF, ONE, ZERO
from ...coverage.kernels.composite import OPAQUE
from ...coverage.kernels.tiles import PIXELS, TILE_WIDTH, between, tile_at
from ...lighting.kernels.shade_strands import aim, past_solids, past_strands
from ...solids.kernels import rays

TINY = np.float32(1e-30)
PI = np.float32(math.pi)
RED, GREEN, BLUE = np.float32(0.2126), np.float32(0.7152), np.float32(0.0722)


class SeenLines(NamedTuple):
    """Polylines in the world and on the screen: strand s owns the vertices first[s] … first[s + 1] − 1."""

    first: NDArray[np.int64]
    """(S + 1,)"""
    world: NDArray[np.float32]
    """(V, 3) metres."""
    screen: NDArray[np.float32]
    """(V, 3) as in `ScreenLines`."""


@device
def nearest(keys, samples, width, y, x):
    """Return the smallest key of a pixel's samples × samples, and the row and column of that sample."""
    best = EMPTY
    row = y * samples
    column = x * samples
    for j in range(y * samples, (y + 1) * samples):
        for i in range(x * samples, (x + 1) * samples):
            key = keys[j * width * samples + i]
            if key < best:
                best = key
                row = j
                column = i
    return best, row, column


@parallel
def front(fragments, vertices, screen, least, keys, mask):
    """Write the strand that contributes most to each pixel to a z-buffer of solids, where strands contribute enough.

    fragments: `tiles.Fragments`; vertices: number of vertices; screen (V, 3); least: least share of light from strands;
    keys (height * width,) uint64; mask (height * width,) float32 out: share of light from strands.
    """
    for one in prange(fragments.begin.shape[0]):
        number = np.int64(one)
        o = fragments.begin[number]
        tile = tile_at(number, fragments)
        width, stride = fragments.width, fragments.stride
        counts, vertex, weight, along = fragments.counts, fragments.vertex, fragments.weight, fragments.along
        for p in range(PIXELS):
            if counts[number * PIXELS + p] == 0:
                continue
            x = tile.left + p % TILE_WIDTH
            y = tile.top + p // TILE_WIDTH
            total = ZERO
            strands_ = ZERO
            most = ZERO
            best = o
            end = o + np.int64(counts[number * PIXELS + p])
            for i in range(o, end):
                total += weight[i]
                if vertex[i] < vertices:
                    strands_ += weight[i]
                    if weight[i] > most:
                        most = weight[i]
                        best = i
            o = end
            share = strands_ / total if ONE - total < OPAQUE else strands_
            mask[y * width + x] = share
            if share >= least:
                v, t = between(np.int64(vertex[best]), along[best], stride)
                past = min(np.int64(t * np.float32(stride)), stride - 1)
                v += past
                t = t * np.float32(stride) - np.float32(past)
                q = max(screen[v, 2] + t * (screen[v + 1, 2] - screen[v, 2]), ZERO)
                depth = np.uint64(np.float32(q).view(np.uint32))
                keys[y * width + x] = ((LOW - depth) << SHIFT) | np.uint64(v)


@parallel
def strands(keys, samples, base, begin, lines, view, ids, tangents, angles):
    """Write number, tangent and orientation of the strand in front in each pixel. Tangents are interpolated between
    those of vertices, which point from the previous vertex to the next.

    keys (samples² · height · width,) uint64; base: number of vertex 0 in the keys; begin: number of the first of these
    strands; lines: `SeenLines`; view: packed, see `view_columns`; ids (height, width) int32, tangents (height, width,
    3), angles (height, width): changed where one of these strands is in front.
    """
    height, width = ids.shape
    first, world, screen = lines
    last = world.shape[0] - 1
    for y in prange(height):
        for x in range(width):
            key, row, column = nearest(keys, samples, width, y, x)
            v = np.int64(key & LOW) - base
            if key == EMPTY or v < 0 or v >= last:
                continue
            s = np.searchsorted(first, v, side="right") - 1
            low = first[s]
            high = first[s + 1] - 1
            dx = screen[v + 1, 0] - screen[v, 0]
            dy = screen[v + 1, 1] - screen[v, 1]
            flat = abs(dx) >= abs(dy)
            way = dx if flat else dy
            past = np.float32(column) + HALF - screen[v, 0] if flat else np.float32(row) + HALF - screen[v, 1]
            t = min(max(past / way if way != ZERO else ZERO, ZERO), ONE)
            ax, ay, az = along(world, max(v - 1, low), v + 1)
            bx, by, bz = along(world, v, min(v + 2, high))
            ax, ay, az = unit(ax + t * (bx - ax), ay + t * (by - ay), az + t * (bz - az))
            ids[y, x] = begin + s
            tangents[y, x, 0] = ax
            tangents[y, x, 1] = ay
            tangents[y, x, 2] = az
            # projected along the ray (u, v, 1): the derivative of (x, y) / z, times z
            tx = view[at.RIGHT_X] * ax + view[at.RIGHT_Y] * ay + view[at.RIGHT_Z] * az
            ty = view[at.UP_X] * ax + view[at.UP_Y] * ay + view[at.UP_Z] * az
            tz = view[at.FORWARD_X] * ax + view[at.FORWARD_Y] * ay + view[at.FORWARD_Z] * az
            u = view[at.PERSPECTIVE] * (np.float32(column) + HALF - view[at.AXIS_X]) / view[at.FOCAL]
            w = view[at.PERSPECTIVE] * (view[at.AXIS_Y] - np.float32(row) - HALF) / view[at.FOCAL]
            angle = math.atan2(ty - w * tz, tx - u * tz)
            angle += PI if angle < ZERO else ZERO
            angles[y, x] = angle if angle < PI else ZERO


@device
def along(world, i, j):
    """Return the unit vector from vertex i to vertex j."""
    return unit(world[j, 0] - world[i, 0], world[j, 1] - world[i, 1], world[j, 2] - world[i, 2])


@device
def unit(x, y, z):
    """Return a vector scaled to length 1, or 0 for a zero vector."""
    size = max(abs(x), max(abs(y), abs(z)))  # squares of very short vectors would underflow
    if not size > TINY:
        return ZERO, ZERO, ZERO
    x /= size
    y /= size
    z /= size
    size = ONE / math.sqrt(x * x + y * y + z * z)
    return x * size, y * size, z * size


@parallel
def depths(keys, shares, samples, view, solids, depth, mask, point, ids):
    """Write depth, mask and point of the nearest sample of each pixel; set ids to −2 where it shows a solid.

    depth (height, width): metres along the view's axis; mask (height, width): mean of shares (samples² · height ·
    width,), or if that is None share of the samples that show a strand; point (height, width, 3): metres, 0 in empty
    pixels; solids: as in `rasterise.draw`."""
    height, width = depth.shape
    share = ONE / np.float32(samples * samples)
    for y in prange(height):
        for x in range(width):
            key, row, column = nearest(keys, samples, width, y, x)
            count = ZERO
            for j in range(y * samples, (y + 1) * samples):
                for i in range(x * samples, (x + 1) * samples):
                    p = j * width * samples + i
                    if shares is not None:
                        count += shares[p]
                    else:
                        count += ONE if (keys[p] & LOW) < FIRST else ZERO
            mask[y, x] = count * share
            depth[y, x] = np.inf
            point[y, x] = ZERO
            if key == EMPTY:
                continue
            right = (np.float32(column) + HALF - view[at.AXIS_X]) / view[at.FOCAL]
            up = (view[at.AXIS_Y] - np.float32(row) - HALF) / view[at.FOCAL]
            ox, oy, oz, dx, dy, dz = rays.ray(view, right, up)
            q = np.uint32(LOW - (key >> SHIFT)).view(np.float32)
            t = ONE / q if view[at.PERSPECTIVE] > ZERO else view[at.NEAR_PLANE] + (ONE - q) * view[at.DEPTH_RANGE]
            if (key & LOW) >= FIRST:
                which = np.int64((key & LOW) - FIRST)
                if view[at.PERSPECTIVE] == ZERO:  # keys are clamped to the depth range, solids are not
                    far = rays.meet(solids, which, ox, oy, oz, dx, dy, dz)
                    t = far if far < INF else t
                ids[y, x] = -2
            depth[y, x] = t
            point[y, x, 0] = ox + t * dx
            point[y, x, 1] = oy + t * dy
            point[y, x, 2] = oz + t * dz


@parallel
def shadows(ids, keys, samples, point, lights, bare, maps, solids, out):
    """Write the share of the irradiance of all lights that reaches the visible points, by luminance (Rec. 709).

    lights, bare: `inputs.Lights` for points of strands, and for points of solids; maps: `ShadowArrays`; solids:
    `Solids`; out (height, width): unchanged in empty pixels and without lights.
    """
    height, width = ids.shape
    for row in prange(height):
        y = np.int64(row)
        work, which = np.empty(ROWS * W, np.float32), np.empty(W, np.int64)
        places, sums = np.empty(6 * W, np.float32), np.empty(2 * W, np.float32)
        for solid in (False, True):
            n = np.int64(0)
            for x in range(width):
                if ids[y, x] != -1 and (ids[y, x] == -2) == solid:
                    which[n] = x
                    for c in range(3):
                        places[c * W + n] = places[(3 + c) * W + n] = point[y, x, c]
                    if solid:
                        rise(nearest(keys, samples, width, y, x)[0], solids, bare.skin, places, n)
                    n += 1
                if n == W or (x == width - 1 and n > 0):
                    shade_points(work, n, places, bare if solid else lights, maps, solids, sums)
                    for k in range(n):
                        if sums[W + k] > ZERO:
                            out[y, which[k]] = sums[k] / sums[W + k]
                    n = np.int64(0)


@device
def rise(key, solids, skin, places, k):
    """Move item k of the second three rows of places, where its shadow rays begin, above the solid of a key."""
    x, y, z = vector_at(places, 0, k)
    nx, ny, nz = rays.normal(solids, np.int64((key & LOW) - FIRST), x, y, z)
    set_vector(places, 3 * W, k, (x + nx * skin, y + ny * skin, z + nz * skin))


@device
def shade_points(work, n, places, lights, maps, solids, sums):
    """Write the luminance of all lights at n points to sums (2 W,): past strands and solids, and without these. places
    (6 W,): the points, and where their shadow rays begin; work: rows of `batch`."""
    rows = lights.rows
    sums[:] = ZERO
    for i in range(rows.shape[0]):
        power = RED * rows[i, POWER_R] + GREEN * rows[i, POWER_G] + BLUE * rows[i, POWER_B]
        for k in range(3 * W):
            work[X + k] = places[k]
        aim(work, n, rows, i)
        for k in range(n):
            sums[W + k] += power * work[ARRIVES + k]
        for k in range(3 * W):
            work[X + k] = places[3 * W + k]
        past_solids(work, n, rows, i, solids, lights.skin, lights.sized)
        for k in range(3 * W):
            work[X + k] = places[k]
        past_strands(work, n, lights, i, maps, None)
        for k in range(n):
            sums[k] += power * work[ARRIVES + k]
