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


def splatted(maps: ShadowMaps, lines: Polylines, thickness: Thickness) -> np.ndarray:
    """τ of each texel and layer (size, size, layers + 1) of the first map, which is of a directional light."""
    size, layers, view = int(maps.sizes[0]), maps.layers[0], maps.views[0]
    lines = maps.simplified(lines, Scratch())
    screen = to_screen(lines, view, Scratch()).astype(np.float64)
    heads = maps.extents[0].reshape(size // 2, size // 2, 2)
    found = np.zeros((size, size, layers + 1))
    for a, b in pairwise(lines.first):
        places = screen[a:b].copy()
        places[:, 2] = view.near + (1 - places[:, 2]) * (view.far - view.near)
        kept = [0]
        for number in range(1, b - a):
            aside = np.abs((places[number] - places[kept[-1]]) * (1, 1, view.focal)).max()
            if aside >= 0.5 or number == b - a - 1:
                kept.append(number)
        for p, q in pairwise(kept):
            begin, way = places[p], places[q] - places[p]
            long = 1 if abs(way[1]) >= abs(way[0]) else 0
            deep = 0.5 * abs(way[2]) * view.focal / max(abs(way[long]), 1e-9)
            steps = int(deep) + 1 if deep > 1 else 1
            borders = np.arange(size * steps + 1) / steps
            with np.errstate(divide="ignore"):  # a piece towards the light meets no border
                t = np.unique(np.clip((borders - begin[long]) / way[long], 0, 1))
            covered = np.hypot(*np.diff(places[p : q + 1, :2], axis=0).T).sum()
            middle = (p + q) / 2 / (b - a - 1) if lines.along is None else lines.along[[a + p, a + q]].mean()
            wide = thickness.width * (1 - thickness.taper * middle) * view.focal
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
