"""Wide strands: which is seen where they touch, against rays at cylinders, and light across them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from strand_kit import groom_of, scene_of
from strandcli.common.registry import FIBRES
from strandcli.draw.common.kernels.keys import EMPTY
from strandcli.draw.common.kernels.view_columns import FLAT, DepthSlope
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.coverage.coverage import Coverage
from strandcli.draw.coverage.kernels import width_profiles as kernel
from strandcli.draw.fibre import chiang, marschner
from strandcli.draw.fibre.tables import N_PHI, N_THETA
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.view.camera import View, axes
from strandcli.draw.zbuffer import raster
from strandcli.groom.blocks import lanes
from strandcli.scene.model import Material, Scene
from strandcli.study.pictures.subject import LinearRenderer
from strandcli.study.sweep import changed
from tests.draw.geometry.test_detail import positions_of
from tests.reference import chiang as chiang_reference

WIDTH, HEIGHT = 160, 120
RADIUS = 0.06
EYE = np.array([0.3, 0.2, 4.0])


def heap(strands: int, pieces: int) -> np.ndarray:
    """(strands, pieces + 1, 3) straight strands, a bundle that is slanted toward the eye, many within others."""
    rng = np.random.default_rng(4)
    way = rng.normal([1, 0.5, 1], 0.2, (strands, 1, 3))
    way /= np.linalg.norm(way, axis=2, keepdims=True)
    middle = rng.normal(0, 0.15, (strands, 1, 3))
    return np.asarray(middle + way * np.linspace(-2, 2, pieces + 1)[:, None])


def cast(view: View, strands: np.ndarray, right: float = 0.0, down: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """(height, width) of the foremost strand at so many pixels from each pixel's middle, and by how many radii it is in
    front of the next; rays at cylinders."""
    y, x = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    cx, cy = view.middle
    aside = (x + right - cx)[..., None] * view.right - (y + down - cy)[..., None] * view.up
    origin = view.eye + (0 if view.perspective else aside / view.focal)
    way = view.forward + (aside / view.focal if view.perspective else 0 * aside)
    way /= np.linalg.norm(way, axis=-1, keepdims=True)
    depth = np.empty((len(strands), HEIGHT, WIDTH))
    for i, line in enumerate(strands):
        long = np.linalg.norm(line[-1] - line[0])
        t = (line[-1] - line[0]) / long
        begin = origin - line[0]
        p, q = way - (way @ t)[..., None] * t, begin - (begin @ t)[..., None] * t
        a, b, c = (p * p).sum(-1), (p * q).sum(-1), (q * q).sum(-1) - RADIUS**2
        square = b * b - a * c
        at = (-b - np.sqrt(np.maximum(square, 0))) / a
        along = begin @ t + at * (way @ t)
        depth[i] = np.where((square > 0) & (along > 0) & (along < long), at, 99)
    first, second = np.sort(depth, 0)[:2]
    return depth.argmin(0), (second - first) / RADIUS


def contest(view: View, strands: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(height, width) of the foremost strand, and where two run into each other, at most a radius apart, but which is
    in front is beyond doubt: everywhere in the pixel, and by a twentieth of a radius."""
    first, apart = cast(view, strands)
    sure = (apart > 0.05) & (apart < 1)
    for right, down in ((-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5)):
        sure &= cast(view, strands, right, down)[0] == first
    return first, sure


