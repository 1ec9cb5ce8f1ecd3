"""What W children need while they are grown: rows of W numbers, of which each lane has those of one child."""

from __future__ import annotations

import math

import numpy as np

from ...constants import W
from ...jit import device, inlined
from .inputs import PARENTS

ZERO = np.float32(0.0)
ONE_PLACE = np.uint64(1)
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
def load_children(guides, following, clumps, waves, own, begin, scratch, lengths):
    """Store what the W children from place ``begin`` of ``own`` on need in the lanes of scratch (rows W,), and their
    segment lengths, metres, in lengths (W,); lanes past the end have the last child.

    One call for all of them: what is handed on are a hundred numbers. Places are not negative, and none is tested."""
    last = np.uint64(own.shape[0] - 1)
    wave = np.uint64(first_wave(clumps))
    for lane in range(np.uint64(W)):
        i = np.uint64(own[min(np.uint64(begin) + lane, last)])
        rest = load_link(guides, following, i, scratch, np.uint64(CHAIN * W) + lane)
        for level in range(np.uint64(clumps.middles.shape[0])):
            at = np.uint64((CHAIN + LINK) * W) + level * np.uint64(LINK * W) + lane
            load_link(guides, following, np.uint64(clumps.middles[level, i]), scratch, at)
            scratch[at + np.uint64(PULL * W)] = clumps.pulls[level, i]
        rest *= following.shares[i]
        scratch[np.uint64(REST * W) + lane] = rest
        scratch[np.uint64(SHARE * W) + lane] = following.shares[i]
        scratch[np.uint64(WAY * W) + lane] = ZERO
        for c in range(np.uint64(3)):
            scratch[np.uint64(ACROSS * W) + c * np.uint64(W) + lane] = waves.across[i, c]
        for w in range(np.uint64(waves.forms.shape[0])):
            at = wave + w * np.uint64(TURNING * W) + lane
            turn = waves.turns[w, i] * rest
            scratch[at + np.uint64(RADIUS * W)] = waves.radii[w, i]
            scratch[at + np.uint64(COSINE * W)] = math.cos(waves.phases[w, i])
            scratch[at + np.uint64(SINE * W)] = math.sin(waves.phases[w, i])
            scratch[at + np.uint64(TURN_COSINE * W)] = math.cos(turn)
            scratch[at + np.uint64(TURN_SINE * W)] = math.sin(turn)
        lengths[lane] = rest


@inlined
def load_link(guides, following, i, scratch, at):
    """Store a link to child i from place ``at`` on, and return its segment length without its own share."""
    rest = ZERO
    many = np.uint64(following.parents.shape[1])
    for c in range(np.uint64(3)):
        scratch[at + np.uint64(ROOT * W) + c * np.uint64(W)] = following.roots[i, c]
    for p in range(np.uint64(PARENTS)):
        g = np.uint64(following.parents[i, min(p, many - ONE_PLACE)])
        weight = following.weights[i, p] if p < many else ZERO
        scratch[at + np.uint64(PARENT * W) + p * np.uint64(W)] = np.float32(g)
        scratch[at + np.uint64(WEIGHT * W) + p * np.uint64(W)] = weight
        base = at + np.uint64(BASE * W) + p * np.uint64(3 * W)
        for c in range(np.uint64(3)):
            scratch[base + c * np.uint64(W)] = guides.particles[g, ONE_PLACE, c]
        rest += weight * guides.segments[g]
    return rest
