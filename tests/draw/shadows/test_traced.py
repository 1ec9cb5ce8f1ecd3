"""Exact shadows of strands on strands, against rays that meet cylinders."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from strand_kit import frames_of, scene_of
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.coverage.kernels.column_light import LINES
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.geometry.extent import Thickness
from strandcli.draw.shadows.traced import Grid, grid_of
from strandcli.draw.view.camera import parallel_view
from strandcli.scene.model import DirectionalLight, Light, PointLight, Shadow
from strandcli.study.pictures.shadow import transmittance

EXACT = Shadow(model="traced")
SUN = DirectionalLight(direction=(-0.5, -1.0, -0.3), shadow=EXACT)
LAMP = PointLight(position=(2.0, 4.0, 1.0), shadow=EXACT)
INSIDE = PointLight(position=(0.1, 0.05, -0.1), shadow=EXACT)
THIN = Thickness(0.004, 0.5)
WIDE = Thickness(0.02, 0.5)
RAYS = 64


def bent(count: int, seed: int = 0, pieces: int = 6) -> Polylines:
    """Strands that turn, but never so far that one is before itself: what rays find leaves a strand's own shade out."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 1, pieces + 1)[:, None]
    begin, one, two = (rng.normal(size=(count, 1, 3)) for _ in range(3))
    one *= 0.4 / np.linalg.norm(one, axis=2, keepdims=True)
    begin, two = 0.3 * begin, 0.04 * two
    world = begin + one * t + two * t**2
    return Polylines(np.arange(count + 1) * (pieces + 1), world.astype(np.float32).reshape(-1, 3))


def grid(light: Light, lines: Polylines, thickness: Thickness = WIDE, opacity: float = 1.0, workers: int = 2) -> Grid:
    bounds = np.stack([lines.world.min(0), lines.world.max(0)]).astype(np.float64)
    return grid_of(light, lines, thickness, opacity, bounds, workers, Scratch())


def visible(grid: Grid, lines: Polylines, screen: np.ndarray | None = None) -> np.ndarray:
    """Of all vertices; to a camera that sees none, so that the mean is over a piece to each side."""
    count = len(lines.world)
    out = np.full(count, np.nan, np.float32)
    marks = np.ones(count, np.uint8)
    grid.visibility(lines, marks, np.zeros((count, 3), np.float32) if screen is None else screen, out)
    return out.astype(np.float64)


def truth(light: Light, lines: Polylines, chosen: np.ndarray, thickness: Thickness = WIDE) -> np.ndarray:
    """The same by rays from many points of the pieces beside each of the chosen vertices."""
    before, here, behind = (lines.world[chosen + step, None].astype(np.float64) for step in (-1, 0, 1))
    t = ((np.arange(RAYS) + 0.5) / RAYS)[:, None]
    points = np.concatenate([before + t * (here - before), here + t * (behind - here)], 1)
    weights = np.concatenate([t, 1 - t])[:, 0] / RAYS  # a hat
    own = np.searchsorted(lines.first, chosen, "right") - 1
    found = transmittance(lines, thickness, light, points.reshape(-1, 3), np.repeat(own, 2 * RAYS), np.zeros((2, 2)))
    return found.mean(1).reshape(-1, 2 * RAYS) @ weights


@pytest.mark.parametrize("light", [SUN, LAMP, INSIDE], ids=["sun", "lamp", "inside"])
def test_light_is_what_rays_find(light: Light) -> None:
    lines = bent(2000)
    vertices = np.arange(len(lines.world)).reshape(2000, 7)
    chosen = np.random.default_rng(1).permutation(vertices[:, 1:-1].ravel())[:200]
    reference = truth(light, lines, chosen, THIN)
    off = visible(grid(light, lines, THIN), lines)[chosen] - reference
    assert 0.2 < reference.mean() < 0.8
    # 128 rays have a noise of their own, the more so the fewer strands share a lamp nearby; and their cylinders have
    # round ends, which takes .004 more of the light
    assert np.abs(off).mean() < (0.016 if light is INSIDE else 0.009)
    assert np.abs(off.mean()) < 0.006


def test_a_strand_that_lets_light_through_lets_through_what_it_says() -> None:
    """A wide strand over a long one, of which it hides the middle third."""

    under = [[[-0.3, 0, z], [0.3, 0, z]] for z in np.linspace(-0.9, 0.9, 40)]

    def found(opacity: float, height: float = 0.5, bias: float = 0.0) -> np.ndarray:
        world = np.array([*under, [[0, height, -1], [0, height, 1]]], np.float32).reshape(-1, 3)
        lines = Polylines(np.arange(0, 83, 2), world)
        sun = DirectionalLight(direction=(0, -1, 0), shadow=replace(EXACT, bias=bias))
        return visible(grid(sun, lines, Thickness(0.2), opacity), lines)[:80]

    # half of one place in 64 may be dark or not at each end
    np.testing.assert_allclose(found(1.0), 2 / 3, atol=0.016)
    # behind what lets light through each place is dark or not by chance
    for opacity in (0.6, 0.1):
        assert found(opacity).mean() == pytest.approx(1 - opacity / 3, abs=0.016)
        assert found(opacity).std() < 0.06
    assert (found(1.0, height=-0.5) == 1).all()
    assert (found(1.0, bias=0.6) == 1).all()


