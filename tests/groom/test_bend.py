"""Strands that bend toward the surface on their way to the tip."""

from __future__ import annotations

import numpy as np

from strandcli.groom.blocks import arranged
from strandcli.groom.emit import emit
from strandcli.scene.model import Emitter, SphereShape

ON_A_BALL = {"shape": SphereShape(radius=0.5), "strands": 300, "comb": (0.3, -1.0, 0.2), "lift": 40.0}


def angles(bend: float, onset: float) -> tuple[np.ndarray, np.ndarray]:
    """Degrees by which edges (20,) of strands turn to their inward side, and by how much they leave that plane."""
    groom = arranged(emit(Emitter(**ON_A_BALL, bend=bend, bend_onset=onset), 1))
    axes = groom.directions.astype(float)
    normals = groom.roots / 0.5
    side = np.cross(axes, normals)
    side /= np.linalg.norm(side, axis=1)[:, None]
    inward = np.cross(axes, side)
    assert ((inward * normals).sum(1) < 0).all()
    edges = np.array([groom.edge(j, 20) for j in range(20)])
    turned = np.degrees(np.arctan2((edges * inward).sum(2), (edges * axes).sum(2)))
    np.testing.assert_allclose(np.linalg.norm(edges, axis=2), 1, atol=1e-6)
    return turned, np.abs((edges * side).sum(2))


def test_strands_turn_evenly_from_the_onset_on() -> None:
    turned, aside = angles(80.0, 0.5)
    middles = (np.arange(20) + 0.5) / 20
    np.testing.assert_allclose(
        turned, np.broadcast_to(160 * np.maximum(middles - 0.5, 0)[:, None], (20, 300)), atol=1e-3
    )
    assert aside.max() < 1e-6
