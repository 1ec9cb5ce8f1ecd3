"""Deep opacity maps: what is counted, what is let through, against rays that meet cylinders."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from shadow_kit import optical_depth
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.geometry.extent import Thickness
from strandcli.draw.lighting.lighting import pack_lights
from strandcli.draw.shadows import shadow
from strandcli.draw.shadows.kernels import opacity
from strandcli.draw.shadows.shadow import ShadowMaps, plan_maps
from strandcli.errors import RefusedError
from strandcli.scene.model import DirectionalLight, Light, PointLight, Shadow

BOX = np.array([[-1.0, -1, -1], [1, 1, 1]])
DEEP = Shadow(model="opacity", size=64, layers=13, texel=1e-6)
SUN = DirectionalLight(direction=(-0.5, -1.0, -0.3), shadow=DEEP)
LAMP = PointLight(position=(2.0, 4.0, 1.0), shadow=DEEP)
INSIDE = PointLight(position=(0.1, 0.05, -0.1), shadow=DEEP)
WIDE = Thickness(0.01, 0.5)


def straight(count: int, seed: int = 0, pieces: int = 8) -> Polylines:
    """Straight strands that stay in the box."""
    rng = np.random.default_rng(seed)
    begin = rng.uniform(-0.6, 0.6, (count, 1, 3))
    way = rng.normal(size=(count, 1, 3))
    way /= np.linalg.norm(way, axis=2, keepdims=True)
    world = begin + 0.35 * way * np.linspace(0, 1, pieces + 1)[:, None]
    return Polylines(np.arange(count + 1) * (pieces + 1), world.astype(np.float32).reshape(-1, 3))


def maps_of(light: Light, lines: Polylines, thickness: Thickness = WIDE, workers: int = 2) -> ShadowMaps:
    maps = plan_maps((light,), BOX, Scratch(), thickness)
    assert maps.deep
    assert maps.texels is None
    maps.build(lines, workers, Scratch())
    return maps


def depth(maps: ShadowMaps, light: Light, point: np.ndarray) -> float:
    """τ in front of a point that is on no strand."""
    packed = pack_lights((light,), maps, BOX)
    x, y, z = np.asarray(point, np.float32)
    numbers = packed, 0, maps.stacks, maps.starts, maps.sizes, maps.packed
    return float(optical_depth(x, y, z, np.float32(0), *numbers))


def test_a_map_counts_projected_area() -> None:
    """Σ τ of all texels times their area is Σ width × length × sin of the angle to the light."""
    lines = straight(200)
    maps = maps_of(SUN, lines)
    rows = maps.stacks[opacity.HEAD * 32 * 32 :].reshape(-1, opacity.stride_for(DEEP.layers))
    assert not rows[0].any()  # of cells that no strand comes to
    assert np.count_nonzero(maps.stacks[opacity.ROW : opacity.HEAD * 32 * 32 : opacity.HEAD]) == len(rows) - 1 < 32 * 32
    texels = rows[:, -4:].sum(1, dtype=np.float64)
    whole = texels.sum() / maps.views[0].focal ** 2
    world = lines.world.astype(np.float64).reshape(200, 9, 3)
    pieces = np.diff(world, axis=1)
    way = np.array(SUN.direction) / np.linalg.norm(SUN.direction)
    across = np.linalg.norm(pieces - (pieces @ way)[..., None] * way, axis=2)
    width = WIDE.width * (1 - WIDE.taper * (np.arange(8) + 0.5) / 8)
    assert whole == pytest.approx((across * width).sum(), rel=1e-4)


def test_a_sheet_of_strands_lets_through_what_lies_between_them() -> None:
    """Parallel strands 0.01 wide, 0.04 apart: τ is 0.25, before the sheet nothing."""
    count = 60
    world = np.zeros((count, 2, 3), np.float32)
    world[:, :, 0] = (np.arange(count) - count / 2)[:, None] * 0.04
    world[:, 0, 2], world[:, 1, 2] = -1, 1
    lines = Polylines(np.arange(count + 1) * 2, world.reshape(-1, 3))
    sun = DirectionalLight(direction=(0, -1, 0), shadow=replace(DEEP, texel=0.08))
    maps = maps_of(sun, lines, Thickness(0.01))
    assert maps.sizes[0] < 40
    below = [depth(maps, sun, np.array([x, -0.5, z])) for x in (-0.4, 0.0, 0.33) for z in (-0.3, 0.01)]
    assert np.mean(below) == pytest.approx(0.25, abs=0.02)
    assert [depth(maps, sun, np.array([x, 0.2, 0.1])) for x in (-0.4, 0.0, 0.33)] == [0, 0, 0]


@pytest.mark.parametrize("light", [SUN, LAMP, INSIDE], ids=["sun", "lamp", "inside"])
def test_behind_all_strands_nothing_is_forgotten_and_beside_them_nothing_is_seen(light: Light) -> None:
    lines = straight(2000, 1)
    maps = maps_of(light, lines)
    assert len(maps.views) == (6 if light is INSIDE else 1)
    far = -np.array([2.0, 4.0, 1.0]) if light is LAMP else np.array([-5.0, -10.0, -3.0])
    assert depth(maps, light, far * 0.1) > 0.05
    if light is not INSIDE:
        assert depth(maps, light, np.array([60.0, 70.0, -50.0])) == 0


def test_along_a_ray_nothing_is_uncounted() -> None:
    """On the way from a light it is always the same four texels that a place lies between, in each of which τ grows:
    only rounding of where it lies, some 1e-5 texels, lets it fall."""
    maps = maps_of(SUN, straight(2000, 1))
    for aside in (0.0, 0.07, 0.31):
        rising = [depth(maps, SUN, t * np.array(SUN.direction) + [aside, 0, 0]) for t in np.linspace(-1, 1, 60)]
        assert rising[-1] > rising[0] + 0.05
        print(np.diff(rising).min())
        assert np.diff(rising).min() > -1e-4


def test_a_map_beyond_what_a_kernel_can_address_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    sun, lines = DirectionalLight(direction=(0, -1, 0), shadow=DEEP), straight(300, 4)
    stacks = maps_of(sun, lines).stacks
    monkeypatch.setattr(shadow, "PLACES", len(stacks))
    maps_of(sun, lines)
    monkeypatch.setattr(shadow, "PLACES", len(stacks) - 1)
    with pytest.raises(RefusedError, match=r"shadow.size"):
        maps_of(sun, lines)


@pytest.mark.parametrize("size", [1, 2, 3, 5])
def test_the_smallest_maps_are_whole_cells(size: int) -> None:
    sun = DirectionalLight(direction=(0, -1, 0), shadow=replace(DEEP, size=size))
    lines = straight(300, 4)
    maps = maps_of(sun, lines)
    assert maps.sizes[0] == max(size + size % 2, 4)
    found = np.array([depth(maps, sun, point) for point in np.linspace([-2, -2, -2], [2, 2, 2], 60)])
    assert np.isfinite(found).all()
    assert 0 < found.max() < 100


def test_min_max_and_opacity_maps_stand_side_by_side() -> None:
    lines = straight(300, 4)
    plain = DirectionalLight(direction=(0, -1, 0), shadow=Shadow(size=32))
    maps = plan_maps((SUN, plain, LAMP), BOX, Scratch(), WIDE)
    maps.build(lines, 1, Scratch())
    packed = pack_lights((SUN, plain, LAMP), maps, BOX)
    assert packed[:, 10].tolist() == [13, 0, 13]
    alone = plan_maps((plain,), BOX, Scratch())
    alone.build(lines, 1, Scratch())
    np.testing.assert_array_equal(maps.texels, alone.texels)
    point = np.array([0.1, -0.3, 0.0])
    for number, light in ((0, SUN), (2, LAMP)):
        x, y, z = point.astype(np.float32)
        numbers = (packed, number, maps.stacks, maps.starts, maps.sizes, maps.packed)
        here = optical_depth(x, y, z, np.float32(0), *numbers)
        assert float(here) == depth(maps_of(light, lines), light, point) > 0


PICTURE = """
seed: 1
emitter: {strands: 400, particles: 6, jitter: 10, shape: {kind: disc, radius: 0.5}}
rules: []
solids: [{kind: plane, colour: [0.5, 0.5, 0.5]}, {kind: sphere, radius: 0.3, position: [0.3, 0.4, 0.2]}]
camera: {position: [0, 2, 4]}
image: {size: 80x60}
material: {width: 0.01, model: chiang, pigment: blond, scatter: %s}
lights:
  - {kind: directional, direction: [1, -1, -0.2], shadow: {model: %s}}
  - {kind: point, position: [-3, 2, 1], shadow: {model: %s}}
"""
