"""Haze: what is left of light at a known depth is e^(−depth / haze) of it and the rest is the background, for strands
and solids, whatever draws them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from strand_kit import frames_of, scene_of

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


@pytest.mark.parametrize("resolver", ["zbuffer", "sorted"])
@pytest.mark.parametrize("camera", ["perspective", "orthographic"])
@pytest.mark.parametrize("width", [0.02, 0.3])
def test_strands_at_one_depth_keep_that_share_of_their_light(resolver: str, camera: str, width: float) -> None:
    """Those of 0.3 m are wide enough for light to vary across them."""
    behind, clear, hazy, _ = pictures(camera=camera, width=width, resolver=resolver)
    assert np.ptp(clear - behind) > 0.1
    np.testing.assert_allclose(hazy - behind, np.exp(-DEPTH / HAZE) * (clear - behind), atol=2e-4)


def test_strands_become_the_background_of_their_own_place() -> None:
    behind, clear, hazy, _ = pictures(behind=f"{FLAT}, horizon: [0.1, 0.3, 0.8]")
    np.testing.assert_allclose(hazy - behind, np.exp(-DEPTH / HAZE) * (clear - behind), atol=0.01)


@pytest.mark.parametrize(("resolver", "samples"), [("zbuffer", 2), ("sorted", 1)])
@pytest.mark.parametrize("camera", ["perspective", "orthographic"])
def test_a_flat_solid_keeps_that_share_of_its_light_up_to_its_edges(resolver: str, samples: int, camera: str) -> None:
    behind, clear, hazy, _ = pictures(roots=AWAY, solids=BOX, camera=camera, resolver=resolver, samples=samples)
    assert np.ptp(clear - behind) > 0.1
    np.testing.assert_allclose(hazy - behind, np.exp(-DEPTH / HAZE) * (clear - behind), atol=1e-5)


def test_a_ground_is_lost_by_its_depth_in_each_pixel() -> None:
    behind, clear, hazy, depth = pictures(roots=AWAY, solids=GROUND, resolver="zbuffer")
    ground = np.isfinite(depth)
    assert 0.3 < ground.mean() < 1
    assert np.ptp(depth[ground]) > HAZE
    share = np.exp(-depth[ground, None] / HAZE)
    np.testing.assert_allclose((hazy - behind)[ground], share * (clear - behind)[ground], atol=1e-5)
    np.testing.assert_array_equal(hazy[~ground], behind[~ground])


def test_strands_stand_before_a_solid_in_the_same_haze() -> None:
    """Strands and the box's front are at one depth, so the picture is as faint as each of them."""
    behind, clear, hazy, _ = pictures(roots="[0, 0, 0.02]", solids=BOX)
    np.testing.assert_allclose(hazy - behind, np.exp(-DEPTH / HAZE) * (clear - behind), atol=2e-3)
