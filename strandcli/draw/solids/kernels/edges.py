"""Edges of solids: pixels that a solid covers in part, resolved by samples (see `strandcli.draw.solids.edges`)."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device, parallel, prange
from ....simd.local import local_float64
from ....solids.kernels import box, built_in, capsule, plane, sphere
from ....solids.kernels.built_in import device_if_built_in
from ....solids.kernels.other import put_ray
from ...common.kernels.keys import EMPTY, FIRST, LOW, SHIFT
from ...common.kernels.numbers import HALF, INF, ONE, ZERO
from ...common.kernels.view_columns import AXIS_X, AXIS_Y, DEPTH_RANGE, FOCAL, PERSPECTIVE
from .rasterise import BOTTOM, LEFT, RIGHT, TOP, key_at
from .rays import BATCH, DX, DY, DZ, MET, OX, OY, OZ, aim, meet, meet_rays, ray

SAMPLES = 4
"""Samples along each side of a pixel."""
WHOLE = SAMPLES * SAMPLES
PER = np.float32(1 / SAMPLES)
IN_ROW, ROW_BITS = np.uint64(SAMPLES - 1), np.uint64(SAMPLES.bit_length() - 1)
"""Mask of a sample's column in its number, and bits below its row."""
TOGETHER = W // WHOLE
"""Pixels whose samples fill one batch."""
AT_OX, AT_OY, AT_OZ = (np.uint64(row) for row in (OX, OY, OZ))
AT_DX, AT_DY, AT_DZ = (np.uint64(row) for row in (DX, DY, DZ))
AT_MET = np.uint64(MET)
"""Rows of a batch, for indices that cannot be negative."""
SLOTS = 4
"""Solids that are distinguished within a pixel; further ones count as the last of them."""


@parallel
def depths(keys, out):
    """Write the depth numbers of a z-buffer (P,) to out (P,) float32; 0 in empty pixels."""
    for p in prange(keys.shape[0]):
        out[p] = np.uint32(LOW - (keys[p] >> SHIFT)).view(np.float32)


