"""Volume: a layer of vertical strands that a plate presses from the side holds n strands a square metre.

The strands hang from their roots, and the plate stands beside their lower halves. Without pressure they pile up before
it, for their weight draws them to it. With it those next to it are as dense as allowed, and no denser, up to where as
many are as the plate has swept together. Where the plate comes back, the layer follows. Of two layers one is pressed to
where it is measured, and the other further, from where the plate has come back. They are measured from strands and not
from a grid: metres of strand in a box before the plate. Strands are limp: stiff ones that lean over the plate's edge
bend away from it further down, hair by 2 mm at the tips, and leave room there that nothing presses them into.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...groom.record import Groom
from .base import Case, Errors, Reference, Track, groom

DEPTH, WIDTH, LENGTH = 0.12, 0.36, 0.3
"""Of the rectangle of roots, before the plate and along it, metres; length of strands. A third of the width is as far
from its walls, but holds too few strands: from one placing to another the density found differs by 3 % then."""
ROWS, COLUMNS = 48, 144
"""Strands across the depth and along the width."""
SPARSE = ROWS * COLUMNS / (DEPTH * WIDTH)
"""Strands a square metre as they stand."""
DENSE = 1.5 * SPARSE
"""Strands a square metre at the most, n."""
CELL = 0.006
YOUNG = 4e7
"""A hundredth of hair's, Pa."""
DEEPEST, MEASURED = 0.03, 0.02
"""How far the plate comes in, and where it is when the layer is measured, metres."""
SPEED, SPAN = 0.03, 3.0
"""Of the plates in and back, m/s, and how long a run takes, seconds: plates stand still after 5/3 of one."""
APART = WIDTH + 2 * DEPTH
"""Metres from layer to layer."""
BOX = 0.5 * MEASURED * SPARSE / (DENSE - SPARSE), WIDTH - 2 / 3 * DEPTH, (-0.95 * LENGTH, -0.6 * LENGTH)
"""Of the box in which strands are measured, metres: its depth before the plate, half of what is as dense as n by
the strands that have been swept together; its width; from what height to what."""
PIECES = 64
"""Of a segment, each of which is in the box or not."""
THICK, TOP = 0.02, -0.525 * LENGTH
"""Of the plate, metres; its upper edge is between particles."""


def strands() -> Groom:
    """Strands in two rectangles alike, in places that no order shows in."""
    rng = np.random.default_rng(0)
    x, z = np.meshgrid(np.arange(ROWS), np.arange(COLUMNS), indexing="ij")
    cells = np.stack([x.ravel(), z.ravel()], 1) + rng.uniform(0.1, 0.9, (ROWS * COLUMNS, 2))
    places = cells * [DEPTH / ROWS, WIDTH / COLUMNS] - [DEPTH / 2, WIDTH / 2]
    roots = np.stack([places[:, 0], np.zeros(len(places)), places[:, 1]], 1)
    roots = np.concatenate([roots, roots + np.array([0.0, 0.0, APART])])
    return groom([[0.0, -1.0, 0.0]] * len(roots), np.full(len(roots), LENGTH), roots)


def case(particles: int) -> Case:
    """Both layers, each between two walls, and their plates."""
    made, outside, solids = strands(), DEPTH / 2 + THICK / 2, []
    for z, path in ((0.0, (0.0, MEASURED)), (APART, (0.0, DEEPEST, MEASURED))):
        ends = np.cumsum(np.abs(np.diff(path, prepend=0.0))) / SPEED
        keys = [
            {"time": float(end), "position": [outside - deep, TOP - LENGTH / 2, z]}
            for end, deep in zip(ends, path, strict=True)
        ]
        solids.append(
            {"kind": "box", "size": [THICK, LENGTH, WIDTH], "position": [outside, TOP - LENGTH / 2, z], "keys": keys}
        )
        solids += [
            {"kind": "box", "size": [3 * DEPTH, 3 * LENGTH, THICK], "position": [0.0, 0.0, z + side]}
            for side in (-WIDTH / 2 - THICK / 2, WIDTH / 2 + THICK / 2)
        ]
    settings = {
        "seed": 0,
        "time": {"preroll": 0},
        "emitter": {"shape": {"kind": "plane", "width": DEPTH, "depth": WIDTH}, "strands": made.strands,
                    "particles": particles, "length": LENGTH},
        "solids": solids,
        "rules": ["gravity", {"interaction": {"density": DENSE, "cell": CELL}}, "collision"],
        "rod": {"rest": "straight", "young": YOUNG, "drag": 5.0, "friction": 0.0},
    }  # fmt: skip
    return Case(settings, made)


def density(positions: NDArray[np.float64], depth: float = BOX[0]) -> float:
    """Metres of strand in a cubic metre before the plate where it is measured. ``positions`` (strands, particles,
    3)."""
    share = (np.arange(PIECES) + 0.5) / PIECES
    segments = np.diff(positions, axis=1)
    at = positions[:, :-1, None] + share[:, None] * segments[:, :, None]
    face = DEPTH / 2 - MEASURED
    low, high = BOX[2]
    inside = (at[..., 0] > face - depth) & (at[..., 0] < face) & (np.abs(at[..., 2]) < BOX[1] / 2)
    inside &= (at[..., 1] > low) & (at[..., 1] < high)
    metres = (inside.sum(2) / PIECES * np.linalg.norm(segments, axis=2)).sum()
    return float(metres / (depth * BOX[1] * (high - low)))


def measure(track: Track) -> Errors:
    """``pressed`` and ``sprung back``: error of the density, as a share; ``density``: the greater of both."""
    half = len(track.last) // 2
    after = track.last[half:] - [0.0, 0.0, APART]
    found = {"pressed": density(track.last[:half]), "sprung back": density(after)}
    errors = {name: abs(one / DENSE - 1) for name, one in found.items()}
    return {"density": max(errors.values()), **errors}


LAYER = Reference(
    name="layer", title="a layer of strands that a plate presses keeps n strands a square metre", metric="density",
    unit="of n", needs="strands that push each other apart", span=SPAN, exact=lambda: {"density": DENSE}, case=case,
    measure=measure, particles=(11, 21),
)  # fmt: skip
