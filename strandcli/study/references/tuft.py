"""Volume: a tuft of thick strands that falls on a table stands as high as its strands do one by one.

Limp strands stand out from a wall in a channel and fall on its floor. Away from the wall they lie beside each other,
and what they do across the channel is what discs of their thickness do there. The reference is a pile of 500 discs
without friction, each contact resolved by itself, one after the other, until all have come to rest
(`tests/study/discs.py`). The rule is given the density of that pile, as its strands a square metre, and nothing else of
it: what is measured is whether it holds up as many, at any step, on a floor.

Discs are outside the solids wholly; strands that interact are where their middles are, and fill a room as large.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .base import Case, Errors, Reference, Track, groom

THICK, LENGTH = 0.002, 0.12
"""From the middle of a strand to that of the next one that touches it, and how long strands are, metres."""
ROWS, ACROSS, SPACING, LOOSE = 20, 25, 1.05, 0.2
"""Strands above and beside each other; how far apart they begin beside each other, and the standard deviation of it,
thicknesses."""
WIDE = (ACROSS + 0.5) * SPACING
"""Of the channel, thicknesses."""
HEIGHT = 8.36
"""Mean height of the middles of discs that have settled, thicknesses, ± .03 for other beginnings."""
DENSITY = ROWS * ACROSS / (WIDE * 2 * HEIGHT) / THICK**2
"""Of the discs, 1/m²."""
CELL = 4 * THICK
PIECES = 48
"""Of a segment, each of which is in the middle third or not."""


def places() -> NDArray[np.float64]:
    """(strands, 2) where strands begin, upward and across, thicknesses."""
    k = np.arange(ROWS * ACROSS)
    across, row = k % ACROSS, k // ACROSS
    beside = (across - (ACROSS - 1) / 2 + 0.25 * np.where(row % 2, 1, -1)) * SPACING
    return np.stack([1.0 + row, beside], 1) + np.random.default_rng(0).normal(scale=LOOSE, size=(len(k), 2))


def case(particles: int) -> Case:
    """The tuft, with the wall that holds it, the channel's, and its floor."""
    at = places() * THICK
    half = WIDE / 2 * THICK
    at[:, 0] = np.maximum(at[:, 0], THICK / 2)
    at[:, 1] = np.clip(at[:, 1], -half, half)
    count = len(at)
    roots = np.stack([np.zeros(count), at[:, 0], at[:, 1]], 1)
    made = groom([[1.0, 0.0, 0.0]] * count, np.full(count, LENGTH), roots)
    settings = {
        "seed": 0,
        "time": {"preroll": 0},
        "emitter": {"shape": {"kind": "plane", "width": 0.01, "depth": 0.01}, "strands": count,
                    "particles": particles, "length": LENGTH},
        "solids": [
            {"kind": "plane", "position": [0.0, 0.0, 0.0]},
            {"kind": "plane", "position": [0.0, 0.0, -half], "rotation": [90, 0, 0]},
            {"kind": "plane", "position": [0.0, 0.0, half], "rotation": [-90, 0, 0]},
            {"kind": "plane", "position": [-1e-4, 0.0, 0.0], "rotation": [0, 0, -90]},
        ],
        "rules": ["gravity", {"interaction": {"density": DENSITY, "cell": CELL, "friction": 0.0}}, "collision"],
        "rod": {"rest": "straight", "radius": THICK / 4, "density": 1000.0, "young": 3e5, "drag": 8.0,
                "friction": 0.0},
    }  # fmt: skip
    return Case(settings, made)


def height(positions: NDArray[np.float64]) -> float:
    """Mean height of strands in the middle third, metres. ``positions`` (strands, particles, 3)."""
    share = (np.arange(PIECES) + 0.5) / PIECES
    at = positions[:, :-1, None] + share[:, None] * np.diff(positions, axis=1)[:, :, None]
    inside = np.abs(at[..., 0] - LENGTH / 2) < LENGTH / 6
    return float(at[..., 1][inside].mean()) if inside.any() else math.nan


def measure(track: Track) -> Errors:
    """``height``: error of the height, as a share; None where no strand is in the middle third."""
    found = height(track.last)
    return {"height": abs(found / (HEIGHT * THICK) - 1) if math.isfinite(found) else None}


TUFT = Reference(
    name="tuft", title="a tuft of 500 strands on a table stands as high as a pile of 500 discs", metric="height",
    unit="of the height", needs="strands that push each other apart", span=1.0,
    exact=lambda: {"height": HEIGHT * THICK}, case=case, measure=measure, particles=(7, 13),
)  # fmt: skip
