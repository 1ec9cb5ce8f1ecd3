# ruff: noqa: RUF009 - these calls make dataclass fields

from __future__ import annotations

import math
from dataclasses import dataclass

from ..fields import integer, items, number, optional

PER_WAVE = 6
"""Pieces that a wave is drawn with, at least."""
MOST_STEPS = 16


@dataclass(frozen=True, slots=True, repr=False)
class Clump:
    """Locks: strands are drawn to the one in their middle, the more the nearer to the tip."""

    size: float = number(0.02, above=0, unit="m", doc="distance between the middles of locks, at the roots")
    strength: float = number(
        0.7, low=0, high=1, doc="share of the way to the middle that tips are moved; 0: none, 1: locks end in points"
    )
    shape: float = number(
        1.0, above=0, high=10, doc="that share grows with the way from the root to this power: 0.5 early, 3 late"
    )
    variation: float = number(0.4, low=0, high=1, doc="part of the strength that differs from lock to lock")
    stray: float = number(0.05, low=0, high=1, doc="share of strands that go their own way")


@dataclass(frozen=True, slots=True, repr=False)
class Wave:
    """Waves, curls or frizz: strands wind about where they would be. Their lengths stay, so their ends draw up."""

    radius: float = number(0.003, low=0, unit="m", doc="how far they depart to each side")
    length: float = number(0.04, above=0, unit="m", doc="along the strand, from one turn to the next")
    round: float = number(0.4, low=0, high=1, doc="0: waves to and fro, 1: corkscrews")
    onset: float = number(0.3, low=0, high=1, doc="share of a strand over which they begin")
    disorder: float = number(
        0.1, low=0, high=1, doc="0: the strands of a lock wave as one; 1: each by itself, which is frizz"
    )
    share: float = number(1.0, low=0, high=1, doc="share of the strands that wave so; 0.02: stray hair")


@dataclass(frozen=True, slots=True, repr=False)
class Fringe:
    """More of the children at the hairline, which is the rim of a sphere's cap, and along the parting, so that skin is
    covered there as soon as by real hair, which is finer and more."""

    share: float = number(0.15, low=0, high=1, doc="share of the children that move there")
    within: float = number(0.01, above=0, unit="m", doc="so far inside they are 37 % (1/e) as dense")
    length: float = number(0.5, above=0, high=1, doc="their lengths are even in this ... 1 of the others'")


@dataclass(frozen=True, slots=True, repr=False)
class Children:
    """Strands that are drawn about the simulated ones, which guide them.

    Each keeps its own root and follows the three guides nearest to it; then come locks, the widest listed first, and
    waves; then it gets its length again and is kept out of the solids that a collision rule names.
    """

    count: int = integer(10, low=1, high=10_000, doc="strands drawn for each one that is simulated")
    cut: float = number(
        0.0, low=0, high=1, doc="lengths are even in 1 - cut ... 1 of the guides', at 1 some are almost nothing"
    )
    undercoat: float = number(0.0, low=0, high=1, doc="share of strands that are short")
    undercoat_length: float = number(0.5, above=0, high=1, doc="of those, the length as a share of the others'")
    fringe: Fringe | None = optional(Fringe, doc="hair at hairline and parting; absent: as dense there as anywhere")
    clumps: tuple[Clump, ...] = items(Clump, doc="locks, and locks in locks, from wide to narrow")
    waves: tuple[Wave, ...] = items(Wave, doc="waves, curls and frizz, one upon another")

    def steps(self, segment: float) -> int:
        """In how many steps a guide's segment of so many metres is drawn, for the waves' sake."""
        seen = (wave.length for wave in self.waves if wave.radius > 0 and wave.share > 0)
        shortest = min(seen, default=math.inf)
        return min(max(math.ceil(PER_WAVE * segment / shortest), 1), MOST_STEPS)
