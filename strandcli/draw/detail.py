"""Level of detail by distance (thesis §3): how many strands are drawn, and how much wider."""

from __future__ import annotations

import math
from typing import Any

from ..scene.motion import camera_at, emitter_pose


def drawn_fraction(scene: Any, time: float) -> tuple[float, float]:
    """The share of strands that is drawn at a time, and the factor by which their width grows.

    A strand as wide as a pixel at `near` is near / distance pixels wide further out. That share of the strands, each
    drawn 1 / share as wide, covers the same area with lines that are still a pixel wide. Strands are kept in their own
    order, every prefix of which covers the emitter evenly, so a strand once kept stays at every larger share.
    """
    detail = scene.detail
    if detail is None:
        return 1.0, 1.0
    share = min(max(detail.near / max(distance(scene, time), 1e-30), detail.fraction), 1.0)
    return share, 1.0 / share if detail.widen else 1.0


def distance(scene: Any, time: float) -> float:
    """From the camera to the emitter's centre, metres."""
    eye = camera_at(scene.camera, time)[0]
    return math.dist(eye, emitter_pose(scene.emitter, max(time, 0.0))[1])
