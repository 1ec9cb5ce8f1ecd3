"""Deep opacity maps: what is counted, what is let through, against rays that meet cylinders."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from shadow_kit import minmax_transmittance, optical_depth
from shadow_kit import transmittance as left_of
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.geometry.extent import Thickness
from strandcli.draw.lighting.lighting import pack_lights
from strandcli.draw.shadows import shadow
from strandcli.draw.shadows.kernels import minmax as minmax
from strandcli.draw.shadows.kernels import opacity
from strandcli.draw.shadows.shadow import ShadowMaps, plan_maps
from strandcli.errors import RefusedError
from strandcli.scene.model import DirectionalLight, Light, PointLight, Shadow
from strandcli.study.pictures.shadow import BUNDLE, bundle, transmittance

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


def read_by(maps: ShadowMaps, *lights: Light, number: int = 0, bounds: np.ndarray = BOX) -> tuple[Any, ...]:
    """What a light is looked up in, after a place: the lights as numbers, its own number, and the maps."""
    packed = pack_lights(lights, maps, bounds)
    return packed, number, maps.stacks if maps.deep else maps.texels, maps.starts, maps.sizes, maps.packed


def depth(maps: ShadowMaps, light: Light, point: np.ndarray) -> float:
    """τ in front of a point that is on no strand."""
    return float(optical_depth(*np.float32(point), np.float32(0), *read_by(maps, light)))


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
    assert read_by(maps, SUN, plain, LAMP)[0][:, 10].tolist() == [13, 0, 13]
    alone = plan_maps((plain,), BOX, Scratch())
    alone.build(lines, 1, Scratch())
    np.testing.assert_array_equal(maps.texels, alone.texels)
    point = np.array([0.1, -0.3, 0.0])
    for number, light in ((0, SUN), (2, LAMP)):
        here = optical_depth(*np.float32(point), np.float32(0), *read_by(maps, SUN, plain, LAMP, number=number))
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


def off_by(
    lines: Polylines, light: Light, points: np.ndarray, truth: np.ndarray, thickness: Thickness, spacing: float
) -> np.ndarray:
    """What a light's map says of the points, less the truth."""
    bounds = np.stack([lines.world.min(0), lines.world.max(0)]).astype(np.float64)
    maps = plan_maps((light,), bounds, Scratch(), thickness, spacing)
    maps.build(lines, 1, Scratch())
    numbers = read_by(maps, light, bounds=bounds)
    if maps.deep:
        found = [left_of(*point, numbers[0][0, 13], *numbers) for point in np.float32(points)]
    else:
        found = [minmax_transmittance(*point, *numbers) for point in np.float32(points)]
    return np.array(found) - truth


def test_a_strand_alone_loses_next_to_no_light() -> None:
    """With texels as they are chosen for it: .06 % in the mean, 2.8 % at the most, from whatever side it is lit."""
    deep = Shadow(model="opacity")
    shade = []
    for seed in range(40):
        lines = straight(1, seed)
        for light in (DirectionalLight(direction=(-0.5, -1.0, -0.3), shadow=deep), replace(LAMP, shadow=deep)):
            points = lines.world[1:-1]
            shade.append(off_by(lines, light, points, np.ones(len(points)), Thickness(0.02), 0.0))
    assert np.mean(shade) > -0.001
    assert np.min(shade) > -0.03


def test_where_strands_lie_apart_a_map_is_read_with_a_wider_window() -> None:
    """Behind a sheet, where τ does not grow: of strands 6 texels apart it is lower in the middle of a shadow, of
    a dense sheet the same, but for half of what a strand has in a texel."""
    sun = DirectionalLight(direction=(0, -1, 0), shadow=DEEP)
    spread = {}
    for apart in (6, 0.5):
        step = apart * 3.5 / 64
        count = int(1.2 / step)
        world = np.zeros((count, 2, 3), np.float32)
        world[:, :, 0] = (np.arange(count) - count / 2)[:, None] * step
        world[:, 0, 2], world[:, 1, 2] = -0.6, 0.6
        lines = Polylines(np.arange(count + 1) * 2, world.reshape(-1, 3))
        maps = maps_of(sun, lines, Thickness(0.01))
        numbers = read_by(maps, sun)
        asked = [np.float32((x, -0.5, 0.01)) for x in np.linspace(-0.3, 0.3, 200)]
        for width in (np.float32(0), numbers[0][0, 13]):
            spread[apart, width > 0] = np.array([optical_depth(*point, width, *numbers) for point in asked])
    own = 0.375 * 0.01 * maps.views[0].focal / 2
    assert np.abs(spread[0.5, True] + own - spread[0.5, False]).mean() < 0.01
    assert -2 * own + 0.02 < spread[6, True].max() - spread[6, False].max() < -own - 0.02


def test_crowded_strands_let_less_light_through_than_independent_ones() -> None:
    """Sheets as far from each other as the strands in them: by a part of τ (width / distance)², whose estimate does not
    waver with layers thinner than a sheet's distance; always less than if each strand had a slot of its own."""
    sun = DirectionalLight(direction=(0, -1, 0), shadow=replace(DEEP, layers=127))
    step = 0.5 * 3.5 / 64
    across = np.arange(-0.4, 0.4, step)
    deep = np.arange(-0.4, 0.4, step)
    world = np.zeros((len(deep), len(across), 2, 3), np.float32)
    world[..., 0] = (across + step * np.random.default_rng(0).random((len(deep), 1)))[:, :, None]
    world[..., 1] = deep[:, None, None]
    world[..., 0, 2], world[..., 1, 2] = -0.6, 0.6
    lines = Polylines(np.arange(world[..., 0, 0].size + 1) * 2, world.reshape(-1, 3))
    for share in (0.05, 0.7):
        maps = maps_of(sun, lines, Thickness(share * step))
        numbers = read_by(maps, sun)
        for y in np.linspace(0.2, -0.1, 40, dtype=np.float32):
            place = np.float32(0.01), y, np.float32(0.02)
            own = 0.375 * share * step * maps.views[0].focal
            independent = float(optical_depth(*place, np.float32(0), *numbers)) - own
            found = float(optical_depth(*place, numbers[0][0, 13], *numbers))
            grown = float(opacity.CROWDED) * share**2 * independent**2
            assert found == pytest.approx(independent + grown, abs=0.005 + 0.35 * grown)
            assert found <= independent * -np.log(1 - share) / share + 1e-3


@pytest.mark.parametrize("light", [SUN, LAMP], ids=["sun", "lamp"])
def test_transmittance_agrees_with_rays_that_meet_cylinders(light: Light) -> None:
    """Mean error under .03 on a groom of three thousand strands; a min/max map is off by some ten times that."""
    lines = straight(3000, 7)
    thickness, spacing = Thickness(0.008, 0.3), 0.04
    rng = np.random.default_rng(0)
    own = rng.integers(0, 3000, 600)
    vertex, part = 9 * own + rng.integers(0, 8, 600), rng.random((600, 1))
    points = (1 - part) * lines.world[vertex] + part * lines.world[vertex + 1]
    jitter, wide = bundle(1024, BUNDLE * spacing, rng), np.ones(600)
    truth = transmittance(lines, thickness, light, points, own, jitter, wide).mean(1)
    assert 0.1 < truth.mean() < 0.9
    deep = off_by(lines, replace(light, shadow=Shadow(model="opacity")), points, truth, thickness, spacing)
    assert np.abs(deep).mean() < 0.03
    assert abs(deep.mean()) < 0.015
    flat = off_by(lines, replace(light, shadow=Shadow(size=128)), points, truth, thickness, spacing)
    assert np.abs(flat).mean() > 0.25
