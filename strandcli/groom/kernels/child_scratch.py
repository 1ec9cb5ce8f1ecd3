"""What W children need while they are grown: rows of W numbers, of which each lane has those of one child."""

from __future__ import annotations

import numpy as np

from ...constants import W
from ...jit import device
from ...simd import lane_count, load, pointer, store
from ...simd.turning import cosine_sine

ZERO = np.float32(0.0)
ONE_PLACE = np.uint64(1)
REST, SHARE, REACH, ACROSS, FIRST_WAVE = 0, 1, 2, 3, 6
"""First rows: segment length, metres; ratio of the length to that of the guides; metres that a strand may go on before
any solid can be met; x, y, z of the unit vector across. Then follow `TURNING` rows of each wave."""
RADIUS, COSINE, SINE, TURN_COSINE, TURN_SINE = 0, 1, 2, 3, 4
"""Rows of a wave: its amplitude, metres; cosine and sine of its angle at a particle, and of the angle to the next."""
TURNING = 5


@device
def load_children(guides, following, waves, own, begin, scratch, lengths):
    """Store what the W children from place ``begin`` of ``own`` on need in the lanes of scratch (rows W,), and their
    segment lengths, metres, in lengths (W,); lanes past the end have the last child. Places are not negative, and none
    is tested."""
    last = np.uint64(own.shape[0] - 1)
    for lane in range(np.uint64(W)):
        i = np.uint64(own[min(np.uint64(begin) + lane, last)])
        rest = ZERO
        for p in range(np.uint64(following.parents.shape[1])):
            rest += following.weights[i, p] * guides.segments[np.uint64(following.parents[i, p])]
        rest *= following.shares[i]
        scratch[np.uint64(REST * W) + lane] = rest
        scratch[np.uint64(SHARE * W) + lane] = following.shares[i]
        scratch[np.uint64(REACH * W) + lane] = ZERO
        for c in range(np.uint64(3)):
            scratch[np.uint64(ACROSS * W) + c * np.uint64(W) + lane] = waves.across[i, c]
        for w in range(np.uint64(waves.forms.shape[0])):
            at = (np.uint64(FIRST_WAVE) + w * np.uint64(TURNING)) * np.uint64(W) + lane
            scratch[at + np.uint64(RADIUS * W)] = waves.radii[i, w]
            scratch[at + np.uint64(COSINE * W)] = waves.phases[i, w]
            scratch[at + np.uint64(TURN_COSINE * W)] = waves.turns[i, w] * rest
        lengths[lane] = rest
    rows = pointer(scratch)
    for first in range(FIRST_WAVE * W, (FIRST_WAVE + waves.forms.shape[0] * TURNING) * W, TURNING * W):
        for k in range(first, first + W, lane_count(rows)):
            turn_wave(rows, k + COSINE * W)
            turn_wave(rows, k + TURN_COSINE * W)


@device
def turn_wave(rows, o):
    """Store the cosines of the angles at place o of rows there, and their sines in the row after it."""
    cosine, sine = cosine_sine(load(rows, o))
    store(rows, o, cosine)
    store(rows, o + W, sine)
