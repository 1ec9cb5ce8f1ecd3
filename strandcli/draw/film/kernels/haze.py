"""Haze over strands and solids (see `strandcli.draw.film.haze`)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....jit import device, inlined, parallel, prange
from ...common.kernels.approximations import exp2
from ...common.kernels.keys import EMPTY, FIRST, LOW, SHIFT
from ...common.kernels.numbers import ONE, ZERO

NEAREST = np.float32(1e-12)
"""Least depth number of a perspective view, 1 / metres."""


class Air(NamedTuple):
    """How light fades with depth."""

    rate: np.float32
    """By how much the binary logarithm of light grows a metre, less than 0."""
    perspective: np.float32
    """1 where depth numbers are 1 / depth, else 0."""
    near: np.float32
    """Depth of the number 1 of an orthographic view, metres."""
    reach: np.float32
    """Its depth of the number 0 minus that."""


@device
def arrives(air, number):
    """Return the share of light that arrives from a depth number."""
    if air.perspective > ZERO:
        return exp2(ONE / max(NEAREST, number) * air.rate)
    return exp2(max(ZERO, air.near + (ONE - number) * air.reach) * air.rate)


@parallel
def veil_strands(air, backdrop, screen, marks, colours, slots, profile):
    """Blend the colours (V, 3) of vertices with marks (V,) with the backdrop (height, width, 3) behind them, and scale
    their width profiles alike.

    air: `Air`; screen (V, 3); slots (V,) int32: number of each vertex's profile, or −1, (0,): none has one; profile
    (profiles, columns, 3).
    """
    right, bottom = np.float32(backdrop.shape[1] - 1), np.float32(backdrop.shape[0] - 1)
    for v in prange(marks.shape[0]):
        if marks[v] == 0:
            continue
        share = arrives(air, screen[v, 2])
        x, y = inside(screen[v, 0], right), inside(screen[v, 1], bottom)
        for c in range(3):
            colours[v, c] = backdrop[y, x, c] + share * (colours[v, c] - backdrop[y, x, c])
        if slots.shape[0] > 0 and slots[v] >= 0:
            for j in range(profile.shape[1]):
                for c in range(3):
                    profile[slots[v], j, c] *= share


@inlined
def inside(x, last):
    """Return the pixel at a position, the nearest of 0 … last; the first for one that is no number."""
    return np.int64(min(x if x > ZERO else ZERO, last))


@parallel
def veil_solids(air, behind, keys, hidden, light):
    """Blend the solids of a picture, light (P, 3), with what is behind them (P, 3); keys (P,): z-buffer; hidden (P,):
    not 0 at pixels that are left as they are, (0,): none are."""
    for p in prange(keys.shape[0]):
        key = keys[p]
        if key == EMPTY or (key & LOW) < FIRST or (hidden.shape[0] > 0 and hidden[p] != 0):
            continue
        share = arrives(air, np.uint32(LOW - (key >> SHIFT)).view(np.float32))
        for c in range(3):
            light[p, c] = behind[p, c] + share * (light[p, c] - behind[p, c])
