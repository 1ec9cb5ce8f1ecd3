"""How far shadow maps are from the truth: transmittance at points on strands, against rays that meet cylinders.

    python -m strandcli.study.shadow hair --frame 10 --light 0

The reference is the share of a bundle of parallel (or converging) rays, jittered over a disc of 1.5 strand spacings
about the probe, that meets no other strand. A map has no finer answer than that to give.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..draw.camera import camera_view
from ..draw.curves import Polylines, flatten
from ..draw.kernels import opacity
from ..draw.kernels import shadow as minmax
from ..draw.scratch import Scratch
from ..draw.shading import pack_lights
from ..draw.shadow import Thickness, plan_maps, strand_spacing
from ..groom.emit import PLASTIC
from ..scene.model import DirectionalLight, Light, Shadow
from .kernels import rays as kernel

BUNDLE = 1.5
"""Radius of a bundle of rays, in strand spacings."""


@dataclass(frozen=True)
class Probes:
    """Points on strands and what is known about the light there."""

    points: NDArray[np.float64]
    own: NDArray[np.int64]
    truth: NDArray[np.float64]


@dataclass(frozen=True)
class Error:
    """Of transmittance: mean of the absolute difference, signed mean, 95th percentile."""

    mean: float
    bias: float
    p95: float
    texels: int
    """Along a side."""
    seconds: float
    """To build the map."""


def probe(
    lines: Polylines,
    light: Light,
    thickness: Thickness,
    spacing: float,
    count: int = 400,
    rays: int = 256,
    seed: int = 0,
) -> Probes:
    """The reference at ``count`` random places on strands; each bundle is an R2 sequence, shifted at random, which
    leaves a third of the noise of random rays."""
    rng = np.random.default_rng(seed)
    strands = len(lines.first) - 1
    own = rng.integers(0, strands, count)
    vertex = lines.first[own] + (rng.random(count) * (np.diff(lines.first)[own] - 1)).astype(np.int64)
    part = rng.random(count)[:, None]
    world = lines.world.astype(np.float64)
    points = world[vertex] + part * (world[vertex + 1] - world[vertex])
    if isinstance(light, DirectionalLight):
        way = np.broadcast_to(-np.array(light.direction) / np.linalg.norm(light.direction), points.shape)
    else:
        way = np.array(light.position) - points
        way = way / np.linalg.norm(way, axis=1, keepdims=True)
    across = np.cross(way, np.where(np.abs(way[:, :1]) < 0.7, [[1.0, 0, 0]], [[0, 1.0, 0]]))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    other = np.cross(way, across)
    radius = BUNDLE * spacing
    steps = np.arange(rays)[:, None] * np.array([1 / PLASTIC, 1 / PLASTIC**2])
    u, v = np.moveaxis((rng.random((count, 1, 2)) + steps) % 1.0, 2, 0)[..., None]
    r, turn = radius * np.sqrt(u), 2 * np.pi * v
    origins = points[:, None] + r * (np.cos(turn) * across[:, None] + np.sin(turn) * other[:, None])
    if isinstance(light, DirectionalLight):
        directions = np.broadcast_to(way[:, None], origins.shape).copy()
        reaches = np.full(origins.shape[:2], 1e6)
    else:
        directions = np.array(light.position) - origins
        reaches = np.linalg.norm(directions, axis=2)
        directions = directions / reaches[..., None]
    truth = np.empty(count)
    kernel.lit(
        lines.first, world, thickness.width, thickness.taper, points, own, origins, directions, reaches, radius, truth
    )
    return Probes(points, own, truth)


def error(
    lines: Polylines, light: Light, probes: Probes, thickness: Thickness, spacing: float, workers: int = 1
) -> Error:
    """What a light's map says of the same points."""
    bounds = np.stack([lines.world.min(0), lines.world.max(0)]).astype(np.float64)
    scratch = Scratch()
    began = time.perf_counter()
    maps = plan_maps((light,), bounds, scratch, thickness, spacing)
    if maps is not None:
        maps.build(lines, workers, scratch)
    seconds = time.perf_counter() - began
    packed = pack_lights((light,), maps, bounds)
    found = np.ones(len(probes.points))
    if maps is not None:
        asked: Any = opacity.transmittance if maps.deep else minmax.transmittance
        array = maps.stacks if maps.deep else maps.texels
        for i, (x, y, z) in enumerate(probes.points.astype(np.float32)):
            found[i] = asked(x, y, z, packed, 0, array, maps.starts, maps.sizes, maps.packed)
    off = found - probes.truth
    texels = 0 if maps is None else int(maps.sizes[0])
    return Error(float(np.abs(off).mean()), float(off.mean()), float(np.percentile(np.abs(off), 95)), texels, seconds)


