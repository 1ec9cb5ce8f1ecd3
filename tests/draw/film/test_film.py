"""From samples to 8-bit pixels: transfer function, averages, exposure, background, and colours along segments."""

from __future__ import annotations

import numpy as np
import pytest

from strandcli.draw.common.kernels.keys import EMPTY
from strandcli.draw.film.film import curve_of, filmic, gradient
from strandcli.draw.film.kernels import film


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
