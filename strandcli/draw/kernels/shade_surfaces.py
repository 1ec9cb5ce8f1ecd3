"""Light on solids."""

from __future__ import annotations

import math

import numpy as np

from ...jit import parallel, prange
from . import dual, occlusion, opacity, penumbra, solids
from .light import around, toward
from .raster import EMPTY, LOW, SHIFT
from .shadow import transmittance

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-6)
INV_PI = np.float32(1 / math.pi)


@parallel
def surfaces(
    keys, width, height, view, ambient, sky, volume, box, bounce, lights, veil, maps, stacks, starts, sizes, views,
    spheres, capsules, planes, boxes, paint, skin, sized, spots, image,
):  # fmt: skip
    """Lambertian radiance of the solids that are seen.

    keys (height * width,) uint64; paint (m, 8): colour, fade distance (0: none), centre of the fading, unused;
    spots (height * width, 2) float32: where on the screen each of these pixels lies, (0, 2) where at its own place;
    bounce (3,): colour of a mass of strands; veil: of `strandcli.draw.dual.veil_of`, None where strands shade in grey;
    image (height, width, 3), which holds the background before and keeps it elsewhere; the rest as in
    `shade_strands.strands`.
    """
    focal = view[13]
    for row in prange(height):
        for column in range(width):
            key = keys[row * width + column]
            if key == EMPTY or (key & LOW) < solids.FIRST:
                continue
            which = np.int64((key & LOW) - solids.FIRST)
            sx = np.float32(column) + HALF
            sy = np.float32(row) + HALF
            if spots.shape[0] > 0:
                sx = spots[row * width + column, 0]
                sy = spots[row * width + column, 1]
            right = (sx - view[15]) / focal
            up = (view[16] - sy) / focal
            ox, oy, oz, dx, dy, dz = solids.ray(view, right, up)
            if view[12] > ZERO:  # the key tells: one over the depth
                t = ONE / np.uint32(LOW - (key >> SHIFT)).view(np.float32)
            else:
                t = solids.meet(spheres, capsules, planes, boxes, which, ox, oy, oz, dx, dy, dz)
            x = ox + t * dx
            y = oy + t * dy
            z = oz + t * dz
            nx, ny, nz = solids.normal(spheres, capsules, planes, boxes, which, x, y, z)
            r = ambient[0]
            g = ambient[1]
            b = ambient[2]
            if sky is not None:
                r += around(sky, 1, 0, nx, ny, nz)
                g += around(sky, 1, 1, nx, ny, nz)
                b += around(sky, 1, 2, nx, ny, nz)
            if volume is not None:
                share = occlusion.seen(volume, box, x, y, z, nx, ny, nz)
                r *= share / max(ONE - bounce[0] * (ONE - share), TINY)
                g *= share / max(ONE - bounce[1] * (ONE - share), TINY)
                b *= share / max(ONE - bounce[2] * (ONE - share), TINY)
            for i in range(lights.shape[0]):
                lx, ly, lz, reach, falloff = toward(lights, i, x, y, z)
                cosine = nx * lx + ny * ly + nz * lz
                if cosine <= ZERO:
                    continue
                falloff *= cosine * INV_PI
                px = x + nx * skin
                py = y + ny * skin
                pz = z + nz * skin
                falloff *= penumbra.past(
                    spheres, capsules, planes, boxes, px, py, pz, lx, ly, lz, reach, skin, lights, i, sized
                )
                if maps is not None and falloff > ZERO and lights[i, 10] == ZERO:
                    falloff *= transmittance(x, y, z, lights, i, maps, starts, sizes, views)
                if stacks is not None and falloff > ZERO and lights[i, 10] > ZERO:
                    if veil is None:
                        falloff *= opacity.transmittance(x, y, z, lights, i, stacks, starts, sizes, views)
                    else:
                        passed = opacity.optical_depth(x, y, z, lights, i, stacks, starts, sizes, views)
                        r += falloff * lights[i, 4] * dual.through(passed, veil, 0)
                        g += falloff * lights[i, 5] * dual.through(passed, veil, 1)
                        b += falloff * lights[i, 6] * dual.through(passed, veil, 2)
                        continue
                r += falloff * lights[i, 4]
                g += falloff * lights[i, 5]
                b += falloff * lights[i, 6]
            there = ONE
            if paint[which, 3] > ZERO:
                ax = x - paint[which, 4]
                ay = y - paint[which, 5]
                az = z - paint[which, 6]
                there = max(ONE - math.sqrt(ax * ax + ay * ay + az * az) / paint[which, 3], ZERO)
                there = there * there * (np.float32(3.0) - np.float32(2.0) * there)
            image[row, column, 0] += there * (r * paint[which, 0] - image[row, column, 0])
            image[row, column, 1] += there * (g * paint[which, 1] - image[row, column, 1])
            image[row, column, 2] += there * (b * paint[which, 2] - image[row, column, 2])
