"""Widths of strands on the screen, aside of a wide camera's axis, against rays that meet cylinders."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from strandcli.draw.common.kernels.keys import EMPTY
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.coverage.coverage import Coverage
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.geometry.extent import Thickness, widths_of
from strandcli.draw.shadows.kernels import opacity
from strandcli.draw.shadows.shadow import plan_maps
from strandcli.draw.view.camera import View
from strandcli.draw.zbuffer.raster import draw, to_screen
from strandcli.scene.model import Material, PointLight, Shadow

SIZE = (160, 120)
ALONG = 40
"""Pieces of a strand: its pixels lie along a line whose depth number is even, but its width is not."""


def view_of(fov: float, perspective: bool = True, samples: int = 1) -> View:
    """A camera at the origin that looks along −z; ``fov`` in degrees from bottom to top."""
    width, height = SIZE[0] * samples, SIZE[1] * samples
    right, up, forward = np.eye(3) * [1, 1, -1]
    focal = height / 2 / math.tan(math.radians(fov) / 2)
    return View(np.zeros(3), right, up, forward, perspective, focal, 0.01, 10.0, width, height)


SAMPLES = {"sorted": 1, "zbuffer": 8}
"""A pixel and axis, for areas to be known."""


def samples_covered(lines: Polylines, view: View, material: Material, resolver: str) -> NDArray[np.float64]:
    """(height, width) how much of each sample strands cover."""
    size, scratch = (int(view.width), int(view.height)), Scratch()
    screen = to_screen(lines, view, scratch)
    widths = widths_of(lines, screen, view, material, 0.0, True, scratch)
    if resolver == "zbuffer":
        keys = np.full(size[0] * size[1], EMPTY)
        draw(lines, screen, widths, 0, size, 1, scratch, keys)
        return (keys != EMPTY).reshape(size[::-1]).astype(np.float64)
    image = np.zeros((*size[::-1], 3), np.float32)
    for layer in Coverage(size, 1.0).layers(lines, screen, widths, None, 1, scratch):
        layer.blend(np.ones((len(screen), 3), np.float32), image)
    return image[..., 0].astype(np.float64)


def line(begin: NDArray[np.float64], end: NDArray[np.float64]) -> Polylines:
    world = begin + (end - begin) * np.linspace(0, 1, ALONG + 1)[:, None]
    return Polylines(np.array([0, ALONG + 1]), world.astype(np.float32))


def at(view: View, x: ArrayLike, y: ArrayLike, depth: float) -> NDArray[np.float64]:
    """The places (…, 3) that are seen at pixels."""
    away = depth / view.focal if view.perspective else 1 / view.focal
    across, up = (np.asarray(x) - view.width / 2) * away, (view.height / 2 - np.asarray(y)) * away
    return np.stack(np.broadcast_arrays(across, up, -depth), -1)


def met(view: View, lines: Polylines, radius: float, pixels: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether the rays through places (n, 2) on the screen come within a radius of the straight line of a strand."""
    far = at(view, *pixels.T, 1.0)
    ways = far if view.perspective else np.tile(view.forward, (len(far), 1))
    origin = np.zeros(3) if view.perspective else far
    begin, end = lines.world[0].astype(np.float64), lines.world[-1].astype(np.float64)
    across = np.cross(ways, end - begin)
    off = ((begin - origin) * across).sum(1) / np.linalg.norm(across, axis=1)
    return np.asarray(np.abs(off) < radius)


def width_by_rays(view: View, lines: Polylines, radius: float, v: int) -> float:
    """Pixels across the strand at a vertex."""
    screen = to_screen(lines, view, Scratch()).astype(np.float64)
    way = screen[-1, :2] - screen[0, :2]
    across = np.array([-way[1], way[0]]) / np.linalg.norm(way)
    offsets = np.linspace(-30, 30, 60_001)
    return float(np.count_nonzero(met(view, lines, radius, screen[v, :2] + offsets[:, None] * across)) * 0.001)


ENDS = {
    "across, in a corner": ((8, 44), (32, 8)),
    "away from the middle": ((80, 60), (158, 3)),
    "level, at the top": ((20, 5), (140, 5)),
    "upright, at the side": ((4, 20), (4, 100)),
    "aslant": ((10, 30), (120, 110)),
}


@pytest.mark.parametrize("fov", [60.0, 120.0])
@pytest.mark.parametrize("name", ENDS)
def test_a_strand_aside_of_the_axis_is_as_wide_as_rays_find(name: str, fov: float) -> None:
    """As wide as in the middle, they would be up to 2.4 times too thin."""
    view = view_of(fov)
    (x0, y0), (x1, y1) = ENDS[name]
    lines = line(at(view, x0, y0, 1.0), at(view, x1, y1, 1.6))
    material = Material(width=0.004, taper=0.0)
    screen = to_screen(lines, view, Scratch())
    found = widths_of(lines, screen, view, material, 0.0, True, Scratch())
    right = np.array([width_by_rays(view, lines, 0.002, v) for v in (0, 13, 29, ALONG)])
    np.testing.assert_allclose(found[[0, 13, 29, ALONG]], right, rtol=0.003, atol=0.002)
    flat = 0.004 * view.focal * screen[[0, 13, 29, ALONG], 2]
    print(f"\n{name}, {fov:g} degrees: {right.max() / flat[right.argmax()]:.3f} times the width in the middle")
    if name == "away from the middle":
        np.testing.assert_allclose(found[[0, 13, 29, ALONG]], flat, rtol=1e-3)
    elif fov == 120:
        assert (right > 1.1 * flat).all()


