"""Which share of the strands an opacity map has where its light adds little to the picture.

A map of a share p of the strands, each of which counts 1 / p times, is right on average, and its variance is about
1 / p times as great. Of a light that adds the share f of all power, the picture's variance has f² times that: what
less strands add to it, f² (1 / p − 1), is at most `SLACK` of what all maps make together, if each of them errs alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...scene.model import DirectionalLight
from ..common.scratch import Scratch
from .kernels import simplify
from .shadow_model import casts_map
from .strands_in_map import FEWEST, Drawn

if TYPE_CHECKING:
    from ...scene.model import Light

SLACK = 0.005
"""Part of the picture's variance that each light may add."""
WORTH = 0.75
"""Shares from which on all strands are drawn."""
LEAST = 0.25
"""Share that every map has: where no other light comes, it is all that is seen."""
DIGITS = 256.0
"""Times a chance, of which the digits after the point say whether a strand is in a share: that has nothing to do with
how great chances are, nor with which strands are sketched."""


def shares_of(lights: Sequence[Light], counted: bool = True) -> list[float]:
    """Return the share of strands that each light's map has, 1 where lights are not all directional; counted: see
    `ShadowModel.casts_map`."""
    if not all(isinstance(light, DirectionalLight) for light in lights):
        return [1.0] * len(lights)
    squares = [(light.intensity * sum(light.colour)) ** 2 for light in lights]
    whole = sum(one for one, light in zip(squares, lights, strict=True) if casts_map(light, counted))
    shares = [one / (one + SLACK * whole) if one > 0 else 1.0 for one in squares]
    return [
        max(share, LEAST) if light.shadow.model == "opacity" and share < WORTH else 1.0
        for share, light in zip(shares, lights, strict=True)
    ]


def share_of(drawn: Drawn, share: float, scratch: Scratch) -> Drawn:
    """Return a share of strands, each of which is as much wider; they are valid until the next are requested. Whether
    a strand is there depends on no other."""
    lines, chances = drawn.lines, drawn.chances
    if share == 1 or chances is None or len(chances) < FEWEST:
        return drawn
    digits = chances * np.float32(DIGITS)
    numbers = np.flatnonzero(digits - np.floor(digits) < np.float32(share))
    first = np.zeros(len(numbers) + 1, np.int64)
    np.cumsum(np.diff(lines.first)[numbers], out=first[1:])
    world = scratch.borrow("chosen_world", (int(first[-1]), 3), np.float32)
    _, every = lines.tapered(0.0)
    along = None if every is None else scratch.borrow("chosen_along", int(first[-1]), np.float32)
    simplify.copy(lines.first, lines.world, every, numbers, first, world, along)
    scale = None if lines.scale is None else lines.scale[numbers]
    lost = None if lines.lost is None else along  # a map takes `along` for widths alone
    some = replace(lines, first=first, world=world, along=along, lost=lost, scale=scale, ways=None)
    thicker = replace(drawn.thickness, width=drawn.thickness.width / share)
    return Drawn(some, thicker, chances[numbers], len(chances))
