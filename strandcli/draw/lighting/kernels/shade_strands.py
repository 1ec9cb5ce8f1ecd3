"""Light on strands: every light with its strand shadow and the solids' shadows, and what comes from everywhere.

Vertices that are seen are gathered in batches of W, strand after strand, into an array of rows; what needs no table is
one loop over a row, which becomes vector code, and only what reads maps and tables goes vertex by vertex.
"""

from __future__ import annotations

import math

import numpy as np

from ....constants import W
from ....jit import device, function, parallel, prange
from ....solids.kernels import sphere
from ....solids.kernels.outside import count as count_solids
from ...common.kernels.approximations import exp
from ...common.kernels.batch import (
    ARRIVES,
    COLOUR,
    EX,
    EXTRA,
    EY,
    EZ,
    INSIDE,
    LEFT,
    LX,
    LY,
    LZ,
    PASSED,
    RADIANCE,
    REACH,
    ROWS,
    TX,
    TY,
    TZ,
    UNBLOCKED,
    X,
    Y,
    Z,
)
from ...common.kernels.light_columns import (
    BIAS,
    CLEAR_ROW,
    FIRST_MAP,
    MAP_COUNT,
    MAP_LAYERS,
    PER_FALL,
    POWER_B,
    POWER_G,
    POWER_R,
    STRAND_WIDTH,
)
from ...common.kernels.view_columns import EYE_X, EYE_Y, EYE_Z, FORWARD_X, FORWARD_Y, FORWARD_Z, PERSPECTIVE
from ...coverage.kernels import width_profiles
from ...fibre.kernels.dual_scattering import glow
from ...fibre.kernels.highlights import highlights
from ...fibre.kernels.lobes import mix
from ...fibre.kernels.marschner import kajiya_diffuse
from ...fibre.kernels.width_highlights import width_highlights
from ...shadows.kernels.soft_shadows import soften
from ...shadows.kernels.strand_shadows import beyond, shade, sink
from ...solids.kernels import rays
from .ambient import ambient_light
from .light import toward

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-30)
STRANDS = 128
"""Strands a task."""


