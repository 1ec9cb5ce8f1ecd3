"""Light on solids."""

from __future__ import annotations

import math

import numpy as np

from ...jit import inner, parallel, prange
from . import finish, occlusion, penumbra, percentage_closer, seams, solids
from .light import around, toward
from .raster import EMPTY, LOW, SHIFT
from .shadow import transmittance

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-6)
INV_PI = np.float32(1 / math.pi)
FOLD = np.float32(4.0)
"""Pixels' widths by which depth leaves a straight line where a surface ends in front of itself."""
FINE = 4
"""Rays along each side of such a pixel."""


@parallel
def surfaces(
    keys, width, height, view, ambient, sky, volume, box, bounce, lights, veil, maps, stacks, starts, sizes, views,
    spheres, capsules, planes, boxes, paint, coats, skin, sized, spots, image,
):  # fmt: skip
    """Radiance of the solids that are seen: Lambertian, under a coat where there is one.

    keys (height * width,) uint64; paint (m, 8): colour, fade distance (0: none), centre of the fading, unused; coats
    (m, 4) as in `kernels.finish`, None where all solids are matte and even;
    spots (height * width, 2) float32: where on the screen each of these pixels lies, (0, 2) where at its own place;
    bounce (3,): colour of a mass of strands; veil: of `strandcli.draw.dual.veil_of`, None where strands shade in grey;
    image (height, width, 3), which holds the background before and keeps it elsewhere; the rest as in
    `shade_strands.strands`. What blends may end in front of itself, which no identity tells: there the mean of 4×4
    rays is taken.
    """
    focal = view[13]
    for row in prange(height):
        for column in range(width):
            at = np.int64(row) * width + column
            key = keys[at]
            if key == EMPTY or (key & LOW) < solids.FIRST:
                continue
            which = np.int64((key & LOW) - solids.FIRST)
            own_place = spots.shape[0] == 0
            fine = own_place and folded(keys, at, column, width, view, spheres, capsules, which)
            side = FINE if fine else 1
            red = ZERO
            green = ZERO
            blue = ZERO
            there = ONE
            hits = ZERO
            for sample in range(side * side):
                sx = np.float32(column) + (np.float32(sample % side) + HALF) / np.float32(side)
                sy = np.float32(row) + (np.float32(sample // side) + HALF) / np.float32(side)
                if not own_place:
                    sx = spots[at, 0]
                    sy = spots[at, 1]
                ox, oy, oz, dx, dy, dz = solids.ray(view, (sx - view[15]) / focal, (view[16] - sy) / focal)
                if view[12] > ZERO and not fine:  # the key tells: one over the depth
                    t = ONE / np.uint32(LOW - (key >> SHIFT)).view(np.float32)
                else:
                    t = solids.meet(spheres, capsules, planes, boxes, which, ox, oy, oz, dx, dy, dz)
                if fine and t == solids.INF:
                    continue
                x = ox + t * dx
                y = oy + t * dy
                z = oz + t * dz
                far = ONE / math.sqrt(dx * dx + dy * dy + dz * dz)
                pixel = t / (focal * far) if view[12] > ZERO else ONE / focal
                r, g, b = radiance(
                    which, x, y, z, -far * dx, -far * dy, -far * dz, pixel, ambient, sky, volume, box, bounce, lights,
                    veil, maps, stacks, starts, sizes, views, spheres, capsules, planes, boxes, paint, coats, skin,
                    sized,
                )  # fmt: skip
                red += r
                green += g
                blue += b
                hits += ONE
                if paint[which, 3] > ZERO:
                    ax = x - paint[which, 4]
                    ay = y - paint[which, 5]
                    az = z - paint[which, 6]
                    there = max(ONE - math.sqrt(ax * ax + ay * ay + az * az) / paint[which, 3], ZERO)
                    there = there * there * (np.float32(3.0) - np.float32(2.0) * there)
            if hits > ZERO:
                image[row, column, 0] += there * (red / hits - image[row, column, 0])
                image[row, column, 1] += there * (green / hits - image[row, column, 1])
                image[row, column, 2] += there * (blue / hits - image[row, column, 2])


@inner
def surroundings(ambient, sky, x, y, z):
    """Radiance, in rgb, of what is around a surface that faces along the unit vector (x, y, z)."""
    r, g, b = ambient[0], ambient[1], ambient[2]
    if sky is not None:
        r += around(sky, 1, 0, x, y, z)
        g += around(sky, 1, 1, x, y, z)
        b += around(sky, 1, 2, x, y, z)
    return r, g, b


@inner
def folded(keys, at, column, width, view, spheres, capsules, which):
    """Whether solid number `which`, if it is one that blends, ends in front of itself at pixel number `at`."""
    if not seams.blends(spheres, capsules, which) or at < width or at >= keys.shape[0] - width:
        return False
    if column < 1 or column > width - 2:
        return False
    here = depth_at(keys, at, view)
    across = bend(keys, at, 1, here, view)
    down = bend(keys, at, width, here, view)
    pixel = here / view[13] if view[12] > ZERO else ONE / view[13]
    return max(across, down) > FOLD * pixel


@inner
def bend(keys, at, step, here, view):
    """Metres by which the depths of three pixels leave a straight line; 0 where they are not of one solid."""
    if (((keys[at - step] ^ keys[at]) | (keys[at + step] ^ keys[at])) & LOW) != np.uint64(0):
        return ZERO
    return abs(depth_at(keys, at - step, view) + depth_at(keys, at + step, view) - here - here)


@inner
def depth_at(keys, at, view):
    """The depth of what a pixel shows, metres."""
    number = np.uint32(LOW - (keys[at] >> SHIFT)).view(np.float32)
    return ONE / number if view[12] > ZERO else view[14] + (ONE - number) * view[19]


@inner
def radiance(
    which, x, y, z, wx, wy, wz, pixel, ambient, sky, volume, box, bounce, lights, veil, maps, stacks, starts, sizes,
    views, spheres, capsules, planes, boxes, paint, coats, skin, sized,
):  # fmt: skip
    """What a point of solid number `which` shows along the unit vector w, where a pixel is ``pixel`` metres wide."""
    nx, ny, nz = solids.normal(spheres, capsules, planes, boxes, which, x, y, z)
    r, g, b = surroundings(ambient, sky, nx, ny, nz)
    if volume is not None:
        share = occlusion.seen(volume, box, x, y, z, nx, ny, nz)
        r *= share / max(ONE - bounce[0] * (ONE - share), TINY)
        g *= share / max(ONE - bounce[1] * (ONE - share), TINY)
        b *= share / max(ONE - bounce[2] * (ONE - share), TINY)
    under = ONE
    coat_r = ZERO
    coat_g = ZERO
    coat_b = ZERO
    if coats is not None:
        facing = nx * wx + ny * wy + nz * wz
        if coats[which, finish.COAT] > ZERO:
            share = finish.mirrored(coats[which, finish.COAT], coats[which, finish.ROUGH], facing)
            under = ONE - share
            # where the eye is mirrored to
            mx = (facing + facing) * nx - wx
            my = (facing + facing) * ny - wy
            mz = (facing + facing) * nz - wz
            coat_r, coat_g, coat_b = surroundings(ambient, sky, mx, my, mz)
            if volume is not None:
                share *= occlusion.seen(volume, box, x, y, z, mx, my, mz)
            coat_r *= share
            coat_g *= share
            coat_b *= share
        if coats[which, finish.MOTTLE] > ZERO:  # a pixel is wider where the surface is seen at a slant
            tone = finish.patches(x, y, z, coats[which, finish.GRAIN], pixel / max(facing, TINY))
            under *= ONE + coats[which, finish.MOTTLE] * tone
    for i in range(lights.shape[0]):
        lx, ly, lz, reach, falloff = toward(lights, i, x, y, z)
        cosine = nx * lx + ny * ly + nz * lz
        if cosine <= ZERO:
            continue
        px = x + nx * skin
        py = y + ny * skin
        pz = z + nz * skin
        falloff *= penumbra.past(
            spheres, capsules, planes, boxes, px, py, pz, lx, ly, lz, reach, skin, lights, i, sized
        )
        if maps is not None and falloff > ZERO and lights[i, 10] == ZERO:
            falloff *= transmittance(x, y, z, lights, i, maps, starts, sizes, views)
        if falloff == ZERO:
            continue
        falloff *= cosine
        red = falloff * lights[i, 4]
        green = falloff * lights[i, 5]
        blue = falloff * lights[i, 6]
        if stacks is not None and lights[i, 10] > ZERO:
            one, two, three = percentage_closer.left(x, y, z, lights, i, veil, stacks, starts, sizes, views)
            red *= one
            green *= two
            blue *= three
        r += INV_PI * red
        g += INV_PI * green
        b += INV_PI * blue
        if coats is not None and coats[which, finish.COAT] > ZERO:
            angle = lights[i, 12] if lights[i, 0] == ZERO else min(lights[i, 12] / reach, ONE)
            share = finish.gleam(
                coats[which, finish.COAT], coats[which, finish.ROUGH], angle, nx, ny, nz, lx, ly, lz, wx, wy, wz
            )
            coat_r += share * red
            coat_g += share * green
            coat_b += share * blue
    return (
        under * r * paint[which, 0] + coat_r,
        under * g * paint[which, 1] + coat_g,
        under * b * paint[which, 2] + coat_b,
    )
