"""An independent opacity map: piece by piece, in double precision."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from strandcli.draw.common.scratch import Scratch
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.geometry.extent import Thickness
from strandcli.draw.shadows.shadow import ShadowMaps
from strandcli.draw.zbuffer.raster import to_screen


def straight(way: np.ndarray) -> bool:
    """Whether the first of two places is between the second and the origin, and less than 1/16 aside."""
    share = way[0] @ way[1] / max(way[1] @ way[1], 1e-30)
    return bool(0 < share < 1 and np.linalg.norm(way[0] - share * way[1]) < 1 / 16)


def splatted(maps: ShadowMaps, lines: Polylines, thickness: Thickness) -> np.ndarray:
    """τ of each texel and layer (size, size, layers + 1) of the first map, which is of a directional light."""
    size, layers, view = int(maps.sizes[0]), maps.layers[0], maps.views[0]
    screen = to_screen(lines, view, Scratch()).astype(np.float64)
    heads = maps.extents[0].reshape(size // 2, size // 2, 2)
    found = np.zeros((size, size, layers + 1))
    for a, b in pairwise(lines.first):
        places = screen[a:b].copy()
        places[:, 2] = view.near + (1 - places[:, 2]) * (view.far - view.near)
        kept = [0]
        for number in range(1, b - a):
            way = (places[number : number + 2] - places[kept[-1]]) * (1, 1, view.focal)
            if number == b - a - 1 or (np.abs(way[0]).max() >= 0.5 and not (number - kept[-1] <= 3 and straight(way))):
                kept.append(number)
        for p, q in pairwise(kept):
            begin, way = places[p], places[q] - places[p]
            long = 1 if abs(way[1]) >= abs(way[0]) else 0
            steps = max(
                int(abs(way[2]) * view.focal / abs(way[long])) + 1 if abs(way[2]) * view.focal > abs(way[long]) else 1,
                1,
            )
            borders = np.arange(size * steps + 1) / steps
            t = np.unique(np.clip((borders - begin[long]) / way[long], 0, 1))
            covered = np.hypot(*np.diff(places[p : q + 1, :2], axis=0).T).sum()
            wide = thickness.width * (1 - thickness.taper * (p + q) / 2 / (b - a - 1)) * view.focal
            for one, two in pairwise(t):
                place = begin + (one + two) / 2 * way
                beside, d = place[1 - long] - 0.5, place[2]
                for number in (math.floor(beside), math.floor(beside) + 1):
                    row, column = (math.floor(place[1]), number) if long else (number, math.floor(place[0]))
                    start, scale = heads[row // 2, column // 2]
                    far = max((d - start) * maps.over, 0)
                    layer = min(int(scale * far / (far + 1)), layers - 1)
                    area = wide * covered * (two - one)
                    found[row, column, layer + 1] += (1 - abs(beside - number)) * area
    return found.cumsum(2)