def test_a_straight_strand_does_not_shade_itself_and_one_that_turns_back_does() -> None:
    straight = np.linspace([0, 0, 0], [0.3, 1, 0], 40, dtype=np.float32)
    back = np.array([[0, 0, 0], [0.5, 0, 0], [1, 0, 0], [1, 0.5, 0], [0.5, 0.5, 0], [0, 0.5, 0], [0, 0.6, 0]])
    sun = DirectionalLight(direction=(0.001, -1, 0), shadow=EXACT)
    for world, dark in ((straight, False), (back.astype(np.float32), True)):
        lines = Polylines(np.array([0, len(world)]), world)
        assert (visible(grid(sun, lines), lines).min() < 0.1) == dark


def test_light_is_averaged_over_a_sample_at_least() -> None:
    """A strand of many pieces within one sample has one light."""
    lines = bent(200, pieces=12)
    light = visible(grid(SUN, lines), lines)
    screen = np.ones((len(lines.world), 3), np.float32)
    screen[:, 0] = np.tile(np.arange(13) / 12, 200)
    whole = visible(grid(SUN, lines), lines, screen)
    spread = [np.abs(np.diff(values.reshape(200, 13), axis=1)).mean() for values in (light, whole)]
    assert spread[1] < 0.25 * spread[0]
    assert whole.mean() == pytest.approx(light.mean(), abs=0.01)


