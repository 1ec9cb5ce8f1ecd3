"""The model `nearby`: exact shadows where light gets, the map's where it hardly does."""

from __future__ import annotations

import numpy as np

from strand_kit import frames_of, scene_of
from strandcli.draw.shadows.kernels.nearby import bury

THICKET = """
emitter: {strands: 3000, particles: 4, length: 0.4, jitter: 30}
rules: []
camera: {position: [0, 0.6, 3], target: [0, 0.2, 0], fov: 50}
image: {size: [60, 40], resolver: sorted}
lights: [{kind: directional, direction: [-0.4, -1, -0.2], shadow: {model: traced}}]
material: {width: 0.03, diffuse: 1, specular: 0}
"""


def test_pictures_are_nearer_to_exact_shadows_than_those_of_maps_and_list_less() -> None:
    exact, near, maps = (
        frames_of(scene_of(THICKET.replace("traced", model)), 1)[0] for model in ("traced", "nearby", "opacity")
    )
    truth = exact.image.astype(np.float64)
    off = [float(np.sqrt(((frame.image - truth) ** 2).mean())) for frame in (near, maps)]
    assert off[0] < 0.5 * off[1]
    assert abs(near.image.mean() / truth.mean() - 1) < 0.02
    assert near.report["counts"]["grid_bytes"] < 0.9 * exact.report["counts"]["grid_bytes"]


def test_a_vertex_is_buried_where_its_neighbours_on_its_strand_are() -> None:
    first = np.array([0, 4, 7])
    depth = np.array([0, 5, 5, 5, 5, 5, 5], np.float32)
    out = np.full(7, 9, np.uint8)
    bury(first, depth, np.float32(4), out)
    assert out.tolist() == [0, 0, 1, 1, 1, 1, 1]
