"""Light on strands: every light with its strand shadow and the solids' shadows, and what comes from everywhere.

Vertices that are seen are gathered in batches of W, strand after strand, into an array of rows; what needs no table is
one loop over a row, which becomes vector code, and only what reads maps and tables goes vertex by vertex.
"""

from __future__ import annotations

import math

import numpy as np

from ...constants import W
from ...jit import function, parallel, prange
from . import chiang, dual, opacity, solids
from .approximations import exp
from .light import around, toward
from .marschner import azimuthal, kajiya_diffuse, longitudinal, mix
from .shadow import between, held, texel_of, through

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-30)
NEXT = np.uint64(1)
STRANDS = 128
"""Strands a task."""

# Rows of a batch, W numbers each, in one array: a compiler that knows how far apart they are need not fear that they
# overlap. Position, tangent, direction to the eye, colour, absorption beyond the tables', radiance; then of one light
# the direction to it, its distance, what of it arrives, the place in a map with its texels or in a table with weights,
# strands that it passed and that it would still meet.
X, Y, Z, TX, TY, TZ, EX, EY, EZ = (i * W for i in range(9))
COLOUR, EXTRA, RADIANCE = 9 * W, 12 * W, 15 * W
LX, LY, LZ, REACH, ARRIVES = (i * W for i in range(18, 23))
U, V, DEPTH, INSIDE = (i * W for i in range(23, 27))
TEXELS = 27 * W
R, TT, TRT, REST = (TEXELS + i * W for i in range(4))
PASSED, WHOLE, LEFT = 35 * W, 36 * W, 37 * W
SIN_L, COS_L, SIN_V, COS_V, COS_PHI, PLACE = (i * W for i in range(38, 44))
TABLE = 44 * W
ROWS = 44 + dual.CHANNELS


