"""The min/max shadow map, what it lets through; and what opacity maps leave out, strands deep in shadow."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shadow_kit import minmax_transmittance
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.geometry.extent import Thickness
from strandcli.draw.lighting.lighting import pack_lights
from strandcli.draw.shadows.kernels.deep_strands import WEIGHTS
from strandcli.draw.shadows.kernels.map_parts import WIDE as WIDTH
from strandcli.draw.shadows.shadow import ShadowMaps, plan_maps
from strandcli.draw.shadows.strands_in_map import FEWEST, chances_of
from strandcli.scene.model import DirectionalLight, Light, PointLight, Shadow
from tests.draw.shadows.test_opacity import depth, straight
from tests.draw.view.test_camera import exact as project

BOX = np.array([[-1.0, -1, -1], [1, 1, 1]])
SUN = DirectionalLight(direction=(-0.5, -1.0, -0.3), shadow=Shadow(size=64))
LAMP = PointLight(position=(2.0, 4.0, 1.0), shadow=Shadow(size=64))
INSIDE = PointLight(position=(0.1, 0.05, -0.1), shadow=Shadow(size=64))
ROUND = 3e-6
"""What the kernel's polynomial for the exponential function may be off."""


def walks(count: int, seed: int = 0) -> Polylines:
    """Polylines that stay in the box."""
    rng = np.random.default_rng(seed)
    world = np.clip(rng.uniform(-1, 1, (count, 1, 3)) + rng.normal(0, 0.1, (count, 8, 3)).cumsum(1), -1, 1)
    return Polylines(np.arange(count + 1) * 8, world.astype(np.float32).reshape(-1, 3))


def maps_of(light: Light, *lines: Polylines, workers: int = 2) -> ShadowMaps:
    maps = plan_maps((light,), BOX, Scratch())
    for one in lines:
        maps.add(one, workers, Scratch())
    return maps


def through(maps: ShadowMaps, light: Light, point: np.ndarray) -> float:
    packed = pack_lights((light,), maps, BOX)
    x, y, z = np.asarray(point, np.float32)
    return float(minmax_transmittance(x, y, z, packed, 0, maps.texels, maps.starts, maps.sizes, maps.packed))


@pytest.mark.parametrize("light", [SUN, LAMP, INSIDE], ids=["sun", "lamp", "inside"])
def test_maps_hold_the_nearest_and_farthest_of_samples_a_texel_apart(light: Light) -> None:
    lines = walks(50)
    maps = maps_of(light, lines)
    assert len(maps.views) == (6 if light is INSIDE else 1)
    for number, view in enumerate(maps.views):
        start, size = maps.starts[number], int(maps.sizes[number])
        found = maps.texels[start : start + size * size].reshape(size, size, 2).astype(np.float64)
        pixels, z = project(view, lines.world)
        near, far = np.full((size, size), np.inf), np.full((size, size), -np.inf)
        unsure = np.zeros((size, size), bool)
        for v in range(len(lines.world) - 1):
            if v % 8 == 7:
                continue
            if min(z[v], z[v + 1]) < view.near:
                if max(z[v], z[v + 1]) >= view.near:
                    unsure[:] |= light is INSIDE  # it is clipped there; that is the projection's matter
                continue
            count = max(int(np.ceil(np.abs(pixels[v + 1] - pixels[v]).max())), 1)
            share = ((np.arange(count) + 0.5) / count)[:, None]
            at = pixels[v] + share * (pixels[v + 1] - pixels[v])
            depth = z[v] + share[:, 0] * (z[v + 1] - z[v])
            doubt = (np.abs(at - np.rint(at)) < 2e-3).any(1)
            for (x, y), d, q in zip(np.floor(at).astype(int), depth, doubt, strict=True):
                if q:
                    unsure[max(y - 1, 0) : y + 2, max(x - 1, 0) : x + 2] = True
                if 0 <= x < size and 0 <= y < size:
                    near[y, x], far[y, x] = min(near[y, x], d), max(far[y, x], d)
        sure = ~unsure
        there = sure & np.isfinite(near)
        assert (np.isfinite(found[..., 0]) == np.isfinite(near))[sure].all()
        if light is not INSIDE:
            assert there.sum() > 100
        np.testing.assert_allclose(found[there], np.stack([near, far], -1)[there], atol=2e-5)


