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

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ...scene.detail import BAND, near_of, share_bounds
from ...scene.motion import camera_at

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ...groom.record import Widths
    from ...scene.model import Scene


@dataclass(frozen=True)
class Level:
    """Level of detail of the strands of a frame."""

    fade: NDArray[np.float32]
    """(strands,) 0 … 1; 0: the strand is not drawn, 1: it is drawn whole."""
    scale: NDArray[np.float32]
    """(strands,) factor of each strand's width."""
    share: float
    """Sum of `fade` over the number of all strands."""


def with_widths(level: Level | None, widths: Widths | None) -> Level | None:
    """Return the level of strands that have widths of their own besides; None where all are drawn whole and as wide as
    each other."""
    import numpy as np

    if widths is None:
        return level
    if level is None:
        return Level(np.ones(len(widths.scale), np.float32), widths.scale, 1.0)
    return replace(level, scale=level.scale * widths.scale)


def level_of(
    scene: Scene, time: float, positions: NDArray[np.float32], strands: int, ids: NDArray[np.int32] | None, thin: bool
) -> Level | None:
    """Return the level of detail of the first ``strands`` of positions (blocks, n + 1, 3 W), metres; None: all strands
    are drawn.

    ``ids`` (strands,): ranks in the order of emission, None: 0, 1, …; ``thin``: whether strands that fade become
    thinner instead of shorter. Lines without a width are not widened.
    """
    import numpy as np

    if scene.detail is None or share_bounds(scene, time)[0] >= 1:
        return None
    near, by_distance = near_of(scene, time)
    total = scene.drawn_strands
    k = np.full(strands, near)
    if by_distance:
        roots = positions[:, 1].reshape(len(positions), 3, -1).transpose(1, 0, 2).reshape(3, -1)[:, :strands]
        x, y, z = roots - np.array(camera_at(scene.camera, time)[0])[:, None]
        k /= np.maximum(np.sqrt(x * x + y * y + z * z), 1e-30)
    k = np.clip(k, scene.detail.fraction, 1.0)
    wide = np.maximum(BAND * k, 1.0 / total)
    rank = ((np.arange(strands) if ids is None else ids) + 0.5) / total
    fade = np.clip((k + wide - rank) / wide, 0.0, 1.0).astype(np.float32)
    beyond = np.maximum(k + wide - 1.0, 0.0)
    scale = (1.0 / (k + 0.5 * wide - 0.5 * beyond * beyond / wide)).astype(np.float32)
    if not scene.detail.widen or scene.material.width == 0:
        scale.fill(1)
    if thin:
        scale *= fade
    return Level(fade, scale, float(fade.sum(dtype=np.float64)) / total)
