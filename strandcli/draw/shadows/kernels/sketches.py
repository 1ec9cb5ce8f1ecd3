"""Drawing of the sketch that tells which strands lie deep in shadow (see `deep_strands`)."""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, function
from .deep_strands import CELL, FALL, LEVELS, OPEN, cell_of, level_of
from .map_parts import depth_of, width_of

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
INF = np.float32(np.inf)
THIN = np.float32(1e-9)
DIGITS = np.float32(4096.0)
"""Times a chance, of which the twelve digits after the point say whether a strand is sketched."""


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


@function
def mark(chances, share, marks):
    """Set the marks (S,) of strands with these chances that belong to a share of them that is sketched."""
    for s in range(chances.shape[0]):
        marks[s] |= is_sketched(chances[s], share)


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
        layer = min(np.int64(level_of(behind, sketch.over)), LEVELS - 1)
        sketch.before[cell * (LEVELS + 1) + layer + 1] += each * scale * np.float32(math.sqrt(dx * dx + dy * dy))