@parallel
def strands(
    first, world, marks, tones, view, colour, tint, diffuse, ambient, sky, lobes, fibre, nodes, paths, twice,
    scale, lights, maps, stacks, starts, sizes, views, spheres, capsules, planes, boxes, skin, out,
):  # fmt: skip
    """Radiance toward the camera at the marked vertices.

    first (S + 1,) int64; world (V, 3) metres; marks (V,) uint8, or None for all; tones (S,) in [−1, 1]; view (26,);
    colour (3,); tint (A, B, 6): for the place along the strand and for its tone, colour and extra absorption, or None;
    diffuse: scale; ambient (3,); sky: of `strandcli.draw.environment`, or None;
    lobes, nodes, paths: tables of `strandcli.draw.marschner`, or fibre, nodes, paths: those of `strandcli.draw.chiang`;
    twice, scale: of `strandcli.draw.dual`; None where not needed;
    lights (n, 16): [0] 0 directional, 1 point; [1:4] unit direction to the light, or its position; [4:7] irradiance,
    or intensity in W/sr; [7:11] shadow maps (`shadow.transmittance`, `opacity.optical_depth`); maps (T, 2) and stacks,
    each None where there is no map of its kind; starts, sizes (M,), views (M, 24); solids packed, `skin` metres;
    spheres None where no solid casts shadows; out (V, 3).
    """
    count = first.shape[0] - 1
    for task in prange((count + STRANDS - 1) // STRANDS):
        work = np.empty(ROWS * W, np.float32)
        work[EXTRA:RADIANCE] = ZERO
        which = np.empty(W, np.int64)
        n = np.int64(0)  # a literal would have everything below compiled twice
        for s in range(task * STRANDS, min((task + 1) * STRANDS, count)):
            begin = first[s]
            end = first[s + 1]
            per = ONE / np.float32(max(end - begin - 1, 1))
            for v in range(begin, end):
                if marks is not None and marks[v] == 0:
                    continue
                gather(world, v, begin, end, tones[s], per, colour, tint, ambient, work, n)
                which[n] = v
                n += 1
                if n == W:
                    batch(
                        work, n, view, diffuse, sky, lobes, fibre, nodes, paths, twice, scale, lights,
                        maps, stacks, starts, sizes, views, spheres, capsules, planes, boxes, skin,
                    )  # fmt: skip
                    scatter(work, which, n, out)
                    n = np.int64(0)
        batch(
            work, n, view, diffuse, sky, lobes, fibre, nodes, paths, twice, scale, lights,
            maps, stacks, starts, sizes, views, spheres, capsules, planes, boxes, skin,
        )  # fmt: skip
        scatter(work, which, n, out)


@function
def gather(world, v, begin, end, tone, per, colour, tint, ambient, work, k):
    """Put a vertex into place k of a batch."""
    low = max(v - 1, begin)
    high = min(v + 1, end - 1)
    for c in range(3):
        work[X + c * W + k] = world[v, c]
        work[TX + c * W + k] = world[high, c] - world[low, c]
    if tint is None:
        for c in range(3):
            work[COLOUR + c * W + k] = colour[c]
    else:
        found = look_up(tint, np.float32(v - begin) * per, tone)
        for c in range(3):
            work[COLOUR + c * W + k] = found[c]
            work[EXTRA + c * W + k] = found[c + 3]
    for c in range(3):
        work[RADIANCE + c * W + k] = ambient[c] * work[COLOUR + c * W + k]


@function
def scatter(work, which, n, out):
    """Radiance back to the vertices of a batch."""
    for k in range(n):
        for c in range(3):
            out[which[k], c] = work[RADIANCE + c * W + k]


@function
def batch(
    work, n, view, diffuse, sky, lobes, fibre, nodes, paths, twice, scale, lights,
    maps, stacks, starts, sizes, views, spheres, capsules, planes, boxes, skin,
):  # fmt: skip
    """Radiance of the first n vertices of a batch."""
    frames(work, n, view)
    if sky is not None:
        for c in range(3):
            for k in range(n):
                whole = around(sky, 0, c, work[TX + k], work[TY + k], work[TZ + k])
                work[RADIANCE + c * W + k] += whole * work[COLOUR + c * W + k]
    for i in range(lights.shape[0]):
        aim(work, n, lights, i)
        if spheres is not None:
            hide(work, n, spheres, capsules, planes, boxes, skin)
        if maps is not None and lights[i, 10] == ZERO:
            for one in range(int(lights[i, 7]), int(lights[i, 7] + lights[i, 8])):
                shade(work, n, views, one, maps, starts[one], sizes[one], lights[i, 9])
        if stacks is not None and lights[i, 10] > ZERO:
            for k in range(n):
                work[PASSED + k] = ZERO
                work[LEFT + k] = ZERO
            for one in range(int(lights[i, 7]), int(lights[i, 7] + lights[i, 8])):
                sink(work, n, views, one, stacks, np.int64(lights[i, 10]), starts[one], sizes[one], lights[i, 9])
                if twice is not None:
                    beyond(work, n, stacks, np.int64(lights[i, 10]), starts[one], sizes[one])
            for k in range(n):
                work[WHOLE + k] = work[ARRIVES + k]
                work[ARRIVES + k] *= exp(-work[PASSED + k])
        if twice is not None and lights[i, 10] > ZERO:
            glow(work, n, lights, i, twice, scale)
        elif diffuse > ZERO:
            for k in range(n):
                d = diffuse * kajiya_diffuse(
                    work[TX + k], work[TY + k], work[TZ + k], work[LX + k], work[LY + k], work[LZ + k]
                )
                d *= work[ARRIVES + k]
                work[RADIANCE + k] += lights[i, 4] * (d * work[COLOUR + k])
                work[RADIANCE + W + k] += lights[i, 5] * (d * work[COLOUR + W + k])
                work[RADIANCE + 2 * W + k] += lights[i, 6] * (d * work[COLOUR + 2 * W + k])
        if lobes is not None:
            shine(work, n, lights, i, lobes, nodes, paths)
        if fibre is not None:
            gleam(work, n, lights, i, fibre, nodes, paths)


@function
def frames(work, n, view):
    """Unit tangents, and unit directions to the eye."""
    perspective = view[12]
    straight = perspective - ONE  # an orthographic eye is everywhere against the view
    for k in range(n):
        x = work[TX + k]
        y = work[TY + k]
        z = work[TZ + k]
        size = ONE / math.sqrt(max(x * x + y * y + z * z, TINY))
        work[TX + k] = x * size
        work[TY + k] = y * size
        work[TZ + k] = z * size
        x = perspective * (view[20] - work[X + k]) + straight * view[8]
        y = perspective * (view[21] - work[Y + k]) + straight * view[9]
        z = perspective * (view[22] - work[Z + k]) + straight * view[10]
        size = ONE / math.sqrt(max(x * x + y * y + z * z, TINY))
        work[EX + k] = x * size
        work[EY + k] = y * size
        work[EZ + k] = z * size


@function
def aim(work, n, lights, i):
    """Directions to a light, and its falloff."""
    for k in range(n):
        x, y, z, reach, falloff = toward(lights, i, work[X + k], work[Y + k], work[Z + k])
        work[LX + k] = x
        work[LY + k] = y
        work[LZ + k] = z
        work[REACH + k] = reach
        work[ARRIVES + k] = falloff
        work[INSIDE + k] = ZERO


@function
def hide(work, n, spheres, capsules, planes, boxes, skin):
    """No light where a solid stands between."""
    for s in range(spheres.shape[0]):
        for k in range(n):
            work[ARRIVES + k] *= solids.past_sphere(
                spheres, s, work[X + k], work[Y + k], work[Z + k], work[LX + k], work[LY + k], work[LZ + k],
                work[REACH + k], skin,
            )  # fmt: skip
    if capsules.shape[0] + planes.shape[0] + boxes.shape[0] > 0:
        for k in range(n):
            if work[ARRIVES + k] > ZERO:
                work[ARRIVES + k] *= solids.past_others(
                    capsules, planes, boxes, work[X + k], work[Y + k], work[Z + k],
                    work[LX + k], work[LY + k], work[LZ + k], work[REACH + k], skin,
                )  # fmt: skip


@function
def shade(work, n, views, one, maps, start, size, bias):
    """What strands leave of a light, by one map: only where no map before held the vertex."""
    if size < 2:
        return
    locate(work, n, views, one, size, bias)
    for k in range(n):
        texel = np.uint64(start + np.int64(work[V + k]) * size + np.int64(work[U + k]))
        below = texel + np.uint64(size)
        work[TEXELS + k] = maps[texel, 0]
        work[TEXELS + W + k] = maps[texel, 1]
        work[TEXELS + 2 * W + k] = maps[texel + NEXT, 0]
        work[TEXELS + 3 * W + k] = maps[texel + NEXT, 1]
        work[TEXELS + 4 * W + k] = maps[below, 0]
        work[TEXELS + 5 * W + k] = maps[below, 1]
        work[TEXELS + 6 * W + k] = maps[below + NEXT, 0]
        work[TEXELS + 7 * W + k] = maps[below + NEXT, 1]
    for k in range(n):
        d = work[DEPTH + k]
        left = between(
            work[U + k] - np.floor(work[U + k]),
            work[V + k] - np.floor(work[V + k]),
            through(d, work[TEXELS + k], work[TEXELS + W + k]),
            through(d, work[TEXELS + 2 * W + k], work[TEXELS + 3 * W + k]),
            through(d, work[TEXELS + 4 * W + k], work[TEXELS + 5 * W + k]),
            through(d, work[TEXELS + 6 * W + k], work[TEXELS + 7 * W + k]),
        )
        work[ARRIVES + k] *= left if work[INSIDE + k] > ZERO else ONE


@function
def locate(work, n, views, one, size, bias):
    """Where a map shows the vertices that no map before held."""
    edge = np.float32(size - 1)
    for k in range(n):
        u, v, d = texel_of(work[X + k], work[Y + k], work[Z + k], views, one)
        fresh = held(u, v, d, views, one, edge) & (work[INSIDE + k] == ZERO)
        work[U + k] = u if fresh else ZERO
        work[V + k] = v if fresh else ZERO
        work[DEPTH + k] = d - bias if fresh else -ONE
        work[INSIDE + k] = ONE if fresh else -work[INSIDE + k] * work[INSIDE + k]  # −1: by a map before


@function
def sink(work, n, views, one, stacks, layers, start, size, bias):
    """Strands between the light and each vertex, by one opacity map: as `shade`."""
    if size < 2:
        return
    locate(work, n, views, one, size, bias)
    stride = np.uint64(layers + opacity.HEAD + 1)
    down = np.uint64(size) * stride
    for k in range(n):
        place = np.int64(work[V + k]) * size + np.int64(work[U + k])
        texel = np.uint64(start) + np.uint64(place) * stride
        d = work[DEPTH + k]
        work[TEXELS + k] = opacity.depth_at(d, texel, layers, stacks)
        work[TEXELS + W + k] = opacity.depth_at(d, texel + stride, layers, stacks)
        work[TEXELS + 2 * W + k] = opacity.depth_at(d, texel + down, layers, stacks)
        work[TEXELS + 3 * W + k] = opacity.depth_at(d, texel + down + stride, layers, stacks)
    for k in range(n):
        passed = between(
            work[U + k] - np.floor(work[U + k]),
            work[V + k] - np.floor(work[V + k]),
            work[TEXELS + k],
            work[TEXELS + W + k],
            work[TEXELS + 2 * W + k],
            work[TEXELS + 3 * W + k],
        )
        work[PASSED + k] += passed if work[INSIDE + k] > ZERO else ZERO


@function
def beyond(work, n, stacks, layers, start, size):
    """Strands behind each vertex, where `sink` has just found those in front of it."""
    if size < 2:
        return
    stride = np.uint64(layers + opacity.HEAD + 1)
    down = np.uint64(size) * stride
    for k in range(n):
        place = np.int64(work[V + k]) * size + np.int64(work[U + k])
        last = np.uint64(start) + np.uint64(place + 1) * stride - NEXT
        work[TEXELS + k] = stacks[last]
        work[TEXELS + W + k] = stacks[last + stride]
        work[TEXELS + 2 * W + k] = stacks[last + down]
        work[TEXELS + 3 * W + k] = stacks[last + down + stride]
    for k in range(n):
        total = between(
            work[U + k] - np.floor(work[U + k]),
            work[V + k] - np.floor(work[V + k]),
            work[TEXELS + k],
            work[TEXELS + W + k],
            work[TEXELS + 2 * W + k],
            work[TEXELS + 3 * W + k],
        )
        work[LEFT + k] += max(total - work[PASSED + k], ZERO) if work[INSIDE + k] > ZERO else ZERO


@function
def shine(work, n, lights, i, lobes, nodes, paths):
    """Highlights by Marschner's model."""
    for k in range(n):
        x, y, r, tt, trt = longitudinal(
            work[TX + k], work[TY + k], work[TZ + k], work[LX + k], work[LY + k], work[LZ + k],
            work[EX + k], work[EY + k], work[EZ + k], lobes,
        )  # fmt: skip
        work[U + k] = x
        work[V + k] = y
        work[R + k] = r
        work[TT + k] = tt
        work[TRT + k] = trt
    for k in range(n):
        arrives = work[ARRIVES + k]
        if arrives > ZERO:
            r, g, b = azimuthal(
                work[U + k], work[V + k], work[R + k], work[TT + k], work[TRT + k], nodes, paths,
                work[EXTRA + k], work[EXTRA + W + k], work[EXTRA + 2 * W + k],
            )  # fmt: skip
            work[RADIANCE + k] += arrives * lights[i, 4] * r
            work[RADIANCE + W + k] += arrives * lights[i, 5] * g
            work[RADIANCE + 2 * W + k] += arrives * lights[i, 6] * b


@function
def gleam(work, n, lights, i, fibre, nodes, paths):
    """Highlights by Chiang's model."""
    for k in range(n):
        x, y, r, tt, trt, rest = chiang.longitudinal(
            work[TX + k], work[TY + k], work[TZ + k], work[LX + k], work[LY + k], work[LZ + k],
            work[EX + k], work[EY + k], work[EZ + k], fibre,
        )  # fmt: skip
        work[U + k] = x
        work[V + k] = y
        work[R + k] = r
        work[TT + k] = tt
        work[TRT + k] = trt
        work[REST + k] = rest
    for k in range(n):
        arrives = work[ARRIVES + k]
        if arrives > ZERO:
            r, g, b = chiang.azimuthal(
                work[U + k], work[V + k], work[R + k], work[TT + k], work[TRT + k], work[REST + k], nodes, paths,
                work[EXTRA + k], work[EXTRA + W + k], work[EXTRA + 2 * W + k],
            )  # fmt: skip
            work[RADIANCE + k] += arrives * lights[i, 4] * r
            work[RADIANCE + W + k] += arrives * lights[i, 5] * g
            work[RADIANCE + 2 * W + k] += arrives * lights[i, 6] * b


@function
def glow(work, n, lights, one, twice, scale):
    """Light that comes by way of other strands. What reaches a vertex with no strand in the way is in the row `WHOLE`,
    what does with them in `ARRIVES`."""
    nodes = twice.shape[0]
    for k in range(n):
        sin_l, cos_l, sin_v, cos_v, cos_phi, place = dual.angles(
            work[TX + k], work[TY + k], work[TZ + k], work[LX + k], work[LY + k], work[LZ + k],
            work[EX + k], work[EY + k], work[EZ + k], nodes,
        )  # fmt: skip
        work[SIN_L + k] = sin_l
        work[COS_L + k] = cos_l
        work[SIN_V + k] = sin_v
        work[COS_V + k] = cos_v
        work[COS_PHI + k] = cos_phi
        work[PLACE + k] = place
    for k in range(n):
        i = min(np.int64(work[PLACE + k]), nodes - 2)
        part = work[PLACE + k] - np.float32(i)
        for c in range(dual.CHANNELS):
            low = twice[i, c]
            work[TABLE + c * W + k] = low + part * (twice[i + 1, c] - low)
    for k in range(n):
        back, through = dual.lobes(
            work[SIN_L + k], work[COS_L + k], work[SIN_V + k], work[COS_V + k], work[PASSED + k],
            work[TABLE + dual.SPREAD * W + k], work[TABLE + dual.WIDTH * W + k], work[TABLE + dual.OWN * W + k],
        )  # fmt: skip
        work[U + k] = back
        work[V + k] = through
    for c in range(3):
        power = lights[one, 4 + c]
        per = scale[c]
        for k in range(n):
            s = dual.scattered(
                work[PASSED + k], work[LEFT + k], exp(-work[PASSED + k]), work[COS_PHI + k], work[U + k], work[V + k],
                work[TABLE + (dual.DECAY + c) * W + k], work[TABLE + (dual.MIRROR + c) * W + k],
                work[TABLE + (dual.BEAM + c) * W + k], work[TABLE + (dual.ON + c) * W + k],
                work[TABLE + (dual.BACK + c) * W + k],
                work[TABLE + (dual.ROUND + c) * W + k], work[TABLE + (dual.COSINE + c) * W + k],
                work[COLOUR + c * W + k] * per,
            )  # fmt: skip
            work[RADIANCE + c * W + k] += work[WHOLE + k] * power * s


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
    return (
        mix(tint, i, j, 0, w00, w01, w10, w11),
        mix(tint, i, j, 1, w00, w01, w10, w11),
        mix(tint, i, j, 2, w00, w01, w10, w11),
        mix(tint, i, j, 3, w00, w01, w10, w11),
        mix(tint, i, j, 4, w00, w01, w10, w11),
        mix(tint, i, j, 5, w00, w01, w10, w11),
    )
