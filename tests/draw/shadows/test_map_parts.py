"""Parts of strands in an opacity map: none is left out, and none is written over."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from strandcli.draw.common.scratch import Scratch
from strandcli.draw.shadows.kernels.map_parts import PART, PARTS, REST, MapView, StrandsInMap
from strandcli.draw.shadows.strands_in_map import parts_of
from strandcli.plan import memory


def test_parts_of_strands_of_any_length_have_memory_of_their_own() -> None:
    some = [0, 2, 3, PART, PART + REST + 1, PART + REST + 2, 2 * PART, 3 * PART, 90, 500]
    lengths = np.random.default_rng(3).choice(some, 400)
    first = np.append(0, np.cumsum(lengths))
    place = np.arange(first[-1], dtype=np.float32) % 61  # each segment is longer than a texel, or a strand's end
    screen = np.stack([place, place[::-1], np.full(len(place), 0.5, np.float32)], 1)
    strands = StrandsInMap(first, screen, np.float32(0.01), np.float32(0), None)
    parts = parts_of(strands, MapView(np.float32(2), np.float32(1), np.float32(8)), 64, 2, Scratch())
    begin, count = parts.order.T[:2].astype(int)
    parts_of_each = [min(max(math.ceil((n - 1 - REST) / PART), 1), PARTS) for n in lengths if n]
    assert len(begin) == sum(parts_of_each)
    taken = np.concatenate([np.arange(a, a + n) for a, n in zip(begin, count, strict=True)])
    assert len(set(taken)) == len(taken) == sum(lengths) + sum(parts_of_each) - len(parts_of_each)
    assert taken.max() < len(parts.kept)
    points = np.concatenate([parts.kept[a + 1 : a + n, 0] for a, n in sorted(zip(begin, count, strict=True))])
    np.testing.assert_array_equal(points, np.concatenate([place[a + 1 : b] for a, b in pairwise(first)]))


def test_plan_knows_how_many_there_are() -> None:
    assert (memory.PARTS, memory.PART) == (PARTS, PART)
