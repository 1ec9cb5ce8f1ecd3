"""What W children need while they are grown: rows of W numbers, of which each lane has those of one child."""

from __future__ import annotations

import math

import numpy as np

from ...constants import W
from ...jit import device
from .inputs import PARENTS

ZERO = np.float32(0.0)
REST, SHARE, WAY, ACROSS, CHAIN = 0, 1, 2, 3, 6
"""First rows: segment length, metres; ratio of the length to that of the guides; metres that a strand may go on before
any solid can be met; x, y, z of the unit vector across. Then follow `LINK` rows of the child itself, as many of the
centre of its clump at each level, and `TURNING` rows of each wave."""
PULL, ROOT, PARENT, WEIGHT, BASE = 0, 1, 4, 4 + PARENTS, 4 + 2 * PARENTS
"""Rows of a link: the clump's pull, the child's root, and of each guide its number, its weight and its root."""
LINK = BASE + 3 * PARENTS
RADIUS, COSINE, SINE, TURN_COSINE, TURN_SINE = 0, 1, 2, 3, 4
"""Rows of a wave: its amplitude, metres; cosine and sine of its angle at a particle, and of the angle to the next."""
TURNING = 5


@device
def first_wave(clumps):
    """Return the place where the rows of the first wave begin."""
    return (CHAIN + (1 + clumps.middles.shape[0]) * LINK) * W


@device
def load_child(guides, following, clumps, waves, i, scratch, lane):
    """Store what child i needs in a lane of scratch (rows W,), and return its segment length, metres."""
    rest = load_link(guides, following, i, scratch, CHAIN * W + lane)
    for level in range(clumps.middles.shape[0]):
        at = (CHAIN + (level + 1) * LINK) * W + lane
        load_link(guides, following, np.int64(clumps.middles[level, i]), scratch, at)
        scratch[at + PULL * W] = clumps.pulls[level, i]
    rest *= following.shares[i]
    scratch[REST * W + lane] = rest
    scratch[SHARE * W + lane] = following.shares[i]
    scratch[WAY * W + lane] = ZERO
    for c in range(3):
        scratch[(ACROSS + c) * W + lane] = waves.across[i, c]
    for w in range(waves.forms.shape[0]):
        at = first_wave(clumps) + w * TURNING * W + lane
        turn = waves.turns[w, i] * rest
        scratch[at + RADIUS * W] = waves.radii[w, i]
        scratch[at + COSINE * W] = math.cos(waves.phases[w, i])
        scratch[at + SINE * W] = math.sin(waves.phases[w, i])
        scratch[at + TURN_COSINE * W] = math.cos(turn)
        scratch[at + TURN_SINE * W] = math.sin(turn)
    return rest


@device
def load_link(guides, following, i, scratch, at):
    """Store a link to child i from place ``at`` on, and return its segment length without its own share."""
    rest = ZERO
    many = following.parents.shape[1]
    for c in range(3):
        scratch[at + (ROOT + c) * W] = following.roots[i, c]
    for p in range(PARENTS):
        g = following.parents[i, min(p, many - 1)]
        weight = following.weights[i, p] if p < many else ZERO
        scratch[at + (PARENT + p) * W] = np.float32(g)
        scratch[at + (WEIGHT + p) * W] = weight
        for c in range(3):
            scratch[at + (BASE + 3 * p + c) * W] = guides.particles[g, 1, c]
        rest += weight * guides.segments[g]
    return rest
