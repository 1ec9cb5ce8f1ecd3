"""Level of detail: how many strands are drawn, how much wider, always the same ones, and never one at once."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from strand_kit import frames_of, groom_of, scene_of
from strandcli.draw.drawn_strands import DrawnStrands
from strandcli.draw.geometry.detail import Level, level_of
from strandcli.groom.blocks import lanes, pack
from strandcli.groom.children import Children
from strandcli.plan import make_plan
from strandcli.scene.detail import near_of, needed_strands, share_at, share_bounds, strands_needed, tiers
from strandcli.scene.model import Scene
from strandcli.study.pictures.subject import LinearRenderer
from strandcli.study.sweep import changed

SCENE = """
emitter: {strands: 1000, particles: 3, shape: {kind: sphere, radius: 0.5}, length: 0.3}
camera:
  fov: 10
  position: [0, 0, 20]
  keys: [{time: 0, position: [0, 0, 20], ease: linear}, {time: 1, position: [0, 0, 320]}]
time: {fps: 10, frames: 11}
image: {size: [48, 40]}
material: {width: %g}
detail: {near: %g, fraction: %g, widen: %s}
"""
STILL = """
seed: 3
emitter: {strands: %d, particles: 4, shape: {kind: disc, radius: 0.5}, length: 0.4, jitter: 20}
rules: []
camera: {position: [0, 0.6, 3], target: [0, 0.2, 0], fov: 24}
image: {size: [96, 72], resolver: %s, background: [0, 0, 0]}
material: {width: 0.004, taper: 0.3}
ambient: [1, 1, 1]
lights: %s
detail: {near: 1, fraction: 0.01}
"""
SUN = "[{kind: directional, direction: [1, -1, -0.4], shadow: {model: %s, size: 64}}]"


def share(far: float, near: float = 10.0, least: float = 0.1) -> float:
    return share_at(scene_of(SCENE % (0.0, near, least, "true")), 0.0, far)


def still(strands: int = 60, resolver: str = "sorted", shadow: str | None = None) -> Scene:
    return scene_of(STILL % (strands, resolver, "[]" if shadow is None else SUN % shadow))


def positions_of(scene: Scene) -> np.ndarray:
    """(blocks, n + 1, 3 W): strands as they grow."""
    groom, n = groom_of(scene), scene.emitter.particles
    steps = (np.arange(-1, n) / (n - 1))[None, :, None]
    return pack(groom.roots[:, None] + steps * (groom.directions * groom.lengths[:, None])[:, None])


class Stage:
    """A scene drawn again and again with other settings of `detail`, in linear light."""

    def __init__(self, scene: Scene) -> None:
        self.scene, self.groom = scene, groom_of(scene)
        self.renderer = LinearRenderer(scene, self.groom)
        self.positions = positions_of(scene)
        self.lengths = lanes((self.groom.lengths / (scene.emitter.particles - 1))[:, None])

    def __call__(self, **settings: Any) -> np.ndarray:
        detail = None if settings.get("off") else replace(self.scene.detail, **settings)  # type: ignore[type-var]
        self.renderer.scene = replace(self.scene, detail=detail)
        self.renderer.draw(self.positions, self.lengths, 0.0, 1)
        assert self.renderer.linear is not None
        return np.asarray(self.renderer.linear).copy()


def level(scene: Scene, near: float, thin: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Fades and scales of all strands."""
    at = changed(scene, {"detail.near": near})
    found = level_of(at, 0.0, positions_of(scene), scene.emitter.strands, None, thin)
    return found.fade, found.scale


def test_near_strands_are_all_kept_and_of_far_ones_the_inverse_of_the_distance() -> None:
    assert share(20, near=30) == share(20, near=20) == 1
    for far in (25.0, 40.0, 80.0):
        assert share(far, near=20) == pytest.approx(20 / far)
    assert share(320, near=20, least=0.25) == 0.25
    plain = scene_of((SCENE % (0, 1, 0.1, "true")).replace("detail:", "# detail:"))
    assert (share_at(plain, 0.0, 1e6), strands_needed(plain, 0.0)) == (1, 1000)