def test_lights_without_maps_have_none() -> None:
    off = DirectionalLight(shadow=Shadow(model="off"))
    dark = DirectionalLight(intensity=0.0)
    black = PointLight(colour=(0.0, 0.0, 0.0))
    assert plan_maps((off, dark, black), BOX, Scratch()) is None
    maps = plan_maps((off, LAMP, dark, INSIDE), BOX, Scratch())
    assert maps.owners == [(0, 0), (0, 1), (1, 0), (1, 6)]
    packed = pack_lights((off, LAMP, dark, INSIDE), maps, BOX)
    assert packed[:, [0, 7, 8]].tolist() == [[0, 0, 0], [1, 0, 1], [1, 1, 6]]


def filled(light: Light, near: float, far: float) -> ShadowMaps:
    maps = maps_of(light)
    maps.texels[:, 0], maps.texels[:, 1] = near, far
    return maps


def at_depth(maps: ShadowMaps, depth: float) -> np.ndarray:
    """A point near the middle of a light's first map, at a depth from it."""
    view = maps.views[0]
    return np.asarray(view.eye + depth * (view.forward + 0.01 * view.right))


@pytest.mark.parametrize("light", [SUN, LAMP], ids=["sun", "lamp"])
@pytest.mark.parametrize("thickness", [0.5, 1e-2])
def test_what_is_let_through_is_the_sources_curve_with_its_fraction_turned(light: Light, thickness: float) -> None:
    """1 − (eˣ − 1) / (e − 1) with x = (d − r) / (a − r)."""
    start = maps_of(light).views[0].near + 1.0
    maps = filled(light, start, start + thickness)
    bias = float(pack_lights((light,), maps, BOX)[0, 9])
    assert 0 < bias < 0.1
    got = []
    for x in np.linspace(-0.5, 1.5, 41):
        y = np.clip((np.exp(np.clip(x, 0, 1)) - 1) / (np.e - 1), 0, 1)
        got.append(through(maps, light, at_depth(maps, start + bias + x * thickness)))
        assert got[-1] == pytest.approx(1 - y, abs=ROUND + 4e-6 / thickness)
    assert (got[0], got[-1]) == pytest.approx((1, 0), abs=ROUND)
    assert (np.diff(got) <= 0).all()


@pytest.mark.parametrize("light", [SUN, LAMP], ids=["sun", "lamp"])
def test_a_single_layer_is_lit_in_front_and_dark_behind(light: Light) -> None:
    """a = r: no division by nothing."""
    start = maps_of(light).views[0].near + 1.0
    maps = filled(light, start, start)
    bias = float(pack_lights((light,), maps, BOX)[0, 9])
    values = [through(maps, light, at_depth(maps, start + bias + way)) for way in (-0.5, -1e-3, 1e-3, 0.5)]
    assert values == pytest.approx([1, 1, 0, 0], abs=ROUND)


def test_between_texels_it_is_linear() -> None:
    maps = maps_of(SUN)
    view = maps.views[0]
    texels = maps.texels.reshape(64, 64, 2)
    texels[...] = 0.0
    texels[20, 30] = [np.inf, -np.inf]  # the only one that lets light through
    for u, v in ((0, 0), (0.25, 0), (0, 0.75), (0.5, 0.5), (-0.4, 0.2), (1, 0), (0, -1.2)):
        right, up = (30.5 + u - 32) / view.focal, (32 - 20.5 - v) / view.focal
        point = view.eye + right * view.right + up * view.up + view.forward
        expected = max(1 - abs(u), 0) * max(1 - abs(v), 0)
        assert through(maps, SUN, point) == pytest.approx(expected, abs=2e-3)


def test_a_given_bias_replaces_the_default() -> None:
    light = DirectionalLight(shadow=Shadow(size=64, bias=0.3))
    maps = filled(light, 1.0, 1.0)
    assert through(maps, light, at_depth(maps, 1.29)) == pytest.approx(1, abs=ROUND)
    assert through(maps, light, at_depth(maps, 1.31)) == pytest.approx(0, abs=ROUND)


def shell(radius: float) -> Polylines:
    """Rings close together, all over a sphere about the light inside."""
    rings, around = 240, 300
    polar = (np.arange(rings) + 0.5) * np.pi / rings
    angle = np.linspace(0, 2 * np.pi, around + 1)
    world = np.empty((rings, around + 1, 3))
    world[..., 0] = np.sin(polar)[:, None] * np.cos(angle)
    world[..., 1] = np.cos(polar)[:, None]
    world[..., 2] = np.sin(polar)[:, None] * np.sin(angle)
    first = np.arange(rings + 1) * (around + 1)
    return Polylines(first, (np.array(INSIDE.position) + radius * world).astype(np.float32).reshape(-1, 3))


