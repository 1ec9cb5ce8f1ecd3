"""Which shadow maps a scene needs. Imports neither numpy nor numba."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .shadow_model import casts_map, shades_vertices, shines

if TYPE_CHECKING:
    from ...scene.model import Light, Scene


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
