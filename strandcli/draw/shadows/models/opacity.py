"""`opacity`: deep opacity maps (see `strandcli.draw.shadows.kernels.opacity`)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..shadow_model import Settings, ShadowModel
from .minmax import SIZES

FINEST = 4096
"""Texels along a side that a map may have where the side of a texel is studied."""


class Opacity(ShadowModel):
    """A map with layers."""

    name = "opacity"

    def casts_map(self, counted: bool) -> bool:
        """Always."""
        return True

    def layers(self, shadow: Any) -> int:
        """As the preset has them."""
        return int(shadow.layers)

    def study(self, path: str, spacing: Callable[[], float]) -> list[Settings]:
        """Coarse to fine; few layers to many; texels by how far strands lie apart."""
        deep = {f"{path}.model": self.name}
        out: list[Settings] = [{**deep, f"{path}.size": size} for size in SIZES]
        out += [{**deep, f"{path}.layers": layers} for layers in (1, 3, 5, 29)]
        apart = spacing()
        sides = [float(f"{times * apart:.3g}") for times in (0.25, 0.5, 1, 2, 4, 8) if apart > 0]
        return out + [{**deep, f"{path}.size": FINEST, f"{path}.texel": side} for side in sides]


DRIVER = Opacity()
