"""From samples to 8-bit pixels: transfer function, averages, exposure, background, alpha, colours along segments."""

from __future__ import annotations

import math
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest
from numpy.typing import NDArray

from strand_kit import frames_of, scene_of
from strandcli.draw.common.kernels.keys import EMPTY
from strandcli.draw.film.film import curve_of, filmic, gradient
from strandcli.draw.film.kernels import film
from strandcli.run.frame import Frame


def encoded(linear: np.ndarray) -> np.ndarray:
    """sRGB of IEC 61966-2-1, 0 to 255, not rounded."""
    x = np.clip(linear, 0, 1)
    return np.asarray(255 * np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055))


def developed(image: np.ndarray, samples: int = 1, exposure: float = 1.0, tone: str = "srgb") -> np.ndarray:
    height, width, _ = image.shape
    out = np.zeros((height // samples, width // samples, 3), np.uint8)
    film.develop(image.astype(np.float32), samples, np.float32(exposure), *curve_of(tone), out)
    return out


def test_pixels_are_srgb_to_the_nearest_level() -> None:
    linear = np.concatenate([np.linspace(0, 1, 3000), np.logspace(-6, 0, 999), [1.0]]).reshape(40, 100, 1)
    found = developed(np.repeat(linear, 3, 2))
    assert np.abs(found - encoded(linear)).max() < 0.56
    curve = curve_of("srgb")[0].astype(int)
    assert (curve[0], curve[-1]) == (0, 255)
    assert set(np.diff(curve)) == {0, 1}  # every level is reached, in order


def test_what_is_out_of_range_is_clipped_and_what_is_no_number_is_black() -> None:
    values = [np.nan, -np.inf, -1.0, -1e-9, 0.0, 1.0, 1.5, 1e30, np.inf]
    image = np.array(values).reshape(1, -1, 1) * np.ones(3)
    assert developed(image)[0, :, 0].tolist() == [0, 0, 0, 0, 0, 255, 255, 255, 255]
    squares = np.ones((4, 4, 3))
    squares[0, 1] = np.nan
    assert developed(squares, 2)[:, :, 1].tolist() == [[0, 255], [255, 255]]


def test_exposure_scales_light() -> None:
    image = np.full((1, 1, 3), 0.1)
    for stops in (-3, -1, 0, 1, 3):
        exact = encoded(np.array(0.1 * 2.0**stops))
        assert developed(image, exposure=2.0**stops)[0, 0, 0] == pytest.approx(exact, abs=0.56)


def test_the_filmic_curve_keeps_mid_grey_and_cuts_nothing_off() -> None:
    light = np.concatenate([np.linspace(0, 1, 3000), np.logspace(-7, 6, 1000)]).reshape(40, 100, 1)
    found = developed(np.repeat(light, 3, 2), tone="filmic")
    assert np.abs(found - encoded(filmic(light))).max() < 0.65
    assert filmic(np.array(0.18)) == pytest.approx(0.18)
    np.testing.assert_allclose(filmic(np.array([0, 1, 4, 16])), [0, 0.671, 0.925, 0.987], atol=5e-4)
    rise = np.log(filmic(0.18 * np.array([0.99, 1.01]))) / np.log(1.01 / 0.99)
    assert rise[1] - rise[0] == pytest.approx(1.3 * 0.82, rel=1e-4)
    bright = np.linspace(1, 8, 300).reshape(1, -1, 1) * np.ones(3)
    steps = np.diff(developed(bright, tone="filmic")[0, :, 0].astype(int))
    assert set(steps) == {0, 1}  # where srgb is white throughout
    odd = np.array([np.nan, -np.inf, -1.0, 0.0, 1e30, np.inf]).reshape(1, -1, 1) * np.ones(3)
    assert developed(odd, tone="filmic")[0, :, 0].tolist() == [0, 0, 0, 0, 255, 255]


@pytest.mark.parametrize("samples", [1, 3])
def test_squares_of_samples_are_averaged_before_they_are_encoded(samples: int) -> None:
    image = np.random.default_rng(samples).uniform(0, 1.2, (5 * samples, 7 * samples, 3))
    mean = image.reshape(5, samples, 7, samples, 3).mean((1, 3))
    assert np.abs(developed(image, samples) - encoded(mean)).max() < 0.56


def test_the_background_goes_from_top_to_bottom_in_equal_steps() -> None:
    top, bottom = np.float32([0.1, 0.2, 0.3]), np.float32([0.5, 0.2, 0.0])
    share = (np.arange(10) + 0.5)[:, None] / 10
    np.testing.assert_allclose(gradient(top, bottom, 10), top + share * (bottom - top), atol=1e-7)
    np.testing.assert_array_equal(gradient(top, top, 10), np.broadcast_to(top, (10, 3)))


def coloured(screen: list[list[float]], vertex: list[list[float]], keys: dict[int, int], **options: int) -> np.ndarray:
    """A row of 12 pixels in which some hold a segment, coloured from two vertices."""
    row = np.full(12, EMPTY)
    for x, low in keys.items():
        row[x] = (np.uint64(5) << np.uint64(32)) | np.uint64(low)
    image = np.full((1, 12, 3), -1, np.float32)
    places = {"base": 0, "per": 0, "stride": 1, **options}
    film.colours(
        row, places["base"], np.float32(screen), places["per"], places["stride"], np.float32(vertex), image
    )  # fmt: skip
    return image[0]


def test_colour_is_linear_between_the_vertices_of_a_segment() -> None:
    screen = [[1.0, 0.5, 1], [11.0, 0.5, 1], [11.0, 9.0, 1]]
    vertex = [[0.0, 1, 5], [10.0, 1, 0], [0, 0, 0]]
    image = coloured(screen, vertex, dict.fromkeys(range(1, 11), 0))
    np.testing.assert_allclose(image[1:11, 0], np.arange(10) + 0.5, atol=1e-5)
    np.testing.assert_allclose(image[1:11, 1], 1)
    np.testing.assert_allclose(image[1:11, 2], 5 - (np.arange(10) + 0.5) / 2, atol=1e-5)
    assert (image[[0, 11]] == -1).all()  # nothing there: the background stays
    # a sample beside the segment's ends takes the end's colour
    assert coloured(screen, vertex, {0: 0})[0].tolist() == [0, 1, 5]


def test_colour_runs_on_between_lit_vertices() -> None:
    """Where only every second vertex is lit, linear over two pieces; strands have five vertices here."""
    screen = [[float(x), 0.5, 1] for x in (1, 3, 5, 7, 9, 1, 3, 5, 7, 9)]
    vertex = [[float(v), 0, 0] if v % 5 % 2 == 0 else [np.nan] * 3 for v in range(10)]
    for start in (0, 5):
        keys = {1 + x: start + x // 2 for x in range(8)}
        image = coloured(screen, vertex, keys, per=5, stride=2)
        np.testing.assert_allclose(image[1:9, 0], start + np.arange(0.25, 4, 0.5), atol=1e-5)


SCENE = """
emitter: {strands: %(strands)d, particles: 5, length: 1.2, direction: [0, 1, 0], position: [0, %(height)s, 0],
  shape: {kind: disc, radius: 0.5}}
rules: []
camera: {kind: %(kind)s, position: [0.1, 0.6, 5], target: [0, 0, 0], fov: 30, height: 2.6%(lens)s}
image: {size: [64, 48], background: %(background)s, aovs: [linear, mask, solid], resolver: %(resolver)s,
  supersample: %(samples)d%(more)s}
curves: {mode: "off"}
material: {width: %(width)g, opacity: %(opacity)g}
lights: [{kind: directional, direction: [0, -1, -1], intensity: %(light)g, size: %(size)g, shadow: {model: %(shadow)s}}]
solids: %(solids)s
"""
BALL = "{kind: sphere, radius: 0.5, position: [0.25, 0, 0], colour: [0.2, 0.2, 0.9]}"
ROD = "{kind: capsule, radius: 0.2, length: 1.5, rotation: [20, 0, 35]}"
COATED = "{kind: sphere, radius: 0.5, colour: [0.2, 0.2, 0.9], coat: 0.5, roughness: 0.1}"
GROUND = "{kind: plane, position: [0, -0.8, 0], rotation: [0, 0, 8], colour: [0.3, 0.7, 0.3], fade: 3}"
USUAL: dict[str, Any] = {
    "strands": 300, "height": -0.6, "kind": "perspective", "lens": "", "background": "none", "resolver": "sorted",
    "samples": 1, "more": "", "opacity": 1, "light": 1, "solids": f"[{BALL}, {GROUND}]",
    "width": 0.01, "shadow": "opacity", "size": 0,
}  # fmt: skip
MANY = ", aperture: 0.1, shutter: 0.5, samples: 3"
STILL = 1 / 1024


def drawn(plate: NDArray[np.float32] | None = None, **changes: Any) -> Frame:
    """A frame of the scene; ``plate`` (48, 64, 3): what stands behind it."""
    settings = USUAL | changes
    scene = scene_of(SCENE % settings)
    if plate is None:
        return frames_of(scene, 1)[0]
    k = settings["samples"]
    with patch("strandcli.draw.renderer.backdrop_of", lambda image: plate.repeat(k, 0).repeat(k, 1)):
        return frames_of(scene, 1)[0]


def over(frame: Frame, plate: NDArray[np.float32]) -> NDArray[np.float32]:
    """The formula of other programs (Porter and Duff 1984), of premultiplied linear light."""
    linear = frame.aovs["linear"]
    return np.asarray(linear[..., :3] + (1 - linear[..., 3:]) * plate)


@pytest.mark.parametrize("resolver", ["sorted", "zbuffer"])
@pytest.mark.parametrize(
    "changes",
    [{}, {"samples": 2, "opacity": 0.4}, {"lens": MANY}, {"kind": "orthographic"}, {"light": 0}, {"solids": "[]"},
     {"height": 90}, {"strands": 4000}, {"solids": f"[{BALL}, {ROD}]"}, {"shadow": "opacity", "width": 0.08},
     {"solids": f"[{COATED}, {ROD}]", "size": 2}, {"solids": f"[{COATED}, {GROUND}]", "samples": 2, "size": 2}],
)  # fmt: skip
def test_a_picture_over_a_plate_is_the_picture_before_that_plate(resolver: str, changes: dict[str, Any]) -> None:
    plate = np.random.default_rng(len(str(changes))).random((48, 64, 3)).astype(np.float32)
    bare = drawn(resolver=resolver, **changes)
    before = drawn(plate, resolver=resolver, **changes | {"background": "[0, 0, 0]"})
    assert before.aovs["linear"].shape == (48, 64, 3)
    alpha = bare.aovs["linear"][..., 3]
    assert alpha.max() > 0.98
    assert 0.02 < alpha.mean() < 0.98
    assert np.abs(over(bare, plate) - before.aovs["linear"]).max() < STILL


@pytest.mark.parametrize("resolver", ["sorted", "zbuffer"])
def test_haze_lets_through_what_it_would_take_of_the_background(resolver: str) -> None:
    changes = {"resolver": resolver, "more": ", haze: 4"}
    colour = [0.9, 0.1, 0.4]
    bare, before = drawn(**changes), drawn(background=str(colour), **changes)
    assert bare.aovs["linear"][..., 3].max() < math.exp(-3.5 / 4)  # nothing is nearer than that
    assert np.abs(over(bare, np.array(colour, np.float32)) - before.aovs["linear"]).max() < STILL


@pytest.mark.parametrize("changes", [{}, {"resolver": "zbuffer"}, {"lens": MANY}])
def test_alpha_is_all_or_nothing_where_a_pixel_shows_only_one(changes: dict[str, Any]) -> None:
    frame = drawn(**changes)
    linear, covered = frame.aovs["linear"], frame.aovs["mask"] + frame.aovs["solid"]
    assert frame.image.shape == (48, 64, 4)
    if not changes.get("lens"):  # layers are drawn through a pinhole
        assert (linear[covered == 0] == 0).all()
        assert (frame.image[covered == 0] == 0).all()
        assert (linear[frame.aovs["mask"] == 1][:, 3] == 1).all()
    assert linear[..., 3].min() >= 0
    assert linear[..., 3].max() <= 1


def test_a_png_over_a_plate_is_the_picture_within_its_levels() -> None:
    """Half a level of colour and of alpha are 0.0045 and 0.002 of the light of white."""
    bare, plate = drawn(light=0.5), np.full((48, 64, 3), (0.05, 0.5, 0.9), np.float32)
    share = bare.image / np.float32(255)
    light = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)[..., :3]
    found = share[..., 3:] * light + (1 - share[..., 3:]) * plate
    assert bare.aovs["linear"].max() <= 1
    assert np.abs(found - over(bare, plate)).max() < 0.0065


def test_horizon_and_its_noise_are_nothing_without_background() -> None:
    plain, with_horizon = drawn(), drawn(more=", horizon: [1, 0, 0]")
    np.testing.assert_array_equal(plain.aovs["linear"], with_horizon.aovs["linear"])
