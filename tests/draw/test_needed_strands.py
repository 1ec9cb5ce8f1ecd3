"""Strands that neither camera nor shadows show are not drawn, and no pixel differs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from strand_kit import frames_of, scene_of
from strandcli.draw.geometry.extent import extents_of
from strandcli.draw.geometry.kernels import bounds
from strandcli.draw.needed_strands import can_leave_out, needed_strands
from strandcli.draw.shadows.strands_in_map import FEWEST, chances_of, mark_sketched
from strandcli.groom.blocks import pack

SCENE = """
seed: %(seed)d
emitter: {strands: %(strands)d, particles: %(particles)d, shape: {kind: plane, width: 16, depth: 16}, length: 0.5,
  length_variation: 0.5, jitter: 40}
children: {count: %(count)d, clumps: [{size: 0.2, strength: 0.5}], waves: [{radius: %(radius)g, length: 0.2}]}
rules: [gravity, {wind: {strength: 3}}]
time: {fps: 24, frames: 3}
camera: {position: [%(x)g, %(y)g, %(z)g], target: [%(aside)g, 0.2, 0], fov: %(fov)g}
image: {size: [%(width)d, %(height)d], resolver: sorted, supersample: %(samples)d}
curves: {mode: %(mode)s}
material: {model: chiang, scatter: dual, width: %(thick)g, taper: 0.3, colour_variation: 0.5}
ambient: [0.1, 0.1, 0.1]
ambient_occlusion: {cells: 3000}
lights:
  - {kind: directional, direction: [%(along)g, -1, %(back)g], size: %(size)g, intensity: 3,
     shadow: {model: opacity, size: %(side)d, texel: 0.02}}
  - {kind: directional, direction: [-0.3, -0.8, -1], shadow: {model: opacity, size: 512, texel: 0.01}}
solids: [%(solids)s]
%(detail)s
"""
DETAIL = "detail: {near: 2, fraction: 0.2}"
PLAIN = {
    "seed": 5, "thick": 0.02, "strands": 150, "particles": 4, "count": 60, "radius": 0.01, "x": 0, "y": 0.6, "z": 4,
    "aside": 0, "fov": 12, "width": 96, "height": 72, "samples": 1, "mode": "adaptive", "along": 1, "back": -0.4,
    "size": 0,    "side": 512, "solids": "{kind: plane}", "detail": DETAIL,
}  # fmt: skip


def random_settings(seed: int) -> dict[str, object]:
    """Settings of `SCENE` by chance."""
    rng = np.random.default_rng(seed)
    return PLAIN | {
        "seed": seed, "thick": rng.uniform(0.005, 0.04), "particles": rng.integers(3, 7),
        "radius": rng.uniform(0.002, 0.08),
        "x": rng.uniform(-2, 2), "y": rng.uniform(0.2, 3), "z": rng.uniform(0, 6), "aside": rng.uniform(-1.5, 1.5),
        "fov": rng.uniform(3, 16), "width": rng.integers(17, 120), "height": rng.integers(17, 90),
        "samples": rng.integers(1, 3), "mode": rng.choice(["adaptive", "thinned"]),
        "along": rng.uniform(-5, 5), "back": rng.uniform(-2, 2), "size": rng.choice([0, 0, 0, 3]),
        "side": rng.choice([256, 1024, 2048]), "detail": rng.choice(["", DETAIL]),
        "solids": rng.choice(["{kind: plane}", "{kind: plane}, {kind: sphere, radius: 0.4}", "{kind: plane, fade: 2}"]),
    }  # fmt: skip


@pytest.mark.parametrize("seed", range(4))
def test_strands_that_no_picture_shows_are_not_drawn_and_no_pixel_differs(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = scene_of(SCENE % random_settings(seed))
    (few,) = frames_of(scene, 2)
    monkeypatch.setattr("strandcli.draw.renderer.can_leave_out", lambda _: False)
    (every,) = frames_of(scene, 2)
    assert few.report["counts"]["strands"] == every.report["counts"]["strands"]
    assert few.report["counts"]["segments"] <= every.report["counts"]["segments"]
    np.testing.assert_array_equal(few.image, every.image)


@pytest.mark.parametrize(("fov", "all_seen"), [(60, True), (6, False)])
def test_strands_are_left_out_only_where_some_are_beside_the_picture(
    fov: float, all_seen: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    found: list[bool] = []

    def note(scene: Any, at: float, strands: Any, *others: Any) -> Any:
        fade = needed_strands(scene, at, strands, *others)
        found.append(fade is strands.level.fade)
        return fade

    monkeypatch.setattr("strandcli.draw.renderer.needed_strands", note)
    list(frames_of(scene_of(SCENE % (PLAIN | {"y": 20, "z": 30, "fov": fov})), 2))
    assert found == [all_seen]


def test_strands_of_a_sketch_are_marked_where_there_is_one() -> None:
    for strands, some in ((FEWEST - 1, 0), (FEWEST, 0.25), (30_000, 0.1)):
        marks = np.zeros(strands, bool)
        mark_sketched(chances_of(None, strands), marks)
        assert marks.mean() == pytest.approx(some, rel=0.1)


@pytest.mark.parametrize(
    "change",
    [
        ("position:", "aperture: 0.1, focus: 4, position:"),
        ("position:", "kind: orthographic, position:"),
        ("resolver: sorted", "resolver: sorted, aovs: [depth]"),
        ("resolver: sorted", "resolver: zbuffer"),
        ("model: opacity, size: 512, texel: 0.01", "model: minmax"),
        ("kind: directional, direction: [-0.3, -0.8, -1]", "kind: point, position: [1, 3, 2]"),
        ("{kind: plane}", "{kind: plane, coat: 0.2, roughness: 0.1}"),
        ("mode: adaptive", "mode: fixed"),
    ],
)
def test_all_strands_are_drawn_where_others_than_those_seen_may_show(change: tuple[str, str]) -> None:
    """Lenses and lights look from elsewhere, coats mirror what is beside the picture."""
    text = SCENE % PLAIN
    assert change[0] in text
    assert can_leave_out(scene_of(text))
    assert not can_leave_out(scene_of(text.replace(*change)))


def test_boxes_are_marked_that_come_into_a_body_on_their_way() -> None:
    """The body is a half-space and a slab, the way ends on the ground; points of the strands' boxes tell."""
    rng = np.random.default_rng(2)
    roots = rng.uniform(-3, 3, (300, 1, 3))
    points = np.concatenate([roots, roots + rng.uniform(-0.5, 0.5, (300, 4, 3))], 1)
    low, high = extents_of(pack(points))
    sides = np.array([[1, 0, 0, -1], [0, 0, 1, 1], [0, 0, -1, 1]], np.float32)
    along = np.array([0.6, -0.8, 0], np.float32)
    floors = np.array([[0, 1, 0, 1]], np.float32)
    marks = np.zeros((len(low), low.shape[1] // 3), np.uint8)
    bounds.mark_inside(low, high, sides, along, floors, np.float32(0), marks)
    least, most = points[:, 1:].min(1), points[:, 1:].max(1)
    end = np.maximum((most[:, 1] + 1) / 0.8, 0)
    inside = (most[:, 0] + 0.6 * end >= 1) & (most[:, 2] >= -1) & (least[:, 2] <= 1)
    assert 30 < inside.sum() < 270
    np.testing.assert_array_equal(marks.reshape(-1)[:300], inside)