def groom_at(scene: Any, frame: int) -> tuple[Polylines, Thickness, float]:
    """Polylines of a scene's strands at a frame, what they cover, and the distance between them."""
    from ..draw.renderer import Renderer
    from ..groom.emit import emit
    from ..simulate import solver_of

    groom = emit(scene.emitter, scene.seed)
    solver = solver_of(scene)(scene, groom)
    solver.advance(frame)
    at = (frame - 1) / scene.time.fps
    renderer = Renderer(scene, groom)
    strands = groom.strands
    bounds = renderer._bounds(solver.positions, strands)
    view = camera_view(scene.camera, at, *renderer.size, bounds)
    lines = flatten(solver.positions, solver.lengths, strands, scene.curves, view, True, Scratch())
    return lines, renderer._thickness(view, bounds, 1.0), strand_spacing(groom.roots)


def sweep(light: Light, size: int = 1024) -> list[tuple[str, Light]]:
    """The maps that are compared."""
    cases = [("off", Shadow(model="off")), ("minmax 512", Shadow(size=512)), ("minmax 128", Shadow(size=128))]
    for layers in (1, 3, 5, 13, 29):
        cases.append((f"opacity {layers} layers", Shadow(model="opacity", size=size, layers=layers)))
    return [(name, replace(light, shadow=shadow)) for name, shadow in cases]


def main(arguments: Sequence[str] | None = None) -> int:
    """Print a table for one light of a preset."""
    from .. import load

    parser = argparse.ArgumentParser(prog="python -m strandcli.study.shadow", description=main.__doc__)
    parser.add_argument("preset")
    parser.add_argument("--frame", type=int, default=1)
    parser.add_argument("--light", type=int, default=0)
    parser.add_argument("--probes", type=int, default=400)
    parser.add_argument("--width", type=float, help="width of strands in metres, in place of the preset's")
    chosen = parser.parse_args(arguments)
    scene = load(chosen.preset)
    lines, thickness, spacing = groom_at(scene, chosen.frame)
    if chosen.width is not None:
        thickness = Thickness(chosen.width, scene.material.taper)
    light = scene.lights[chosen.light]
    probes = probe(lines, light, thickness, spacing, chosen.probes)
    print(f"{chosen.preset}: spacing {1e3 * spacing:.3g} mm, width {1e3 * thickness.width:.3g} mm, mean T "
          f"{probes.truth.mean():.3f}")  # fmt: skip
    cases = sweep(light)
    for factor in (0.5, 1.0, 2.0, 4.0, 8.0):
        shadow = Shadow(model="opacity", size=4096, texel=factor * spacing)
        cases.append((f"texel of {factor:g} spacings", replace(light, shadow=shadow)))
    for name, one in cases:
        e = error(lines, one, probes, thickness, spacing)
        print(
            f"{name:24} {e.texels:5}²  |ΔT| {e.mean:.4f}  bias {e.bias:+.4f}  p95 {e.p95:.3f}  {1e3 * e.seconds:.0f} ms"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
