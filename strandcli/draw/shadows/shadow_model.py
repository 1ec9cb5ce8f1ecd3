"""Base class of shadow models. Imports neither numpy nor numba: presets are checked and planned without them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ...common.registry import SHADOWS

if TYPE_CHECKING:
    from .vertex_shadows import StrandsInLight, VertexShadows
if TYPE_CHECKING:
    from ...scene.model import Light, Scene

Settings = dict[str, Any]


class ShadowModel:
    """A method that computes the shadows of strands in a light. Derive from it, and override what differs.

    A model uses a shadow map (`casts_map`), which the shading kernels read at vertices of strands and at points of
    solids, or computes the visibility of each vertex with its own code (`shades_vertices`). If it does both, the map
    serves solids, dual scattering and the layer `shadow`, and the model's own values serve strands.

    The optional attribute ``Parameters`` is a frozen dataclass made with the helpers of `strandcli.scene.fields`: the
    model's own settings, which presets write under `shadow.parameters`.
    """

    name = ""
    """The value of `shadow.model` in presets."""
    side = 1024
    """Default texels along a side of its maps; an upper limit for maps with layers."""
    shades_vertices = False
    """Whether `vertex_shadows` computes the visibility of lights at strand vertices."""
    thins = True
    """Whether the shadow of a thinner strand is thinner, so that level of detail may fade strands by their width."""

    def casts_map(self, counted: bool) -> bool:
        """Return whether a light has shadow maps; counted: whether solids, dual scattering or the layer `shadow` read
        them."""
        return False

    def side_of(self, shadow: Any) -> int:
        """Return the texels along a side of a light's maps; an upper limit for maps with layers."""
        return int(shadow.size or self.side)

    def layers(self, shadow: Any) -> int:
        """Return the layers of a light's opacity maps, 0 for min/max maps; shadow: a `strandcli.scene.model.Shadow`."""
        return 0

    def vertex_shadows(self, light: Any, strands: StrandsInLight) -> VertexShadows:
        """Return the shadows of all strands in one light, for one exposure."""
        raise NotImplementedError(f"shadow model {self.name!r} has no vertex_shadows")

    def stage(self, lights: int) -> tuple[str, str] | None:
        """Return name and description of the model's own stage for `strandcli plan`, or None; lights: number of lights
        that use the model."""
        return None

    def map_bytes(self, shadow: Any, directional: bool) -> int:
        """Return the bytes of one light's maps; a light that is not directional has six."""
        side, layers = self.side_of(shadow), self.layers(shadow)
        # a quarter of the cells contain strands; a box covers at most 1 / √3 of the map fitted to its bounding sphere
        cell = 4 * (6 + 4 * (layers + 1)) / 4 * (0.6 if directional else 1)
        return int((4 + cell if layers else 8) * side**2) * (1 if directional else 6)

    def vertex_bytes(self, vertices: int) -> int:
        """Return the bytes that `vertex_shadows` of one light takes for so many strand vertices."""
        return 0

    def study(self, path: str, spacing: Callable[[], float]) -> list[Settings]:
        """Return the variants that `strandcli study --axis shadow` compares, as settings by path; path: path of the
        light's `shadow`; spacing: returns the distance between strands, metres."""
        return [{f"{path}.model": self.name}]


def model_of(light: Any) -> Any:
    """Return the shadow model of a light."""
    return SHADOWS[light.shadow.model]


def shines(light: Any) -> bool:
    """Return whether a light emits any light."""
    return bool(light.intensity > 0 and any(light.colour))


def casts_map(light: Any, counted: bool = True) -> bool:
    """Return whether a light emits light and has shadow maps; counted: see `ShadowModel.casts_map`."""
    return shines(light) and bool(model_of(light).casts_map(counted))


def counts_strands(light: Any) -> bool:
    """Return whether a light may have opacity maps, which dual scattering needs."""
    return casts_map(light) and bool(model_of(light).layers(light.shadow) > 0)


def shades_vertices(light: Any) -> bool:
    """Return whether a light's model computes visibility at strand vertices itself."""
    return shines(light) and bool(model_of(light).shades_vertices)


def shining(scene: Scene) -> list[Light]:
    """The lights that are not dark."""
    return [light for light in scene.lights if shines(light)]


def needs_shadow_maps(scene: Scene) -> bool:
    """Whether any light's shadow model asks for strands: for maps, or to shade vertices."""
    return any(casts_map(light) or shades_vertices(light) for light in scene.lights)


def needs_counts(scene: Scene) -> bool:
    """Whether visible solids, dual scattering or the layer `shadow` read shadow maps."""
    solid = any(solid.visible for solid in scene.solids)
    return solid or scene.material.scatter == "dual" or "shadow" in scene.image.aovs
