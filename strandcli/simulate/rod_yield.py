"""Bending that keeps a set: beyond a strain, rest shapes follow the strand (perfect plasticity).

A joint's rest is a vector in the frame of the edge before it, as `kernels.rod_curl` reads it. Where the part of a bend
that is across that edge is further from its rest than the limit, the rest follows until it is at the limit: a strand
bent to a curvature springs back by that of the limit and no further. It happens between steps, and strands without it
are stepped as ever.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..constants import FOLD
from .kernels.rod_scratch import PACK
from .material import matter

if TYPE_CHECKING:
    from ..scene.model import Rod, Scene
    from ..scene.motion import Pose
    from .kernels.records import Forcing, Material, State

Floats = NDArray[np.floating]


class Yielding:
    """How far bends may be from their rest, ``limits`` (N, P, `PACK`)."""

    def __init__(self, rod: Rod, material: Material, segments: int) -> None:
        """Of rods with the limit ``rod.yield_strain``, which is radius times curvature."""
        radius = matter(rod)[1] * (1 + (rod.tip - 1) * np.arange(segments) / segments)
        reach = np.ones(segments)  # segments whose curvature is a joint's: half of the first one is the root's
        reach[0] = 0.5
        self.limits = (rod.yield_strain or 0.0) * (reach / radius)[:, None, None] * material.lengths

    def follow(self, state: State, material: Material, forcing: Forcing, pose: Pose) -> bool:
        """Have rest shapes follow the strands as they are, with the emitter in a pose. Return whether some change."""
        # t: edge before the joint; a, b: axes across it, carried along the strand as by `kernels.rod_curl`, before they
        # are turned by the angle of twist; x, y: bend less rest, along the turned axes
        turn = np.array(pose.rotation, state.edges.dtype)
        edges = _vectors(state.edges)
        bends = material.bends.reshape(*material.bends.shape[:2], 3, PACK)
        t = np.einsum("ij,pjk->ipk", turn, forcing.directions.reshape(-1, 3, PACK))
        a = np.einsum("ij,pjk->ipk", turn, bends[:, 0])
        angle, changed = np.zeros_like(t[0]), False
        for j in range(len(self.limits)):
            e, b = edges[j], np.cross(t, a, axis=0)
            cosine, sine = np.cos(angle), np.sin(angle)
            bend, rest = e - t, bends[:, j + 1]
            x = (bend * (a * cosine + b * sine)).sum(0) - rest[:, 1]
            y = (bend * (b * cosine - a * sine)).sum(0) - rest[:, 2]
            away = np.sqrt(x * x + y * y)
            beyond = away > self.limits[j]
            if beyond.any():
                changed = True
                share = np.where(beyond, 1 - self.limits[j] / np.maximum(away, 1e-30), 0.0)
                v, w = rest[:, 1] + share * x, rest[:, 2] + share * y
                along = np.sqrt(np.maximum(1 - v * v - w * w, 0.0)) - 1  # t plus the rest is a unit vector
                for c, value in enumerate((along, v, w)):
                    rest[:, c] = np.where(beyond, value, rest[:, c])
            angle = state.twist[:, j]
            a = a - (a * e).sum(0) / np.maximum(1 + (t * e).sum(0), FOLD) * (t + e)
            a /= np.sqrt((a * a).sum(0))
            t = e
        return changed


def yielding_of(scene: Scene, material: Material) -> Yielding | None:
    """Return what has rest shapes follow strands, where a preset asks for it."""
    if scene.rod.yield_strain is None:
        return None
    return Yielding(scene.rod, material, len(material.joint))


def _vectors(rows: Floats) -> Floats:
    """(P, N, 3 S) -> (N, 3, P, S)."""
    return np.asarray(rows.reshape(*rows.shape[:2], 3, PACK).transpose(1, 2, 0, 3))
