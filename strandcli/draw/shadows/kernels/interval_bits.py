"""Places along a line, a bit for each: set where it is dark."""

from __future__ import annotations

import numpy as np

from ....jit import device, inlined

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
WORD = 64
"""Bits of a word."""
NONE, ALL = np.uint64(0), np.uint64(0xFFFFFFFFFFFFFFFF)
VEIL_BITS = 8
VEILS = np.int64(2**VEIL_BITS)
"""Of so many bits behind a strand that lets light through, some are set."""


@inlined
def between_bits(since, until, w):
    """The bits of word w among those from `since` to before `until`, which it has some of."""
    first = np.uint64(max(since - WORD * w, 0))
    rest = np.uint64(max(WORD * (w + 1) - until, 0))
    return (ALL << first) & (ALL >> rest)


@device
def darken(dark, since, until, veil, v, w):
    """Set the bits from `since` to before `until`, those that band w darkens of the line v; whether there are any."""
    if since >= until:
        return False
    for word in range(since // WORD, (until - 1) // WORD + 1):
        mask = between_bits(since, until, word)
        if veil < VEILS:
            mask &= scattered(np.uint64(v) * np.uint64(0x9E3779B97F4A7C15) + np.uint64(w), np.uint64(word), veil)
        dark[word] |= mask
    return True


@device
def all_dark(dark, since, until):
    """Whether all bits from `since` to before `until` are set."""
    for word in range(since // WORD, (until - 1) // WORD + 1):
        mask = between_bits(since, until, word)
        if dark[word] & mask != mask:
            return False
    return True


@device
def scattered(seed, word, veil):
    """Bits of which `veil` in `VEILS` are set, by chance, the same for the same numbers (SplitMix64)."""
    out = NONE
    state = seed + word * np.uint64(0xD1B54A32D192ED03)
    for i in range(VEIL_BITS):
        state += np.uint64(0x9E3779B97F4A7C15)
        x = (state ^ (state >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        x ^= x >> np.uint64(31)
        out = out | x if (veil >> i) & 1 else out & x
    return out


@device
def add_up(dark, sums, p):
    """Share of piece p that is lit, and what it comes to where it counts the more the nearer it is to the piece's
    end."""
    words = dark.shape[0]
    total = ZERO
    toward = ZERO
    for w in range(words):
        x = ~dark[w]  # bits that are set: in each two, each four, each byte; then all bytes, and bytes by their number
        x -= (x >> np.uint64(1)) & np.uint64(0x5555555555555555)
        x = (x & np.uint64(0x3333333333333333)) + ((x >> np.uint64(2)) & np.uint64(0x3333333333333333))
        x = (x + (x >> np.uint64(4))) & np.uint64(0x0F0F0F0F0F0F0F0F)
        count = np.float32((x * np.uint64(0x0101010101010101)) >> np.uint64(56))
        total += count
        toward += np.float32((x * np.uint64(0x0001020304050607)) >> np.uint64(56)) * np.float32(8)
        toward += count * np.float32(4 + WORD * w)
    per = ONE / np.float32(WORD * words)
    sums[2 * p] = total * per
    sums[2 * p + 1] = toward * per * per
