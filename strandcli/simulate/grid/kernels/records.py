"""Arguments of the kernels of interaction, as flat tuples.

Strands are cut into parts, whose number no number of threads changes: one thread works on a part, and parts are added
up in their order. Columns of cells are planes, one number a cell, x fastest. Kernels take a vector of `LANES` cells
along x at once, and those beside them; what is loaded beside the box is of another row, and not used.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device
from ....simd import broadcast, load, pointer

FIRST, LAST = 0, 1
"""Columns of parts: the first pack and the one after the last."""
LOW, SIZE, OFFSET = 0, 3, 6
"""Columns of boxes: number of the lowest cell along x, y and z, cells along each, and place of the first in the
memory of all parts."""
BOX = 7
MASS, MOMENTUM, BETWEEN = 0, 1, 4
"""Columns of a cell: metres of strand; those times their velocity (3), m²/s; metres between its middle and that of the
next cell along x, y and z (3), by bilinear weights across. One is not used."""
RATE, TARGET, PUSH = 0, 1, 4
"""Columns of a target: share of its velocity against the cell's that a strand loses in the step, the rest of what its
velocity changes by (3), m/s, and what is added to that between two middles (3), m/s. One is not used."""
CELL = 8
"""Columns of each."""
FULL, RATIO, MOST, LOST, SPEED, STOP, WIND, CHANGE, FALL = 0, 1, 2, 3, 4, 5, 6, 9, 12
"""Numbers of a step: metres in a cell that is as dense as allowed; half the step over the cell's side, s/m; the share
of the density that pressure makes up for at the most; the share of its velocity against a cell that is as dense as
allowed that a strand loses; the cell's side over the step, m/s; and of the wind, the optical depth along a cell's side
of a cell that holds a metre of strand, its unit direction (3), and by how much the open wind changes velocities (3),
m/s; and by how much gravity does (3), cells a step."""
NUMBERS = 15

SHARE, BELOW, VELOCITY = 0, 3, 4
"""Rows of scratch, one lane a strand of the pack: of a sample, shares (3) of the cells beyond it along x, y and z, the
number of the cell before it, and its velocity (3), m/s. A box has no more cells than single precision can count."""
RESULT = 7
"""(4) Targets at the sample: the rate, and the rest with what lies between middles."""
ROWS = 11
FOUND = CELL + 4
"""Numbers a strand of what is found in cells, or left in them: all columns of each strand, and then rows of them."""


class Moving(NamedTuple):
    """Strands as a step finds them: P packs of S strands with N segments."""

    positions: Any
    """(blocks, N + 2, 3 W) metres."""
    velocity: Any
    """(P, N, 3 S) m/s."""
    unloaded: Any
    """(P, N, 3 S) velocity of the last step without forces but the grid's and what they undo, m/s."""
    pushed: Any
    """(P, N, 3 S) acceleration by the strands around in the last step, m/s²."""
    jolted: Any
    """(P, S) as `State.jolted`."""
    roots: Any
    """(P, 3 S) velocity of roots, m/s."""
    metres: Any
    """(P, S) float32 metres that a segment at the root counts for, with its children; 0 of padding."""


class Samples(NamedTuple):
    """Points at which strands are sampled, where cells are, and the step, numbers of the strands' floating type."""

    first: Any
    """(samples,) number of the first particle of which each is a mean, 0 that of the root; int64."""
    counts: Any
    """(samples,) of how many."""
    weights: Any
    """(samples, greatest count) the particles' shares."""
    mass: Any
    """(samples,) metres that each counts for, by those of a segment at the root."""
    inverse: Any
    """1 / cell, 1/m."""
    origins: Any
    """(parts + 1, 3) the middle of the lowest cell of each box, metres."""
    step: Any
    """Length of the step, seconds."""
    again: Any
    """That over the length of the step before: what has changed velocities then is expected to do so again."""


def samples_of(segments: NDArray[np.float64], length: float, kind: Any) -> tuple[Any, Any, Any, Any]:
    """Return the first four fields of `Samples` of strands whose segments have the relative masses ``segments`` (N,)
    and the length ``length``, in cells, of the longest. A sample of several segments is a mean by masses."""
    n = len(segments)
    several = max(1, math.ceil(length * (1 - 1e-6)))
    if several > 1:
        t = np.tile((np.arange(several) + 0.5) / several, n)
        first = np.repeat(np.arange(n), several)
        weights, mass = np.stack([1 - t, t], 1), np.repeat(segments / several, several)
        return first, np.full(len(first), 2), weights.astype(kind), mass.astype(kind)
    group = min(max(1, int(1 / length * (1 + 1e-6))), n)
    first = np.arange(0, n, group)
    count = np.minimum(first + group, n) - first + 1
    weights, mass = np.zeros((len(first), group + 1)), np.zeros(len(first))
    for row, begin, end in zip(range(len(first)), first, first + count - 1, strict=True):
        mass[row] = segments[begin:end].sum()
        weights[row, : end - begin] += segments[begin:end] / 2 / mass[row]
        weights[row, 1 : end - begin + 1] += segments[begin:end] / 2 / mass[row]
    return first, count, weights.astype(kind), mass.astype(kind)


LANES = 16
"""Cells along x are a multiple of it."""


class Room(NamedTuple):
    """What solids leave of cells, and what follows for them: (cells,) float32."""

    open: Any
    """Share of each that is outside of solids."""
    aperture: Any
    """Root of that: a face is open by the product of those of its cells."""
    faces: Any
    """Its aperture over the sum of those of its neighbours, 0 in solids."""
    excess: Any
    """e of `pressure` over the aperture, 0 in solids."""
    carried: Any
    """`HELD` of the pressure of the step before."""
    left: Any
    """Share of the wind that is left; no rows in calm air."""
    behind: Any
    """The same behind the cell."""


LIVE = 1
"""Row of what tells whether rows of cells have pressure, after that of whether their excess is positive."""
REACH = 2
"""Cells on either side that are looked at."""
WITHIN = np.concatenate([np.zeros(REACH), np.ones(2 * LANES), np.zeros(REACH)]).astype(np.float32)
"""1 for cells within a row that is two vectors long."""
COUNTED = np.arange(LANES).astype(np.float32)
"""Numbers of lanes."""


@device
def beside_along(i, wide):
    """Steps from the cells of a vector, of which the first is cell i of its row, to those before and after, and masks
    of those that there are, and of those two before and two after."""
    rows = pointer(WITHIN)
    first = REACH + (LANES if i > 0 else 0)
    last = REACH + (0 if i < wide - LANES else LANES)
    return np.int64(-1), np.int64(1), (
        load(rows, first - 1) > 0.0, load(rows, last + 1) > 0.0, load(rows, first - 2) > 0.0, load(rows, last + 2) > 0.0
    )  # fmt: skip


@device
def beside_across(place, count, stride):
    """The same across rows, of the row or layer at a place of so many, a ``stride`` apart: where there is none, the
    step is 0."""
    a, b = place > 0, place < count - 1
    masks = all_or_none(a), all_or_none(b), all_or_none(place > 1), all_or_none(place < count - 2)
    return -stride * np.int64(a), stride * np.int64(b), masks


@device
def all_or_none(holds):
    """A mask that holds in all lanes, or in none."""
    return broadcast(pointer(WITHIN), np.float32(holds)) > 0.0


@device
def beside(row, i, wide, high, deep):
    """The same along x, y and z, of the cells of a vector in a row of the box."""
    along = beside_along(i, wide)
    return along, beside_across(row % high, high, wide), beside_across(row // high, deep, wide * high)