def test_neither_workers_nor_portions_of_marks_nor_the_grid_change_a_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    lines = bent(300, 2)
    one = visible(grid(LAMP, lines, workers=1), lines)
    np.testing.assert_array_equal(visible(grid(LAMP, lines, workers=2), lines), one)
    marks = np.zeros(len(lines.world), np.uint8)
    marks[::3] = 1
    out = np.full(len(marks), -1, np.float32)
    grid(LAMP, lines).visibility(lines, marks, np.zeros((len(marks), 3), np.float32), out)
    np.testing.assert_array_equal(out[::3], one[::3].astype(np.float32))
    assert (out[1::3] == -1).all()
    monkeypatch.setattr("strandcli.draw.shadows.traced.LIST", 64.0)  # cells that may still be fewer
    fine = grid(LAMP, lines)
    bounds = np.stack([lines.world.min(0), lines.world.max(0)]).astype(np.float64)
    coarse = grid_of(LAMP, lines, WIDE, 1.0, bounds, 2, Scratch(), room=fine.nbytes // 3)
    assert coarse.nbytes < fine.nbytes
    assert coarse.lists.sizes[0] < fine.lists.sizes[0]
    assert np.abs(visible(coarse, lines) - one).max() < 0.02


def test_strands_without_vertices_are_as_if_they_were_not() -> None:
    """As those are that level of detail leaves out: first, last, and in between."""
    lines = bent(50)
    first = lines.first
    begin = np.concatenate([[0, 0], first[:20], first[19:20], first[20:], first[-1:], first[-1:]])
    holes = Polylines(begin, lines.world)
    one, two = grid(SUN, lines), grid(SUN, holes)
    np.testing.assert_array_equal(one.lists.sizes, two.lists.sizes)
    np.testing.assert_array_equal(visible(one, lines), visible(two, holes))
    alone = Polylines(np.array([0, 0, 0]), np.zeros((0, 3), np.float32))
    thin = grid_of(SUN, alone, WIDE, 1.0, np.array([[-1.0] * 3, [1.0] * 3]), 2, Scratch())
    assert visible(thin, alone).shape == (0,)


def test_what_has_no_length_or_width_shades_nothing_and_is_lit() -> None:
    world = np.array([[0, 0, 0]] * 3 + [[0, 1, 0]] * 3 + [[0, 0.5, 0], [0, 0.5, 1e-7], [1e-7, 0.5, 0]], np.float32)
    lines = Polylines(np.array([0, 3, 6, 9]), world)
    for light in (SUN, LAMP, INSIDE):
        assert (visible(grid(light, lines), lines) == 1).all()
        assert (visible(grid(light, bent(50), Thickness(0.0)), bent(50)) == 1).all()


PRESET = """\
title: brush
emitter: {shape: {kind: disc, radius: 0.3}, strands: 300, particles: 6, length: 0.5, jitter: 30}
rules: []
camera: {position: [0, 0.6, 2], target: [0, 0.2, 0], fov: 30}
image: {size: [60, 40], resolver: sorted}
lights: [{kind: directional, direction: [-0.4, -1, -0.2], shadow: {model: traced}}]
material: {width: 0.01, diffuse: 1, specular: 0}
"""


OTHERWISE = {
    "alone": (),
    "finer": ("image: {size: [60, 40], resolver: sorted}", "image: {size: [60, 40], resolver: sorted, supersample: 2}"),
    "zbuffer": ("resolver: sorted", "supersample: 4"),
    "on the ground": ("rules: []", "rules: []\nsolids: [{kind: plane}]"),
    "from strand to strand": ("diffuse: 1, specular: 0", "model: chiang, pigment: blond, scatter: dual"),
    "from a lamp": ("kind: directional, direction: [-0.4, -1, -0.2]", "kind: point, position: [1, 2, 1]"),
}


@pytest.mark.parametrize("other", OTHERWISE.values(), ids=OTHERWISE)
def test_pictures_with_exact_shadows(other: tuple[str, str]) -> None:
    """As light as with opacity maps, which are right on average, and darker than without shadows."""
    text = PRESET.replace(*other) if other else PRESET
    assert not other or text != PRESET
    frames = [frames_of(scene_of(text.replace("traced", model)), 1)[0] for model in ("traced", "opacity", "'off'")]
    exact, maps, none = (frame.image.astype(np.float64).mean() for frame in frames)
    assert exact < 0.98 * none
    assert exact == pytest.approx(maps, rel=0.05)
    assert frames[0].report["counts"]["grid_bytes"] > 0


def test_motion_blur_and_a_lens_have_exact_shadows_too() -> None:
    scene = scene_of(PRESET.replace("fov: 30}", "fov: 30, aperture: 0.1, shutter: 0.5, samples: 4}"))
    sharp = frames_of(scene_of(PRESET), 1)[0].image.astype(np.float64)
    assert frames_of(scene, 1)[0].image.mean() == pytest.approx(sharp.mean(), rel=0.05)


@pytest.mark.parametrize(("pixels", "alike"), [(400, 1), (64, 2), (16, 4)])
@pytest.mark.parametrize("edge", [0.5, 0.4, 0.2])
def test_a_shadow_has_its_edge_where_it_falls_across_the_width(edge: float, pixels: int, alike: int) -> None:
    """Light from 60° aside, of which a second strand keeps what passes to the left of the first one's middle, by half a
    radius and more: there the side is dark that the eye sees to the left of h = ½, .4 or .2. The fewer samples show the
    width, the fewer lines across it are traced."""
    turn, radius = np.radians(60.0), 0.01
    way = np.array([np.sin(turn), 0.0, np.cos(turn)])
    aside = np.array([np.cos(turn), 0.0, -np.sin(turn)])
    left = -np.sin(np.arcsin(edge) - turn)
    post = np.linspace(-1.0, 1.0, 9)[:, None] * [0.0, 1.0, 0.0]
    world = np.concatenate([post, post + 0.3 * way - (1 + left) * radius * aside]).astype(np.float32)
    lines = Polylines(np.array([0, 9, 18]), world)
    slots = np.arange(18, dtype=np.int32)
    shades = np.zeros((18, LINES), np.uint64)
    out = np.full(18, np.nan, np.float32)
    eye = parallel_view((0.0, 0.0, -1.0), pixels, np.array([[-1.0] * 3, [1.0] * 3]))
    light = DirectionalLight(direction=tuple(-way), shadow=EXACT)
    grid(light, lines, Thickness(2 * radius, 0.0)).visibility(
        lines, np.ones(18, np.uint8), np.zeros((18, 3), np.float32), out, eye, slots, None, shades
    )
    offsets = np.repeat((2 * np.arange(LINES / alike) + 1) / (LINES / alike) - 1, alike)
    dark = (np.uint64(0xFFFFFFFFFFFFFFFF) * (offsets < edge)).astype(np.uint64)
    np.testing.assert_array_equal(shades[1:7], np.broadcast_to(dark, (6, LINES)))
    np.testing.assert_allclose(out[2:7], (offsets > edge).mean(), atol=1e-6)
    assert not shades[9:17].any()  # nothing stands before the other one


def test_a_strand_that_points_to_the_light_is_not_in_its_own_shade() -> None:
    """Along its whole length, though it is bent by as much as its radius."""
    t = np.linspace(0, 1, 13)[:, None]
    world = (-t * [0.5, 1.0, 0.3] + 0.01 * np.sin(3 * t) * [1.0, 0.0, 0.0]).astype(np.float32)
    lines = Polylines(np.array([0, 13]), world)
    np.testing.assert_array_equal(visible(grid(SUN, lines), lines), 1.0)