def test_without_a_distance_strands_are_kept_while_they_are_wide_enough_on_the_screen() -> None:
    """A strand is `pixels` samples wide at the distance found; a zoom counts; an orthographic camera has none."""
    text = (SCENE % (0.002, 1, 0.1, "true")).replace("near: 1,", "pixels: 0.5,")
    scene = scene_of(text)
    near, by_distance = near_of(scene, 0.0)
    assert by_distance
    assert 0.002 * (40 / 2 / np.tan(np.radians(5))) / near == pytest.approx(0.5)
    assert near_of(changed(scene, {"image.supersample": 3}), 0.0)[0] == pytest.approx(3 * near)
    assert near_of(changed(scene, {"camera.fov": 20.0, "camera.keys": ()}), 0.0)[0] < 0.6 * near
    flat = changed(scene, {"camera.kind": "orthographic", "camera.height": 4.0, "camera.keys": ()})
    assert near_of(flat, 0.0) == (pytest.approx(0.002 * 10 / 0.5), False)
    assert share_at(changed(flat, {"material.width": 0.01}), 0.0, 1e9) == pytest.approx(0.2)
    lines = scene_of(text.replace("width: 0.002", "width: 0"))
    assert share_bounds(lines, 0.0) == (1, 1)


def test_bounds_hold_for_every_strand_as_camera_and_emitter_move() -> None:
    text = (SCENE % (0, 20, 0.01, "true")).replace("strands: 1000,", "strands: 1000, position: [0, 30, 20],")
    scene = scene_of(text)
    assert share_bounds(scene, 0.0) == pytest.approx((20 / 30.5, 20 / 29.5))
    assert share_bounds(scene, 0.1) == pytest.approx((20 / (np.hypot(30, 30) + 0.5), 20 / (np.hypot(30, 30) - 0.5)))
    for near in (0.2, 1.0, 2.0):
        at = changed(still(500), {"detail.near": near})
        fade, _ = level(at, near)
        assert not fade[strands_needed(at, 0.0) :].any()


def test_a_strand_once_kept_is_kept_at_every_greater_share() -> None:
    scene = still(500)
    before = np.zeros(500)
    for near in np.linspace(0.05, 3.4, 60):
        fade, _ = level(scene, near)
        assert (fade >= before).all()
        before = fade
    assert before.mean() > 0.98


def test_widths_add_up_however_few_strands_there_are() -> None:
    for strands in (1, 3, 40, 1000):
        scene = changed(still(strands), {"camera.kind": "orthographic", "camera.height": 1.0, "detail.near": None})
        for k in (0.013, 0.2, 0.5, 0.93, 0.999):
            at = changed(scene, {"material.width": k / 72})
            found = level_of(at, 0.0, positions_of(at), strands, None, False)
            share = max(k, 1 / strands)
            assert (found.fade * found.scale).sum() == pytest.approx(strands, abs=0.15 * max(1 / share, 1))


@pytest.mark.parametrize(("resolver", "shadow"), [("sorted", None), ("sorted", "opacity"), ("zbuffer", None)])
def test_nothing_jumps(resolver: str, shadow: str | None) -> None:
    """While the share goes from a third to a tenth in small steps, no step changes the picture by more than a fraction
    of what one of the strands then drawn does, and half of a step by about half of that: none comes or goes at once.
    Without anti-aliasing a sample is one strand's or another's, and the bound is a strand."""
    stage = Stage(still(60, resolver, shadow))
    whole = stage(off=True)
    one = whole.sum() / 60
    nears = np.geomspace(1.0, 0.3, 241)
    pictures = [stage(near=float(near)) for near in nears]
    steps = np.array([np.abs(b - a).sum() for a, b in pairwise(pictures)])
    assert steps.sum() > 20 * one
    shares = steps * nears[1:] / 3 / one  # of a strand, each as wide as 1 / k of them
    if resolver == "zbuffer":
        assert shares.max() < 1
        return
    assert shares.max() < 0.3
    worst = int(shares.argmax())
    between = stage(near=float(np.sqrt(nears[worst] * nears[worst + 1])))
    halves = np.abs(between - pictures[worst]).sum(), np.abs(pictures[worst + 1] - between).sum()
    assert max(halves) < 0.7 * steps[worst]


