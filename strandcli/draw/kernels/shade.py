"""Light on strands and solids: every light with its strand shadow and the solids' shadows, and what comes from
everywhere."""

from __future__ import annotations

import math

import numpy as np

from ...jit import function, parallel, prange
from . import solids
from .marschner import kajiya_diffuse, marschner
from .raster import EMPTY, LOW
from .shadow import transmittance

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
INV_PI = np.float32(1 / math.pi)
TINY = np.float32(1e-30)
FAR = np.float32(1e30)


@function
def mark(keys, base, count, per, stride, marks):
    """Note the vertices that the light has to be known at: the ends of what is seen.

    keys (P,) uint64; base: number that was added to vertex indices; per: vertices a strand where all have the same
    number, else 0; stride: every which vertex is lit, 1 unless `per` says where a strand begins; marks (count,) uint8,
    zero before.
    Returns how many pixels hold one of these segments.
    """
    seen = 0
    for p in range(keys.shape[0]):
        if keys[p] != EMPTY:
            v = np.int64(keys[p] & LOW) - base
            if 0 <= v < count - 1:
                if stride > 1:
                    v -= (v % per) % stride
                marks[v] = 1
                marks[v + stride] = 1
                seen += 1
    return seen


@function
def toward(light, x, y, z):
    """Unit direction to a light, its distance, and its irradiance's falloff at a point."""
    if light[0] == ZERO:
        return light[1], light[2], light[3], FAR, ONE
    lx = light[1] - x
    ly = light[2] - y
    lz = light[3] - z
    square = max(lx * lx + ly * ly + lz * lz, TINY)
    size = math.sqrt(square)
    return lx / size, ly / size, lz / size, size, ONE / square


@parallel
def strands(
    first, world, marks, tones, view, colour, tint, diffuse, ambient, lobes, nodes, paths,
    lights, maps, starts, sizes, views, spheres, capsules, planes, boxes, skin, out,
):  # fmt: skip
    """Radiance toward the camera at the marked vertices.

    first (S + 1,) int64; world (V, 3) metres; marks (V,) uint8, or None for all; tones (S,) in [−1, 1]; view (24,);
    colour (3,); tint (A, B, 6): for the place along the strand and for its tone, colour and extra absorption, or None;
    diffuse: scale; ambient (3,); lobes, nodes, paths: tables of `strandcli.render.marschner`, None where not needed;
    lights (n, 16): [0] 0 directional, 1 point; [1:4] unit direction to the light, or its position; [4:7] irradiance,
    or intensity in W/sr; [7:10] shadow maps (`shadow.transmittance`); maps (T, 2), or None for no maps at all; starts,
    sizes (M,), views (M, 24); solids packed, `skin` metres; spheres None where no solid casts shadows; out (V, 3).
    """
    for s in prange(first.shape[0] - 1):
        begin = first[s]
        end = first[s + 1]
        per = ONE / np.float32(max(end - begin - 1, 1))
        for v in range(begin, end):
            if marks is not None and marks[v] == 0:
                continue
            x = world[v, 0]
            y = world[v, 1]
            z = world[v, 2]
            low = max(v - 1, begin)
            high = min(v + 1, end - 1)
            tx = world[high, 0] - world[low, 0]
            ty = world[high, 1] - world[low, 1]
            tz = world[high, 2] - world[low, 2]
            size = ONE / math.sqrt(max(tx * tx + ty * ty + tz * tz, TINY))
            tx *= size
            ty *= size
            tz *= size
            if view[12] > ZERO:
                ex = view[20] - x
                ey = view[21] - y
                ez = view[22] - z
                size = ONE / math.sqrt(max(ex * ex + ey * ey + ez * ez, TINY))
                ex *= size
                ey *= size
                ez *= size
            else:
                ex = -view[8]
                ey = -view[9]
                ez = -view[10]
            extra_r = ZERO
            extra_g = ZERO
            extra_b = ZERO
            if tint is None:
                cr = colour[0]
                cg = colour[1]
                cb = colour[2]
            else:
                cr, cg, cb, extra_r, extra_g, extra_b = look_up(tint, np.float32(v - begin) * per, tones[s])
            r = ambient[0] * cr
            g = ambient[1] * cg
            b = ambient[2] * cb
            for i in range(lights.shape[0]):
                light = lights[i]
                lx, ly, lz, reach, falloff = toward(light, x, y, z)
                if spheres is not None:
                    falloff *= solids.lit(spheres, capsules, planes, boxes, x, y, z, lx, ly, lz, reach, skin)
                    if falloff == ZERO:
                        continue
                if maps is not None:
                    falloff *= transmittance(x, y, z, light, maps, starts, sizes, views)
                    if falloff == ZERO:
                        continue
                if diffuse > ZERO:
                    d = diffuse * kajiya_diffuse(tx, ty, tz, lx, ly, lz)
                    sr = d * cr
                    sg = d * cg
                    sb = d * cb
                else:
                    sr = ZERO
                    sg = ZERO
                    sb = ZERO
                if lobes is not None:
                    mr, mg, mb = marschner(
                        tx, ty, tz, lx, ly, lz, ex, ey, ez, lobes, nodes, paths, extra_r, extra_g, extra_b
                    )
                    sr += mr
                    sg += mg
                    sb += mb
                r += falloff * light[4] * sr
                g += falloff * light[5] * sg
                b += falloff * light[6] * sb
            out[v, 0] = r
            out[v, 1] = g
            out[v, 2] = b


