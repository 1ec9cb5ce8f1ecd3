"""What a solid mirrors: against energy, the directions it has to go to, and Smith's masking in double precision."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from strand_kit import frames_of, scene_of
from strandcli.constants import W
from strandcli.draw.common.kernels import batch, surface_batch
from strandcli.draw.lighting.kernels import surface_points
from strandcli.draw.solids.kernels import coat as kernel
from strandcli.draw.solids.solids import coats_of
from strandcli.jit import function
from strandcli.scene.model import BoxSolid, PlaneSolid, SphereSolid
from strandcli.simd import broadcast, pointer, reduce_max

UP = np.array([0.0, 0.0, 1.0])


@function
def gleam(given: Any) -> Any:
    """`kernel.gleam`, which is part of its callers, of twelve numbers."""
    rows = pointer(given)
    normal = broadcast(rows, given[3]), broadcast(rows, given[4]), broadcast(rows, given[5])
    light = broadcast(rows, given[6]), broadcast(rows, given[7]), broadcast(rows, given[8])
    eye = broadcast(rows, given[9]), broadcast(rows, given[10]), broadcast(rows, given[11])
    return reduce_max(kernel.gleam(given[0], given[1], broadcast(rows, given[2]), normal, light, eye))


@function
def mirrored(coat: Any, rough: Any, nv: Any) -> Any:
    """`kernel.mirrored`, which is part of its callers."""
    return kernel.mirrored(coat, rough, nv)


def towards(theta: float, phi: float = 0.0) -> np.ndarray:
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])


def brdf(coat: float, rough: float, light: np.ndarray, eye: np.ndarray, size: float = 0.0) -> float:
    return float(gleam(np.array([coat, rough, size, *UP, *light, *eye], np.float32)))


def exact(coat: float, rough: float, light: np.ndarray, eye: np.ndarray) -> float:
    """GGX with Smith's height-correlated masking, in double precision."""
    alpha = rough**2
    half = (light + eye) / np.linalg.norm(light + eye)
    facets = alpha**2 / (np.pi * (half[2] ** 2 * (alpha**2 - 1) + 1) ** 2)
    hidden = [(np.sqrt(1 + alpha**2 * (1 / w[2] ** 2 - 1)) - 1) / 2 for w in (light, eye)]
    mirror = coat + (1 - coat) * (1 - light @ half) ** 5
    return float(mirror * facets / (1 + sum(hidden)) / (4 * light[2] * eye[2]))


def sky(count: int = 4000) -> np.ndarray:
    """Directions over the half sphere, evenly by the cosine."""
    i = np.arange(count)
    return np.array([towards(np.arcsin(np.sqrt((j + 0.5) / count)), 2.399963 * j) for j in i])


@pytest.mark.parametrize("rough", [0.2, 0.45, 0.8])
def test_the_coat_is_ggx_with_smiths_masking(rough: float) -> None:
    ways = sky(400)
    for theta in (0.1, 0.8, 1.3):
        eye = towards(theta)
        got, true = (np.array([f(0.04, rough, way, eye) for way in ways]) for f in (brdf, exact))
        np.testing.assert_allclose(got, true, rtol=2e-3)


@pytest.mark.parametrize(("rough", "least"), [(0.3, 0.95), (0.6, 0.77), (1.0, 0.3)])
def test_a_mirror_gives_back_no_more_than_arrives_and_most_of_it(rough: float, least: float) -> None:
    """What rough facets mirror onto each other is lost."""
    ways = sky()
    for theta in (0.0, 0.7, 1.2):
        whole = np.pi * np.mean([brdf(1.0, rough, way, towards(theta)) for way in ways])
        assert least < whole < 1.02


