"""Tables of a material for shading: of its fibre model, its colours, and dual scattering."""

from __future__ import annotations

from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.registry import FIBRES
from ...scene.model import Material
from ..fibre import dual
from ..fibre.pigment import absorption, colour_of, tint, varies

ALONG = 17
TONES, TONES_GREY = 9, 65
"""Nodes over the tone, without and with grey strands, whose colours must hardly be interpolated with the rest."""
MOST = 0.92
"""Greatest part of a strand's colour that its shade makes paler."""


class Palette:
    """Tables of a material for the shading kernels; those that a scene does not need are None."""

    def __init__(
        self, material: Material, counts: bool = False, colours: NDArray[np.float32] | None = None, shades: int = 1
    ) -> None:  # fmt: skip
        """``counts``: whether any light has an opacity map, which dual scattering needs; ``colours``: linear, those of
        strands at tones −1 to 1, in place of the material's: (k, 3), in so many ``shades`` each, or (A, k, 3) from root
        to tip."""
        model = FIBRES[material.model]
        own = material.parameters is not None  # a model from elsewhere, with settings that may have no hash
        tables = model.tables(material) if own else _tables_of(model, material)
        self._columns = getattr(model, "columns", None)
        self._material = material
        self.use(tables)
        self.diffuse = np.float32(material.diffuse)
        roughness = model.roughness(material) if hasattr(model, "roughness") else material.beta_n
        self.colour = colour_of(material, roughness).astype(np.float32)
        self.dual: dual.kernel.DualArrays | None = None
        self.loss: NDArray[np.float32] | None = None
        """Of light behind strands, for the shadows on solids."""
        if counts and material.scatter == "dual":
            self.dual, self.loss = (_scattered.__wrapped__ if own else _scattered)(material, roughness)
        base = getattr(tables, "absorption", None)
        self.tint = tint_table(material, roughness, base) if varies(material) else None
        if colours is not None:
            rows = colours.astype(np.float64) if shades == 1 else shaded(colours.astype(np.float64), shades, material)
            self.tint = colour_table(rows, roughness, base)

    @cached_property
    def columns(self) -> NDArray[np.float32] | None:
        """Tables over a strand's width, built when the first wide strand is shaded."""
        found: NDArray[np.float32] | None = None if self._columns is None else self._columns(self._material)
        return found

    def use(self, tables: Any) -> None:
        """Set the tables of the fibre model, or their arrays alone; None: no highlights."""
        self.arrays = getattr(tables, "arrays", tables)


# a process that draws a preset again and again, or panels, has mostly one material: a twentieth of a second
@lru_cache(maxsize=1)
def _tables_of(model: Any, material: Material) -> Any:
    return model.tables(material)


@lru_cache(maxsize=1)
def _scattered(material: Material, roughness: float) -> tuple[dual.kernel.DualArrays, NDArray[np.float32]]:
    tables = dual.build_tables(material, roughness)
    return tables, dual.loss_table(tables)


def tint_table(material: Material, roughness: float, base: NDArray[np.float64] | None) -> NDArray[np.float32]:
    """Return a table (ALONG, n, 6) float32 over the position along the strand, 0 to 1, and its tone in [−1, 1]: colour,
    and absorption minus ``base``, that of the fibre model's tables, 1/radius (0 without tables)."""
    tones = TONES_GREY if material.grey > 0 else TONES
    along, tone = np.meshgrid(np.linspace(0, 1, ALONG), np.linspace(-1, 1, tones), indexing="ij")
    colour, sigma = tint(material, roughness, along, tone)
    table = np.zeros((ALONG, tones, 6), np.float32)
    table[..., :3] = colour
    if base is not None:
        table[..., 3:] = sigma - base
    return table


def shaded(colours: NDArray[np.float64], shades: int, material: Material) -> NDArray[np.float64]:
    """Return colours (ALONG, k * shades, 3) of colours (k, 3): each as many times, dark to pale by the material's
    variation, and toward the tip as its colour is."""
    tones = (np.arange(shades) + 0.5) * (2 / shades) - 1
    spread = np.exp(np.log1p(material.colour_variation) * tones)
    rows = (colours[:, None] * spread[:, None]).reshape(1, -1, 3)
    if material.tip_colour is not None:
        change = np.array(material.tip_colour) / np.maximum(material.colour, 1e-4)
        rows = rows * (1 + np.linspace(0, 1, ALONG)[:, None, None] * (change - 1))
    rows = rows * np.minimum(
        MOST / np.maximum(rows.max(axis=-1, keepdims=True), MOST), 1
    )  # paler, but not of another hue
    return np.asarray(np.broadcast_to(rows, (ALONG, rows.shape[1], 3)))


def colour_table(
    colours: NDArray[np.float64], roughness: float, base: NDArray[np.float64] | None
) -> NDArray[np.float32]:
    """Return a table (A, k, 6) float32 as `tint_table` does, of strands that each have one of some colours: (k, 3), or
    (A, k, 3) where they change along the strand."""
    table = np.zeros((len(colours) if colours.ndim > 2 else 2, colours.shape[-2], 6), np.float32)
    table[..., :3] = colours
    if base is not None:
        table[..., 3:] = absorption(colours, roughness) - base
    return table
