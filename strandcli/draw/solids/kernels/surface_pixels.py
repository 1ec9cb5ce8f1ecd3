"""Batches of up to W pixels that show the same solid, for `shade_surfaces`, and compositing of their radiance."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device, function, inlined
from ....jit.pruned import device_where
from ....simd import floor, gather, lane_count, load, pointer, store, where
from ....simd.local import local_float64
from ....solids.kernels import built_in, custom
from ....solids.kernels.custom import put_ray
from ...common.kernels.batch import RADIANCE
from ...common.kernels.keys import FIRST, LOW, SHIFT
from ...common.kernels.numbers import HALF, INF, ONE, ZERO
from ...common.kernels.surface_batch import BEFORE, DISTANCE, NOISE, RAYS, SHARE, SX, SY, THERE
from ...common.kernels.view_columns import AXIS_X, AXIS_Y, DEPTH_RANGE, FOCAL, NEAR_PLANE, PERSPECTIVE
from . import appearance, rays

BRIGHTEST = np.float32(1e6)
BITS = np.float32(2.0**-24)
SAMPLES, CORNER_X, CORNER_Y, EXPOSURE, PER_EXPOSURE = range(5)
"""Columns of a frame: samples along a side of a pixel; position in the full picture, pixels; scale of light, and its
inverse."""


FOLD = np.float32(4.0)
"""Second difference of depth between neighbouring pixels, in pixel widths, beyond which a surface is taken to have an
edge in front of itself."""
UNKNOWN, MOST = np.int64(-1), np.int64(1 << 24)
"""Where no triangle is known; whole numbers up to which single precision has all."""
FINE = 4
"""Rays along each side of a pixel with such an edge."""


@function
def noise(x, y):
    """Return noise in [−½, ½) of a pixel of the full picture, by its position alone (Wellons's `lowbias32` hash)."""
    bits = np.uint32(np.uint32(x) + np.uint32(0x9E3779B9) * np.uint32(y))
    bits = np.uint32((bits ^ (bits >> np.uint32(16))) * np.uint32(0x7FEB352D))
    bits = np.uint32((bits ^ (bits >> np.uint32(15))) * np.uint32(0x846CA68B))
    bits = np.uint32(bits ^ (bits >> np.uint32(16)))
    return np.float32(bits >> np.uint32(8)) * BITS - HALF


@device
def noise_at(column, row, frame):
    """Return the noise of the pixel that holds a sample; frame: its columns."""
    x, y = np.uint32(column), np.uint32(row)
    samples = np.uint32(frame[SAMPLES])
    if samples > np.uint32(1):
        x, y = x // samples, y // samples
    return noise(x + np.uint32(frame[CORNER_X]), y + np.uint32(frame[CORNER_Y]))


@inlined
def dithered(light, share, levels, count, frame):
    """Return light with `share` of an 8-bit level more, which hides the steps of these levels as in the light of the
    backdrop (`film.dithered`). Vectors; levels: pointer to the `count` of `film.level_sizes`; frame: its columns."""
    exposed = light * frame[EXPOSURE]
    some = (exposed > ZERO) & (exposed < BRIGHTEST)
    exposed = where(some, exposed, ZERO)
    step = gather(levels, 0, floor(exposed / (ONE + exposed) * np.float32(count)), np.int64(1), ZERO)
    return where(some, max(light + share * step * frame[PER_EXPOSURE], ZERO), light)


@device
def fill_batch(screen, found, i, end, width, solids, work, which):
    """Fill a batch with points of one solid, from pixel number i of `found` on: one a pixel, and two of one in which
    the solid has an edge in front of itself.

    Returns the next number, how many points, the number of the solid, and whether some pixels have such an edge.
    screen: `inputs.Screen`; found, end: from `find_pixels`; which (W,) int64 out: pixel of each point.
    """
    keys, view, spots = screen.keys, screen.camera, screen.spots
    n = np.int64(0)
    solid = np.int64(-1)
    folds = fine = False
    for number in range(i, end):
        at = found[number]
        key = keys[at]
        own = np.int64((key & LOW) - FIRST)
        if n > 0 and (own != solid or n > W - 2):
            return number, n, solid, fine
        if own != solid:
            solid = own
            folds = spots.shape[0] == 0 and appearance.folds(solids, own)
        row = np.int64(np.uint32(at) // np.uint32(width))
        column = at - row * width
        edge = folds and folded(keys, at, column, width, view)
        fine |= edge
        if edge:
            n = fine_points(solids, work, which, n, at, column, row, view, own)
            continue
        which[n] = at
        before = np.int64(screen.triangles[at]) if screen.triangles.shape[0] > 0 else UNKNOWN
        work[BEFORE + n] = np.float32(before if before < MOST else UNKNOWN)
        work[SHARE + n] = ONE
        work[SX + n] = np.float32(column) + HALF if spots.shape[0] == 0 else spots[at, 0]
        work[SY + n] = np.float32(row) + HALF if spots.shape[0] == 0 else spots[at, 1]
        if view[PERSPECTIVE] > ZERO:  # the depth number is one over the depth
            work[DISTANCE + n] = ONE / np.uint32(LOW - (key >> SHIFT)).view(np.float32)
        else:
            ox, oy, oz, dx, dy, dz = ray_through(work[SX + n], work[SY + n], view)
            work[DISTANCE + n] = rays.meet(solids, own, ox, oy, oz, dx, dy, dz)
        n += 1
    return end, n, solid, fine


@device_where(custom.may_fold, lambda solids, work, which, n, at, column, row, view, solid: n)
def fine_points(solids, work, which, n, at, column, row, view, solid):
    """Add to a batch of n points those that stand for the FINE × FINE rays of pixel number `at`: one for the rays that
    meet the solid on each side of its edge. Return how many points there are then."""
    near, far = INF, -INF
    beams, found = local_float64(), local_float64()
    for ray in range(FINE * FINE):
        x, y = ray_at(ray, column, row)
        put_ray(beams, ray, ray_through(x, y, view))
    custom.trace_rays(solids, solid - built_in.count(solids), beams, found)
    for ray in range(FINE * FINE):
        t = np.float32(found[ray])
        work[RAYS + ray] = t
        near, far = min(near, t), max(far, t if t < INF else -INF)
    middle = HALF * (near + far)
    met = ZERO
    for ray in range(FINE * FINE):
        met += ONE if work[RAYS + ray] < INF else ZERO
    for side in range(2):
        low, high = (near, middle) if side == 0 else (middle, far)
        count = across = down = ZERO
        for ray in range(FINE * FINE):
            if between(work[RAYS + ray], low, high, side):
                x, y = ray_at(ray, column, row)
                count += ONE
                across += x
                down += y
        if count == ZERO:
            continue
        least = INF
        for ray in range(FINE * FINE):
            x, y = ray_at(ray, column, row)
            aside = (x - across / count) * (x - across / count) + (y - down / count) * (y - down / count)
            if between(work[RAYS + ray], low, high, side) and aside < least:
                least = aside
                work[SX + n], work[SY + n], work[DISTANCE + n] = x, y, work[RAYS + ray]
        which[n] = at
        work[BEFORE + n] = -ONE
        work[SHARE + n] = count / met
        n += 1
    return n


@inlined
def between(t, low, high, side):
    """Return whether a distance along a ray is one of those before the edge (side 0) or of those behind it."""
    return (low <= t) & (t <= high) & ((side == 0) | (t > low))


@inlined
def ray_at(ray, column, row):
    """Return where on the screen ray number `ray` of a pixel is."""
    x = np.float32(column) + (np.float32(ray % FINE) + HALF) / np.float32(FINE)
    y = np.float32(row) + (np.float32(ray // FINE) + HALF) / np.float32(FINE)
    return x, y


@inlined
def ray_through(x, y, view):
    """Return origin and direction of the ray through a screen position."""
    return rays.ray(view, (x - view[AXIS_X]) / view[FOCAL], (view[AXIS_Y] - y) / view[FOCAL])


@device
def average(work, n, which):
    """Let each pixel of a batch of n points have one, with the mean of its points by their shares; return how many
    there are then."""
    m = np.int64(-1)
    for k in range(n):
        share = work[SHARE + k]
        if m >= 0 and which[m] == which[k]:
            work[THERE + m] += share * work[THERE + k]
            for c in range(3):
                work[RADIANCE + c * W + m] += share * work[RADIANCE + c * W + k]
        else:
            m += 1
            which[m] = which[k]
            work[THERE + m] = share * work[THERE + k]
            for c in range(3):
                work[RADIANCE + c * W + m] = share * work[RADIANCE + c * W + k]
    return m + 1


@device
def composite(work, n, which, screen, width, picture):
    """Composite the first n points of a batch over the picture (3 P,), dithered if there are levels; screen:
    `inputs.Screen`; width: samples a row."""
    if screen.levels.shape[0] > 0:
        dither(work, n, which, screen, width)
    for k in range(n):
        p = 3 * which[k]
        for c in range(3):
            picture[p + c] += work[THERE + k] * (work[RADIANCE + c * W + k] - picture[p + c])


@device
def dither(work, n, which, screen, width):
    """Add the noise of their pixels to the radiance of the first n points of a batch."""
    spots, levels, frame = screen.spots, screen.levels, screen.frame
    for k in range(n):
        if spots.shape[0] > 0:
            work[NOISE + k] = noise_at(spots[which[k], 0], spots[which[k], 1], frame)
        else:
            pixel = np.uint32(which[k])
            row = pixel // np.uint32(width)
            work[NOISE + k] = noise_at(pixel - row * np.uint32(width), row, frame)
    rows, sizes = pointer(work), pointer(levels)
    for c in range(3):
        for k in range(0, n, lane_count(rows)):
            light = load(rows, RADIANCE + c * W + k)
            store(rows, RADIANCE + c * W + k, dithered(light, load(rows, NOISE + k), sizes, levels.shape[0], frame))


@device
def folded(keys, at, column, width, view):
    """Return whether a solid has an edge in front of itself at pixel number `at`."""
    if at < width or at >= keys.shape[0] - width:
        return False
    if column < 1 or column > width - 2:
        return False
    here = depth_at(keys, at, view)
    across = bend(keys, at, 1, here, view)
    down = bend(keys, at, width, here, view)
    wide = here / view[FOCAL] if view[PERSPECTIVE] > ZERO else ONE / view[FOCAL]  # of a pixel there, metres
    return max(across, down) > FOLD * wide


@device
def bend(keys, at, step, here, view):
    """Return the second difference of the depths of three pixels, metres; 0 if they do not show the same solid."""
    if (((keys[at - step] ^ keys[at]) | (keys[at + step] ^ keys[at])) & LOW) != np.uint64(0):
        return ZERO
    return abs(depth_at(keys, at - step, view) + depth_at(keys, at + step, view) - here - here)


@device
def depth_at(keys, at, view):
    """Return the depth of the surface that a pixel shows, metres."""
    number = np.uint32(LOW - (keys[at] >> SHIFT)).view(np.float32)
    return ONE / number if view[PERSPECTIVE] > ZERO else view[NEAR_PLANE] + (ONE - number) * view[DEPTH_RANGE]
