"""Parts of an empty frame, drawn to compile their kernels (see `strandcli.compiling.service`)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .canvas import mark
from .common.kernels.keys import EMPTY
from .film.kernels import film
from .geometry.curves import Polylines
from .geometry.extent import Thickness
from .geometry.kernels.ribbon import ScreenLines
from .lighting import occlusion
from .lighting.lighting import Lighting, pack_lights
from .renderer import Renderer
from .shadows.shadow import plan_maps
from .solids.edges import find_edges
from .strand_batches import StrandBatch
from .view.camera import camera_view

BOUNDS = np.array([[-1.0] * 3, [1.0] * 3])
"""Bounding box of the strands, metres."""


def compile_part(renderer: Renderer, part: str) -> None:
    """Draw a part of an empty frame: "light", everything after visibility, or "coverage", sorting of fragments."""
    {"light": _light, "coverage": _coverage}[part](renderer)


def _light(renderer: Renderer) -> None:
    """Shade a single vertex and no solids, and develop the picture."""
    scene, size = renderer.scene, renderer.size
    view = camera_view(scene.camera, 0.0, *size, BOUNDS)
    maps = plan_maps(scene.lights, BOUNDS, renderer.scratch, Thickness(0.01), 0.1)
    hidden = occlusion.nothing() if scene.occluded else None
    lights = pack_lights(scene.lights, maps, BOUNDS)
    lighting = Lighting(scene, renderer.palette, renderer.sky, view, 0.0, lights, maps, hidden, renderer.solids(0.0))
    lines = Polylines(np.array([0, 1]), np.zeros((1, 3), np.float32))
    keys = np.full(size[0] * size[1], EMPTY)
    image = renderer.backdrop.copy()
    marks = mark(keys, lines, 0, renderer.scratch)[0] if renderer.coverage is None else np.zeros(1, np.uint8)
    visibility = np.ones((len(renderer.shadowed), 1), np.float32) if renderer.shadowed else None
    batch = StrandBatch(0, 1, lines, renderer.tones[:1], lines.world, None, None)
    colours = renderer.shade(lighting, batch, marks, visibility)
    if renderer.coverage is None:
        film.colours(keys, 0, lines.world, lines.per, lines.stride, colours, image)
    else:
        empty = ScreenLines(lines.first, np.zeros((1, 3), np.float32), _widths(renderer, 1))
        renderer.coverage.empty_layer(empty, view.depth_slope).blend(colours, image)
    lighting.shade_surfaces(keys, image)
    renderer.develop(image, renderer.blank())


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


def _widths(renderer: Renderer, vertices: int) -> NDArray[np.float32] | None:
    """Return widths (V,) of 0, or None if strands are lines one pixel wide."""
    return np.zeros(vertices, np.float32) if renderer.scene.material.width > 0 else None
