"""Which strands a picture needs: those that the camera sees, and those that may shade what it sees.

The box of a strand's particles is tested against the sides of the camera's view, and so is what it covers on its way
along a light: down to a plane that hides what is below it, and up to where strands end, for the layers of an opacity
map depend on the strands behind a place too. Others are not drawn, and no pixel differs: bounding box, ambient
occlusion and the distance between strands are of them all, and so is the sketch of a map (`deep_strands`).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..constants import W
from ..scene.model import DirectionalLight, PlaneSolid
from ..solids import pack_all
from .geometry.extent import extents_of
from .geometry.kernels.bounds import mark_inside
from .geometry.kernels.curves import longest_segment
from .lighting.kernels.mirror import DULL
from .shadows.kernels.filter_window import WIDEST
from .shadows.shadow_model import casts_map, model_of, shades_vertices
from .shadows.strands_in_map import chances_of, mark_sketched
from .solids.solids import rows_of
from .view.camera import corners_of
from .view.lens import is_sampled

if TYPE_CHECKING:
    from ..scene.model import Scene
    from .geometry.extent import Extents
    from .shadows.shadow import ShadowMaps
    from .strand_batches import Strands
    from .view.camera import View

AROUND = 16.0
"""Pixels about the picture that it may look at, of what is filtered."""
TEXELS = 7.0
"""Texels between a place and strands that change what a map tells there: 4.5 along each axis, for interpolation between
cells, the other texel of a cell, and strands that are divided between two texels."""
BLUR = 1.35
"""Radius of a filter over that of a light's blur, at the most."""
WORTH = 0.02
"""Part of the strands that must be left out, or none are."""
NO_FLOORS = np.zeros((0, 4), np.float32)
STILL = np.zeros(3, np.float32)


def can_leave_out(scene: Scene) -> bool:
    """Return whether pictures of a scene do not depend on strands that are not seen and shade nothing that is: seen
    through a pinhole, sorted, with opacity maps of directional lights alone, and no solid that mirrors others."""
    camera, curves = scene.camera, scene.curves
    if camera.kind != "perspective" or is_sampled(camera) or scene.image.resolver != "sorted" or scene.image.aovs:
        return False
    if curves.mode not in ("adaptive", "thinned") or any(shades_vertices(light) for light in scene.lights):
        return False
    if any(solid.visible and solid.coat > 0 and solid.roughness < DULL for solid in scene.solids):
        return False
    return all(
        isinstance(light, DirectionalLight) and model_of(light).layers(light.shadow) > 0
        for light in scene.lights if casts_map(light)
    )  # fmt: skip


def needed_strands(
    scene: Scene, at: float, strands: Strands, extents: Extents | None, bounds: NDArray[np.float64], view: View,
    maps: ShadowMaps | None,
) -> NDArray[np.float32] | None:  # fmt: skip
    """Return the fade (count,) of strands at a time in seconds, 0 for those that are not needed; None: all are whole.

    extents: from `extents_of`, if they are known; bounds (2, 3): box of all strands, metres; view: the camera's; maps:
    those of the lights, still empty.
    """
    fade = strands.fade
    sides = _sides(view, AROUND * scene.image.supersample)
    if (corners_of(bounds) @ sides[:, :3].T + sides[:, 3]).min() >= 0:
        return fade
    low, high = extents_of(strands.positions) if extents is None else extents
    scale = 1.0 if strands.level is None else float(strands.level.scale.max())
    segment = float(longest_segment(strands.positions) if strands.lengths is None else strands.lengths.max())
    room = scene.material.width * scale + segment / 3 + 1e-5 * float(np.abs(bounds).max())  # curves leave their chords
    lit = segment * (strands.positions.shape[1] - 2 if scene.curves.mode == "thinned" else 1)
    marks = np.zeros((len(strands.positions), W), np.uint8)
    packed_sides = sides.astype(np.float32)

    def mark(along: NDArray[np.float32], floors: NDArray[np.float32], room: float) -> None:
        mark_inside(low, high, packed_sides, along, floors, np.float32(room), marks)

    if maps is None:
        mark(STILL, NO_FLOORS, room)
    else:
        for number, wide in _lights(scene, maps):
            along = maps.views[number].forward.astype(np.float32)
            mark(along, _grounds(scene, at, view.eye), room + lit + wide)
            mark(-along, _ends(bounds), room + lit + wide)
    needed = marks.reshape(-1)[: strands.count].astype(bool)
    if maps is not None:
        mark_sketched(chances_of(strands.ids, strands.count), needed)
    if np.count_nonzero(needed) > (1 - WORTH) * strands.count:
        return fade
    return needed.astype(np.float32) if fade is None else np.where(needed, fade, np.float32(0))


def _sides(view: View, around: float) -> NDArray[np.float64]:
    """Return the sides (5, 4) of what a perspective view shows, and so many samples about it: inward unit normals, and
    offsets in metres."""
    x, y = view.middle
    right, up, forward = view.focal * view.right, view.focal * view.up, view.forward
    normals = np.stack([
        right + (x + around) * forward, (view.width - x + around) * forward - right,
        (view.height - y + around) * forward + up, (y + around) * forward - up, forward,
    ])  # fmt: skip
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return np.column_stack([normals, -normals @ view.eye])


def _lights(scene: Scene, maps: ShadowMaps) -> list[tuple[int, float]]:
    """Return the number of each map, and how far from a strand it may shade a point, metres, across the light."""
    found = []
    for light, (number, count) in zip(scene.lights, maps.owners, strict=True):
        if count:
            assert isinstance(light, DirectionalLight)
            view = maps.views[number]
            blur = BLUR * math.sin(math.radians(light.size / 2)) * (view.far - view.near)
            texel = 1 / view.focal
            found.append((number, TEXELS * texel + min(blur, float(WIDEST) * texel) * math.sqrt(2)))
    return found


def _grounds(scene: Scene, at: float, eye: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return the planes (F, 4) of visible solids that hide from the eye what is below them."""
    planes = [solid for solid in scene.solids if isinstance(solid, PlaneSolid) and solid.visible and solid.fade == 0]
    rows = [row for _, row in rows_of(pack_all(planes, scene.emitter, at))] if planes else []
    above = [[*row[:3], -row[3]] for row in rows if row[:3] @ eye > row[3]]
    return np.array(above, np.float32).reshape(-1, 4)


def _ends(bounds: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return the sides (6, 4) of a box: inward unit normals, and offsets in metres."""
    inward = np.concatenate([np.eye(3), -np.eye(3)])
    offsets = np.concatenate([-bounds[0], bounds[1]])
    return np.column_stack([inward, offsets]).astype(np.float32)
