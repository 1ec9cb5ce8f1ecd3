"""`nearby`: the nearest strands exactly, the rest by an opacity map (see `strandcli.draw.shadows.nearby`)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ....constants import GRID_BYTES
from ....counted import counted
from .traced import Traced

if TYPE_CHECKING:
    from ..vertex_shadows import StrandsInLight, VertexShadows


class Nearby(Traced):
    """Exact shadows among strands that a light reaches; opacity maps for all others."""

    name = "nearby"
    shown_seconds, listed_seconds = 450e-9, 260e-9  # fewer lines a strand; depths of all vertices, lists of fewer

    def casts_map(self, counted: bool) -> bool:
        """Always."""
        return True

    def vertex_shadows(self, light: Any, strands: StrandsInLight) -> VertexShadows:
        """A grid over the light's view that lists the strands that light reaches, and what the map leaves of it."""
        from ..nearby import nearby_of

        return nearby_of(light, strands)

    def stage(self, lights: int) -> tuple[str, str] | None:
        """What is done, and the memory of the lists."""
        return "nearby shadows", (
            f"strands that light reaches against each other in {counted(lights, 'light')}; "
            f"lists of about {GRID_BYTES / 1e6:,.0f} MB a light at most"
        )

    def vertex_bytes(self, vertices: int) -> int:
        """At most those of `traced`, and the depths of all vertices."""
        return super().vertex_bytes(vertices) + 5 * vertices


DRIVER = Nearby()
