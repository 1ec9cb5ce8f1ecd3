"""Parts of an empty frame, drawn to compile their kernels (see `strandcli.compiling.service`)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..constants import W
from .canvas import clear, mark
from .common.drawing import Drawing
from .common.kernels.keys import EMPTY
from .film.kernels import film
from .geometry.curves import Polylines
from .geometry.detail import Level
from .geometry.extent import Thickness, widths_of
from .geometry.kernels.ribbon import ScreenLines
from .lighting import occlusion
from .lighting.lighting import Lighting, pack_lights
from .renderer import Renderer
from .shadows.shadow import plan_maps
from .shadows.strands_in_map import FEWEST, chances_of
from .solids.edges import find_edges
from .strand_batches import StrandBatch, StrandBatches, Strands
from .view.camera import camera_view
from .zbuffer.raster import to_screen

LENGTH = np.float32(0.01)
"""Of a segment, metres."""
BOUNDS = np.array([[-1.0] * 3, [1.0] * 3])
"""Bounding box of the strands, metres."""


def compile_part(renderer: Renderer, part: str) -> None:
    """Draw a part of an empty frame: "surfaces", light on solids, "strands", light on strands and the film, "coverage",
    sorting of fragments, or "lines", from curves to shadow maps and places on the screen."""
    {"surfaces": _surfaces, "strands": _strands, "coverage": _coverage, "lines": _lines}[part](renderer)


def _surfaces(renderer: Renderer) -> None:
    """Shade no solids, and then find those that there are."""
    keys, lighting = np.full(renderer.size[0] * renderer.size[1], EMPTY), _lighting(renderer)
    lighting.shade_surfaces(keys, renderer.backdrop.copy())
    clear(keys, renderer.size, replace(lighting, triangles=np.full(len(keys), -1, np.int32)))


def _strands(renderer: Renderer) -> None:
    """Shade a single vertex, and develop the picture."""
    lighting, image = _lighting(renderer), renderer.backdrop.copy()
    lines = Polylines(np.array([0, 1]), np.zeros((1, 3), np.float32))
    keys = np.full(renderer.size[0] * renderer.size[1], EMPTY)
    marks = mark(keys, lines, 0, renderer.scratch)[0] if renderer.coverage is None else np.zeros(1, np.uint8)
    visibility = np.ones((len(renderer.shadowed), 1), np.float32) if renderer.shadowed else None
    batch = StrandBatch(0, 1, lines, renderer.tones[:1], lines.world, None, None)
    colours = renderer.shade(lighting, batch, marks, visibility)
    if renderer.coverage is None:
        film.colours(keys, 0, lines.world, lines.per, lines.stride, colours, image)
    else:
        empty = ScreenLines(lines.first, np.zeros((1, 3), np.float32), _widths(renderer, 1))
        renderer.coverage.empty_layer(empty, lighting.view.depth_slope).blend(colours, image)
    renderer.develop(image, renderer.blank())


def _lighting(renderer: Renderer) -> Lighting:
    """Return the light of a frame without strands."""
    scene = renderer.scene
    view = camera_view(scene.camera, 0.0, *renderer.size, BOUNDS)
    maps = plan_maps(scene.lights, BOUNDS, renderer.scratch, Thickness(0.01), 0.1)
    hidden = occlusion.nothing() if scene.occluded else None
    lights = pack_lights(scene.lights, maps, BOUNDS)
    return Lighting(scene, renderer.palette, renderer.sky, view, 0.0, lights, maps, hidden, renderer.solids(0.0))


def _coverage(renderer: Renderer) -> None:
    """Resolve a strand behind the eye."""
    if renderer.coverage is None:
        return
    view = camera_view(renderer.scene.camera, 0.0, *renderer.size, BOUNDS)
    lines = Polylines(np.array([0, 2]), np.zeros((2, 3), np.float32))
    behind = np.zeros((2, 3), np.float32)  # depth number 0: behind the eye
    keys = np.full(renderer.size[0] * renderer.size[1], EMPTY)
    packed = renderer.solids(0.0)
    edges = None if packed is None else find_edges(keys, packed, view, renderer.size, renderer.scratch)
    if edges is not None:
        edges.composite(lambda *picture: None, renderer.backdrop.copy(), renderer.backdrop)
    widths, scratch = _widths(renderer, 2), renderer.scratch
    for _ in renderer.coverage.layers(lines, behind, widths, edges, 1, scratch, view.depth_slope):
        pass


def _lines(renderer: Renderer) -> None:
    """Draw as many straight strands as every kernel is needed for, into the maps, and project them."""
    scene, scratch, thickness = renderer.scene, renderer.scratch, Thickness(0.01)
    view = camera_view(scene.camera, 0.0, *renderer.size, BOUNDS)
    count = min(scene.drawn_strands, FEWEST + 1)
    positions = np.zeros((-(-count // W), scene.emitter.particles + 1, 3 * W), np.float32)
    positions[:, :, W : 2 * W] = LENGTH * np.arange(scene.emitter.particles + 1)[:, None]
    lengths = None if renderer.drawn.uneven else np.full((len(positions), W), LENGTH, np.float32)
    level = None if scene.detail is None else Level(np.ones(count, np.float32), np.ones(count, np.float32), 1.0)
    strands = Strands(positions, lengths, count, level, np.zeros(count, np.float32), None)
    batches = StrandBatches(
        scene, strands, view, renderer.thins, [(0, count)], True, Drawing(renderer.blank()), scratch
    )
    lines = next(batches.lines())
    maps = plan_maps(scene.lights, BOUNDS, scratch, thickness, 0.1, renderer.counts_strands)
    if maps is not None:
        if renderer.coverage is not None:
            maps.chances = chances_of(None, count)
        maps.build(lines, 1, scratch)
    screen = to_screen(lines, view, scratch)
    widths_of(lines, screen, view, scene.material, 0.0, renderer.thins, scratch)


def _widths(renderer: Renderer, vertices: int) -> NDArray[np.float32] | None:
    """Return widths (V,) of 0, or None if strands are lines one pixel wide."""
    return np.zeros(vertices, np.float32) if renderer.scene.material.width > 0 else None