def draw(view: View, strands: np.ndarray, resolver: str, slope: DepthSlope) -> np.ndarray:
    """(height, width) of the foremost strand, −1 where there is none."""
    count, points, _ = strands.shape
    lines = Polylines(np.arange(count + 1) * points, strands.reshape(-1, 3).astype(np.float32))
    screen = raster.to_screen(lines, view, Scratch())
    widths = np.full(len(screen), 2 * RADIUS * view.focal, np.float32)
    if view.perspective:
        widths *= screen[:, 2]
    if resolver == "zbuffer":
        keys = np.full(WIDTH * HEIGHT, EMPTY)
        raster.draw(lines, screen, widths, 0, (WIDTH, HEIGHT), 1, Scratch(), keys, slope)
        number = (keys & np.uint64(0xFFFFFFFF)).astype(np.int64)
        return np.where(keys == EMPTY, -1, number // points).reshape(HEIGHT, WIDTH)
    colours = np.repeat(np.arange(count, dtype=np.float32), points)[:, None] * np.ones(3, np.float32)
    image = np.full((HEIGHT, WIDTH, 3), -1, np.float32)
    coverage = Coverage((WIDTH, HEIGHT), 1.0)
    for layer in coverage.layers(lines, screen, widths, None, 1, Scratch(), slope):
        layer.blend(colours, image)
    return image[..., 0]


@pytest.mark.parametrize("perspective", [True, False], ids=["perspective", "orthographic"])
@pytest.mark.parametrize("resolver", ["sorted", "zbuffer"])
@pytest.mark.parametrize("pieces", [1, 12])
def test_strands_that_touch_hide_each_other_as_cylinders_do(resolver: str, perspective: bool, pieces: int) -> None:
    focal, strands = 240.0 if perspective else 60.0, heap(30, pieces)
    view = View(EYE, *axes(-EYE, (0.0, 1.0, 0.0)), perspective, focal, 0.1, 9.0, WIDTH, HEIGHT)
    right, sure = contest(view, strands)
    assert sure.sum() > 500
    wrong, flat = (
        (abs(draw(view, strands, resolver, slope) - right) > 0.01)[sure].mean() for slope in (view.depth_slope, FLAT)
    )
    assert wrong < 0.02
    assert flat > 6 * wrong  # bands without a round side: a tenth of the pixels or more


@pytest.mark.parametrize("resolver", ["sorted", "zbuffer"])
def test_far_aside_of_the_views_axis_the_edges_of_a_strand_are_not_equally_far(resolver: str) -> None:
    """Nearly parallel strands that lie in each other, in the corner of a wide lens's picture."""
    view = View(EYE, *axes(-EYE, (0.0, 1.0, 0.0)), True, 240.0, 0.1, 9.0, WIDTH, HEIGHT, centre=(-160.0, 300.0))
    rng = np.random.default_rng(2)
    way = rng.normal([1, 0.5, 1], 0.06, (40, 1, 3))
    way /= np.linalg.norm(way, axis=2, keepdims=True)
    middle = EYE + 4 * (view.forward + view.right + view.up) + rng.normal(0, 0.12, (40, 1, 3))
    strands = middle + way * np.linspace(-2, 2, 13)[:, None]
    right, sure = contest(view, strands)
    assert sure.sum() > 500
    # as if the view's axis went through the middle of the picture
    middle_of_picture = view.depth_slope._replace(axis_x=np.float32(WIDTH / 2), axis_y=np.float32(HEIGHT / 2))
    wrong, even = (
        (abs(draw(view, strands, resolver, slope) - right) > 0.01)[sure].mean()
        for slope in (view.depth_slope, middle_of_picture)
    )
    assert wrong < 0.02
    assert even > 3 * wrong


POST = """
emitter: {strands: 1, particles: 3, shape: {kind: disc, radius: 0.0001}, length: 3}
rules: []
camera: {kind: orthographic, height: 1, position: [0, 0, 5]}
image: {size: [64, 48], resolver: %s, background: [0, 0, 0]}
material: {model: %s, width: %g, taper: 0, diffuse: %g, beta_n: 0.2}
ambient: [0.1, 0.1, 0.1]
lights: [{kind: directional, direction: [%g, -0.2, %g], shadow: {model: "off"}}]
"""


def post(
    resolver: str = "sorted", model: str = "chiang", width: float = 0.5, diffuse: float = 0.0, light: float = 60.0
) -> Scene:
    """A strand that stands upright from the middle of the picture; ``light``: degrees from the eye toward +x."""
    turn = np.radians(light)
    model = "chiang, scatter: dual" if model == "chiang" else model  # whose kernel presets have
    return scene_of(POST % (resolver, model, width, diffuse, -np.sin(turn), -np.cos(turn)))


def drawn(scene: Scene, **settings: Any) -> np.ndarray:
    """(height, width, 3) linear."""
    scene = changed(scene, settings)
    groom = groom_of(scene)
    renderer = LinearRenderer(scene, groom)
    renderer.draw(positions_of(scene), lanes((groom.lengths / 2)[:, None]), 0.0, 1)
    return np.asarray(renderer.linear)


def across(scene: Scene, **settings: Any) -> np.ndarray:
    """(width, 3): a row of the upper half, where the strand is."""
    return np.asarray(drawn(scene, **settings)[8])


@pytest.mark.parametrize("model", ["marschner", "chiang"])
def test_columns_average_to_nothing_and_with_the_average_are_the_light_at_an_offset(model: str) -> None:
    material = Material(model=model, colour=(0.5, 0.3, 0.2), beta_n=0.35, azimuthal=15.0)
    columns = FIBRES[material.model].columns(material)
    np.testing.assert_allclose(columns.mean(2), 0, atol=2e-6 * np.abs(columns).max())
    tables = (marschner if model == "marschner" else chiang).build_tables(material, N_THETA, N_PHI)
    whole = columns[..., :7] + tables.nodes[:, :, None, :7]
    assert whole.min() > -0.06 * whole.max()  # light is not negative, but for what far tables average over their cells
    # light from the eye's own side is reflected in the middle; from the side where h is positive, there
    assert np.argmax(columns[2, 0, :, 0]) in (kernel.COLUMNS // 2 - 1, kernel.COLUMNS // 2)
    assert np.argmax(columns[2, N_PHI // 3, :, 0]) == int((np.sin(np.pi / 6) + 1) / 2 * kernel.COLUMNS)
    if model == "chiang":
        sigma = float(tables.absorption[0])
        hair = chiang_reference.Hair(material.beta_m, material.beta_n, material.tilt, sigma)
        offsets = -(np.arange(160) + 0.5) / 80 + 1  # there h is positive away from b
        theta = 0.5 * np.pi * 5 / (N_THETA - 1)
        for lobe, c in ((0, 0), (1, 1), (2, 4)):
            for j in (5, 20, 40):
                phi = np.pi * j / (N_PHI - 1)
                exact = chiang_reference.attenuations(hair, theta, offsets)[lobe] * chiang_reference.azimuthal(
                    lobe, hair, theta, phi, offsets
                )
                means = exact.reshape(kernel.COLUMNS, -1).mean(1)
                found = columns[5, j, :, c] + means.mean()
                np.testing.assert_allclose(found, means, atol=0.01 * max(means.max(), 0.1))


@pytest.mark.parametrize("resolver", ["sorted", "zbuffer"])
@pytest.mark.parametrize("model", ["chiang"])
def test_a_wide_strand_has_on_average_the_light_of_a_flat_one(resolver: str, model: str) -> None:
    for light in (10.0, 70.0, 150.0):
        scene = post(resolver, model, 0.5, 0.4, light)
        flat, rounded = across(scene, **{"material.rounded": False}), across(scene)
        on = slice(20, 44) if resolver == "zbuffer" else slice(None)
        assert rounded[on].mean() == pytest.approx(flat[on].mean(), rel=0.004)
        assert np.abs(rounded - flat).max() > 0.1 * flat.max()
        assert rounded.min() >= 0


def test_streaks_stand_on_the_side_of_the_light() -> None:
    """R of a light 60° aside shines where the normal is 30° aside, at h = ½, and mirrored for its mirror image."""
    colours = {"material.colour": (0.01, 0.01, 0.01), "ambient": (0.0, 0.0, 0.0)}
    right, left = (across(post(light=angle), **colours).sum(1) for angle in (60.0, -60.0))
    assert np.argmax(right) + 0.5 == pytest.approx(32 + 0.5 * 12, abs=1.1)
    np.testing.assert_allclose(left[::-1], right, rtol=1e-3, atol=1e-4)
    behind = across(post(light=180.0), **{**colours, "material.colour": (0.8, 0.8, 0.8)}).sum(1)
    assert behind[32] > 2 * behind[22]  # light passes straight through the middle


def test_it_grows_from_nothing_and_thin_strands_are_left_alone() -> None:
    """At two pixels nothing departs, and just above almost nothing: no step as the camera comes near."""
    apart = []
    for pixels in (1.5, 2.0, 2.05, 2.2, 3.0, 4.0, 6.0):
        scene = post(width=pixels / 48)
        flat, rounded = (drawn(scene, **{"material.rounded": on}) for on in (False, True))
        apart.append(float(np.abs(rounded - flat).max() / flat.max()))
    assert apart[:2] == [0, 0]
    assert 0 < apart[2] < 0.003
    assert (np.diff(apart[1:5]) > 0).all()
    fine = replace(post(width=1.5 / 48), image=replace(post().image, supersample=3))  # samples are no pixels
    np.testing.assert_array_equal(drawn(fine), drawn(fine, **{"material.rounded": False}))
