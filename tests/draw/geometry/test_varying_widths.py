"""Widths that vary from point to point: on the screen, in pictures, in maps, in grids of shadows and of the sky."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from strandcli.draw.common.scratch import Scratch
from strandcli.draw.geometry.curves import Polylines, flatten
from strandcli.draw.geometry.extent import Thickness, lost_of
from strandcli.draw.lighting.kernels import occlusion_sweep
from strandcli.draw.lighting.kernels.occlusion import BOX_SIZE, CHANNELS, DENSITY
from strandcli.draw.shadows.kernels.map_parts import WIDE
from strandcli.draw.shadows.strands_in_map import parts_in_map
from strandcli.draw.view.camera import View, parallel_view
from strandcli.groom.blocks import pack
from strandcli.scene.model import Curves, Material
from tests.draw.geometry.test_widths import SAMPLES, samples_covered

Floats = NDArray[np.float64]
SIZE = (200, 160)
BOX = np.array([[-1.0, -1, -1], [1, 1, 1]])
MANY = 6000


def view_of(samples: int = 1) -> View:
    """A camera that looks along −z, of which a metre is a pixel."""
    right, up, forward = np.eye(3) * [1, 1, -1]
    width, height = SIZE[0] * samples, SIZE[1] * samples
    return View(np.zeros(3), right, up, forward, False, float(samples), 0.01, 10.0, width, height)


def strand(angle: float, length: float, points: int) -> Floats:
    """(points, 3) of a straight strand about the middle of the picture, at uneven distances."""
    along = np.linspace(0, 1, points) ** 1.3 - 0.5
    ways = np.array([math.cos(angle), math.sin(angle)])
    return np.column_stack([length * along[:, None] * ways + 0.37, np.full(points, -2.0)])


def covered(lines: Polylines, width: float, resolver: str) -> float:
    """Square pixels of the picture that strands cover."""
    samples = SAMPLES[resolver]
    return float(samples_covered(lines, view_of(samples), Material(width=width), resolver).sum()) / samples**2


def area(points: Floats, widths: Floats) -> float:
    """Of what a straight strand covers whose width changes evenly from point to point."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return float((steps * (widths[1:] + widths[:-1]) / 2).sum())


PROFILES = {
    "cone": lambda t: 1 - 0.95 * t,
    "to the tip": lambda t: 0.1 + 0.9 * t,
    "step": lambda t: np.where(t < 0.5, 1.0, 0.2),
    "waves": lambda t: 0.55 + 0.45 * np.cos(9 * t),
}
MODES = {
    "straight": Curves(mode="off"),
    "fine": Curves(mode="fixed", level=2),
    "adaptive": Curves(mode="adaptive", tolerance=0.02),
    "thinned": Curves(mode="thinned", tolerance=0.1),
}


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("resolver", ["sorted", "zbuffer"])
@pytest.mark.parametrize("profile", PROFILES)
def test_a_strand_covers_its_length_times_its_mean_width(profile: str, resolver: str, mode: str) -> None:
    """However long, thin, wide and slanted it is; a z-buffer's is never thinner than a sample, and its edges along rows
    of samples are only as exact as these are fine."""
    sizes = ((130.0, 4.0), (100.0, 20.0)) if resolver == "zbuffer" else ((120.0, 0.3), (130.0, 4.0), (100.0, 20.0))
    for angle in (0.03, 0.5, 1.2, 1.54, 3.9) if resolver == "zbuffer" else (0.0, 0.5, 1.2, math.pi / 2, 3.9):
        for length, width in sizes:
            points = strand(angle, length, 30)
            shares = PROFILES[profile](np.linspace(0, 1, 30)).astype(np.float32)
            lines = lines_of(points[None], shares[None], width, MODES[mode])
            want = area(points, width * shares.astype(float))
            near = 0.012 * want + (0.01 * width * length if mode == "thinned" else 0)
            assert covered(lines, width, resolver) == pytest.approx(want, abs=near), (angle, width)


@pytest.mark.parametrize("angle", [0.0, math.pi / 2])
def test_straight_strands_along_rows_of_samples_have_no_caps_at_joints(angle: float) -> None:
    """Where segments are shorter than the strand is wide, those at joints would stand out behind its ends."""
    points = strand(angle, 100.0, 40)
    for shares in (np.ones(40, np.float32), np.linspace(1, 0.2, 40, dtype=np.float32)):
        lines = lines_of(points[None], shares[None], 20.0, MODES["straight"])
        assert covered(lines, 20.0, "zbuffer") == pytest.approx(area(points, 20.0 * shares), rel=2e-3)


