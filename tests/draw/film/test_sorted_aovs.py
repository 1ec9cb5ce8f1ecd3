"""Layers beside the picture, of sorted strands."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from strand_kit import frames_of, scene_of
from strandcli.draw.film.aovs import NOTHING, SOLID
from strandcli.run.frame import Frame
from strandcli.scene import Scene
from tests.draw.film.test_aovs import KINDS, SHEET, rays

# strands of true widths, sorted: what belongs to `SHEET` besides
SORTED = "material: {width: %g, "


def sorted_sheet(strands: int, wide: float, **options: Any) -> tuple[Scene, Frame]:
    """As `drawn`, by true coverage."""
    text = SHEET.replace("image: {", "image: {resolver: sorted, ").replace("material: {", SORTED % wide)
    names = {"direction": [0, 1, 0], "position": [0, -1, 0], "width": 1.0, "kind": "perspective", "samples": 1,
             "lights": "[]", "solids": "[]"} | options  # fmt: skip
    scene = scene_of(text % (strands, *names.values()))
    return scene, frames_of(scene, 1)[0]


@KINDS
@pytest.mark.parametrize("samples", [1, 2])
@pytest.mark.parametrize("wide", [0.001, 0.2])
def test_layers_of_sorted_strands_tell_what_their_picture_shows(kind: str, samples: int, wide: float) -> None:
    """The mask is the exact share of the picture that is not background, however thin the strands; the rest is that of
    a strand that is there."""
    scene, frame = sorted_sheet(40, wide, kind=kind, samples=samples)
    mask, linear, ids = frame.aovs["mask"], frame.aovs["linear"], frame.aovs["strand_id"]
    strand = np.array([0.6, 0.4, 0.2]) * 0.1  # ambient
    background = np.array([0.2, 0.3, 0.4])
    np.testing.assert_allclose(linear, background + mask[..., None] * (strand - background), atol=2e-6)
    assert len(np.unique(mask)) > 40
    # a sheet of strands of one direction: both as exact as ever
    there = ids >= 0
    assert (mask[there] >= 1 / 64 / samples**2).all()
    assert there[mask >= 1 / 64 + 1e-6].all() if samples == 1 else there[mask >= 0.1].all()
    origin, way = rays(scene)
    exact = ((np.array([0, -1, 0]) - origin) @ [0, 0, 1.0]) / (way @ [0, 0, 1.0])
    # a fragment has the depth of its strand's middle, in a plane that leans to the camera's sides by 1/20
    assert np.abs(frame.aovs["depth"] - exact)[there].max() < 0.005 + wide / 20
    np.testing.assert_allclose(frame.aovs["tangent"][there], np.broadcast_to([0, 1, 0], (there.sum(), 3)), atol=1e-5)
    place = origin + np.where(there, frame.aovs["depth"], 0)[..., None] * way
    reach = wide / 2 + 0.02 * (2 - 1 / samples)  # and as far as a sample's border is from the pixel's middle
    assert np.abs(place[there][:, 0] - frame.positions[ids[there], 0, 0]).max() < reach


def test_a_sorted_pixel_is_that_of_the_strand_that_shows_most() -> None:
    """Thin strands before a wide one that they hardly cover, and a ball that shows between and beside them."""
    ball = "[{kind: sphere, radius: 0.4, position: [0.3, 0, -0.5]}]"
    for wide, holds in ((0.002, SOLID), (0.3, 0)):
        _, frame = sorted_sheet(1, wide, width=1e-6, solids=ball)
        ids, mask = frame.aovs["strand_id"], frame.aovs["mask"]
        assert set(np.unique(ids)) <= {NOTHING, SOLID, 0}
        assert ids[24, 29] == 0  # where the strand is, however little of the pixel it covers
        assert ids[24, 40] == SOLID
        assert 1 / 64 < mask[24].max() < 0.1 if wide < 0.01 else mask[24].max() == pytest.approx(1)
        assert (mask[ids == NOTHING] < 1 / 64).all()
        assert holds in ids[24]
    text = SHEET.replace("image: {", "image: {resolver: sorted, ").replace("material: {", SORTED % 0.3)
    thick = scene_of(text % (1, [0, 1, 0], [0, -1, 0], 1e-6, "perspective", 1, "[]", "[]"))
    assert (frames_of(thick, 1)[0].aovs["mask"] > 0.99).sum() > 100
