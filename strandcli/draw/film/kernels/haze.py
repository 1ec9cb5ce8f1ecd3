"""Haze over strands and solids (see `strandcli.draw.film.haze`)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ....jit import device, inlined, parallel, prange
from ...common.kernels.keys import EMPTY, FIRST, LOW, SHIFT

ZERO = np.float32(0.0)
STEPS = 32
STEP_BITS = np.int64(5)
PER_STEP = STEPS / math.log(2.0)
STEP = math.log(2.0) / STEPS
POWERS = np.array([2 ** (k / STEPS) for k in range(STEPS)])
"""Of two, between one and two."""
THIRD, FOURTH, FIFTH = 1 / 6, 1 / 24, 1 / 120
"""Of the series of e to the power x, which is off by less than 3e-15 from −`STEP` / 2 to `STEP` / 2."""
LEAST = -700.0
"""Exponent up to which the result is a normal number of double precision."""
NEAREST = 1e-12
"""Least depth number of a perspective view, 1 / metres."""
BIAS, MANTISSA_BITS = np.int64(1023), np.int64(52)
AT_ONCE = 1 << 14
"""Vertices or pixels a task."""


class Air(NamedTuple):
    """How light fades with depth, in double precision."""

    haze: float
    """Depth, metres, at which 1 / e of the light is left."""
    perspective: float
    """1 where depth numbers are 1 / depth, else 0."""
    near: float
    """Depth of the number 1 of an orthographic view, metres."""
    reach: float
    """Its depth of the number 0 minus that."""


@device
def exponential(x):
    """Return e to the power x <= 0, in double precision."""
    x = max(x, LEAST)
    step = np.int64(x * PER_STEP - 0.5)
    x -= np.float64(step) * STEP
    power = ((((FIFTH * x + FOURTH) * x + THIRD) * x + 0.5) * x + 1.0) * x + 1.0
    power *= POWERS[np.uint64(step & (STEPS - 1))]
    return power * np.int64(((step >> STEP_BITS) + BIAS) << MANTISSA_BITS).view(np.float64)


@inlined
def arrives(air, number):
    """Return the share of light that arrives from a depth number."""
    if air.perspective > 0.0:
        depth = 1.0 / max(np.float64(number), NEAREST)
    else:
        depth = air.near + (1.0 - np.float64(number)) * air.reach
    return np.float32(exponential(-max(depth, 0.0) / air.haze))


@parallel
def veil_strands(air, backdrop, screen, marks, colours, slots, profile):
    """Blend the colours (V, 3) of vertices with marks (V,) with the backdrop (height, width, 3) behind them, and scale
    their width profiles alike.

    air: `Air`; screen (V, 3); slots (V,) int32: number of each vertex's profile, or −1, (0,): none has one; profile
    (lights, profiles, columns, 3).
    """
    count = np.int64(marks.shape[0])
    right, bottom = np.float32(backdrop.shape[1] - 1), np.float32(backdrop.shape[0] - 1)
    for one in prange((count + AT_ONCE - 1) // AT_ONCE):
        begin = np.int64(one) * AT_ONCE
        for v in range(begin, min(begin + AT_ONCE, count)):
            if marks[v] == 0:
                continue
            share = arrives(air, screen[v, 2])
            x, y = inside(screen[v, 0], right), inside(screen[v, 1], bottom)
            for c in range(3):
                behind = backdrop[y, x, c]
                colours[v, c] = behind + share * (colours[v, c] - behind)
            if slots.shape[0] > 0 and slots[v] >= 0:
                fade(profile, slots[v], share)


@device
def inside(x, last):
    """Return the pixel at a position, the nearest of 0 … last; the first for one that is no number."""
    return np.int64(min(x if x > ZERO else ZERO, last))


@device
def fade(profile, slot, share):
    """Scale a width profile (lights, profiles, columns, 3)."""
    for i in range(profile.shape[0]):
        for j in range(profile.shape[2]):
            for c in range(3):
                profile[i, slot, j, c] *= share


@parallel
def veil_solids(air, behind, keys, hidden, light):
    """Blend the solids of a picture, light (P, 3), with what is behind them (P, 3); keys (P,): z-buffer; hidden (P,):
    not 0 at pixels that are left as they are, (0,): none are."""
    count = np.int64(keys.shape[0])
    for one in prange((count + AT_ONCE - 1) // AT_ONCE):
        begin = np.int64(one) * AT_ONCE
        for p in range(begin, min(begin + AT_ONCE, count)):
            key = keys[p]
            if key == EMPTY or (key & LOW) < FIRST or (hidden.shape[0] > 0 and hidden[p] != 0):
                continue
            share = arrives(air, np.uint32(LOW - (key >> SHIFT)).view(np.float32))
            for c in range(3):
                light[p, c] = behind[p, c] + share * (light[p, c] - behind[p, c])