def lines_of(points: Floats, shares: NDArray[np.float32], width: float, curves: Curves) -> Polylines:
    """Strands (S, n, 3) whose widths are these shares (S, n) of one width."""
    before = 2 * points[:, :1] - points[:, 1:2]
    positions = pack(np.concatenate([before, points], axis=1))
    radii = np.float32(width / 2) * shares if curves.mode == "thinned" else None
    lines = flatten(positions, None, len(points), curves, view_of(), True, Scratch(), None, radii)
    return replace(lines, lost=lost_of(lines, shares, Scratch()), scale=np.ones(len(points), np.float32))


@pytest.mark.parametrize("width", [8.0, 0.2])
def test_dense_strands_keep_the_points_that_tell_their_widths(width: float) -> None:
    """Edges are within the tolerance, a tenth of a pixel, and widths within a hundredth of the greatest: those of thin
    strands are seen by how much they cover."""
    points, t = strand(0.3, 120.0, 200), np.linspace(0, 1, 200)
    shares = (0.6 + 0.4 * np.sin(20 * t)).astype(np.float32)
    even = lines_of(points[None], np.ones((1, 200), np.float32), width, MODES["thinned"])
    waves = lines_of(points[None], shares[None], width, MODES["thinned"])
    assert len(even.world) == 2
    between = width * np.interp(points[:, 0], waves.world[:, 0], 1 - waves.lost)
    most = min(0.1, 0.01 * width / 2)
    assert 0.3 * most < np.abs(between - width * shares).max() / 2 <= 1.01 * most
    assert len(waves.world) < 80


def many(points: int = 24, seed: int = 1) -> tuple[Floats, NDArray[np.float32]]:
    """Straight strands in the box, and their shares."""
    rng = np.random.default_rng(seed)
    begin, ways = rng.uniform(-0.5, 0.5, (MANY, 1, 3)), rng.normal(size=(MANY, 1, 3))
    ways /= np.linalg.norm(ways, axis=2, keepdims=True)
    t = np.linspace(0, 1, points)
    shares = 0.5 + 0.5 * np.cos(rng.uniform(3, 12, (MANY, 1)) * t + rng.uniform(0, 6, (MANY, 1)))
    return begin + 0.4 * ways * t[:, None], shares.astype(np.float32)


def in_light(lines: Polylines, thickness: Thickness, view: View) -> float:
    """Square metres that a light sees of strands."""
    parts = parts_in_map(lines, thickness, view, int(view.width), 1, Scratch())
    total = 0.0
    for begin, vertices in parts.order[:, :2]:
        kept = parts.vertices[begin : begin + vertices].astype(np.float64)
        there = kept[1:, WIDE] >= 0
        total += (np.hypot(*np.diff(kept[:, :2], axis=0).T) * kept[1:, WIDE])[there].sum()
    return total / view.focal**2


@pytest.mark.parametrize("mode", ["straight", "fine"])
def test_opacity_maps_count_what_light_sees_of_widths(mode: str) -> None:
    """Projected area, whatever the map's resolution."""
    points, shares = many()
    width, direction = 0.004, np.array([-0.5, -1.0, -0.3])
    lines = lines_of(points, shares, width, MODES[mode])
    steps = np.diff(points, axis=1)
    ahead = direction / np.linalg.norm(direction)
    across = np.linalg.norm(steps - (steps @ ahead)[..., None] * ahead, axis=2)
    want = float((across * width * (shares[:, 1:] + shares[:, :-1]) / 2).sum())
    for side in (512, 64):
        view = parallel_view(direction, side, BOX)
        thick = Thickness(width, 0.4)
        assert in_light(lines, thick, view) == pytest.approx(want, rel=2e-3)


def test_the_grid_of_the_sky_counts_widths() -> None:
    """The density in all cells is the area of strands; as a taper's where shares are those of a taper."""
    points, shares = many()
    before = 2 * points[:, :1] - points[:, 1:2]
    positions = pack(np.concatenate([before, points], axis=1))
    box = np.zeros(BOX_SIZE, np.float32)
    low, high, counts = -2.0, 2.0, 16
    side = (high - low) / counts
    box[:9] = [*[low + side / 2] * 3, *[1 / side] * 3, *[counts] * 3]
    length = np.linalg.norm(np.diff(points, axis=1), axis=2)
    taper = np.tile(np.linspace(1, 0.4, 24, dtype=np.float32), (MANY, 1))
    found = []
    for each, share in ((shares, 0.0), (taper, 0.0), (None, 0.6)):
        cells = np.zeros((counts**3, CHANNELS), np.float32)
        scale = np.full(MANY, 2, np.float32)
        occlusion_sweep.count_strands(
            positions, np.arange(MANY), np.float32(0.002), np.float32(share), scale, each, np.float32(1), box, cells
        )
        found.append(float(cells[:, DENSITY].sum(dtype=np.float64)))
    middle = (shares[:, 1:] + shares[:, :-1]).astype(np.float64) / 2
    assert found[0] == pytest.approx(float((0.004 * length * middle).sum()), rel=1e-4)
    assert found[1] == pytest.approx(found[2], rel=1e-5)
