"""Whole pictures against closed forms: light on strands and solids, shadows, what hides what."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba import typeof
from PIL import Image

from reference.rules import depth
from strand_kit import frames_of, scene_of
from strandcli.draw.lighting.kernels import shade_strands, shade_surfaces
from tests.draw.film.test_film import encoded

GROUND = """
emitter: {position: [0, 50, 0], strands: 1, particles: 2, length: 0.001, shape: {kind: disc, radius: 0.001}}
camera: {kind: orthographic, position: [0, 20, 0], target: [0, 0, 0], up: [0, 0, -1], height: 10, near: 1}
image: {size: [50, 50]}
ambient: [0.2, 0.1, 0.05]
solids:
- {kind: plane, colour: [0.5, 0.4, 0.8]}
%s
lights:
- %s
"""
SUN = "{kind: directional, direction: [0, -1, 1], colour: [1, 0.5, 1], intensity: 2, shadow: {size: 32}}"
LAMP = "{kind: point, position: [1, 4, 0], intensity: 60, shadow: {size: 32}}"
AMBIENT = encoded(np.array([0.2, 0.1, 0.05]) * [0.5, 0.4, 0.8])


def ground(light: str, solids: str = "") -> np.ndarray:
    image = frames_of(scene_of(GROUND % (solids, light)), 1)[0].image
    return image.astype(float)


def place(x: float, z: float) -> tuple[int, int]:
    """Row and column of the pixel that shows (x, 0, z)."""
    return int((z + 5) * 5), int((x + 5) * 5)


def test_a_plane_in_the_sun_has_lamberts_radiance() -> None:
    """colour (ambient + E cos / π)."""
    lit = np.array([0.5, 0.4, 0.8]) * (np.array([0.2, 0.1, 0.05]) + 2 * np.array([1, 0.5, 1]) * np.sqrt(0.5) / np.pi)
    assert np.abs(ground(SUN) - encoded(lit)).max() < 0.8


def test_a_lamps_light_falls_with_the_square_of_the_distance() -> None:
    image = ground(LAMP)
    for x, z in ((1.1, 0.1), (-3.1, 2.1), (4.1, -4.1), (-4.9, -4.9)):
        row, column = place(x, z)
        away = np.array([(column + 0.5) / 5 - 5 - 1, -4, (row + 0.5) / 5 - 5])
        square = away @ away
        radiance = np.array([0.2, 0.1, 0.05]) + 60 / square * 4 / np.sqrt(square) / np.pi
        assert np.abs(image[row, column] - encoded(radiance * [0.5, 0.4, 0.8])).max() < 0.8


@pytest.mark.parametrize(
    "solid",
    [
        "{kind: sphere, radius: 1, position: [0, 2, 0]}",
        "{kind: capsule, radius: 0.5, length: 2, position: [0, 2, 0], rotation: [0, 0, 90]}",
        "{kind: box, size: [2, 0.5, 2], position: [0, 2, 0]}",
    ],
)
def test_solids_shade_the_ground_where_the_light_says(solid: str) -> None:
    """Pixel by pixel: in shadow where the way to the sun goes through the solid."""
    free, shaded = ground(SUN), ground(SUN, f"- {solid}")
    scene = scene_of(GROUND % (f"- {solid}", SUN))
    row, column = np.mgrid[:50, :50]
    point = np.stack([(column + 0.5) / 5 - 5, 0 * row, (row + 0.5) / 5 - 5], -1)
    way = np.linspace(0, 6, 601)[:, None, None, None]
    to_sun = depth(point + way * [0, 1, -1], scene.solids[1], scene.emitter, 0.0).max(0)
    upward = depth(point + way * [0, 1, 0], scene.solids[1], scene.emitter, 0.0).max(0)
    dark = np.abs(shaded - AMBIENT).max(2) < 0.8
    light = (shaded == free).all(2)
    assert (to_sun > 0.02).sum() > 60
    assert dark[(to_sun > 0.02) & (upward < -0.02)].all()
    assert light[(to_sun < -0.02) & (upward < -0.02)].all()


def test_a_lamp_below_a_solid_is_not_hidden_by_it() -> None:
    """Nor where the solid stands farther out on the same line."""
    free, with_ball = ground(LAMP), ground(LAMP, "- {kind: sphere, radius: 1, position: [1, 5.1, 0]}")
    hidden = np.zeros((50, 50), bool)  # by the ball itself, seen from above
    y, x = np.mgrid[:50, :50]
    hidden |= np.hypot((x + 0.5) / 5 - 6, (y + 0.5) / 5 - 5) < 1.05
    np.testing.assert_array_equal(free[~hidden], with_ball[~hidden])


def test_strands_shade_the_ground() -> None:
    """A thick curtain of strands along z, 2 m up, under a sun from straight above."""
    text = GROUND.replace(
        "position: [0, 50, 0], strands: 1, particles: 2, length: 0.001, shape: {kind: disc, radius: 0.001}",
        "strands: 4000, particles: 3, length: 4, direction: [0, 0, 1], "
        "shape: {kind: plane, width: 2, depth: 0.1}, position: [0, 2, -2]",
    ).replace("near: 1}", "near: 18.5}")  # the camera sees only what is less than 1.5 m high
    down = SUN.replace("[0, -1, 1]", "[0, -1, 0]").replace("size: 32", "size: 64")
    image = frames_of(scene_of(text % ("", down)), 1)[0].image
    for x, z in ((0.0, 0.0), (-0.7, 1.5), (0.7, -1.5)):
        assert np.abs(image[place(x, z)] - AMBIENT).max() < 0.8
    lit = image[place(3, 3)].astype(int)
    for x, z in ((1.4, 0.0), (-1.4, 1.0), (0.0, 2.5), (0.0, -2.5)):
        np.testing.assert_array_equal(image[place(x, z)], lit)
    assert (lit - AMBIENT).min() > 30
    without = frames_of(scene_of(text % ("", down.replace("size: 64", "model: 'off'"))), 1)[0].image
    np.testing.assert_array_equal(without[place(0, 0)], lit)


HAIR = """
emitter: {strands: %d, particles: 3, length: 4, direction: [0, 1, 0], shape: {kind: plane, width: %g, depth: 0.0001},
  position: [0, -2, 0]}
