"""Material and lights as kernels read them."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...scene.model import DirectionalLight, Light, Material
from ..fibre.chiang import ChiangTables
from ..fibre.chiang import build_tables as build_chiang
from ..fibre.dual import build_tables as build_dual
from ..fibre.dual import veil_of
from ..fibre.marschner import MarschnerTables, azimuthal_beta
from ..fibre.marschner import build_tables as build_marschner
from ..fibre.pigment import colour_of, tint, varies
from ..fibre.width_tables import columns_of
from ..shadows.shadow import ShadowMaps, default_bias, is_traced

ALONG = 17
TONES, TONES_GREY = 9, 65
"""Nodes over the tone: with grey strands enough that few are in between."""


class Palette:
    """What the shading kernel needs of a material; an argument that a scene does not need is None."""

    def __init__(self, material: Material, deep: bool = False) -> None:
        """``deep``: whether any light has an opacity map, without which dual scattering has nothing to count."""
        tables = build_marschner(material) if material.model == "marschner" else build_chiang(material)
        self.take(tables)
        self._material = material
        self.diffuse = np.float32(material.diffuse)
        roughness = material.beta_n if material.model == "chiang" else azimuthal_beta(material.azimuthal)
        self.colour = colour_of(material, roughness).astype(np.float32)
        dual = build_dual(material, roughness) if deep and material.scatter == "dual" else None
        self.dual = None if dual is None else dual.rows
        self.dual_scale = None if dual is None else dual.scale
        self.veil = None if dual is None else veil_of(dual)
        """Of solids behind strands."""
        self.tint = (
            tint_table(material, roughness, None if tables is None else tables.absorption) if varies(material) else None
        )

    @cached_property
    def columns(self) -> NDArray[np.float32] | None:
        """Tables over a strand's width, made when the first strand is wide."""
        return columns_of(self._material)

    def take(self, tables: MarschnerTables | ChiangTables | None) -> None:
        """Tables to shade with; None: no highlights."""
        self.lobes = tables.lobes if isinstance(tables, MarschnerTables) else None
        self.fibre = tables.fibre if isinstance(tables, ChiangTables) else None
        self.nodes = None if tables is None else tables.nodes
        self.paths = None if tables is None else tables.paths


def tint_table(material: Material, roughness: float, base: NDArray[np.float64] | None) -> NDArray[np.float32]:
    """(17, n, 6) float32 over the place along the strand and its tone in [−1, 1]: colour, and the absorption beyond
    ``base``, that of the tables, in 1/radius (0 where there are none)."""
    tones = TONES_GREY if material.grey > 0 else TONES
    along, tone = np.meshgrid(np.linspace(0, 1, ALONG), np.linspace(-1, 1, tones), indexing="ij")
    colour, sigma = tint(material, roughness, along, tone)
    table = np.zeros((ALONG, tones, 6), np.float32)
    table[..., :3] = colour
    if base is not None:
        table[..., 3:] = sigma - base
    return table


def pack_lights(lights: tuple[Light, ...], maps: ShadowMaps | None, bounds: NDArray[np.float64]) -> NDArray[np.float32]:
    """(n, 16) float32 as in `kernels.shade_strands.strands`; lights that are dark are left out."""
    rows: list[list[Any]] = []
    traced = 0
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
        layers = maps.layers[first] if count and maps is not None else 0
        if count and maps is not None and bias == 0 and layers == 0:
            # an opacity map needs none: what a strand adds in front of itself is made up for by what is left out
            bias = default_bias(maps.views[first], bounds)
        power = np.array(light.colour) * light.intensity
        kind = float(not isinstance(light, DirectionalLight))
        traced += is_traced(light)
        number = traced if is_traced(light) else 0
        width, over = (maps.thickness.mean, maps.over) if maps is not None else (0.0, 0.0)
        rows.append([kind, *where, *power, first, count, bias, layers, number, _size(light), width, over, 0.0])
    return np.array(rows, np.float32).reshape(-1, 16)


def _size(light: Light) -> float:
    """Sine of the angular radius of a light that is far away, radius in metres of one that is near."""
    return math.sin(math.radians(light.size / 2)) if isinstance(light, DirectionalLight) else light.size / 2