def test_a_strand_in_the_z_buffer_grows_from_its_root() -> None:
    """It is shortened, since its line cannot be less than a sample wide: pixels of one strand come bit by bit."""
    flat = {"material.width": 0.0, "camera.kind": "orthographic", "camera.height": 1.5}
    stage = Stage(changed(still(1, "zbuffer"), flat))
    scene = changed(stage.scene, {"detail.widen": False})
    seen = []
    for part in (0.2, 0.6, 1.0):
        stage.scene = scene
        with pytest.MonkeyPatch.context() as patch:
            faded = Level(np.full(1, part, np.float32), np.ones(1, np.float32), 1.0)
            patch.setattr("strandcli.draw.drawn_strands.level_of", lambda *_, faded=faded: faded)
            seen.append((stage(near=1.0).sum(2) > 0.1).sum())
    assert seen[2] > 12
    assert seen[0] == pytest.approx(0.2 * seen[2], abs=1.5)
    assert seen[1] == pytest.approx(0.6 * seen[2], abs=1.5)


def test_an_eighth_of_the_strands_covers_what_all_do() -> None:
    """The area that white strands cover before black, which were a fifth of it if they were not wider."""
    stage = Stage(changed(still(6000), {"material.width": 0.0003, "curves.mode": "fixed"}))
    whole = stage(off=True).sum()
    near = 3.0 / 8  # metres from the camera to the middle
    assert 0.996 < stage(near=near).sum() / whole < 1.053
    assert stage(near=near, widen=False).sum() / whole < 0.25


def test_only_strands_that_some_frame_draws_are_simulated() -> None:
    scene = scene_of(SCENE % (0, 20, 0.01, "true"))
    drawn = [int(np.ceil(1000 * 1.1 * 20 / (far - 0.5) - 0.5)) for far in (80, 320)]
    most = [next(end for end in (128, 256, 384, 512, 768, 1000) if end >= count) for count in drawn]
    assert tiers(1000) == [128, 256, 384, 512, 768, 1000]
    assert needed_strands(scene, [1]) == 1000
    assert needed_strands(scene, [11]) == most[1]
    assert needed_strands(scene, [3, 11, 7]) == most[0]
    assert needed_strands(scene, []) == 1000
    tiny = scene_of((SCENE % (0, 20, 0.01, "true")).replace("strands: 1000", "strands: 3"))
    assert needed_strands(tiny, [11]) == 3
    assert make_plan(scene, [11]).strands == most[1]


CHILDREN = """
seed: 5
emitter: {strands: 90, particles: 4, shape: {kind: plane, width: 3, depth: 9}, length: 0.3, jitter: 20}
children: {count: 400, clumps: [{size: 0.2}], waves: [{radius: 0.01, length: 0.2}]}
rules: [gravity, {wind: {strength: 3}}]
camera: {position: [0, 0.6, 6], target: [0, 0.2, 0], fov: 24}
image: {size: [96, 72], resolver: sorted}
material: {model: chiang, scatter: dual, width: 0.004, taper: 0.3, colour_variation: 0.5}
ambient: [0.5, 0.5, 0.5]
ambient_occlusion: {cells: 3000}
lights: [{kind: directional, direction: [1, -1, -0.4], shadow: {model: opacity, size: 64}}]
solids: [{kind: plane}]
detail: {near: 1.2, fraction: 0.05}
"""


def test_children_that_are_not_drawn_are_not_made_and_no_pixel_differs(monkeypatch: pytest.MonkeyPatch) -> None:
    grown: list[int] = []
    grow = Children.grow_along

    def note(self: Children, leading: Any, ids: Any, scratch: Any) -> Any:
        grown.append(len(ids))
        return grow(self, leading, ids, scratch)

    monkeypatch.setattr(Children, "grow_along", note)
    (few,) = frames_of(scene_of(CHILDREN), 2)
    drawn = few.report["counts"]["strands"]
    assert 3000 < drawn < 12000
    assert grown[0] == drawn
    assert grown[1] < 24000  # those about the points where spacing is measured
    grown.clear()
    monkeypatch.setattr(DrawnStrands, "_choose", lambda *_: (None, None))
    (every,) = frames_of(scene_of(CHILDREN), 2)
    assert grown == [36000]
    np.testing.assert_array_equal(few.image, every.image)
