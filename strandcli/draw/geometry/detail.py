"""Level of detail: the fraction k of strands that are drawn, by distance, and the factor of their width.

Strands are ranked in the order in which they are emitted, of which every prefix covers the emitter evenly. A strand is
drawn if its rank, divided by the number of strands, is less than the fraction k at its root's distance; so a strand
drawn at some fraction is drawn at every greater one. Between k and k + b, where b is `BAND` times k but at least one
strand, it fades from 1 to 0, so that no strand appears or disappears at once however the camera moves. All strands with
this k are wider by 1 / ∫ fade, so that they cover as much as all strands would.

k is near / distance: a strand that is one pixel wide at the distance `near` is k pixels wide farther away, and 1 / k
times that is a pixel again.
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
"""Width of the band in which strands fade, as a fraction of k."""


@dataclass(frozen=True)
class Level:
    """Level of detail of the strands of a frame."""

    fade: NDArray[np.float32]
    """(strands,) 0 … 1; 0: the strand is not drawn, 1: it is drawn whole."""
    scale: NDArray[np.float32]
    """(strands,) factor of each strand's width."""
    share: float
    """Sum of `fade` over the number of all strands."""


def all_drawn(widths: NDArray[np.float32]) -> Level:
    """Return the level at which all strands are drawn whole, with these factors of their widths (strands,)."""
    import numpy as np

    return Level(np.ones(len(widths), np.float32), widths, 1.0)


def near_of(scene: Scene, time: float) -> tuple[float, bool]:
    """Return the distance from the camera up to which every strand is drawn, metres, and True; or k and False for an
    orthographic camera, under which width on the screen does not depend on distance.

    The distance is infinite for lines without a width, which are one pixel wide at any distance."""
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
    """Return the fraction k of strands that are drawn at a distance from the camera, metres."""
    if scene.detail is None:
        return 1.0
    near, by_distance = near_of(scene, time)
    return min(max(near / max(distance, 1e-30) if by_distance else near, scene.detail.fraction), 1.0)


def share_bounds(scene: Scene, time: float) -> tuple[float, float]:
    """Return a lower and an upper bound of k over all roots at a time, seconds."""
    eye, shape = camera_at(scene.camera, time)[0], scene.emitter.shape
    radius = math.hypot(shape.width, shape.depth) / 2 if isinstance(shape, PlaneShape) else shape.radius
    carried = any(use.name == "emitter_motion" for use in scene.rules)
    centre = emitter_pose(scene.emitter, max(time, 0.0) if carried else 0.0).translation
    away = math.dist(eye, centre)
    return share_at(scene, time, away + radius), share_at(scene, time, away - radius)


def strands_needed(scene: Scene, time: float) -> int:
    """Return the number of strands, from the first, that a picture at a time, seconds, can show."""
    total = scene.drawn_strands
    k = share_bounds(scene, time)[1]
    return min(max(math.ceil(total * (k + fade_band(k, total)) - 0.5), 1), total)


def fade_band(k: float, total: int) -> float:
    """Return the width of the band of ranks, of all 1, in which strands fade."""
    return max(BAND * k, 1.0 / total)


def level_of(
    scene: Scene, time: float, positions: NDArray[np.float32], strands: int, ids: NDArray[np.int32] | None, thin: bool
) -> Level | None:
    """Return the level of detail of the first ``strands`` of positions (blocks, n + 1, 3 W), metres; None: all strands
    are drawn.

    ``ids`` (strands,): ranks in the order of emission, None: 0, 1, …; ``thin``: whether strands that fade become
    thinner instead of shorter. Lines without a width are not widened.
    """
    import numpy as np

    from .kernels import detail as kernel

    if scene.detail is None or share_bounds(scene, time)[0] >= 1:
        return None
    near, by_distance = near_of(scene, time)
    total = scene.drawn_strands
    eye = np.array(camera_at(scene.camera, time)[0] if by_distance else (), np.float64)
    ranks = np.zeros(0, np.int32) if ids is None else ids
    fade, scale = np.empty(strands, np.float32), np.empty(strands, np.float32)
    kernel.fade_by_distance(positions, ranks, total, eye, near, scene.detail.fraction, BAND, fade, scale)
    if not scene.detail.widen or scene.material.width == 0:
        scale.fill(1)
    if thin:
        scale *= fade
    return Level(fade, scale, float(fade.sum(dtype=np.float64)) / total)