camera: {kind: orthographic, position: [0, 0, 5], height: 2}
image: {size: [24, 20], background: [0, 0, 0]}
ambient: [0.1, 0.1, 0.1]
material: {colour: [0.5, 0.3, 0.2], specular: 0, diffuse: 0.6}
lights: [{kind: directional, direction: %s, intensity: 4, shadow: {model: 'off'}}]
"""


@pytest.mark.parametrize("direction", [[0, 0, -1], [0, -1, -1], [3, 0, 4], [1, -2, 0.5]])
def test_a_strand_without_highlights_has_the_stand_ins_radiance(direction: list[float]) -> None:
    """colour (ambient + diffuse E cos θ / π), θ the light's inclination from the plane across the strand."""
    image = frames_of(scene_of(HAIR % (1, 0.0001, direction)), 1)[0].image
    seen = image[image.max(2) > 0]
    assert len(seen) == 20  # a line of a pixel's width, from bottom to top
    cosine = np.sqrt(1 - (direction[1] / np.linalg.norm(direction)) ** 2)
    radiance = np.array([0.5, 0.3, 0.2]) * (0.1 + 0.6 * 4 * cosine / np.pi)
    assert np.abs(seen - encoded(radiance)).max() < 0.8


def test_strands_are_hidden_by_what_stands_before_them_and_hide_what_stands_behind() -> None:
    def fragments(solids: str) -> int:
        text = HAIR % (40, 1.5, [0, 0, -1]) + f"solids: [{solids}]\n"
        return int(frames_of(scene_of(text), 1)[0].report["counts"]["fragments"])

    free = fragments("{kind: box, size: [9, 9, 0.1], position: [0, 0, -1]}")
    assert free > 200
    assert fragments("{kind: box, size: [9, 9, 0.1], position: [0, 0, 1]}") == 0
    assert fragments("{kind: box, size: [9, 1, 0.1], position: [0, 0.5, 1]}") == free / 2
    assert fragments("{kind: box, size: [9, 9, 0.1], position: [0, 0, 1], visible: false}") == free


