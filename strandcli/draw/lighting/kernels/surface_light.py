"""Light that arrives at a batch of points of a solid, past solids and strands: computed, or taken from a `lattice`."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device, inlined
from ....solids.kernels import other
from ...common.kernels.batch import ARRIVES, LX, RADIANCE, X, vector_at
from ...common.kernels.light_columns import BIAS, FIRST_MAP, MAP_COUNT, MAP_LAYERS
from ...common.kernels.numbers import HALF, ONE, ZERO
from ...common.kernels.surface_batch import COAT, LEFT, LIFT, PX, SHARE, SX, SY, TRUE_X, UNDER
from ...shadows.kernels import percentage_closer
from ...shadows.kernels.free_ways import FreeWays
from ...shadows.kernels.strand_shadows import shade_by_minmax
from .inputs import COMPUTED, Lights
from .lattice import COATED, LIT, UNKNOWN
from .light import toward
from .reflection import bend, rise
from .shade_strands import aim, past_solids


@device
def as_computed(lights):
    """Return the `inputs.Lights` of points that are no pixels of the picture, without a lattice."""
    return Lights(
        lights.rows, lights.clear, lights.skin, lights.sized, lights.known, lights.down, lights.right, COMPUTED,
        lights.free, lights.free_views,
    )  # fmt: skip


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
    past_solids(work, n, rows, i, solids, lights.skin, lights.sized, FreeWays(lights.free, lights.free_views))
    for k in range(3 * W):
        work[X + k] = work[PX + k]
    if depth > ZERO:
        for k in range(3 * W):  # and straight to the light again
            work[LX + k] = work[TRUE_X + k]
    past_strands(work, n, rows, i, shadows, loss)


@device
def recall(work, n, i, lights, depth):
    """As `arrive`, from the lattice."""
    aim(work, n, lights.rows, i)
    rise(work, n, lights.skin, depth)
    for k in range(3 * W):
        work[X + k] = work[PX + k]
    known = lights.known
    for k in range(n):
        x = np.int64(work[SX + k]) + np.int64(lights.right)
        y = np.int64(work[SY + k]) + np.int64(lights.down)
        left, up = x >> 1, y >> 1
        right, low = (x + 1) >> 1, (y + 1) >> 1
        for c in range(3):
            above = HALF * (known[up, left, i, c] + known[up, right, i, c])
            below = HALF * (known[low, left, i, c] + known[low, right, i, c])
            work[LEFT + c * W + k] = HALF * (above + below)


@device
def note(work, n, i, lights):
    """Write what has arrived of light number i to the lattice; where a solid has an edge in front of itself nothing is
    known."""
    for k in range(n):
        _, _, _, _, falloff = toward(lights.rows, i, vector_at(work, X, k))
        share = work[ARRIVES + k] / falloff
        y, x = place_of(work, k, lights)
        for c in range(3):
            lights.known[y, x, i, c] = UNKNOWN if work[SHARE + k] < ZERO else share * work[LEFT + c * W + k]


@device
def note_all(work, n, lights, coats):
    """Write the light of a white surface under its coat, and that of the coat, to the lattice, behind the shares of the
    lights, but where a solid has an edge in front of itself."""
    first = np.uint64(lights.rows.shape[0])
    for k in range(n):
        y, x = place_of(work, k, lights)
        under = work[UNDER + k] if coats.shape[0] > 0 else ONE
        for c in range(3):
            own = work[COAT + c * W + k] if coats.shape[0] > 0 else ZERO
            lights.known[y, x, first + LIT, c] = under * work[RADIANCE + c * W + k]
            lights.known[y, x, first + COATED, c] = own
        if work[SHARE + k] < ZERO:
            lights.known[y, x, first + LIT, 0] = UNKNOWN


@device
def note_nothing(work, n, lights):
    """Write to the lattice that radiance is not known."""
    for k in range(n):
        y, x = place_of(work, k, lights)
        for c in range(3):
            lights.known[y, x, np.uint64(lights.rows.shape[0]) + LIT, c] = UNKNOWN
            lights.known[y, x, np.uint64(lights.rows.shape[0]) + COATED, c] = ZERO


@inlined
def place_of(work, k, lights):
    """Return row and column in the lattice of point number k, which is one of its pixels."""
    x = (np.int64(work[SX + k]) + np.int64(lights.right)) >> 1
    y = (np.int64(work[SY + k]) + np.int64(lights.down)) >> 1
    return np.uint64(y), np.uint64(x)


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
