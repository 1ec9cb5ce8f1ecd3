"""Light across wide strands: its average is what a thin strand has, its streaks are where they should be."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from strand_kit import groom_of, scene_of
from strandcli.common.registry import FIBRES
from strandcli.draw.coverage.kernels import width_profiles as kernel
from strandcli.draw.fibre import chiang, marschner
from strandcli.draw.fibre.tables import N_PHI, N_THETA
from strandcli.groom.blocks import lanes
from strandcli.scene.model import Material, Scene
from strandcli.study.axes import changed
from strandcli.study.pictures.subject import LinearRenderer
from tests.draw.geometry.test_detail import positions_of
from tests.reference import chiang as chiang_reference

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
