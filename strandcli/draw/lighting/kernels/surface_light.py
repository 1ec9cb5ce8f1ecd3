"""Light that arrives at a batch of points of a solid, past solids and strands: computed, or taken from a `lattice`."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device
from ....solids.kernels import other
from ...common.kernels.batch import ARRIVES, X, Y, Z
from ...common.kernels.light_columns import MAP_LAYERS
from ...common.kernels.surface_batch import LEFT, PX, SHARE, SX, SY
from ...shadows.kernels import percentage_closer
from ...shadows.kernels.minmax import transmittance
from .inputs import COMPUTED, Lights
from .lattice import UNKNOWN
from .light import toward
from .reflection import bend, lift, rise, unbend
from .shade_strands import aim, past_solids

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)


@device
def as_computed(lights):
    """Return the `inputs.Lights` of points that are no pixels of the picture, without a lattice."""
    return Lights(
        lights.rows, lights.clear, lights.skin, lights.sized, lights.known, lights.down, lights.right, COMPUTED
    )


@device
def arrive(work, n, i, lights, shadows, solids, loss, depth):
    """Store what arrives of light number i, `ARRIVES`, and what strands leave of that, `LEFT`, at the first n points of
    a batch; loss: of `inputs.StrandLight`; depth: of subsurface scattering."""
    rows = lights.rows
    aim(work, n, rows, i)
    rise(work, n, lights.skin, depth)
    if other.has_look(solids):
        lift(work, n)
    if depth > ZERO:
        bend(work, n, rows, i)
    past_solids(work, n, rows, i, solids, lights.skin, lights.sized)
    for k in range(3 * W):
        work[X + k] = work[PX + k]
    if depth > ZERO:
        unbend(work, n)
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
        _, _, _, _, falloff = toward(lights.rows, i, work[X + k], work[Y + k], work[Z + k])
        share = work[ARRIVES + k] / falloff
        x = (np.int64(work[SX + k]) + np.int64(lights.right)) >> 1
        y = (np.int64(work[SY + k]) + np.int64(lights.down)) >> 1
        for c in range(3):
            lights.known[y, x, i, c] = UNKNOWN if work[SHARE + k] < ZERO else share * work[LEFT + c * W + k]


@device
def past_strands(work, n, lights, i, shadows, loss):
    """Apply the strand shadows of light number i: min/max maps change `ARRIVES`, opacity maps set `LEFT`, else 1."""
    if lights[i, MAP_LAYERS] == ZERO:
        for k in range(n):
            if work[ARRIVES + k] > ZERO:
                work[ARRIVES + k] *= transmittance(
                    work[X + k], work[Y + k], work[Z + k], lights, i,
                    shadows.texels, shadows.starts, shadows.sizes, shadows.views,
                )  # fmt: skip
    if lights[i, MAP_LAYERS] > ZERO:
        percentage_closer.transmittance(work, n, lights, i, loss, shadows)
    else:
        for k in range(3 * W):
            work[LEFT + k] = ONE