def test_bends_and_strands_that_are_seen_end_on() -> None:
    """At a bend the width is between those of both pieces; a strand that points at the eye is a point, and one of which
    a part lies behind the camera keeps its width in front of it."""
    view = view_of(110)
    material = Material(width=0.01, taper=0.0)

    def widths(*points: NDArray[np.float64]) -> NDArray[np.float32]:
        lines = Polylines(np.array([0, len(points)]), np.array(points, np.float32))
        found = widths_of(lines, to_screen(lines, view, Scratch()), view, material, 0.0, True, Scratch())
        assert found is not None
        return found

    middle, inner, above = at(view, 20, 20, 1.0), at(view, 50, 40, 1.0), at(view, 20, 5, 1.0)
    bent = widths(inner, middle, above)
    assert widths(inner, middle)[1] < bent[1] < widths(middle, above)[0]
    ahead = widths(middle, 2 * middle) * [1, 2] / (0.01 * view.focal)
    assert (ahead >= 0.999).all()
    assert (ahead <= 1.001 * np.linalg.norm(middle)).all()  # how wide it is depends on what is its direction
    crossing = widths(middle, middle + np.array([0, 0, 2.0]), middle + np.array([0, 0, 3.0]))
    assert np.isfinite(crossing).all()
    assert crossing[0] == pytest.approx(0.01 * view.focal)


@pytest.mark.parametrize("resolver", ["sorted", "zbuffer"])
@pytest.mark.parametrize("name", [name for name in ENDS if name != "away from the middle"])
def test_pictures_cover_what_rays_meet(resolver: str, name: str) -> None:
    """The area that a strand covers in a view of 120 degrees; a z-buffer's by many samples a pixel."""
    samples = SAMPLES[resolver]
    view = view_of(120, samples=samples)
    (x0, y0), (x1, y1) = np.array(ENDS[name]) * samples
    lines = line(at(view, x0, y0, 1.0), at(view, x1, y1, 1.6))
    screen = to_screen(lines, view, Scratch())
    covered = samples_covered(lines, view, Material(width=0.08, taper=0.0), resolver)
    # rows or columns well within the strand: how rays end at its ends is another matter
    across = int(abs(screen[-1, 0] - screen[0, 0]) > abs(screen[-1, 1] - screen[0, 1]))
    low, high = np.sort(screen[[0, -1], 1 - across])
    cuts = np.arange(math.ceil(low + 0.25 * (high - low)), math.floor(high - 0.25 * (high - low)), samples)
    fine = (np.arange(SIZE[across] * 8) + 0.5) / 8 * samples
    met_by_rays = 0.0
    for cut in cuts:
        places = np.stack([np.full(len(fine), cut + 0.5), fine], 1)
        met_by_rays += np.count_nonzero(met(view, lines, 0.04, places if across else places[:, ::-1])) / 8 * samples
    drawn = covered[:, cuts].sum() if across else covered[cuts].sum()
    assert met_by_rays > 50 * samples
    assert drawn == pytest.approx(met_by_rays, rel=0.005 if resolver == "sorted" else 0.01)


@pytest.mark.parametrize("perspective", [True, False])
def test_strands_of_any_length_are_as_wide_as_in_double_precision(perspective: bool) -> None:
    view = view_of(100.0, perspective)
    rng = np.random.default_rng(5)
    lengths = [2, 1, 64, 65, 200]
    first = np.cumsum([0, *lengths])
    world = rng.uniform([-1, -1, -3], [1, 1, -0.5], (first[-1], 3)).astype(np.float32)
    scale = rng.uniform(0.5, 2, len(lengths)).astype(np.float32)
    lines = Polylines(first, world, scale=scale)
    screen = to_screen(lines, view, Scratch())
    found = widths_of(lines, screen, view, Material(width=0.03, taper=0.6), 0.0, True, Scratch())
    for s, (a, b) in enumerate(pairwise(first)):
        x, y, q = screen[a:b].astype(np.float64).T
        wide = 0.03 * scale[s] * view.focal * (1 - 0.6 * np.arange(b - a) / max(b - a - 1, 1))
        if perspective:
            low, high = np.maximum(np.arange(b - a) - 1, 0), np.minimum(np.arange(b - a) + 1, b - a - 1)
            dx, dy = x[high] - x[low], y[high] - y[low]
            off = dx * (y - SIZE[1] / 2) - dy * (x - SIZE[0] / 2)
            wide *= q * np.sqrt(1 + (off / np.maximum(np.hypot(dx, dy), 1e-12) / view.focal) ** 2)
        np.testing.assert_allclose(found[a:b], wide, rtol=2e-5)


def test_a_lamps_map_counts_strands_as_wide_as_the_lamp_sees_them() -> None:
    """In the corners of a cube of maps a strand across covers up to √3 times as much."""
    radius, size = 0.01, 64
    lamp = PointLight(position=(0.0, 0.0, 0.0), shadow=Shadow(model="opacity", size=size, layers=4, texel=1e-6))
    lines = line(np.array([0.55, 0.98, -1.0]), np.array([0.98, 0.55, -1.0]))
    maps = plan_maps((lamp,), np.array([[-1.0] * 3, [1.0] * 3]), Scratch(), Thickness(2 * radius))
    maps.build(lines, 1, Scratch())
    rows = maps.stacks[opacity.HEAD * len(maps.views) * size**2 // 4 :].reshape(-1, opacity.stride_for(4))
    view = max(maps.views, key=lambda one: -one.forward[2])  # the one that looks along −z
    area = rows[:, -4:].sum(dtype=np.float64) / view.focal**2  # on a plane a metre away
    length = float(np.linalg.norm(lines.world[-1] - lines.world[0]))
    wide = width_by_rays(view, lines, radius, ALONG // 2) / view.focal
    assert wide > 1.4 * 2 * radius
    assert area == pytest.approx(length * wide, rel=0.01)