@pytest.mark.parametrize(("rough", "degrees"), [(0.2, 8.0), (0.3, 16.0), (0.4, 40.0)])
def test_a_wide_lights_gleam_is_the_mean_over_its_disc(rough: float, degrees: float) -> None:
    angle = np.radians(degrees / 2)
    eye = towards(0.5, np.pi)
    middle = towards(0.5)
    side, up = np.array([0.0, 1.0, 0.0]), np.cross(middle, [0.0, 1.0, 0.0])
    disc = [np.sqrt((j + 0.5) / 600) * np.array([np.cos(2.399963 * j), np.sin(2.399963 * j)]) for j in range(600)]
    ways = [middle + np.tan(angle) * (u * side + v * up) for u, v in disc]
    mean = np.mean([brdf(0.04, rough, way / np.linalg.norm(way), eye) for way in ways])
    got, point = (brdf(0.04, rough, middle, eye, size) for size in (np.sin(angle), 0.0))
    assert got == pytest.approx(mean, rel=0.1)
    assert point > 1.3 * mean


def test_a_polished_coat_shows_a_lights_disc_with_its_edge() -> None:
    """From the disc's middle to beyond its edge, against the mean over 4,000 places of it, as a share of the middle."""
    angle, eye = np.radians(8.0), towards(0.1, np.pi)
    j = np.arange(4000) + 0.5
    disc = (np.sqrt(j / 4000) * np.array([np.cos(2.399963 * j), np.sin(2.399963 * j)])).T
    got, true = [], []
    for off in np.radians([0.0, 4.0, 7.0, 8.0, 9.0, 14.0]):
        middle = towards(0.1 + off)
        up = np.cross(middle, [0.0, 1.0, 0.0])
        ways = [middle + np.tan(angle) * (u * np.array([0.0, 1.0, 0.0]) + v * up) for u, v in disc]
        true.append(np.mean([exact(0.04, 0.12, way / np.linalg.norm(way), eye) for way in ways]))
        got.append(brdf(0.04, 0.12, middle, eye, np.sin(angle)))
    np.testing.assert_allclose(np.array(got) / true[0], np.array(true) / true[0], atol=0.03)
    assert got[1] > 0.9 * got[0]  # a disc, not a bell


@pytest.mark.parametrize("rough", [0.2, 0.58])
def test_a_coat_weaker_than_waters_covers_part_of_the_surface(rough: float) -> None:
    """A third of what one of .02 mirrors, the Fresnel term at grazing angles included, of lights as of the sky."""
    for theta in (0.1, 0.8, 1.5):
        eye = towards(theta, np.pi)
        for angle in (0.2, 1.0, 1.52):
            third, whole = (brdf(coat, rough, towards(angle), eye) for coat in (0.02 / 3, 0.02))
            assert whole == pytest.approx(exact(0.02, rough, towards(angle), eye), rel=2e-3)
            assert third == pytest.approx(whole / 3, rel=1e-4)
        numbers = (np.float32(rough), np.float32(np.cos(theta)))
        third, whole = (mirrored(np.float32(coat), *numbers) for coat in (0.02 / 3, 0.02))
        assert third == pytest.approx(whole / 3, rel=1e-4)


SCENE = """
emitter: {strands: 1, length: 0.01, shape: {kind: sphere, radius: 0.01}}
rules: []
solids: [{kind: sphere, radius: 1%s}]
camera: {position: [0, 0, 4]}
ambient: [%s, 0.25, 0.25]
lights: [%s]
image: {size: 64x48, background: [0.25, 0.25, 0.25]}
"""


def test_a_white_coated_ball_in_even_light_is_as_bright_as_that() -> None:
    for finish in ("", ", coat: 0.04, roughness: 0.5", ", coat: 0.7, roughness: 0.1"):
        image = frames_of(scene_of(SCENE % (f", colour: [1, 1, 1]{finish}", 0.25, "")), 1)[0].image
        assert np.ptp(image[..., :].astype(int)) <= 1


