"""`minmax`: the source's map, nearest and farthest strand a texel (see `strandcli.draw.shadows.kernels.minmax`)."""

from __future__ import annotations

from collections.abc import Callable

from ..shadow_model import Settings, ShadowModel

SIZES = (32, 64, 128, 256, 512, 1024)


class MinMax(ShadowModel):
    """A map without layers."""

    name = "minmax"
    side = 512
    thins = False

    def casts_map(self, counted: bool) -> bool:
        """Always."""
        return True

    def study(self, path: str, spacing: Callable[[], float]) -> list[Settings]:
        """Coarse to fine."""
        return [{f"{path}.model": self.name, f"{path}.size": size} for size in SIZES]


DRIVER = MinMax()