@parallel
def strands(
    first, world, marks, tones, view, colour, tint, diffuse, ambient, sky, volume, box, lobes, fibre, nodes, paths,
    twice, scale, lights, clear, maps, stacks, starts, sizes, views, solids, skin, sized,
    slots, columns, profile, out,
):  # fmt: skip
    """Radiance toward the camera at the marked vertices.

    first (S + 1,) int64; world (V, 3) metres; marks (V,) uint8, or None for all; tones (S,) in [−1, 1]; view (26,);
    colour (3,); tint (A, B, 6): for the place along the strand and for its tone, colour and extra absorption;
    diffuse: scale; ambient (3,); sky: of `strandcli.draw.lighting.environment`; volume,
    box: of `strandcli.draw.lighting.occlusion`;
    lobes, nodes, paths: tables of `strandcli.draw.fibre.marschner`, or fibre, nodes,
    paths: those of `strandcli.draw.fibre.chiang`;
    twice, scale: of `strandcli.draw.fibre.dual`; None where not needed;
    lights (n, 16): [0] 0 directional, 1 point; [1:4] unit direction to the light, or its position; [4:7] irradiance,
    or intensity in W/sr; [7:11] shadow maps (`shadow.transmittance`, `opacity.optical_depth`), [11] 0, or 1 and more:
    the row of clear, (m, V), that tells exactly what strands leave of it at the marked vertices, after which its maps
    only count strands; maps (T, 2), stacks; starts, sizes (M,), views (M, 24); solids packed, `skin` metres; sized:
    None where no light has a size, [12] in lights: the sine of its angular radius, or its radius in metres, [13] mean
    width of strands, metres, [14] 1 / h of `opacity`; slots, columns,
    profile: of `strandcli.draw.coverage.width_profiles`, None where no
    strand is wide; out (V, 3).

    tint, sky, volume, paths and clear have no rows where there are none of them: what is asked once a batch or costs
    next to nothing is not worth a kernel of its own, as what is None has.
    """
    count = first.shape[0] - 1
    for task in prange((count + STRANDS - 1) // STRANDS):
        work = np.empty(ROWS * W, np.float32)
        work[EXTRA : EXTRA + 3 * W] = ZERO
        which = np.empty(W, np.int64)
        n = np.int64(0)  # a literal would have everything below compiled twice
        for s in range(task * STRANDS, min((task + 1) * STRANDS, count)):
            begin = first[s]
            end = first[s + 1]
            per = ONE / np.float32(max(end - begin - 1, 1))
            for v in range(begin, end):
                if marks is not None and marks[v] == 0:
                    continue
                gather(world, v, begin, end, tones[s], per, colour, tint, work, n)
                if slots is not None and slots[v] >= 0:
                    width_profiles.begin(profile, slots[v])
                which[n] = v
                n += 1
                if n == W:
                    batch(
                        work, n, view, diffuse, ambient, sky, volume, box, lobes, fibre, nodes, paths, twice, scale,
                        lights, clear, maps, stacks, starts, sizes, views, solids, skin,
                        sized, which, slots, columns, profile,
                    )  # fmt: skip
                    scatter(work, which, n, out)
                    n = np.int64(0)
        batch(
            work, n, view, diffuse, ambient, sky, volume, box, lobes, fibre, nodes, paths, twice, scale, lights, clear,
            maps, stacks, starts, sizes, views, solids, skin,
            sized, which, slots, columns, profile,
        )  # fmt: skip
        scatter(work, which, n, out)


@device
def gather(world, v, begin, end, tone, per, colour, tint, work, k):
    """Put a vertex into place k of a batch."""
    low = max(v - 1, begin)
    high = min(v + 1, end - 1)
    for c in range(3):
        work[X + c * W + k] = world[v, c]
        work[TX + c * W + k] = world[high, c] - world[low, c]
    if tint.shape[0] == 0:
        for c in range(3):
            work[COLOUR + c * W + k] = colour[c]
    else:
        found = look_up(tint, np.float32(v - begin) * per, tone)
        for c in range(3):
            work[COLOUR + c * W + k] = found[c]
            work[EXTRA + c * W + k] = found[c + 3]


@device
def scatter(work, which, n, out):
    """Radiance back to the vertices of a batch."""
    for k in range(n):
        for c in range(3):
            out[which[k], c] = work[RADIANCE + c * W + k]


@device
def batch(
    work, n, view, diffuse, ambient, sky, volume, box, lobes, fibre, nodes, paths, twice, scale, lights, clear,
    maps, stacks, starts, sizes, views, solids, skin, sized, which, slots,
    columns, profile,
):  # fmt: skip
    """Radiance of the first n vertices of a batch, and profiles of those among them that are wide."""
    frames(work, n, view)
    ambient_light(work, n, ambient, sky, volume, box)
    for i in range(lights.shape[0]):
        aim(work, n, lights, i)
        if sized is None:
            hide(work, n, solids, skin)
        else:
            soften(work, n, lights, i, solids, skin)
        if lights[i, MAP_LAYERS] == ZERO:
            for one in range(int(lights[i, FIRST_MAP]), int(lights[i, FIRST_MAP] + lights[i, MAP_COUNT])):
                shade(work, n, views, one, maps, starts[one], sizes[one], lights[i, BIAS])
        else:
            for k in range(n):
                work[PASSED + k] = ZERO
                work[LEFT + k] = ZERO
            for one in range(int(lights[i, FIRST_MAP]), int(lights[i, FIRST_MAP] + lights[i, MAP_COUNT])):
                layers = np.int64(lights[i, MAP_LAYERS])
                width = lights[i, STRAND_WIDTH]
                sink(work, n, views, one, stacks, layers, starts[one], sizes[one], lights[i, BIAS], width, lights[i,
                PER_FALL])
                if twice is not None:
                    beyond(work, n, views, one, stacks, layers, starts[one], sizes[one], lights[i, BIAS], width)
            for k in range(n):
                work[UNBLOCKED + k] = work[ARRIVES + k]
            if clear.shape[0] == 0 or lights[i, CLEAR_ROW] == ZERO:
                for k in range(n):
                    work[ARRIVES + k] *= exp(-work[PASSED + k])
        row = np.int64(0)
        if slots is not None and twice is None and clear.shape[0] > 0:  # exact shadows across the width come at the end
            row = np.int64(lights[i, CLEAR_ROW])
        if clear.shape[0] > 0 and lights[i, CLEAR_ROW] > ZERO and row == 0:
            for k in range(n):
                work[ARRIVES + k] *= clear[np.int64(lights[i, CLEAR_ROW]) - 1, which[k]]
        if slots is not None:
            width_profiles.remember(work)
        if twice is not None and lights[i, MAP_LAYERS] > ZERO:
            glow(work, n, lights, i, twice, scale)
        elif diffuse > ZERO:
            for k in range(n):
                d = diffuse * kajiya_diffuse(
                    work[TX + k], work[TY + k], work[TZ + k], work[LX + k], work[LY + k], work[LZ + k]
                )
                d *= work[ARRIVES + k]
                work[RADIANCE + k] += lights[i, POWER_R] * (d * work[COLOUR + k])
                work[RADIANCE + W + k] += lights[i, POWER_G] * (d * work[COLOUR + W + k])
                work[RADIANCE + 2 * W + k] += lights[i, POWER_B] * (d * work[COLOUR + 2 * W + k])
        if slots is not None:
            width_profiles.round_off(work, n, which, slots, profile, row)
        if nodes is not None:
            highlights(work, n, lights, i, lobes, fibre, nodes, paths)
            if slots is not None:
                width_highlights(work, n, which, slots, lights, i, nodes, paths, columns, profile, row)
        if slots is not None and twice is None and row > 0:
            width_profiles.darken(work, n, which, slots, profile, row, clear)
    if slots is not None:
        for k in range(n):
            if slots[which[k]] >= 0:
                width_profiles.add_up(profile, slots[which[k]])


@device
def frames(work, n, view):
    """Unit tangents, and unit directions to the eye."""
    perspective = view[PERSPECTIVE]
    straight = perspective - ONE  # an orthographic eye is everywhere against the view
    for k in range(n):
        x = work[TX + k]
        y = work[TY + k]
        z = work[TZ + k]
        size = ONE / math.sqrt(max(x * x + y * y + z * z, TINY))
        work[TX + k] = x * size
        work[TY + k] = y * size
        work[TZ + k] = z * size
        x = perspective * (view[EYE_X] - work[X + k]) + straight * view[FORWARD_X]
        y = perspective * (view[EYE_Y] - work[Y + k]) + straight * view[FORWARD_Y]
        z = perspective * (view[EYE_Z] - work[Z + k]) + straight * view[FORWARD_Z]
        size = ONE / math.sqrt(max(x * x + y * y + z * z, TINY))
        work[EX + k] = x * size
        work[EY + k] = y * size
        work[EZ + k] = z * size


@device
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


@device
def hide(work, n, solids, skin):
    """No light where a solid stands between."""
    for s in range(solids.spheres.shape[0]):
        for k in range(n):
            work[ARRIVES + k] *= sphere.past(
                solids.spheres, s, work[X + k], work[Y + k], work[Z + k], work[LX + k], work[LY + k], work[LZ + k],
                work[REACH + k], skin,
            )  # fmt: skip
    if count_solids(solids) > solids.spheres.shape[0]:
        for k in range(n):
            if work[ARRIVES + k] > ZERO:
                work[ARRIVES + k] *= rays.past_others(
                    solids, work[X + k], work[Y + k], work[Z + k],
                    work[LX + k], work[LY + k], work[LZ + k], work[REACH + k], skin,
                )  # fmt: skip


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
        mix(tint, i, j, np.int64(0), w00, w01, w10, w11),
        mix(tint, i, j, np.int64(1), w00, w01, w10, w11),
        mix(tint, i, j, np.int64(2), w00, w01, w10, w11),
        mix(tint, i, j, np.int64(3), w00, w01, w10, w11),
        mix(tint, i, j, np.int64(4), w00, w01, w10, w11),
        mix(tint, i, j, np.int64(5), w00, w01, w10, w11),
    )
