"""Pictures without background: alpha against closed forms, and composited against pictures with a background."""

from __future__ import annotations

import math
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest
from numpy.typing import NDArray

from strand_kit import frames_of, scene_of
from strandcli.run.frame import Frame

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
