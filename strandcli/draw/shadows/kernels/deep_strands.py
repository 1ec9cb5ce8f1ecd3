"""Which strands an opacity map needs where hardly any light comes: a share of them, each of which counts for several.

A sketch of the map, of few strands and in cells of `CELL` texels, tells about how many strands a place has before it.
Up to `OPEN` of them all strands are drawn. Behind that a share is, which falls with what is left of the light, and each
has the weight that makes up for those left out: so the map's τ is right on average, and its noise is where there is no
light that could show it.

A strand is drawn where its chance, even in [0, 1) among strands anywhere, is below the share; about there it fades, so
that nothing comes or goes at once when strands move.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device, function
from ...common.kernels.numbers import HALF, INF, ONE, ZERO
from .map_parts import depth_of, width_of

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
THIN = np.float32(1e-9)
DIGITS = np.float32(4096.0)
"""Times a chance, of which the twelve digits after the point say whether a strand is sketched."""


def weights() -> NDArray[np.float32]:
    """Return (LAST + 1, 3) for each step of the share: a strand whose chance is c has the weight (a − c) b, at least 0
    and at most the last number; 1 on average over all chances."""
    whole = 1 / (1 - FADES / 2)  # a share of which all strands are drawn as they are
    share = whole * np.exp(-(np.arange(LAST + 1) / STEPS))
    most = share * (1 + FADES / 2)
    beyond = np.maximum(most - 1, 0)
    remaining = share - beyond**2 / (2 * FADES * share)
    return np.stack([most, 1 / (FADES * share * remaining), 1 / remaining], 1).astype(np.float32)


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


@device
def weight_of_vertex(sketch, screen, v, view, chance):
    """Return the weight of a strand with that chance at one of its vertices; 1 where that is behind a light."""
    if not screen[v, 2] > ZERO:
        return ONE
    return weight_at(sketch, screen[v, 0], screen[v, 1], depth_of(screen[v, 2], view.near, view.far), chance)


@function
def draw(strands, view, share, sketch):
    """Draw a ``share`` of the strands into a sketch. Return which part of what all strands cover lies
    behind `OPEN` strands.

    strands: `StrandsInMap`; view: `MapView`; sketch: `Sketch`, changed.
    """
    sketch.nearest[:] = INF
    for s in range(sketch.chances.shape[0]):
        if is_sketched(sketch.chances[s], share):
            find_nearest(strands, s, view, sketch)
    for cell in range(sketch.nearest.shape[0]):
        if sketch.nearest[cell] < INF:
            for level in range(cell * (LEVELS + 1), (cell + 1) * (LEVELS + 1)):
                sketch.before[level] = ZERO
    for s in range(sketch.chances.shape[0]):
        if is_sketched(sketch.chances[s], share):
            add_strand(strands, s, view, share, sketch)
    every = deep = 0.0
    for cell in range(sketch.nearest.shape[0]):
        total = finish(sketch, np.int64(cell))
        every += total
        deep += max(total - OPEN, ZERO)
    return deep / max(every, 1e-30)


@device
def is_sketched(chance, share):
    """Return whether a strand belongs to a share of them that has nothing to do with how great their chances are: were
    it those of small chance, they would be thought deep where there are many of them, and count too much."""
    last = chance * DIGITS
    return last - np.float32(np.int64(last)) < share


@device
def finish(sketch, cell):
    """Sum the layers of a cell, write its `Sketch.deep`, and return how many strands are in it on average."""
    sketch.deep[cell, 0], sketch.deep[cell, 1] = INF, ONE
    if not sketch.nearest[cell] < INF:
        return ZERO
    base = cell * (LEVELS + 1)
    for layer in range(base, base + LEVELS):
        sketch.before[layer + 1] += sketch.before[layer]
    begin = depth_behind(sketch, cell, OPEN)
    if begin < INF:
        sketch.deep[cell, 0] = begin
        sketch.deep[cell, 1] = ONE / max(depth_behind(sketch, cell, OPEN + FALL) - begin, THIN)
    return sketch.before[base + LEVELS]


@device
def depth_behind(sketch, cell, strands):
    """Return the depth behind which so many strands are in a cell on average, metres; inf if there are fewer."""
    base = cell * (LEVELS + 1)
    for layer in range(LEVELS):
        low, high = sketch.before[base + layer], sketch.before[base + layer + 1]
        if high > strands:
            level = np.float32(layer) + (strands - low) / (high - low)
            return sketch.nearest[cell] + level / max((np.float32(LEVELS) - level) * sketch.over, THIN)
    return INF


@device
def find_nearest(strands, s, view, sketch):
    """Bring the nearest depth of cells up to the vertices of a strand."""
    screen, nearest = strands.screen, sketch.nearest
    for v in range(strands.first[s], strands.first[s + 1]):
        cell = cell_of(screen[v, 0], screen[v, 1], sketch.side)
        if cell >= 0 and screen[v, 2] > ZERO:
            nearest[cell] = min(nearest[cell], depth_of(screen[v, 2], view.near, view.far))


@device
def add_strand(strands, s, view, share, sketch):
    """Add the segments of a strand to layers, each in its middle."""
    screen = strands.screen
    width = width_of(strands.width, strands.scale, s) * (ONE - HALF * strands.taper)
    each = width / (share * np.float32(CELL * CELL))
    for v in range(strands.first[s] + 1, strands.first[s + 1]):
        q = HALF * (screen[v - 1, 2] + screen[v, 2])
        x, y = HALF * (screen[v - 1, 0] + screen[v, 0]), HALF * (screen[v - 1, 1] + screen[v, 1])
        cell = cell_of(x, y, sketch.side)
        if cell < 0 or not (screen[v - 1, 2] > ZERO and screen[v, 2] > ZERO and sketch.nearest[cell] < INF):
            continue
        dx, dy = screen[v, 0] - screen[v - 1, 0], screen[v, 1] - screen[v - 1, 1]
        scale = view.focal if view.far > ZERO else view.focal * q
        behind = max(depth_of(q, view.near, view.far) - sketch.nearest[cell], ZERO)
        far = behind * sketch.over
        layer = min(np.int64(np.float32(LEVELS) * (far / (far + ONE))), LEVELS - 1)
        sketch.before[cell * (LEVELS + 1) + layer + 1] += each * scale * np.float32(math.sqrt(dx * dx + dy * dy))
