"""Light under the surface of solids: against the energy that arrives, an average over cosines, and opaque solids."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from strand_kit import frames_of, scene_of
from strandcli.draw.solids.kernels.coat import scattered
from strandcli.jit import function
from strandcli.simd import lane_count, load, pointer, store

WIDTHS = [0.05, 0.3, 1.0]


@function
def scatter(cosines: Any, width: Any) -> None:
    """`scattered` of so many numbers as are whole vectors, in place."""
    rows = pointer(cosines)
    for k in range(0, len(cosines), lane_count(rows)):
        store(rows, k, scattered(load(rows, k), width))


def lobe(cosines: np.ndarray, width: float) -> np.ndarray:
    found = np.resize(cosines, 96).astype(np.float32)
    scatter(found, np.float32(width))
    return found[: len(cosines)].astype(np.float64)


def middles(count: int) -> np.ndarray:
    """Cosines of directions evenly over the whole sphere."""
    return (np.arange(count) + 0.5) / count * 2 - 1


@pytest.mark.parametrize("width", WIDTHS)
def test_it_is_lamberts_law_averaged_over_a_window_of_cosines(width: float) -> None:
    cosines = np.linspace(-1, 1, 81)
    inside = width * middles(2000)
    mean = np.maximum(cosines[:, None] + inside, 0).mean(axis=1) / (1 + width**2 / 3)
    np.testing.assert_allclose(lobe(cosines, width), mean, atol=2e-6)


BALL = """
emitter: {strands: 1, length: 0.01, shape: {kind: sphere, radius: 0.01}}
rules: []
solids: [{kind: sphere, radius: 1, colour: [0.5, 0.5, 0.5]%s}]
camera: {position: [0, 0, 40], fov: 4}
ambient: [0, 0, 0]
lights: [{kind: directional, direction: [-1, 0, 0], intensity: 3, size: %g, shadow: {model: off}}]
image: {size: 64x48, background: [0, 0, 0]}
"""


def picture(finish: str, size: float = 0.0) -> np.ndarray:
    image = frames_of(scene_of(BALL % (finish, size)), 1)[0].image
    return image.astype(int)


@pytest.mark.parametrize("size", [0.0, 10.0])
def test_red_light_comes_furthest_round_a_ball_and_its_own_shadow_does_not_stop_it(size: float) -> None:
    """The light comes from the right of the picture, at a right angle to the camera."""
    row = picture(", subsurface: [0.4, 0.2, 0]", size)[24]
    opaque = picture("", size)[24]
    reach = [np.flatnonzero(row[:, channel]).min() for channel in range(3)]
    assert reach[0] < reach[1] < reach[2]
    half = np.ptp(np.flatnonzero(opaque[:, 0])) + 1  # the lit half of the ball
    assert 32 - reach[0] == pytest.approx(0.4 * half, abs=1.5)
    assert 32 - reach[1] == pytest.approx(0.2 * half, abs=1.5)
    if size == 0.0:
        np.testing.assert_array_equal(row[:, 2], opaque[:, 2])


def test_a_scene_without_it_keeps_its_bits_beside_a_solid_that_has_it() -> None:
    two = ", position: [9, 0, 0]}, {kind: sphere, radius: 0.1, position: [%s, 0, -30], subsurface: [1, 1, 1]"
    np.testing.assert_array_equal(picture(two % "-9"), picture(two.split("}", maxsplit=1)[0]))


FOLD = """
emitter: {strands: 100, length: 0.2, shape: {kind: sphere, radius: 1.2}}
material: {width: 1.0e-7, colour: [0.1, 0.1, 0.1]}
rules: []
solids:
  - {kind: sphere, radius: 1, colour: [1, 1, 1]%s}
  - {kind: box, size: [9, 9, 0.2], position: [0, 0, -0.9], colour: [1, 1, 1]%s}
camera: {position: [0, 0, 40], fov: 4}
ambient: [0.25, 0.25, 0.25]
ambient_occlusion: {}
lights: []
image: {size: 64x48, background: [0.25, 0.25, 0.25], resolver: sorted}
"""


def test_a_white_fold_in_even_light_is_as_bright_as_that() -> None:
    """It is as light as what hides the sky from it."""
    for finish, brightest in ((", subsurface: [0, 0, 0.1]", True), ("", False)):
        image = frames_of(scene_of(FOLD % (finish, finish)), 1)[0].image
        assert (np.ptp(image.astype(int)) <= 1) == brightest