@function
def look_up(tint, along, tone):
    """Bilinear in a table (A, B, 6) over along in [0, 1] and tone in [−1, 1]."""
    a = along * np.float32(tint.shape[0] - 1)
    b = (tone + ONE) * HALF * np.float32(tint.shape[1] - 1)
    i = min(int(a), tint.shape[0] - 2)
    j = min(int(b), tint.shape[1] - 2)
    a -= np.float32(i)
    b -= np.float32(j)
    w11 = a * b
    w10 = a - w11
    w01 = b - w11
    w00 = ONE - a - w01
    p = tint[i, j]
    q = tint[i, j + 1]
    r = tint[i + 1, j]
    s = tint[i + 1, j + 1]
    return (
        w00 * p[0] + w01 * q[0] + w10 * r[0] + w11 * s[0],
        w00 * p[1] + w01 * q[1] + w10 * r[1] + w11 * s[1],
        w00 * p[2] + w01 * q[2] + w10 * r[2] + w11 * s[2],
        w00 * p[3] + w01 * q[3] + w10 * r[3] + w11 * s[3],
        w00 * p[4] + w01 * q[4] + w10 * r[4] + w11 * s[4],
        w00 * p[5] + w01 * q[5] + w10 * r[5] + w11 * s[5],
    )


@parallel
def surfaces(
    keys, width, height, view, ambient, lights, maps, starts, sizes, views,
    spheres, capsules, planes, boxes, paint, skin, image,
):  # fmt: skip
    """Lambertian radiance of the solids that are seen.

    keys (height * width,) uint64; paint (m, 8): colour, fade distance (0: none), centre of the fading, unused;
    image (height, width, 3), which holds the background before and keeps it elsewhere; the rest as in `strands`.
    """
    focal = view[13]
    for row in prange(height):
        up = (view[16] - np.float32(row) - HALF) / focal
        for column in range(width):
            key = keys[row * width + column]
            if key == EMPTY or (key & LOW) < solids.FIRST:
                continue
            which = np.int64((key & LOW) - solids.FIRST)
            right = (np.float32(column) + HALF - view[15]) / focal
            ox, oy, oz, dx, dy, dz = solids.ray(view, right, up)
            t = solids.meet(spheres, capsules, planes, boxes, which, ox, oy, oz, dx, dy, dz)
            x = ox + t * dx
            y = oy + t * dy
            z = oz + t * dz
            nx, ny, nz = solids.normal(spheres, capsules, planes, boxes, which, x, y, z)
            r = ambient[0]
            g = ambient[1]
            b = ambient[2]
            for i in range(lights.shape[0]):
                light = lights[i]
                lx, ly, lz, reach, falloff = toward(light, x, y, z)
                cosine = nx * lx + ny * ly + nz * lz
                if cosine <= ZERO:
                    continue
                falloff *= cosine * INV_PI
                px = x + nx * skin
                py = y + ny * skin
                pz = z + nz * skin
                falloff *= solids.lit(spheres, capsules, planes, boxes, px, py, pz, lx, ly, lz, reach, skin)
                if maps is not None and falloff > ZERO:
                    falloff *= transmittance(x, y, z, light, maps, starts, sizes, views)
                r += falloff * light[4]
                g += falloff * light[5]
                b += falloff * light[6]
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
