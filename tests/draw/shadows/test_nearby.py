"""The model `nearby`: exact shadows where light gets, the map's where it hardly does."""

from __future__ import annotations

import numpy as np

from strand_kit import frames_of, scene_of
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.geometry.extent import Thickness
from strandcli.draw.lighting.pack_lights import pack_lights
from strandcli.draw.shadows.kernels.nearby import bury, depths
from strandcli.draw.shadows.nearby import LIMIT
from strandcli.draw.shadows.shadow import map_arrays, plan_maps
from strandcli.scene.model import DirectionalLight, Shadow

THICKET = """
emitter: {strands: 6000, particles: 4, length: 0.4, jitter: 30}
rules: []
camera: {position: [0, 0.6, 3], target: [0, 0.2, 0], fov: 50}
image: {size: [60, 40], resolver: sorted}
lights: [{kind: directional, direction: [-0.4, -1, -0.2], shadow: {model: traced}}]
material: {width: 0.01, diffuse: 1, specular: 0}
"""


def test_pictures_are_nearer_to_exact_shadows_than_those_of_maps() -> None:
    exact, near, maps = (
        frames_of(scene_of(THICKET.replace("traced", model)), 1)[0] for model in ("traced", "nearby", "opacity")
    )
    truth = exact.image.astype(np.float64)
    off = [float(np.sqrt(((frame.image - truth) ** 2).mean())) for frame in (near, maps)]
    assert off[0] < off[1] / 3
    assert abs(near.image.mean() / truth.mean() - 1) < 0.002


def test_a_vertex_is_buried_where_its_neighbours_on_its_strand_are() -> None:
    first = np.array([0, 4, 7])
    depth = np.array([0, 5, 5, 5, 5, 5, 5], np.float32)
    out = np.full(7, 9, np.uint8)
    bury(first, depth, np.float32(4), out)
    assert out.tolist() == [0, 0, 1, 1, 1, 1, 1]


def test_depths_are_those_of_the_strands_in_front() -> None:
    """A hundred sheets of strands across the light's way: each is in front of all that are below it."""
    sheets, rows = 100, 40
    x = np.linspace(-1.0, 1.0, 9)
    y, z = np.repeat(np.linspace(0.0, -1.0, sheets), rows), np.tile(np.linspace(-1.0, 1.0, rows), sheets)
    z += np.random.default_rng(0).uniform(-0.05, 0.05, len(z))  # sheets do not stand one behind the other
    world = np.stack([np.tile(x, len(y)), np.repeat(y, 9), np.repeat(z, 9)], 1).astype(np.float32)
    lines = Polylines(np.arange(len(y) + 1) * 9, world)
    bounds = np.stack([world.min(0), world.max(0)]).astype(np.float64)
    sun = (DirectionalLight(direction=(0.0, -1.0, 0.0), shadow=Shadow(model="nearby")),)
    maps = plan_maps(sun, bounds, Scratch(), Thickness(0.004), 2.0 / rows)
    assert maps is not None
    maps.build(lines, 1, Scratch())
    found = np.empty(len(world), np.float32)
    depths(world, pack_lights(sun, maps, bounds), np.int64(0), map_arrays(maps), found)
    middle = found.reshape(sheets, rows, 9)[:, 8:-8, 2:-2].mean((1, 2))
    truth = np.arange(sheets) * rows * 0.004 / 2.0
    np.testing.assert_allclose(middle, truth, atol=0.4)
    assert middle[90] > LIMIT > middle[40]
