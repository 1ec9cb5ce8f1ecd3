"""What arrives of one light at solids, past solids and strands, and what they reflect of it, for batches of points of
`shade_surfaces`."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device
from ....simd import broadcast, lane_count, load, load3, pointer, sqrt, store, store3, where
from ....solids.kernels import custom
from ...common.kernels.batch import ARRIVES, EX, LX, RADIANCE, REACH, X
from ...common.kernels.light_columns import BIAS, FIRST_MAP, KIND, LIGHT_SIZE, MAP_COUNT, MAP_LAYERS, POWER_R
from ...common.kernels.numbers import INV_PI, ONE, ZERO
from ...common.kernels.surface_batch import ARRIVED, COAT, COSINE, LEFT, LIFT, NX, PX, TRUE_X
from ...shadows.kernels import percentage_closer
from ...shadows.kernels.strand_shadows import shade_by_minmax
from ...solids.kernels import coat
from ...solids.kernels.coat import SUBSURFACE, scattered
from .light import aim
from .shade_strands import past_solids

TINY = np.float32(1e-6)


@device
def arrive(work, n, i, lights, shadows, solids, loss, depth):
    """Store what arrives of light number i, `ARRIVES`, and what strands leave of that, `LEFT`, at the first n points of
    a batch; loss: of `inputs.StrandLight`; depth: of subsurface scattering."""
    rows = lights.rows
    aim(work, n, rows, i)
    rise(work, n, lights.skin, depth)
    if custom.has_look(solids):
        lift(work, n)
    if depth > ZERO:
        bend(work, n, rows, i)
    past_solids(work, n, rows, i, solids, lights.skin, lights.sized)
    copy(work, n, POINTS, RAYS)
    if depth > ZERO:
        copy(work, n, TRUE, LIGHT)  # and straight to the light again
    past_strands(work, n, rows, i, shadows, loss)


POINTS, RAYS, TRUE, LIGHT = (np.int64(row) for row in (PX, X, TRUE_X, LX))


@device
def copy(work, n, source, to):
    """Copy the first n numbers of three rows."""
    rows = pointer(work)
    for k in range(0, n, lane_count(rows)):
        x, y, z = load3(rows, source + k, W)
        store3(rows, to + k, W, x, y, z)


@device
def lift(work, n):
    """Move points on to where shadow rays begin."""
    rows = pointer(work)
    for k in range(0, n, lane_count(rows)):
        x, y, z = load3(rows, X + k, W)
        u, v, w = load3(rows, LIFT + k, W)
        store3(rows, X + k, W, x + u, y + v, z + w)


@device
def past_strands(work, n, lights, i, shadows, loss):
    """Apply the strand shadows of light number i: min/max maps change `ARRIVES`, opacity maps set `LEFT`, else 1."""
    if lights[i, MAP_LAYERS] == ZERO:
        for one in range(int(lights[i, FIRST_MAP]), int(lights[i, FIRST_MAP] + lights[i, MAP_COUNT])):
            shade_by_minmax(work, n, shadows, one, lights[i, BIAS])
    if lights[i, MAP_LAYERS] > ZERO:
        percentage_closer.transmittance(work, n, lights, i, loss, shadows)
    else:
        rows = pointer(work)
        for k in range(0, n, lane_count(rows)):
            store3(rows, LEFT + k, W, ONE, ONE, ONE)


@device
def rise(work, n, skin, depth):
    """Move points above the surface, store the cosine to the light, and stop light from behind the surface; depth: the
    least cosine that counts as in front is minus this."""
    rows = pointer(work)
    for k in range(0, n, lane_count(rows)):
        nx, ny, nz = load3(rows, NX + k, W)
        lx, ly, lz = load3(rows, LX + k, W)
        cosine = nx * lx + ny * ly + nz * lz
        store(rows, COSINE + k, cosine)
        store(rows, ARRIVES + k, where(cosine <= -depth, ZERO, load(rows, ARRIVES + k)))
        x, y, z = load3(rows, X + k, W)
        store3(rows, PX + k, W, x, y, z)
        store3(rows, X + k, W, x + nx * skin, y + ny * skin, z + nz * skin)


@device
def bend(work, n, lights, i):
    """Raise the directions to light number i until all of it stands above the surface's tangent plane, for shadow rays
    of light that enters a surface beside the point and leaves it here."""
    rows = pointer(work)
    for k in range(0, n, lane_count(rows)):
        x, y, z = load3(rows, LX + k, W)
        nx, ny, nz = load3(rows, NX + k, W)
        store3(rows, TRUE_X + k, W, x, y, z)
        more = max(angles_of(rows, k, lights, i) - load(rows, COSINE + k), ZERO)
        x, y, z = x + more * nx, y + more * ny, z + more * nz
        per = ONE / sqrt(max(x * x + y * y + z * z, TINY))
        store3(rows, LX + k, W, x * per, y * per, z * per)


@device
def reflect(work, n, lights, i):
    """Store the irradiance of light number i, and add what a white Lambertian surface reflects of it."""
    rows = pointer(work)
    for k in range(0, n, lane_count(rows)):
        for c in range(3):
            arrived = load(rows, ARRIVES + k) * load(rows, COSINE + k) * lights[i, POWER_R + c]
            arrived = arrived * load(rows, LEFT + c * W + k)
            store(rows, ARRIVED + c * W + k, arrived)
            store(rows, RADIANCE + c * W + k, load(rows, RADIANCE + c * W + k) + INV_PI * arrived)


@device
def reflect_from_below(work, n, lights, i, coats, which):
    """As `reflect`, of a surface under which light spreads (`strandcli.draw.solids.kernels.coat`)."""
    rows = pointer(work)
    for k in range(0, n, lane_count(rows)):
        cosine = load(rows, COSINE + k)
        for c in range(3):
            power = load(rows, ARRIVES + k) * lights[i, POWER_R + c] * load(rows, LEFT + c * W + k)
            store(rows, ARRIVED + c * W + k, power * max(cosine, ZERO))
            light = INV_PI * power * scattered(cosine, coats[which, SUBSURFACE + c])
            store(rows, RADIANCE + c * W + k, load(rows, RADIANCE + c * W + k) + light)


@device
def angles_of(rows, k, lights, i):
    """Return the sines of the angular radius of light number i at the vector of points from number k on."""
    if lights[i, KIND] == ZERO:
        return broadcast(rows, lights[i, LIGHT_SIZE])
    return min(lights[i, LIGHT_SIZE] / load(rows, REACH + k), ONE)


@device
def gleam(work, n, lights, i, coats, which):
    """Add the light of light number i that a coat mirrors."""
    if coats[which, coat.COAT] <= ZERO:
        return
    rows = pointer(work)
    for k in range(0, n, lane_count(rows)):
        share = coat.gleam(
            coats[which, coat.COAT], coats[which, coat.ROUGH], angles_of(rows, k, lights, i), load3(rows, NX + k, W),
            load3(rows, LX + k, W), load3(rows, EX + k, W),
        )  # fmt: skip
        share = where(load(rows, ARRIVES + k) != ZERO, share, ZERO)
        for c in range(3):
            light = load(rows, ARRIVED + c * W + k)
            store(rows, COAT + c * W + k, load(rows, COAT + c * W + k) + share * light)
