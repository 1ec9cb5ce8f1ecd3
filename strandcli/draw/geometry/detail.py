"""Level of detail: which share of the strands is drawn, by their distance, and how much wider.

Strands have an order chosen once, that in which they are emitted: every prefix of it covers the emitter evenly. A
strand whose root is so far away that the share k is kept is drawn if its place in that order, in (0, 1), is less than
k: one that is kept at some share is kept at every greater one. Between k and k + b, `BAND` of k but never less than one
strand, it fades from whole to nothing, so that no strand comes or goes at once however the camera moves; and the width
of all that have this k grows by 1 / ∫ fade, so that they cover what all of them would.

k is near / distance: a strand as wide as a pixel at `near` is near / distance pixels wide further out, and 1 / k times
that is a pixel again.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...scene.model import PlaneShape
from ...scene.motion import camera_at, emitter_pose

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ...scene.model import Scene

BAND = 0.1


@dataclass(frozen=True)
class Level:
    """What is drawn of each strand of a frame."""

    fade: NDArray[np.float32]
    """(strands,) 0 … 1: what is there of a strand; none of those with 0 is drawn."""
    scale: NDArray[np.float32]
    """(strands,) factor of its width."""
    share: float
    """Strands that are drawn, faded ones in part, over all."""


def whole_of(widths: NDArray[np.float32]) -> Level:
    """All of strands whose widths have these factors (strands,)."""
    import numpy as np

    return Level(np.ones(len(widths), np.float32), widths, 1.0)


def near_of(scene: Scene, time: float) -> tuple[float, bool]:
    """Distance from the camera up to which every strand is drawn, metres, and whether distance counts at all: under an
    orthographic camera the width of strands on the screen does not depend on it, and the first is k itself. Lines
    without a width are as wide far away as near, and are all drawn."""
    detail, camera = scene.detail, scene.camera
    assert detail is not None
    if detail.near is not None:
        return detail.near, True
    if scene.material.width == 0:
        return math.inf, False
    _, _, fov, tall = camera_at(camera, time)
    samples = scene.image.size[1] * scene.image.supersample
    by_distance = camera.kind == "perspective"
    focal = samples / 2 / math.tan(math.radians(fov) / 2) if by_distance else samples / tall
    return scene.material.width * focal / detail.pixels, by_distance


def share_at(scene: Scene, time: float, distance: float) -> float:
    """k: the share of strands kept so many metres from the camera."""
    if scene.detail is None:
        return 1.0
    near, by_distance = near_of(scene, time)
    return min(max(near / max(distance, 1e-30) if by_distance else near, scene.detail.fraction), 1.0)


def shares(scene: Scene, time: float) -> tuple[float, float]:
    """Bounds of k over all roots at a time: of those farthest away, and of the nearest."""
    eye, shape = camera_at(scene.camera, time)[0], scene.emitter.shape
    radius = math.hypot(shape.width, shape.depth) / 2 if isinstance(shape, PlaneShape) else shape.radius
    carried = any(use.name == "emitter_motion" for use in scene.rules)
    centre = emitter_pose(scene.emitter, max(time, 0.0) if carried else 0.0).translation
    away = math.dist(eye, centre)
    return share_at(scene, time, away + radius), share_at(scene, time, away - radius)


def needed(scene: Scene, time: float) -> int:
    """How many strands, from the first, a picture at a time can show: a little more than the greatest share."""
    total = scene.drawn_strands
    k = shares(scene, time)[1]
    return min(max(math.ceil(total * (k + band(k, total)) - 0.5), 1), total)


def band(k: float, total: int) -> float:
    """Width of the band of places in which strands fade."""
    return max(BAND * k, 1.0 / total)


def level_of(
    scene: Scene, time: float, positions: NDArray[np.float32], strands: int, ids: NDArray[np.int32] | None, thin: bool
) -> Level | None:
    """What is drawn of the first ``strands`` of positions (blocks, n + 1, 3 W); None where it is all of them.

    ``ids``: places in the groom, where they are not 0, 1, …; ``thin``: strands that fade become thinner, and not
    shorter. Strands without a width of their own are not widened.
    """
    import numpy as np

    from .kernels import detail as kernel

    if scene.detail is None or shares(scene, time)[0] >= 1:
        return None
    near, by_distance = near_of(scene, time)
    total = scene.drawn_strands
    eye = np.array(camera_at(scene.camera, time)[0] if by_distance else (), np.float64)
    places = np.zeros(0, np.int32) if ids is None else ids
    fade, scale = np.empty(strands, np.float32), np.empty(strands, np.float32)
    kernel.choose(positions, places, total, eye, near, scene.detail.fraction, BAND, fade, scale)
    if not scene.detail.widen or scene.material.width == 0:
        scale.fill(1)
    if thin:
        scale *= fade
    return Level(fade, scale, float(fade.sum(dtype=np.float64)) / total)