@parallel
def sample(pixels, width, view, solids, frames, keys, spots, counts):
    """Find the solids that the samples of each pixel show.

    pixels (E,) int64; width: of the picture; frames: as in `rasterise.draw`. Out: counts (E, SLOTS) int64, samples that
    show each solid of a pixel; spots (E, SLOTS, 2) float32, mean screen position of these samples; keys (E, SLOTS)
    uint64, z-buffer key of the solid there, `EMPTY` in unused slots.
    """
    flat = ONE - view[PERSPECTIVE]
    far = ONE / view[DEPTH_RANGE]
    for task in prange((pixels.shape[0] + TOGETHER - 1) // TOGETHER):
        begin = np.int64(task) * TOGETHER
        end = min(begin + TOGETHER, pixels.shape[0])
        work = np.zeros(BATCH, np.float32)
        best = np.empty(W, np.uint64)
        for e in range(begin, end):
            x, y = np.float32(pixels[e] % width), np.float32(pixels[e] // width)
            for i in range(np.uint64(WHOLE)):
                j = np.uint64((e - begin) * WHOLE) + i
                column, row = spot(x, y, i)
                aim(work, j, view, (column - view[AXIS_X]) / view[FOCAL], (view[AXIS_Y] - row) / view[FOCAL])
                best[j] = EMPTY
        for m in range(frames.shape[0]):
            for e in range(begin, end):
                if within(pixels[e] % width, pixels[e] // width, frames, m):
                    meet_pixel(work, (e - begin) * WHOLE, solids, m)
                    identity = FIRST + np.uint64(m)
                    for i in range(np.uint64(WHOLE)):
                        j = np.uint64((e - begin) * WHOLE) + i
                        t = work[AT_MET + j]
                        best[j] = min(best[j], key_at(t, view, flat, far, identity))
        for e in range(begin, end):
            count_samples(pixels, width, e, best, (e - begin) * WHOLE, keys, spots, counts)
            place_at_mean(e, view, flat, far, solids, keys, spots, counts)


@device
def spot(x, y, i):
    """Return the screen position of sample number i of the pixel of column x and row y."""
    across, down = np.uint64(i) & IN_ROW, np.uint64(i) >> ROW_BITS
    return x + (np.float32(across) + HALF) * PER, y + (np.float32(down) + HALF) * PER


@device
def within(x, y, frames, m):
    """Return whether the pixel of a column and a row can show solid number m."""
    return frames[m, LEFT] - 1 <= x <= frames[m, RIGHT] and frames[m, TOP] - 1 <= y <= frames[m, BOTTOM]


@device
def meet_one(work, j, solids, m):
    """Return the depth at which ray number j of a batch meets solid number m."""
    return meet(
        solids, m, work[OX + j], work[OY + j], work[OZ + j], work[DX + j], work[DY + j], work[DZ + j]
    )  # fmt: skip


@device
def meet_pixel(work, at, solids, m):
    """Store the depths at which the samples of a pixel, from ray number `at` on, meet solid number m, as `meet_one`."""
    if m < built_in.count(solids):
        meet_built_in(solids, m, work, np.uint64(at))
        return
    rays, found = local_float64(), local_float64()
    for k in range(WHOLE):
        put_ray(rays, k, ray_at(work, np.uint64(at + k)))
    meet_rays(solids, m, rays, found)
    for k in range(WHOLE):
        work[MET + at + k] = found[k]


@device_if_built_in(lambda solids, m, work, at: None)
def meet_built_in(solids, m, work, at):
    """Store the depths of `meet_pixel` of a solid that has kernels of its own. A loop for each shape has no branches,
    so LLVM makes vectors of it."""
    spheres, capsules, planes = solids.spheres, solids.capsules, solids.planes
    end = at + np.uint64(WHOLE)
    if m < spheres.shape[0]:
        for j in range(at, end):
            ox, oy, oz, dx, dy, dz = ray_at(work, j)
            work[AT_MET + j] = sphere.meet(spheres, m, ox, oy, oz, dx, dy, dz)
        return
    m -= spheres.shape[0]
    if m < capsules.shape[0]:
        for j in range(at, end):
            ox, oy, oz, dx, dy, dz = ray_at(work, j)
            work[AT_MET + j] = capsule.meet(capsules, m, ox, oy, oz, dx, dy, dz)
        return
    m -= capsules.shape[0]
    if m < planes.shape[0]:
        for j in range(at, end):
            ox, oy, oz, dx, dy, dz = ray_at(work, j)
            work[AT_MET + j] = plane.meet(planes, m, ox, oy, oz, dx, dy, dz)
        return
    m -= planes.shape[0]
    for j in range(at, end):
        ox, oy, oz, dx, dy, dz = ray_at(work, j)
        work[AT_MET + j] = box.meet(solids.boxes, m, ox, oy, oz, dx, dy, dz)


@device
def ray_at(work, j):
    """Return origin and direction of ray number j of a batch."""
    return (
        work[AT_OX + j], work[AT_OY + j], work[AT_OZ + j],
        work[AT_DX + j], work[AT_DY + j], work[AT_DZ + j],
    )  # fmt: skip


@device
def count_samples(pixels, width, e, best, at, keys, spots, counts):
    """Count the samples of a pixel by solid, and sum their positions; at: index of the pixel's first sample in best."""
    for slot in range(SLOTS):
        keys[e, slot] = EMPTY
        counts[e, slot] = 0
        spots[e, slot, 0] = ZERO
        spots[e, slot, 1] = ZERO
    x, y = np.float32(pixels[e] % width), np.float32(pixels[e] // width)
    for i in range(WHOLE):
        own = best[at + i]
        if own != EMPTY:
            slot = 0
            while slot < SLOTS - 1 and keys[e, slot] != EMPTY and (keys[e, slot] & LOW) != (own & LOW):
                slot += 1
            column, row = spot(x, y, i)
            keys[e, slot] = min(own, keys[e, slot])
            counts[e, slot] += 1
            spots[e, slot, 0] += column
            spots[e, slot, 1] += row


@device
def place_at_mean(e, view, flat, far, solids, keys, spots, counts):
    """Replace the summed positions of a pixel's solids by their means, and compute the solids' keys there."""
    for slot in range(SLOTS):
        if counts[e, slot] > 0:
            column = spots[e, slot, 0] / np.float32(counts[e, slot])
            row = spots[e, slot, 1] / np.float32(counts[e, slot])
            spots[e, slot, 0] = column
            spots[e, slot, 1] = row
            ox, oy, oz, dx, dy, dz = ray(
                view, (column - view[AXIS_X]) / view[FOCAL], (view[AXIS_Y] - row) / view[FOCAL]
            )
            which = np.int64((keys[e, slot] & LOW) - FIRST)
            # solids are convex, so the mean position shows the solid too, except for rounding
            t = meet(solids, which, ox, oy, oz, dx, dy, dz)
            if t < INF:
                keys[e, slot] = key_at(t, view, flat, far, FIRST + np.uint64(which))


@device
def foremost(keys, e):
    """Return the slot of the solid in front in pixel number e."""
    best = 0
    for slot in range(1, SLOTS):
        if keys[e, slot] < keys[e, best]:
            best = slot
    return best


@parallel
def part(pixels, keys, counts, hides, depth, cover):
    """Separate the solid in front from the rest of each pixel.

    depth, cover (E,) float32 out: its depth number, and its share of the samples; hides (P,) float32 out: depth number
    behind which the other samples hide everything, 0 if any of them is empty."""
    for edge in prange(pixels.shape[0]):
        e = np.int64(edge)
        front = foremost(keys, e)
        depth[e] = number(keys[e, front])
        # a solid that all samples show is the opaque background, as in the other pixels
        cover[e] = np.float32(counts[e, front] % WHOLE) / np.float32(WHOLE)
        rest = np.float32(np.inf)
        shown = np.int64(0)
        for slot in range(SLOTS):
            shown += counts[e, slot]
            if slot != front and counts[e, slot] > 0:
                rest = min(rest, number(keys[e, slot]))
        if counts[e, front] < WHOLE:
            hides[pixels[e]] = rest if shown == WHOLE else ZERO


@device
def number(key):
    """Return the depth number of a key."""
    return np.uint32(LOW - (key >> SHIFT)).view(np.float32)


@parallel
def composite(pixels, keys, counts, colours, front, image):
    """Write the radiance of the solid in front to front (E, 3), and the mean of the other samples to the picture.

    colours (E, SLOTS, 3): radiance of each solid; image (height, width, 3): contains the background, which empty
    samples show."""
    width = image.shape[1]
    for edge in prange(pixels.shape[0]):
        e = np.int64(edge)
        x = pixels[e] % width
        y = pixels[e] // width
        best = foremost(keys, e)
        alone = counts[e, best] == WHOLE
        others = np.float32(WHOLE if alone else WHOLE - counts[e, best])
        shown = np.int64(0)
        for slot in range(SLOTS):
            shown += counts[e, slot]
        for c in range(3):
            front[e, c] = colours[e, best, c]
            light = np.float32(WHOLE - shown) * image[y, x, c]
            for slot in range(SLOTS):
                if alone or slot != best:
                    light += np.float32(counts[e, slot]) * colours[e, slot, c]
            image[y, x, c] = light / others
