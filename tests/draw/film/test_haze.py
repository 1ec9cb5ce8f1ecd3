"""Haze: e^(−depth / haze) of light at a known depth is left and the rest is background; noise is nothing on average."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from strand_kit import frames_of, scene_of
from strandcli.draw.film import film
from strandcli.draw.solids.kernels import surface_pixels
from strandcli.simd import lane_count, load, pointer, store

HAZE = 4.0
DEPTH = 5.0
FLAT = "background: [0.9, 0.2, 0.1]"
SCENE = """
emitter: {shape: {kind: plane, width: 2, depth: 0.0001}, position: %s, strands: 9, particles: 3, length: 1}
solids: [%s]
camera: {kind: %s, position: [0, 0.5, 5], target: [0, 0.5, 0], height: 3}
material: {width: %g, colour: [0.2, 0.5, 0.8]}
lights: [{kind: directional, direction: [-1, 0, -0.4], intensity: 3, shadow: {model: "off"}}]
image: {size: 48x36, resolver: %s, supersample: %d, aovs: [linear, depth], %s}
"""
AWAY = "[0, 0, 500]"
BOX = "{kind: box, size: [1.1, 0.7, 2], position: [0.1, 0.5, -1]}"
GROUND = "{kind: plane, position: [0, -0.5, 0], rotation: [4, 0, 3]}"


def pictures(
    *, roots: str = "[0, 0, 0]", solids: str = "", camera: str = "perspective", width: float = 0.02,
    resolver: str = "sorted", samples: int = 1, behind: str = FLAT,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float32]]:  # fmt: skip
    """In linear light, (36, 48, 3) each: what is behind everything, the picture in clear air, and in haze; and depths
    (36, 48)."""
    found, depth = [], np.empty(0, np.float32)
    for root, solid, air in ((AWAY, "", behind), (roots, solids, behind), (roots, solids, f"{behind}, haze: {HAZE}")):
        scene = scene_of(SCENE % (root, solid, camera, width, resolver, samples, air))
        layers = frames_of(scene, 1)[0].aovs
        depth = layers["depth"]
        found.append(np.asarray(layers["linear"], np.float64))
    return found[0], found[1], found[2], depth


HORIZON = f"{FLAT}, horizon: [0.1, 0.3, 0.8]"
VIEWS = ("perspective", "orthographic")


@pytest.mark.parametrize(
    ("scene", "off"),
    [
        *(({"camera": camera, "width": width, "resolver": resolver}, 2e-4)
          for camera in VIEWS for width in (0.02, 0.3) for resolver in ("zbuffer", "sorted")),
        ({"behind": HORIZON}, 0.01),
        *(({"roots": AWAY, "solids": BOX, "camera": camera, **samples}, 1e-5)
          for camera in VIEWS for samples in ({"resolver": "zbuffer", "samples": 2}, {})),
        ({"roots": "[0, 0, 0.02]", "solids": BOX}, 2e-3),
    ],
    ids=str,
)  # fmt: skip
def test_what_is_at_one_depth_keeps_that_share_of_its_light(scene: dict[str, Any], off: float) -> None:
    """Strands, of which those of 0.3 m are wide enough for light to vary across them; strands before a horizon; a flat
    solid, up to its edges; and both in the same place."""
    behind, clear, hazy, _ = pictures(**scene)
    assert np.ptp(clear - behind) > 0.1
    np.testing.assert_allclose(hazy - behind, np.exp(-DEPTH / HAZE) * (clear - behind), atol=off)


def test_a_ground_is_lost_by_its_depth_in_each_pixel() -> None:
    behind, clear, hazy, depth = pictures(roots=AWAY, solids=GROUND, resolver="zbuffer")
    ground = np.isfinite(depth)
    assert 0.3 < ground.mean() < 1
    assert np.ptp(depth[ground]) > HAZE
    share = np.exp(-depth[ground, None] / HAZE)
    np.testing.assert_allclose((hazy - behind)[ground], share * (clear - behind)[ground], atol=1e-5)
    np.testing.assert_array_equal(hazy[~ground], behind[~ground])


FLOOR = """
emitter: {strands: 1, length: 0.01, shape: {kind: sphere, radius: 0.01}, position: [0, -9, 0]}
rules: []
solids: [{kind: plane, colour: [0.2, 0.3, 0.4]}]
camera: {position: [0, 2, 2], fov: 20}
ambient: [0.25, 0.25, 0.25]
lights: []
image: {size: 96x72, background: [0.03, 0.03, 0.03]%s}
"""


def floor(settings: str) -> np.ndarray:
    image = frames_of(scene_of(FLOOR % settings), 1)[0].image
    return image.astype(float)


def exact(tone: str, exposure: float) -> np.ndarray:
    """The floor's levels before rounding."""
    light = 0.25 * np.array([0.2, 0.3, 0.4]) * 2.0**exposure
    linear = film.filmic(light) if tone == "filmic" else light
    return 255 * (1.055 * linear ** (1 / 2.4) - 0.055)


@pytest.mark.parametrize(("tone", "exposure"), [("srgb", 0.0), ("filmic", 1.0)])
def test_a_floor_has_its_light_on_average_and_the_two_levels_beside_it(tone: str, exposure: float) -> None:
    look = f", tone: {tone}, exposure: {exposure}"
    plain = floor(look)
    assert np.ptp(plain, axis=(0, 1)).max() == 0
    image = floor(f"{look}, horizon: [0.1, 0.1, 0.1]")
    assert image.mean((0, 1)) == pytest.approx(exact(tone, exposure), abs=0.03)
    assert np.abs(image - exact(tone, exposure)).max() < 1.03


def test_noise_is_that_of_the_position_in_the_full_picture() -> None:
    whole = floor(", horizon: [0.1, 0.1, 0.1]")
    part = floor(", horizon: [0.1, 0.1, 0.1], crop: [17, 9, 40, 30]")
    assert np.array_equal(part, whole[9:39, 17:57])
    for settings in (", supersample: 3", ", resolver: sorted"):
        assert np.array_equal(floor(f", horizon: [0.1, 0.1, 0.1]{settings}"), whole)


@njit
def dithered(light: np.float32, share: np.float32, levels: np.ndarray, frame: np.ndarray) -> np.float32:
    """`surface_pixels.dithered` of one number."""
    row = np.full(64, light, np.float32)
    rows = pointer(row)
    for k in range(0, 64, lane_count(rows)):
        store(rows, k, surface_pixels.dithered(load(rows, k), share, pointer(levels), levels.shape[0], frame))
    return row[0]


@pytest.mark.parametrize("tone", ["srgb", "filmic"])
def test_what_is_white_or_black_stays_so(tone: str) -> None:
    for light in (1.3, 40.0, 1e4):
        rows = np.full((8, 3), light, np.float32)
        image = film.dithered(rows, 64, 1, tone, 0.0)
        assert film._response(image.astype(float), tone, 0.0).min() > (254 if tone == "srgb" else 220)
    frame = np.array([1, 0, 0, 1, 1], np.float32)
    levels = film.level_sizes(tone)
    for light in (0.0, 1e9, np.inf):
        assert dithered(np.float32(light), np.float32(-0.5), levels, frame) == np.float32(light)
    for light in (0.01, 0.1, 0.7):
        moved = dithered(np.float32(light), np.float32(0.5), levels, frame)
        more = film._response(np.array([light, moved], float), tone, 0.0)
        assert more[1] - more[0] == pytest.approx(0.5, abs=0.02)
