"""Bit masks of positions along a line: a set bit is in shadow."""

from __future__ import annotations

import numpy as np

from ....jit import device, inlined

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
WORD = 64
"""Bits a word."""
NONE, ALL = np.uint64(0), np.uint64(0xFFFFFFFFFFFFFFFF)
MEAN, MOMENT = 0, 1
"""Columns of the sums of a segment."""
OPACITY_BITS = 8
OPACITY_STEPS = np.int64(2**OPACITY_BITS)
"""Steps of opacity: a strand of opacity k / `OPACITY_STEPS` sets this share of the bits behind it."""


@inlined
def between_bits(since, until, w):
    """Return the mask of the bits since <= bit < until in word w, which must contain some of them."""
    first = np.uint64(max(since - WORD * w, 0))
    rest = np.uint64(max(WORD * (w + 1) - until, 0))
    return (ALL << first) & (ALL >> rest)


@device
def darken(dark, since, until, opacity, v, w):
    """Set the bits since <= bit < until of `dark`; return whether there are any. A translucent band sets a random
    subset, with a seed that depends on line v and band w."""
    if since >= until:
        return False
    for word in range(since // WORD, (until - 1) // WORD + 1):
        mask = between_bits(since, until, word)
        if opacity < OPACITY_STEPS:
            mask &= random_bits(np.uint64(v) * np.uint64(0x9E3779B97F4A7C15) + np.uint64(w), np.uint64(word), opacity)
        dark[word] |= mask
    return True


@device
def all_dark(dark, since, until):
    """Return whether all bits since <= bit < until are set."""
    for word in range(since // WORD, (until - 1) // WORD + 1):
        mask = between_bits(since, until, word)
        if dark[word] & mask != mask:
            return False
    return True


@device
def random_bits(seed, word, opacity):
    """Return a word of pseudorandom bits, each set with probability opacity / `OPACITY_STEPS` (SplitMix64)."""
    out = NONE
    state = seed + word * np.uint64(0xD1B54A32D192ED03)
    for i in range(OPACITY_BITS):
        state += np.uint64(0x9E3779B97F4A7C15)
        x = (state ^ (state >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        x ^= x >> np.uint64(31)
        out = out | x if (opacity >> i) & 1 else out & x
    return out


@device
def add_up(dark, sums, p):
    """Write the visibility of a segment to row p of sums: `MEAN`, and `MOMENT`, the integral of visibility · t over
    t ∈ [0, 1]."""
    words = dark.shape[0]
    total = ZERO
    toward = ZERO
    for w in range(words):
        x = ~dark[w]  # parallel bit count: pairs, nibbles, bytes; then the sum of bytes, and the sum weighted by index
        x -= (x >> np.uint64(1)) & np.uint64(0x5555555555555555)
        x = (x & np.uint64(0x3333333333333333)) + ((x >> np.uint64(2)) & np.uint64(0x3333333333333333))
        x = (x + (x >> np.uint64(4))) & np.uint64(0x0F0F0F0F0F0F0F0F)
        count = np.float32((x * np.uint64(0x0101010101010101)) >> np.uint64(56))
        total += count
        toward += np.float32((x * np.uint64(0x0001020304050607)) >> np.uint64(56)) * np.float32(8)
        toward += count * np.float32(4 + WORD * w)
    per = ONE / np.float32(WORD * words)
    sums[p, MEAN] = total * per
    sums[p, MOMENT] = toward * per * per
