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
    """Clumps (locks): strands are drawn toward the strand at the clump's centre, the more the nearer to the tip."""

    size: float = number(0.02, above=0, unit="m", doc="distance between clump centres at the roots")
    strength: float = number(
        0.7,
        low=0,
        high=1,
        doc="fraction of the distance to the clump centre by which tips are moved; 1: pointed clumps",
    )
    shape: float = number(1.0, above=0, high=10, doc="exponent along the strand: 0.5 clumps early, 3 late")
    variation: float = number(0.4, low=0, high=1, doc="variation of the strength between clumps")
    stray: float = number(0.05, low=0, high=1, doc="fraction of strands outside any clump")


@dataclass(frozen=True, slots=True, repr=False)
class Wave:
    """Waves, curls or frizz, with the length of strands preserved, so that tips draw up."""

    radius: float = number(0.003, low=0, unit="m", doc="amplitude")
    length: float = number(0.04, above=0, unit="m", doc="wavelength along the strand")
    round: float = number(0.4, low=0, high=1, doc="0: flat waves, 1: helices")
    onset: float = number(0.3, low=0, high=1, doc="fraction of a strand over which waves grow to full amplitude")
    disorder: float = number(0.1, low=0, high=1, doc="0: the strands of a clump in phase; 1: each by itself, frizz")
    share: float = number(1.0, low=0, high=1, doc="fraction of the strands that wave; 0.02: stray hairs")


@dataclass(frozen=True, slots=True, repr=False)
class Fringe:
    """Moves some children to the hairline (the rim of a sphere's cap) and the parting, where skin would show."""

    share: float = number(0.15, low=0, high=1, doc="fraction of the children that is moved there")
    within: float = number(0.01, above=0, unit="m", doc="distance from the hairline at which their density is 1/e")
    length: float = number(0.5, above=0, high=1, doc="least length relative to the others'")


@dataclass(frozen=True, slots=True, repr=False)
class Children:
    """Strands drawn around the simulated ones. Each follows its three nearest guides; then come clumps, waves, its own
    length, and the solids of a collision rule."""

    count: int = integer(10, low=1, high=10_000, doc="strands drawn per simulated strand")
    cut: float = number(0.0, low=0, high=1, doc="lengths are uniform in 1 - cut ... 1 times the guides'")
    undercoat: float = number(0.0, low=0, high=1, doc="fraction of strands that are short")
    undercoat_length: float = number(0.5, above=0, high=1, doc="length of the undercoat relative to the others'")
    fringe: Fringe | None = optional(Fringe, doc="denser hair at hairline and parting; absent: none")
    clumps: tuple[Clump, ...] = items(Clump, doc="clumps and clumps in clumps, from wide to narrow")
    waves: tuple[Wave, ...] = items(Wave, doc="waves, curls and frizz, added up")

    def steps(self, segment: float) -> int:
        """In how many steps a guide's segment of so many metres is drawn, for the waves' sake."""
        seen = (wave.length for wave in self.waves if wave.radius > 0 and wave.share > 0)
        shortest = min(seen, default=math.inf)
        return min(max(math.ceil(PER_WAVE * segment / shortest), 1), MOST_STEPS)
