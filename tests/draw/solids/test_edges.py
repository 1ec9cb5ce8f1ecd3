"""Edges of solids under sorted strands against pictures of very many samples, which know nothing of coverage."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pytest

from strand_kit import frames_of, scene_of
from strandcli.draw.canvas import Canvas
from strandcli.draw.common.kernels.keys import EMPTY
from strandcli.draw.lighting.lighting import NO_SPOTS, Lighting
from strandcli.draw.transmittance import draw_solids

# no strand is near the camera, or one as wide as a board, alone: all light comes from everywhere
SCENE = """
emitter: {strands: 1, particles: 2, length: 4, direction: [0, 1, 0], position: %s,
  shape: {kind: disc, radius: 0.000001}}
rules: []
camera: {kind: %s, position: [0.1, 0.6, 5], target: [0, 0, 0], fov: 30, height: 2.6}
image: {size: [64, 48], background: [0.9, 0.1, 0.1], aovs: [linear], resolver: %s, supersample: %d}
ambient: [1, 1, 1]
curves: {mode: "off"}
material: {width: 0.5, taper: 0, colour: [0.1, 0.9, 0.2], specular: 0, diffuse: 0}
lights: []
solids: %s
"""
BALL = "{kind: sphere, radius: 0.5, position: [0.25, 0, 0], colour: [0.2, 0.2, 0.9]}"
ROD = "{kind: capsule, radius: 0.2, length: 2, position: [-0.2, 0.2, 0], rotation: [20, 0, 35], colour: [0.9, 0.9, 0]}"
BOX = "{kind: box, size: [0.8, 0.5, 0.6], position: [-0.3, -0.3, 0.2], rotation: [20, 30, 10], colour: [0.9, 0.9, 0.1]}"
GROUND = "{kind: plane, position: [0, -0.8, 0], rotation: [0, 0, 8], colour: [0.3, 0.7, 0.3], fade: 0}"
AWAY, BEFORE, BETWEEN, BEHIND = ("[0, 90, 0]", "[0.05, -2, 1.5]", "[0.05, -2, -0.7]", "[0.05, -2, -1.5]")
KINDS = pytest.mark.parametrize("kind", ["perspective", "orthographic"])


def light(strand: str, kind: str, resolver: str, samples: int, *solids: str) -> np.ndarray:
    """(48, 64, 3) linear light."""
    scene = scene_of(SCENE % (strand, kind, resolver, samples, f"[{', '.join(solids)}]"))
    return np.asarray(frames_of(scene, 1)[0].aovs["linear"], float)


@KINDS
@pytest.mark.parametrize("solids", [[BALL], [BOX], [BALL, ROD, BOX, GROUND]])
def test_edges_of_solids_are_what_samples_show(kind: str, solids: list[str]) -> None:
    """All pixels are within what 4×4 samples can be off by; where the edge goes through, one sample is far off."""
    exact = light(AWAY, kind, "zbuffer", 8, *solids)
    got = light(AWAY, kind, "sorted", 1, *solids)
    hard = light(AWAY, kind, "zbuffer", 1, *solids)
    if solids != [GROUND] or kind == "perspective":  # else there is no horizon
        assert (np.abs(hard - exact).max(2) > 0.15).sum() > 20
    assert np.abs(got - exact).max() < 0.8 / 8 + 1e-5  # the greatest contrast, of two colours a sample in eight apart
    assert np.sqrt(np.mean((got - exact) ** 2)) <= 0.2 * np.sqrt(np.mean((hard - exact) ** 2)) + 1e-6
    inside = np.abs(hard - exact).max(2) < 1e-6
    np.testing.assert_allclose(got[inside], exact[inside], atol=1e-5)


@KINDS
@pytest.mark.parametrize("strand", [BEFORE, BETWEEN, BEHIND])
def test_strands_go_before_between_and_behind_the_edges_of_solids(kind: str, strand: str) -> None:
    """A board of a strand, a ball before a wall: at the ball's edge the wall shows, or the board where it is nearer."""
    wall = "{kind: box, size: [9, 9, 0.1], position: [0, 0, -1.1], colour: [0.5, 0.5, 0.5]}"
    exact = light(strand, kind, "zbuffer", 8, BALL, wall)
    got = light(strand, kind, "sorted", 1, BALL, wall)
    error = np.abs(got - exact).max(2)
    # where the edges of both cross a pixel each may lie anywhere in it
    assert (error > 0.1).sum() <= 4
    assert error.max() < 0.35
    assert np.sqrt(np.mean(error**2)) < 0.02


@KINDS
def test_edges_at_the_border_are_those_of_a_wider_picture(kind: str) -> None:
    """A crop window through a ball has the light of the whole picture up to its border."""
    text = SCENE % (AWAY, kind, "sorted", 1, f"[{BALL}, {GROUND}]")
    whole = frames_of(scene_of(text), 1)[0].aovs["linear"]
    for x in range(20, 36):
        scene = scene_of(text.replace("image: {", f"image: {{crop: [{x}, {x - 6}, 11, 14], "))
        part = frames_of(scene, 1)[0].aovs["linear"]
        np.testing.assert_allclose(part, whole[x - 6 : x + 8, x : x + 11], atol=1e-5)


def test_solids_behind_closed_strands_are_not_shaded_and_no_pixel_differs(monkeypatch: pytest.MonkeyPatch) -> None:
    """In bands, with haze and edges of solids before, between and behind an opaque board."""
    left: list[np.ndarray] = []
    beside: list[int] = []
    shade = Lighting.shade_surfaces

    def note(self: Lighting, keys: Any, image: Any, spots: Any = NO_SPOTS, *rest: Any) -> None:
        before = image.copy()
        shade(self, keys, image, spots, *rest)
        if not len(spots):
            left.append((image != before).any(2))
        else:
            beside.append(np.count_nonzero(keys != EMPTY))

    def all_of_them(self: Canvas, layer: Any, edges: Any) -> None:
        rows = layer.fragments.top, layer.fragments.bottom
        draw = partial(draw_solids, self.lighting)
        draw(self.keys, self.image, rows=rows)
        edges.within(rows[0] * self.size[0], rows[1] * self.size[0]).composite(draw, self.image, self.backdrop)

    monkeypatch.setattr("strandcli.draw.coverage.coverage.Coverage._cuts", lambda self: [(0, 21), (21, 48)])
    monkeypatch.setattr(Lighting, "shade_surfaces", note)
    text = SCENE % (BETWEEN, "perspective", "sorted", 1, f"[{BALL}, {ROD}, {GROUND}]")
    scene = scene_of(text.replace("image: {", "image: {haze: 20, "))
    spared = np.asarray(frames_of(scene, 1)[0].aovs["linear"])
    shaded, shaded_beside = np.any(left, 0), sum(beside)
    left.clear()
    beside.clear()
    monkeypatch.setattr(Canvas, "_behind", all_of_them)
    whole = np.asarray(frames_of(scene, 1)[0].aovs["linear"])
    assert np.any(left, 0).sum() > shaded.sum() + 100
    assert sum(beside) > shaded_beside + 10
    np.testing.assert_array_equal(spared, whole)


def test_a_picture_of_one_pixel_and_a_ball_about_the_camera_have_edges_or_none() -> None:
    around = "{kind: sphere, radius: 9, position: [0, 0, 0]}"
    for solid in (BALL, around):
        for kind in ("perspective", "orthographic"):
            text = SCENE % (BETWEEN, kind, "sorted", 1, f"[{solid}]")
            frame = frames_of(scene_of(text.replace("[64, 48]", "[1, 1]")), 1)[0]
            assert np.isfinite(frame.aovs["linear"]).all()