def test_a_light_inside_shades_all_round_its_cube_of_maps() -> None:
    light = PointLight(position=INSIDE.position, shadow=Shadow(size=32))
    maps = maps_of(light, shell(0.5))
    rng = np.random.default_rng(3)
    ways = rng.normal(size=(600, 3))
    # and along the edges and corners of the cube, where one map ends and the next begins
    edges = rng.choice([-1.0, 1.0], (600, 3))
    edges[:, 0] *= rng.uniform(0, 1, 600)
    edges += rng.normal(0, 0.01, (600, 3))
    for way in np.concatenate([ways, edges]):
        way = way / np.linalg.norm(way)
        assert through(maps, light, np.array(light.position) + 0.25 * way) == pytest.approx(1, abs=ROUND)
        assert through(maps, light, np.array(light.position) + 0.75 * way) == pytest.approx(0, abs=ROUND)


@settings(max_examples=100, deadline=None)
@given(
    st.tuples(*[st.floats(-1e6, 1e6, width=32) | st.floats(-2, 2, width=32)] * 3), st.sampled_from([SUN, LAMP, INSIDE])
)
def test_a_share_of_light_is_between_nothing_and_all(point: tuple[float, float, float], light: Light) -> None:
    maps = SHARED.setdefault(light, maps_of(light, walks(50)))
    assert 0 <= through(maps, light, np.array(point)) <= 1


SHARED: dict[Light, ShadowMaps] = {}


LAYERED = DirectionalLight(direction=(-0.5, -1.0, -0.3), shadow=Shadow(model="opacity", layers=31))
THICK = Thickness(0.02, 0.3)
SPACING = 0.04
STRANDS = 6000


def layers_of(lines: Polylines, chances: np.ndarray | None) -> ShadowMaps:
    maps = plan_maps((LAYERED,), BOX, Scratch(), THICK, SPACING)
    maps.chances = chances
    maps.build(lines, 2, Scratch())
    return maps


def drawn(maps: ShadowMaps, lines: Polylines) -> tuple[int, float]:
    """How many segments a map is drawn of, and how much they cover, texels."""
    parts = maps.parts(0, lines, 1, Scratch())
    count, area = 0, 0.0
    for begin, vertices in parts.order[:, :2]:
        kept = parts.vertices[begin : begin + vertices].astype(np.float64)
        there = kept[1:, WIDTH] >= 0
        count += np.count_nonzero(there)
        area += (np.hypot(*np.diff(kept[:, :2], axis=0).T) * kept[1:, WIDTH])[there].sum()
    return count, area


def test_weights_make_up_for_what_is_left_out() -> None:
    chances = (np.arange(10_000) + 0.5) / 10_000
    for most, slope, top in WEIGHTS.astype(np.float64):
        weights = np.clip((most - chances) * slope, 0, top)
        assert weights.mean() == pytest.approx(1, abs=1e-3)
        assert (np.diff(weights) <= 0).all()
    assert np.allclose(np.clip((WEIGHTS[0, 0] - chances) * WEIGHTS[0, 1], 0, WEIGHTS[0, 2]), 1, atol=1e-6)


def test_part_of_a_dense_ball_is_left_out_and_light_is_the_same() -> None:
    """Mean of four choices of strands, of which one is 1.5 % off in what is covered, standard deviation."""
    lines = straight(STRANDS, 3)
    whole = layers_of(lines, None)
    every, area = drawn(whole, lines)
    points = np.random.default_rng(1).uniform(-0.6, 0.6, (400, 3))
    full = np.array([depth(whole, LAYERED, point) for point in points])
    assert (full > 8).mean() > 0.3
    assert (full < 3).mean() > 0.2
    shares, deep = [], []
    for choice in range(4):
        ids = np.arange(STRANDS, dtype=np.int32) + 100_000 * choice
        some = layers_of(lines, chances_of(ids, STRANDS))
        few, covered = drawn(some, lines)
        found = np.array([depth(some, LAYERED, point) for point in points])
        off = np.abs(np.exp(-found) - np.exp(-full))
        assert few < 0.72 * every
        assert off.mean() < 0.005
        assert off[full < 2].mean() < 0.015
        shares.append(covered / area)
        deep.append((found[full > 8] / full[full > 8]).mean())
    assert np.mean(shares) == pytest.approx(1, abs=0.03)
    assert np.mean(deep) == pytest.approx(1, abs=0.06)


@pytest.mark.parametrize("strands", [FEWEST - 1, STRANDS])
def test_nothing_is_left_out_of_few_strands_or_thin_ones(strands: int) -> None:
    lines = straight(strands, 3)
    maps = plan_maps((LAYERED,), BOX, Scratch(), THICK if strands < FEWEST else Thickness(0.0005), SPACING)
    before = drawn(maps, lines)
    maps.chances = chances_of(None, strands)
    assert drawn(maps, lines) == before
