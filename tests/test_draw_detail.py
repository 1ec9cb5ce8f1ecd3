"""Level of detail by distance: how many strands are drawn, how much wider, and always the same ones."""

from __future__ import annotations

import numpy as np
import pytest
from strand_kit import frames_of, scene_of

from strandcli.draw.detail import distance, drawn_fraction
from strandcli.plan import make_plan, needed_strands

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


def at(far: float, near: float = 10.0, least: float = 0.1, widen: str = "true") -> tuple[float, float]:
    return drawn_fraction(scene_of(SCENE % (0.0, near, least, widen)), (far - 20) / 300)


def test_near_strands_are_all_drawn_and_far_ones_by_the_inverse_of_the_distance() -> None:
    assert at(20, near=30) == (1, 1)
    assert at(20, near=20) == (1, 1)
    for far in (25.0, 40.0, 80.0):
        share, wider = at(far, near=20)
        assert share == pytest.approx(20 / far)
        assert wider == pytest.approx(far / 20)
        assert share * wider == pytest.approx(1)  # the covered area stays
    assert at(320, near=20, least=0.25) == pytest.approx((0.25, 4))
    assert at(40, near=20, widen="false") == pytest.approx((0.5, 1))


def test_without_the_setting_every_strand_is_drawn() -> None:
    text = (SCENE % (0, 1, 0.1, "true")).replace("detail:", "# detail:")
    assert drawn_fraction(scene_of(text), 1.0) == (1, 1)


def test_distance_is_from_the_camera_to_the_emitter_as_both_move() -> None:
    text = (SCENE % (0, 1, 0.1, "true")).replace("strands: 1000,", "strands: 1000, position: [0, 30, 20],")
    assert distance(scene_of(text), 0.0) == pytest.approx(30)
    assert distance(scene_of(text), 0.1) == pytest.approx(np.hypot(30, 30))


def test_the_share_changes_without_jumps() -> None:
    scene = scene_of(SCENE % (0.0, 20, 0.1, "true"))
    shares = [drawn_fraction(scene, time)[0] for time in np.arange(0, 1, 0.002)]
    assert np.abs(np.diff(shares)).max() < 0.03
    assert (np.diff(shares) <= 0).all()


def test_only_strands_that_some_frame_draws_are_simulated() -> None:
    scene = scene_of(SCENE % (0, 20, 0.01, "true"))
    assert needed_strands(scene, [1]) == 1000
    assert needed_strands(scene, [11]) == round(1000 * 20 / 320)
    assert needed_strands(scene, [3, 11, 7]) == round(1000 * 20 / 80)
    assert needed_strands(scene, []) == 1000
    tiny = scene_of((SCENE % (0, 20, 0.01, "true")).replace("strands: 1000", "strands: 3"))
    assert needed_strands(tiny, [11]) == 1
    assert make_plan(scene, [11]).strands == 62


def test_a_frame_draws_the_same_strands_whichever_frames_are_drawn_with_it() -> None:
    """Those that are kept are the first ones, so a strand kept at some distance is kept at every lesser one."""
    scene = scene_of(SCENE % (0.01, 20, 0.01, "true"))
    together = {frame.number: frame for frame in frames_of(scene, 1, 3, 6, 11)}
    counts = [together[number].report["counts"]["strands"] for number in (1, 3, 6, 11)]
    assert counts == [1000, 250, round(1000 * 20 / 170), 62]
    for number in (3, 11):
        (alone,) = frames_of(scene, number)
        assert alone.report["counts"]["strands"] == together[number].report["counts"]["strands"]
        np.testing.assert_array_equal(alone.image, together[number].image)
        np.testing.assert_array_equal(alone.positions, together[1].positions[: len(alone.positions)])  # type: ignore[index, arg-type]


def test_wider_strands_cover_what_the_others_did() -> None:
    """Half of the strands, each twice as wide, cover as much as all of them would."""
    plane = "shape: {kind: plane, width: 1.1, depth: 0.01}, length: 1.2"
    text = SCENE.replace("shape: {kind: sphere, radius: 0.5}, length: 0.3", plane)
    text = text.replace("fov: 10", "fov: 5").replace("[48, 40]", "[300, 400]").replace("strands: 1000", "strands: %d")

    def covered(strands: int, near: float, widen: str) -> int:
        frame = frames_of(scene_of(text % (strands, 0.01, near, 0.01, widen)), 1)[0]
        assert frame.report["counts"]["strands"] == strands * near / 20
        return int(frame.report["counts"]["fragments"])

    assert covered(16, 10, "true") == pytest.approx(covered(16, 20, "false"), rel=0.03)
    assert covered(16, 10, "false") == pytest.approx(covered(16, 20, "false") / 2, rel=0.03)