def test_a_coat_shines_towards_the_mirrored_light_and_is_left_out_where_nothing_has_one() -> None:
    sun = "{kind: directional, direction: [0.8, -0.8, -1], shadow: {model: off}}"
    images = [
        frames_of(scene_of(SCENE % (f", colour: [0.1, 0.1, 0.1]{coat}", 0.0, sun)), 1)[0].image
        for coat in ("", ", coat: 0.05, roughness: 0.2")
    ]
    more = images[1].astype(int)[..., 0] - images[0].astype(int)[..., 0]
    row, column = np.unravel_index(more.argmax(), more.shape)
    assert more.max() > 100
    assert (row, column) == (pytest.approx(17, abs=2), pytest.approx(25, abs=2))
    matte = [SphereSolid(), BoxSolid()]
    assert coats_of(matte) is None
    shiny = [BoxSolid(coat=0.5, roughness=0.2), PlaneSolid(mottle=0.3, grain=0.7), SphereSolid()]
    found = coats_of(shiny)
    np.testing.assert_allclose(found[:, :4], np.float32([[0, 0.3, 0, 0.1], [0, 0.3, 0.3, 0.7], [0.5, 0.2, 0, 0.1]]))


@function
def mottle(work: Any, n: Any, grain: Any) -> None:
    """The kernel for the first n points of a batch."""
    surface_points.mottle(work, n, np.float32(1), grain)


def noise(x: np.ndarray, grain: float = 0.5, pixel: float = 1e-3) -> np.ndarray:
    """In [−1, 1], of patches at places along a line."""
    out = np.empty(len(x), np.float32)
    for first in range(0, len(x), W):
        here = x[first : first + W]
        work = np.zeros((surface_batch.ROWS, W), np.float32)
        places = np.stack([here, np.full(len(here), 0.3), np.full(len(here), -0.3)])
        work[batch.X // W :][:3, : len(here)] = places
        work[surface_batch.ACROSS // W], work[surface_batch.UNDER // W] = pixel, 1
        mottle(work.reshape(-1), len(here), np.float32(grain))
        out[first : first + W] = work[surface_batch.UNDER // W, : len(here)] - 1
    return out


def test_patches_are_even_handed_smooth_and_as_wide_as_they_are_said_to_be() -> None:
    far = noise(np.random.default_rng(0).uniform(-500, 500, 4000))
    assert abs(far.mean()) < 0.02
    assert 0.15 < far.std() < 0.5
    near = noise(np.linspace(-2, 2, 20001))
    assert np.abs(np.diff(near)).max() < 0.01
    places = np.arange(400) * 37.3
    for grain in (0.1, 0.5, 8.0):
        alike = [
            np.corrcoef(noise(places, grain), noise(places + gap * grain, grain))[0, 1] for gap in (0.06, 0.5, 4.0)
        ]
        assert alike[0] > 0.8
        assert 0.2 < alike[1] < 0.8
        assert abs(alike[2]) < 0.2


MIRROR = """
emitter: {strands: 1, length: 0.01, shape: {kind: sphere, radius: 0.01}}
rules: []
solids:
  - {kind: sphere, radius: 1, position: [0, 1.5, 0], colour: [0, 0, 0], coat: 1, roughness: %s}
  - {kind: plane, colour: [0.2, 0.5, 0.1]}
camera: {position: [0, 1.5, 4], target: [0, 1.5, 0]}
ambient: [0.5, 0.5, 0.5]
lights: []
image: {size: 65x49, background: [0.5, 0.5, 0.5]}
"""


def test_a_perfect_mirror_shows_the_floor_below_and_the_sky_above_and_a_dull_one_neither() -> None:
    image = frames_of(scene_of(MIRROR % 0.05), 1)[0].image.astype(int)
    sky, floor = image[1, 1], image[-2, 1]
    assert abs(sky - floor).max() > 30
    ball = image[:, 32]
    middle = next(row for row in range(24, 49) if abs(ball[row] - floor).max() < 3)
    assert abs(ball[12] - sky).max() < 3
    # the ray back to a horizon: the normal there looks half as far down as from the ball's middle to the eye
    assert 24 <= middle <= 28
    assert abs(ball[middle : middle + 8] - floor).max() < 3
    dull = frames_of(scene_of(MIRROR % 0.5), 1)[0].image.astype(int)[:, 32]
    assert abs(dull[30] - dull[20]).max() < 3