def test_solids_shade_strands() -> None:
    """The sun from the right; a box to the right of the lower half, out of the picture."""
    text = HAIR.replace("particles: 3", "particles: 9") % (1, 0.0001, [-1, 0, 0])
    box = "solids: [{kind: box, size: [1, 4, 1], position: [4, -2.1, 0]}]\n"
    free, shaded = (frames_of(scene_of(text + more), 1)[0].image for more in ("solids: []\n", box))
    line = np.flatnonzero(free.max((0, 2)))
    assert len(line) == 1
    radiance = np.array([0.5, 0.3, 0.2]) * (0.1 + 0.6 * 4 / np.pi)
    assert np.abs(free[:, line[0]] - encoded(radiance)).max() < 0.8
    np.testing.assert_array_equal(shaded[:10, line[0]], free[:10, line[0]])
    # light is known at vertices 0.5 m apart: between the last lit and the first dark one it fades
    assert np.abs(shaded[16:, line[0]] - encoded(0.1 * np.array([0.5, 0.3, 0.2]))).max() < 0.8


def test_the_background_shows_where_nothing_is_and_where_the_ground_fades() -> None:
    text = """
emitter: {strands: 1, particles: 2, length: 0.001}
camera: {position: [0, 1, 5], target: [0, 1, 0], fov: 60}
image: {size: [40, 40], background: [0.1, 0.2, 0.4], horizon: [0.6, 0.5, 0.3]}
solids: [{kind: plane, fade: 8, colour: [0.9, 0, 0]}]
lights: [{kind: directional, direction: [0, -1, 0], shadow: {model: 'off'}}]
"""
    image = frames_of(scene_of(text), 1)[0].image
    share = (np.arange(40) + 0.5)[:, None] / 40
    sky = encoded(np.array([0.1, 0.2, 0.4]) + share * (np.array([0.6, 0.5, 0.3]) - np.array([0.1, 0.2, 0.4])))
    above = image[:15, :] - sky[:15, None]
    assert np.abs(above).max() < 1.05  # half a level of rounding, and half of noise
    assert np.abs(above.mean(1)).max() < 0.25
    assert np.abs(image[20:22, 0] - sky[20:22]).max() < 3  # the ground, faded with the distance
    assert np.abs(image[39, 20] - sky[39]).max() > 40


BALL = """
emitter: {strands: 20, particles: 3}
solids: [{kind: sphere, radius: 0.2%s}]
image: {size: 8x6}
material: {model: chiang%s}
lights: [{kind: directional, direction: [0, -1, 0], shadow: {model: opacity}}]
"""


@pytest.mark.parametrize(("kernels", "name"), [(shade_strands, "strands"), (shade_surfaces, "surfaces")])
def test_what_a_scene_goes_without_asks_for_no_kernel_of_its_own(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, kernels: Any, name: str
) -> None:
    """One more type of an argument is seconds of compiling for whoever draws the first scene that has it."""
    found = []

    def note(*given: Any) -> None:
        found.append([str(typeof(one)) for one in given])
        given[-1].fill(0)

    monkeypatch.setattr(kernels, name, note)
    Image.new("RGB", (4, 2)).save(tmp_path / "sky.png")
    more = f"environment: {{image: {tmp_path / 'sky.png'}}}\nambient_occlusion: {{cells: 2000}}\n"
    for text in (BALL % ("", ""), BALL % (", coat: 0.1, roughness: 0.5", ", tip_colour: [1, 1, 1]") + more):
        frames_of(scene_of(text), 1)
    assert found[0] == found[1]
