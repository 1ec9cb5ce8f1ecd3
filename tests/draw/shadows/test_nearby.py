"""The model `nearby`: exact shadows where light gets, the map's where it hardly does."""

from __future__ import annotations

import hashlib
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from strand_kit import frames_of, scene_of
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.geometry.extent import Thickness
from strandcli.draw.lighting.pack_lights import pack_lights
from strandcli.draw.shadows.kernels.nearby import bury, depths
from strandcli.draw.shadows.nearby import LIMIT
from strandcli.draw.shadows.shadow import map_arrays, plan_maps
from strandcli.groom.record import Groom
from strandcli.plan import make_plan
from strandcli.plan.cost import frame_seconds
from strandcli.scene.model import DirectionalLight, Shadow

OF_STRANDS = ("roots", "directions", "lengths", "tones")
"""Arrays of a groom that have a row for each strand."""

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


def test_pixels_do_not_depend_on_threads_portions_or_layers(monkeypatch: pytest.MonkeyPatch) -> None:
    """And but by rounding on the order of strands, in which sums of maps round otherwise, and on a crop window,
    in which places on the screen do, and pieces of curves with them."""
    text = THICKET.replace("traced", "nearby")

    def pixels(text: str = text, threads: int = 1) -> NDArray[np.uint8]:
        image = frames_of(scene_of(text), 1, threads=threads)[0].image
        assert image is not None
        return image

    def hashed(image: NDArray[np.uint8]) -> str:
        return hashlib.sha256(np.ascontiguousarray(image)).hexdigest()

    def shuffled(groom: Groom, ends: tuple[int, ...]) -> Groom:
        order = np.random.default_rng(3).permutation(groom.strands)
        return replace(groom, **{name: getattr(groom, name)[order] for name in OF_STRANDS})

    whole = pixels()
    assert len(np.unique(whole)) > 50
    assert hashed(pixels(threads=2)) == hashed(whole)
    assert hashed(pixels(text.replace("sorted}", "sorted, aovs: [shadow, depth]}"))) == hashed(whole)
    part = pixels(text.replace("sorted}", "sorted, crop: [20, 8, 23, 17]}")).astype(np.int64)
    assert np.abs(part - whole[8:25, 20:43]).mean() < 0.3
    monkeypatch.setattr("strandcli.draw.strand_batches.BATCH_VERTICES", 4000)
    assert hashed(pixels()) == hashed(whole)
    monkeypatch.setattr("strandcli.stages.arranged", shuffled)
    apart = np.abs(pixels().astype(np.int64) - whole)
    assert apart.max() <= 1
    assert (apart > 0).mean() < 0.01


def test_planned_seconds_are_between_those_of_maps_and_of_exact_shadows() -> None:
    large = THICKET.replace("[60, 40]", "[1200, 800]")
    scenes = [scene_of(large.replace("traced", model)) for model in ("opacity", "nearby", "traced")]
    maps, near, exact = (frame_seconds(make_plan(scene, [1]), scene) for scene in scenes)
    assert 1.2 * maps < near < exact / 1.1


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
