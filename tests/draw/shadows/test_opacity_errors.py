"""What opacity maps let through, against rays that meet cylinders, and what a strand alone loses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from shadow_kit import minmax_transmittance, optical_depth
from shadow_kit import transmittance as left_of
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.geometry.extent import Thickness
from strandcli.draw.lighting.lighting import pack_lights
from strandcli.draw.shadows.kernels import minmax as minmax
from strandcli.draw.shadows.kernels import opacity
from strandcli.draw.shadows.shadow import plan_maps
from strandcli.scene.model import DirectionalLight, Light, Shadow
from strandcli.study.pictures.shadow import BUNDLE, bundle, transmittance
from tests.draw.shadows.test_opacity import BOX, DEEP, LAMP, SUN, maps_of, straight


def off_by(
    lines: Polylines, light: Light, points: np.ndarray, truth: np.ndarray, thickness: Thickness, spacing: float
) -> np.ndarray:
    """What a light's map says of the points, less the truth."""
    bounds = np.stack([lines.world.min(0), lines.world.max(0)]).astype(np.float64)
    maps = plan_maps((light,), bounds, Scratch(), thickness, spacing)
    maps.build(lines, 1, Scratch())
    packed = pack_lights((light,), maps, bounds)
    rest = packed, 0, maps.stacks if maps.deep else maps.texels, maps.starts, maps.sizes, maps.packed
    if maps.deep:
        found = [left_of(*point, packed[0, 13], *rest) for point in np.float32(points)]
    else:
        found = [minmax_transmittance(*point, *rest) for point in np.float32(points)]
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
        packed = pack_lights((sun,), maps, BOX)
        asked = [np.float32((x, -0.5, 0.01)) for x in np.linspace(-0.3, 0.3, 200)]
        for width in (np.float32(0), packed[0, 13]):
            numbers = (packed, 0, maps.stacks, maps.starts, maps.sizes, maps.packed)
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
        packed = pack_lights((sun,), maps, BOX)
        numbers = (packed, 0, maps.stacks, maps.starts, maps.sizes, maps.packed)
        for y in np.linspace(0.2, -0.1, 40, dtype=np.float32):
            place = np.float32(0.01), y, np.float32(0.02)
            own = 0.375 * share * step * maps.views[0].focal
            independent = float(optical_depth(*place, np.float32(0), *numbers)) - own
            found = float(optical_depth(*place, packed[0, 13], *numbers))
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
    truth = transmittance(lines, thickness, light, points, own, bundle(1024, BUNDLE * spacing, rng)).mean(1)
    assert 0.1 < truth.mean() < 0.9
    deep = off_by(lines, replace(light, shadow=Shadow(model="opacity")), points, truth, thickness, spacing)
    assert np.abs(deep).mean() < 0.03
    assert abs(deep.mean()) < 0.015
    flat = off_by(lines, replace(light, shadow=Shadow(size=128)), points, truth, thickness, spacing)
    assert np.abs(flat).mean() > 0.25
