"""Which shadow maps a scene needs. Imports neither numpy nor numba."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ...scene.model import Light, Scene


def shining(scene: Scene) -> list[Light]:
    """The lights that are not dark."""
    return [light for light in scene.lights if light.intensity > 0 and any(light.colour)]


def needs_shadow_maps(scene: Scene) -> bool:
    """Whether any light has a shadow map."""
    return any(light.shadow.model != "off" for light in shining(scene))


def needs_counts(scene: Scene) -> bool:
    """Whether lights with exact shadows have opacity maps beside them: for solids, and for what counts strands."""
    solid = any(solid.visible for solid in scene.solids)
    return solid or scene.material.scatter == "dual" or "shadow" in scene.image.aovs
