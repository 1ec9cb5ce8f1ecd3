"""What shading reads of a material: the tables of its fibre model, its colours, and those of dual scattering."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...registry import FIBRES
from ...scene.model import Material
from ..fibre import dual
from ..fibre.pigment import colour_of, tint, varies

ALONG = 17
TONES, TONES_GREY = 9, 65
"""Nodes over the tone: with grey strands enough that few are in between."""


class Palette:
    """What the shading kernels read of a material; what a scene does not need is None."""

    def __init__(self, material: Material, counts: bool = False) -> None:
        """``counts``: whether any light has an opacity map, without which dual scattering has nothing to count."""
        model = FIBRES[material.model]
        tables = model.tables(material)
        self._columns = getattr(model, "columns", None)
        self._material = material
        self.use(tables)
        self.diffuse = np.float32(material.diffuse)
        roughness = model.roughness(material) if hasattr(model, "roughness") else material.beta_n
        self.colour = colour_of(material, roughness).astype(np.float32)
        self.dual = dual.build_tables(material, roughness) if counts and material.scatter == "dual" else None
        self.loss = None if self.dual is None else dual.loss_table(self.dual)
        """Light that strands keep from solids behind them."""
        base = getattr(tables, "absorption", None)
        self.tint = tint_table(material, roughness, base) if varies(material) else None

    @cached_property
    def columns(self) -> NDArray[np.float32] | None:
        """Tables over a strand's width, made when the first strand is wide."""
        found: NDArray[np.float32] | None = None if self._columns is None else self._columns(self._material)
        return found

    def use(self, tables: Any) -> None:
        """Shade with these tables of a fibre model, or their arrays alone; None: no highlights."""
        self.arrays = getattr(tables, "arrays", tables)


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
