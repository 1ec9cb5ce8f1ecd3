"""Which strands an opacity map needs where hardly any light comes: a share of them, each of which counts for several.

A sketch of the map, of few strands and in cells of `CELL` texels, tells about how many strands a place has before it.
Up to `OPEN` of them all strands are drawn. Behind that a share is, which falls with what is left of the light, and each
has the weight that makes up for those left out: so the map's τ is right on average, and its noise is where there is no
light that could show it.

A strand is drawn where its chance, even in [0, 1) among strands anywhere, is below the share; about there it fades, so
that nothing comes or goes at once when strands move.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device, inlined

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
CELL = 4
"""Texels along a side of a cell."""
PER_TEXEL = np.float32(1 / CELL)
LEVELS = 12
"""Layers of a cell, of which LEVELS x / (x + h) have ended x metres behind its nearest strand."""
OPEN = np.float32(5.0)
"""Strands before a place, on average, up to which all strands are drawn."""
FALL = np.float32(2.0)
"""How many more leave e times fewer strands."""
RANGE = np.float32(1.4)
"""Up to so many times: the least share is e^-RANGE."""
FADES = 0.25
"""Part of the share of strands over which they fade."""
STEPS = 32
"""Of the share, while `FALL` more strands are passed."""
LAST = int(STEPS * RANGE) - 1


def weights() -> NDArray[np.float32]:
    """Return (LAST + 1, 3) for each step of the share: a strand whose chance is c has the weight (a − c) b, at least 0
    and at most the last number; 1 on average over all chances."""
    whole = 1 / (1 - FADES / 2)  # a share of which all strands are drawn as they are
    share = whole * np.exp(-(np.arange(LAST + 1) / STEPS))
    most = share * (1 + FADES / 2)
    beyond = np.maximum(most - 1, 0)
    kept = share - beyond**2 / (2 * FADES * share)
    return np.stack([most, 1 / (FADES * share * kept), 1 / kept], 1).astype(np.float32)


WEIGHTS = weights()


class Sketch(NamedTuple):
    """A coarse map of few strands."""

    chances: NDArray[np.float32]
    """(S,) of all strands, in [0, 1); empty: no strand is left out."""
    nearest: NDArray[np.float32]
    """(side²,) depth of the nearest strand of each cell, metres; inf where none is."""
    before: NDArray[np.float32]
    """(side² (LEVELS + 1),) strands before the end of each layer, on average; first of each cell 0."""
    deep: NDArray[np.float32]
    """(side², 2) the depth of each cell behind which strands are left out, metres, inf if none are, and 1 / how far
    `FALL` strands more reach, 1/m."""
    steps: NDArray[np.float32]
    """`WEIGHTS`."""
    side: int
    """Cells along a side."""
    over: Any
    """float32: 1 / h, 1/m."""


NONE = np.zeros(0, np.float32)
NO_SKETCH = Sketch(NONE, NONE, NONE, NONE.reshape(0, 2), WEIGHTS, 0, np.float32(0))
"""Of maps into which all strands are drawn. Empty arrays, because None would compile another variant."""


@inlined
def level_of(behind, over):
    """Return how many layers have ended ``behind`` metres behind the nearest strand; over: 1 / h, 1/m."""
    far = behind * over
    return np.float32(LEVELS) * (far / (far + ONE))


@device
def cell_of(x, y, side):
    """Return the number of the cell at x and y, texels; −1 outside of the map."""
    if not (x >= ZERO and y >= ZERO and max(x, y) < np.float32(CELL * side)):
        return np.int64(-1)
    return np.int64(y * PER_TEXEL) * side + np.int64(x * PER_TEXEL)


@device
def weight_at(sketch, x, y, depth, chance):
    """Return the weight of a strand with that chance at a place on the map, texels, and a depth, metres."""
    cell = cell_of(x, y, sketch.side)
    if cell < 0:
        return ONE
    behind = (depth - sketch.deep[cell, 0]) * sketch.deep[cell, 1]
    if not behind > ZERO:
        return ONE
    step = min(np.int64(min(behind, RANGE) * np.float32(STEPS)), LAST)
    return min(max((sketch.steps[step, 0] - chance) * sketch.steps[step, 1], ZERO), sketch.steps[step, 2])
