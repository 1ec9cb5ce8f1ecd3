"""Level of detail as a scene alone tells it: which share of the strands is drawn at a distance, and how many strands a
frame can show. `strandcli.draw.geometry.detail` says what the share means."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..constants import W
from .model import MeshShape, PlaneShape
from .motion import apply, camera_at, emitter_pose
from .rule_type import MUTUAL

if TYPE_CHECKING:
    from .model import DiscShape, Scene, SphereShape

BAND = 0.1
"""Width of the band in which strands fade, as a fraction of k."""

MOST_FRAMES = 10_000
"""That are looked at one by one, a tenth of a second."""
SPREAD = 32
"""Distances that a mean is taken over."""
GROWTH = 1.5
"""Of a tier's end to that of the one before."""
UNKNOWN = 1e15
"""Metres that a mesh may reach to, where that is not known: larger than any."""


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
    away, radius = _reach(scene, time)
    return share_at(scene, time, away + radius), share_at(scene, time, away - radius)


def mean_share(scene: Scene, time: float) -> float:
    """Return about what k is on average at a time, seconds, over roots at evenly spread distances from the camera."""
    away, radius = _reach(scene, time)
    if radius == UNKNOWN:
        return sum(share_bounds(scene, time)) / 2
    low, high = max(away - radius, 0.0), away + radius
    return sum(share_at(scene, time, low + (high - low) * (i + 0.5) / SPREAD) for i in range(SPREAD)) / SPREAD


def _reach(scene: Scene, time: float) -> tuple[float, float]:
    """Return how far the emitter is from the camera and the radius of a ball that holds its roots, metres."""
    eye, radius = camera_at(scene.camera, time)[0], _radius(scene.emitter.shape)
    carried = any(use.name == "emitter_motion" for use in scene.rules)
    pose, followers = emitter_pose(scene.emitter, max(time, 0.0) if carried else 0.0), scene.emitter.followers
    centre = pose.translation
    if followers is not None:
        radius, centre = followers.radius, apply(pose, followers.centre)
    return math.dist(eye, centre), radius


def _radius(shape: SphereShape | DiscShape | PlaneShape | MeshShape) -> float:
    """Return the radius of a ball about the emitter's origin that holds its surface, metres."""
    if isinstance(shape, PlaneShape):
        return math.hypot(shape.width, shape.depth) / 2
    if isinstance(shape, MeshShape):  # settings alone do not tell where a file has its mesh
        return UNKNOWN if shape.size is None or shape.place == "file" else 2 * shape.size
    return shape.radius


def strands_needed(scene: Scene, time: float) -> int:
    """Return the number of strands, from the first, that a picture at a time, seconds, can show."""
    total = scene.drawn_strands
    k = share_bounds(scene, time)[1]
    return min(max(math.ceil(total * (k + fade_band(k, total)) - 0.5), 1), total)


def most_needed(scene: Scene, frames: Sequence[int]) -> int:
    """Return the greatest of `strands_needed` in some frames; all strands, which are enough for any, where that is more
    than `MOST_FRAMES` to look at."""
    some = times_of(scene, frames)
    if not some or len(some) > MOST_FRAMES:
        return scene.drawn_strands
    return max(strands_needed(scene, time) for time in some)


def tiers(total: int) -> list[int]:
    """Return the ends of tiers, counted from the first strand: whole blocks, each up to half as many again as all
    before it, and all of so many strands."""
    ends, size = [], float(W)
    while size < total:
        ends.append(W * math.ceil(size / W))
        size *= GROWTH
    return [*dict.fromkeys(end for end in ends if end < total), total]


def tiers_of(scene: Scene) -> list[int]:
    """Return the tiers of a scene's strands, of which a frame takes the first few; all in one where strands are needed
    though they are not drawn: as guides, for a tie, or because they act on the rest."""
    apart = scene.detail is None or scene.children is not None or scene.emitter.followers is not None
    if apart or scene.emitter.tie is not None or any(use.name in MUTUAL for use in scene.rules):
        return [scene.emitter.strands]
    return tiers(scene.emitter.strands)


def needed_strands(scene: Scene, frames: Sequence[int]) -> int:
    """Return the number of strands of the tiers from which any of the frames is drawn; all strands of no frames. Others
    need not be emitted: how a strand moves does not depend on further tiers, and no picture on more than its own."""
    total = scene.emitter.strands
    ends = tiers_of(scene)
    if len(ends) == 1 or not frames:
        return total
    least = most_needed(scene, with_before(scene, frames))
    return next(end for end in ends if end >= least)


def with_before(scene: Scene, frames: Sequence[int]) -> list[int]:
    """Return frames, and where the shutter is open those before them: what moves is drawn between two."""
    before = 1 if scene.camera.shutter > 0 else 0
    return sorted({one for frame in frames for one in (frame, frame - before) if one > 0})


def times_of(scene: Scene, frames: Sequence[int]) -> list[float]:
    """Return the seconds of frames, numbered from 1, that differ for level of detail: of those after the last key only
    one."""
    last = max(0.0, *(key.time for key in scene.camera.keys), *(key.time for key in scene.emitter.keys), 0.0)
    still = 2 + math.ceil(last * scene.time.fps)
    return [(frame - 1) / scene.time.fps for frame in sorted({min(frame, still) for frame in frames})]


def fade_band(k: float, total: int) -> float:
    """Return the width of the band of ranks, of all 1, in which strands fade."""
    return max(BAND * k, 1.0 / total)
