"""What arrives of one light at solids, past solids and strands, and what they reflect of it, for batches of points of
`shade_surfaces`."""

from __future__ import annotations

import math

import numpy as np

from ....constants import W
from ....jit import device
from ....solids.kernels import other
from ...common.kernels.batch import ARRIVES, EX, LX, RADIANCE, REACH, X, set_vector, vector_at
from ...common.kernels.light_columns import BIAS, FIRST_MAP, KIND, LIGHT_SIZE, MAP_COUNT, MAP_LAYERS, POWER_R
from ...common.kernels.numbers import INV_PI, ONE, ZERO
from ...common.kernels.surface_batch import ARRIVED, COAT, COSINE, LEFT, LIFT, NX, PX, SHINE, TRUE_X
from ...shadows.kernels import percentage_closer
from ...shadows.kernels.strand_shadows import shade_by_minmax
from ...solids.kernels import coat
from ...solids.kernels.coat import SUBSURFACE, scattered
from .shade_strands import aim, past_solids

TINY = np.float32(1e-6)


@device
def arrive(work, n, i, lights, shadows, solids, loss, depth):
    """Store what arrives of light number i, `ARRIVES`, and what strands leave of that, `LEFT`, at the first n points of
    a batch; loss: of `inputs.StrandLight`; depth: of subsurface scattering."""
    rows = lights.rows
    aim(work, n, rows, i)
    rise(work, n, lights.skin, depth)
    if other.has_look(solids):
        for k in range(3 * W):  # on to where shadow rays begin
            work[X + k] += work[LIFT + k]
    if depth > ZERO:
        bend(work, n, rows, i)
    past_solids(work, n, rows, i, solids, lights.skin, lights.sized)
    for k in range(3 * W):
        work[X + k] = work[PX + k]
    if depth > ZERO:
        for k in range(3 * W):  # and straight to the light again
            work[LX + k] = work[TRUE_X + k]
    past_strands(work, n, rows, i, shadows, loss)


@device
def past_strands(work, n, lights, i, shadows, loss):
    """Apply the strand shadows of light number i: min/max maps change `ARRIVES`, opacity maps set `LEFT`, else 1."""
    if lights[i, MAP_LAYERS] == ZERO:
        for one in range(int(lights[i, FIRST_MAP]), int(lights[i, FIRST_MAP] + lights[i, MAP_COUNT])):
            shade_by_minmax(work, n, shadows, one, lights[i, BIAS])
    if lights[i, MAP_LAYERS] > ZERO:
        percentage_closer.transmittance(work, n, lights, i, loss, shadows)
    else:
        for k in range(3 * W):
            work[LEFT + k] = ONE


@device
def rise(work, n, skin, depth):
    """Move points above the surface, store the cosine to the light, and stop light from behind the surface; depth: the
    least cosine that counts as in front is minus this."""
    for k in range(3 * W):
        work[PX + k] = work[X + k]
    for k in range(n):
        nx, ny, nz = vector_at(work, NX, k)
        lx, ly, lz = vector_at(work, LX, k)
        cosine = nx * lx + ny * ly + nz * lz
        work[COSINE + k] = cosine
        work[ARRIVES + k] = ZERO if cosine <= -depth else work[ARRIVES + k]
        x, y, z = vector_at(work, X, k)
        set_vector(work, X, k, (x + nx * skin, y + ny * skin, z + nz * skin))


@device
def bend(work, n, lights, i):
    """Raise the directions to light number i until all of it stands above the surface's tangent plane, for shadow rays
    of light that enters a surface beside the point and leaves it here."""
    for k in range(n):
        x, y, z = vector_at(work, LX, k)
        nx, ny, nz = vector_at(work, NX, k)
        set_vector(work, TRUE_X, k, (x, y, z))
        more = max(angle_of(work, k, lights, i) - work[COSINE + k], ZERO)
        x, y, z = x + more * nx, y + more * ny, z + more * nz
        per = ONE / math.sqrt(max(x * x + y * y + z * z, TINY))
        set_vector(work, LX, k, (x * per, y * per, z * per))


@device
def reflect(work, n, lights, i):
    """Store the irradiance of light number i, and add what a white Lambertian surface reflects of it."""
    for c in range(3):
        for k in range(n):
            arrived = work[ARRIVES + k] * work[COSINE + k] * lights[i, POWER_R + c] * work[LEFT + c * W + k]
            work[ARRIVED + c * W + k] = arrived
            work[RADIANCE + c * W + k] += INV_PI * arrived


@device
def reflect_from_below(work, n, lights, i, coats, which):
    """As `reflect`, of a surface under which light spreads (`strandcli.draw.solids.kernels.coat`)."""
    for c in range(3):
        width = coats[which, SUBSURFACE + c]
        for k in range(n):
            cosine = work[COSINE + k]
            power = work[ARRIVES + k] * lights[i, POWER_R + c] * work[LEFT + c * W + k]
            work[ARRIVED + c * W + k] = power * max(cosine, ZERO)
            work[RADIANCE + c * W + k] += INV_PI * power * scattered(cosine, width)


@device
def angle_of(work, k, lights, i):
    """Return the sine of the angular radius of light number i at point number k."""
    return lights[i, LIGHT_SIZE] if lights[i, KIND] == ZERO else min(lights[i, LIGHT_SIZE] / work[REACH + k], ONE)


@device
def gleam(work, n, lights, i, coats, which):
    """Add the light of light number i that a coat mirrors."""
    if coats[which, coat.COAT] <= ZERO:
        return
    for k in range(n):
        angle = angle_of(work, k, lights, i)
        share = coat.gleam(
            coats[which, coat.COAT], coats[which, coat.ROUGH], angle, vector_at(work, NX, k), vector_at(work, LX, k),
            vector_at(work, EX, k),
        )  # fmt: skip
        work[SHINE + k] = share if work[ARRIVES + k] != ZERO else ZERO
    for c in range(3):
        for k in range(n):
            work[COAT + c * W + k] += work[SHINE + k] * work[ARRIVED + c * W + k]
