"""What workers compile ahead of a first frame is what the frame calls."""

from __future__ import annotations

import dataclasses

import pytest

from strand_kit import frames_of, groom_of, scene_of
from strandcli.compiling.service import PARTS
from strandcli.draw.compile_parts import compile_part
from strandcli.draw.coverage.kernels import resolve, tile_binning
from strandcli.draw.film.kernels import film
from strandcli.draw.geometry.kernels import ribbon
from strandcli.draw.lighting.kernels import shade_strands, shade_surfaces
from strandcli.draw.renderer import Renderer
from strandcli.draw.solids.kernels import visible

SCENE = """
emitter: {strands: 1, particles: 2, length: 4, direction: [0, 1, 0], position: [0.05, -2, 1.5],
  shape: {kind: disc, radius: 0.000001}}
rules: []
camera: {kind: perspective, position: [0.1, 0.6, 5], target: [0, 0, 0], fov: 30}
image: {size: [64, 48], resolver: sorted}
curves: {mode: "off"}
material: {width: 0.004, taper: 0, colour: [0.1, 0.9, 0.2], specular: 0, diffuse: 0}
lights: []
solids: [{kind: sphere, radius: 0.5, position: [0.25, 0, 0], colour: [0.2, 0.2, 0.9]}]
"""
KERNELS = {
    "light": (shade_strands.strands, shade_surfaces.surfaces, resolve.resolve, resolve.blend, film.develop),
    "coverage": (
        visible.find, ribbon.find_on_screen, tile_binning.bin_segments, resolve.resolve,
    ),
}  # fmt: skip


@pytest.mark.parametrize("part", PARTS)
def test_a_part_compiles_what_a_frame_calls_and_nothing_else(part: str) -> None:
    scene = scene_of(SCENE)
    frames_of(scene, 1)
    drawn = {kernel: list(kernel.signatures) for kernel in KERNELS[part]}
    assert all(drawn.values())
    calls = {kernel: sum(kernel.stats.cache_hits.values()) for kernel in KERNELS[part]}
    small = dataclasses.replace(scene, image=dataclasses.replace(scene.image, size=(8, 8)))
    compile_part(Renderer(small, groom_of(scene)), part)
    assert {kernel: list(kernel.signatures) for kernel in KERNELS[part]} == drawn
    assert {kernel: sum(kernel.stats.cache_hits.values()) for kernel in KERNELS[part]} == calls
