"""Material and lights as kernels read them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..scene.model import DirectionalLight, Light, Material
from .marschner import absorption, build_tables
from .shadow import ShadowMaps, default_bias

TINT_NODES = (17, 9)


class Palette:
    """What the shading kernel needs of a material; an argument that a scene does not need is None."""

    def __init__(self, material: Material) -> None:
        tables = build_tables(material)
        self.lobes = None if tables is None else tables.lobes
        self.nodes = None if tables is None else tables.nodes
        self.paths = None if tables is None else tables.paths
        self.diffuse = np.float32(material.diffuse)
        self.colour = np.array(material.colour, np.float32)
        self.tint: NDArray[np.float32] | None = None
        if material.tip_colour is not None or material.colour_variation > 0:
            base = None if tables is None else (tables.absorption, tables.roughness)
            self.tint = tint_table(material, base)


def tint_table(material: Material, base: tuple[NDArray[np.float64], float] | None) -> NDArray[np.float32]:
    """(17, 9, 6) float32 over the place along the strand and its tone in [−1, 1]: colour, and the absorption beyond
    that of the tables in 1/radius (0 where there are none)."""
    along = np.linspace(0, 1, TINT_NODES[0])[:, None, None]
    tone = np.linspace(-1, 1, TINT_NODES[1])[None, :, None]
    root = np.array(material.colour)
    tip = root if material.tip_colour is None else np.array(material.tip_colour)
    # tones are multiplied, so that no colour turns negative and dark and pale strands are as frequent
    colour = (root + along * (tip - root)) * np.exp(np.log1p(material.colour_variation) * tone)
    table = np.zeros((*TINT_NODES, 6), np.float32)
    table[..., :3] = colour
    if base is not None:
        table[..., 3:] = absorption(colour, base[1]) - base[0]
    return table


def pack_lights(lights: tuple[Light, ...], maps: ShadowMaps | None, bounds: NDArray[np.float64]) -> NDArray[np.float32]:
    """(n, 16) float32 as in `kernels.shade_strands.strands`; lights that are dark are left out."""
    rows: list[list[Any]] = []
    for i, light in enumerate(lights):
        if light.intensity <= 0 or not any(light.colour):
            continue
        if isinstance(light, DirectionalLight):
            away = -np.array(light.direction, np.float64)
            where = away / np.linalg.norm(away)
        else:
            where = np.array(light.position)
        first, count = maps.owners[i] if maps is not None else (0, 0)
        bias = light.shadow.bias
        if count and maps is not None and bias == 0:
            bias = default_bias(maps.views[first], bounds)
        power = np.array(light.colour) * light.intensity
        kind = float(not isinstance(light, DirectionalLight))
        rows.append([kind, *where, *power, first, count, bias, *[0.0] * 6])
    return np.array(rows, np.float32).reshape(-1, 16)
