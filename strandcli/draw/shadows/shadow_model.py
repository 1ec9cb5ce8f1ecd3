"""What a shadow model is. Imports neither numpy nor numba: presets are checked and planned without them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ...registry import SHADOWS

if TYPE_CHECKING:
    from .vertex_shadows import StrandsInLight, VertexShadows

Settings = dict[str, Any]


class ShadowModel:
    """A way to find what strands leave of a light. Derive from it, and override what differs.

    A model shades by a map (`casts_map`), which the shading kernels read at vertices of strands and at points of
    solids; or vertex by vertex (`shades_vertices`), with code of its own. It may do both: then the map shades solids,
    and counts strands for dual scattering and for the layer `shadow`, while strands have what the model says of their
    vertices.

    It may have an attribute ``Parameters``, a frozen dataclass made of the helpers of `strandcli.scene.fields`: its own
    settings, which presets write under `shadow.parameters`.
    """

    name = ""
    """What a preset writes."""
    side = 1024
    """Texels along a side of its maps, where a preset gives none; of maps with layers, at most."""
    shades_vertices = False
    """Whether `vertex_shadows` is asked what strands leave of a light at their vertices."""
    thins = True
    """Whether a thinner strand has a thinner shadow, so that strands which fade may become thinner."""
    blurs = True
    """Whether it tells the mean over some distances between strands, and not the shadow of each strand."""

    def casts_map(self, counted: bool) -> bool:
        """Whether a light has shadow maps; counted: whether anything but light on strands reads them: solids, dual
        scattering, or the layer `shadow`."""
        return False

    def side_of(self, shadow: Any) -> int:
        """Texels along a side of a light's maps; of maps with layers, at most."""
        return int(shadow.size or self.side)

    def layers(self, shadow: Any) -> int:
        """Layers of an opacity map, by the settings of one light (`strandcli.scene.model.Shadow`); 0: a min/max map."""
        return 0

    def vertex_shadows(self, light: Any, strands: StrandsInLight) -> VertexShadows:
        """The shadows of all strands in one light, for one exposure."""
        raise NotImplementedError(f"shadow model {self.name!r} has no vertex_shadows")

    def stage(self, lights: int) -> tuple[str, str] | None:
        """Name of its stage and what it does there, for `strandcli plan`, in so many lights; None: no stage but that
        of the maps."""
        return None

    def map_bytes(self, shadow: Any, directional: bool) -> int:
        """Bytes of the maps of one light; a light that is not directional has six."""
        side, layers = self.side_of(shadow), self.layers(shadow)
        # of a cell's numbers a quarter, where strands are: no box takes more than 1 / √3 of what the ball about it does
        # of a map
        cell = 4 * (2 + 5 * (layers + 1)) / 4 * (0.6 if directional else 1)
        return int((4 + cell if layers else 8) * side**2) * (1 if directional else 6)

    def vertex_bytes(self, vertices: int) -> int:
        """Bytes that `vertex_shadows` of one light takes, of strands of so many vertices."""
        return 0

    def study(self, path: str, spacing: Callable[[], float]) -> list[Settings]:
        """Settings that `strandcli study --axis shadow` tries, by path; path: of the light's `shadow`; spacing: tells
        metres between strands."""
        return [{f"{path}.model": self.name}]


def model_of(light: Any) -> Any:
    """The shadow model of a light."""
    return SHADOWS[light.shadow.model]


def shines(light: Any) -> bool:
    """Whether a light is not dark."""
    return bool(light.intensity > 0 and any(light.colour))


def casts_map(light: Any, counted: bool = True) -> bool:
    """Whether a light has a shadow map; one that is dark needs none. counted: see `ShadowModel.casts_map`."""
    return shines(light) and bool(model_of(light).casts_map(counted))


def counts_strands(light: Any) -> bool:
    """Whether a light may have maps that count strands, as dual scattering needs."""
    return casts_map(light) and bool(model_of(light).layers(light.shadow) > 0)


def shades_vertices(light: Any) -> bool:
    """Whether a light's model tells the strands' shadows on strands vertex by vertex."""
    return shines(light) and bool(model_of(light).shades_vertices)
