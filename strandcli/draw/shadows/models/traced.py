"""`traced`: every strand against all others (see `strandcli.draw.shadows.traced`)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ....constants import GRID_BYTES, GRID_SIDE
from ....counted import counted
from ..shadow_model import ShadowModel

if TYPE_CHECKING:
    from ..vertex_shadows import StrandsInLight, VertexShadows


class Traced(ShadowModel):
    """Exact shadows on strands; opacity maps beside them for solids and for all that counts strands."""

    name = "traced"
    shades_vertices = True
    blurs = False

    def casts_map(self, counted: bool) -> bool:
        """Whether anything reads the number of strands before a point."""
        return counted

    def layers(self, shadow: Any) -> int:
        """As the preset has them."""
        return int(shadow.layers)

    def vertex_shadows(self, light: Any, strands: StrandsInLight) -> VertexShadows:
        """A grid over the light's view that lists the strands in its cells."""
        from ..traced import grid_of

        return grid_of(
            light, strands.lines, strands.thickness, strands.opacity, strands.bounds, strands.workers, strands.scratch,
            strands.number,
        )  # fmt: skip

    def stage(self, lights: int) -> tuple[str, str] | None:
        """What is done, and the memory of the lists."""
        return "exact shadows", (
            f"every strand against all others in {counted(lights, 'light')}; "
            f"lists of about {GRID_BYTES / 1e6:,.0f} MB a light at most"
        )

    def vertex_bytes(self, vertices: int) -> int:
        """The lists, where they begin, and the strands as the light sees them; some three cells a piece is usual, and
        one the least."""
        return max(min(105 * vertices, GRID_BYTES), 40 * vertices) + 8 * min(GRID_SIDE**2, 2 * vertices) + 45 * vertices


DRIVER = Traced()
