"""Cameras that stand where they see the strands of a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import exchange_kit as kit
from groom_file_kit import hanging, scene, write
from strandcli.groom_file import from_file
from strandcli.scene.motion import emitter_pose


@pytest.mark.parametrize(("kind", "size"), [("perspective", (200, 20)), ("orthographic", (48, 64))])
def test_the_camera_sees_all_strands_and_comes_as_near_as_asked(
    kind: str, size: tuple[int, int], tmp_path: Path
) -> None:
    strands = hanging([6] * 200)
    given = scene(
        write(tmp_path / "a.data", strands), camera__kind=kind, image__size=size, camera__fit=0.8,
        camera__position=(3.0, 1.0, 2.0), emitter__position=(5.0, 0.0, 0.0), emitter__rotation=(0.0, 30.0, 0.0),
    )  # fmt: skip
    camera, pose = given.camera, emitter_pose(given.emitter, 0.0)
    points = np.concatenate(strands) @ np.array(pose.rotation).T + np.array(pose.translation) - camera.position
    ahead = np.subtract(camera.target, camera.position)
    ahead /= np.linalg.norm(ahead)
    assert ahead == pytest.approx(-np.array([3, 1, 2]) / np.sqrt(14), abs=1e-6)
    right = np.cross(ahead, camera.up)
    right /= np.linalg.norm(right)
    depth = points @ ahead
    flat = np.full(len(points), camera.height / 2)
    half = np.tan(np.radians(camera.fov) / 2) * depth if kind == "perspective" else flat
    x, y = points @ right / (half * size[0] / size[1]), points @ np.cross(right, ahead) / half
    assert depth.min() > camera.near
    spans = [max(-values.min(), values.max()) for values in (x, y)]
    assert max(spans) == pytest.approx(0.8, abs=2e-3)
    for values in (x, y):
        if kind == "orthographic" or np.abs(values).max() > 0.79:
            assert values.min() == pytest.approx(-values.max(), abs=2e-3)


def test_one_strand_far_away_does_not_make_the_others_a_speck(tmp_path: Path) -> None:
    strands = hanging([6] * 200)
    alone, beside = write(tmp_path / "a.data", strands), tmp_path / "b.data"
    write(beside, [*strands, np.array([[0, 0, 0], [1e4, 0, 0]], np.float32)])
    one, other = scene(alone), scene(beside)
    assert other.camera.position == pytest.approx(one.camera.position, rel=0.02)
    assert other.material.width == pytest.approx(one.material.width, rel=0.2)
    told = [" ".join(from_file(given.emitter.groom, 0).notes) for given in (one, other)]
    assert "far from the rest" in told[1]
    assert "far from" not in told[0]


def moving(folder: Path, shifts: tuple[float, ...]) -> Path:
    """Numbered files of the same strands, each so far along x; the last of them damaged where that is not finite."""
    for number, shift in enumerate(shifts, 1):
        strands = [one + np.float32([shift, 0, 0]) for one in hanging([6] * 200)]
        (folder / f"a.{number}.ply").write_bytes(kit.ply(strands) if np.isfinite(shift) else b"ply")
    return folder / "a.#.ply"


def test_the_camera_sees_strands_that_move_at_their_first_middle_and_last_moment(tmp_path: Path) -> None:
    path = moving(tmp_path, (0.0, 3.0, 7.0, 1.0, 5.0))
    wide = scene(path, camera__kind="orthographic", camera__position=(0.0, 0.0, 5.0), camera__fit=1.0)
    across = np.concatenate(hanging([6] * 200))[:, 0]
    assert wide.camera.height * 64 / 48 == pytest.approx(np.ptp(across) + 7, rel=1e-4)
    assert wide.camera.position[0] == pytest.approx((across.min() + across.max() + 7) / 2, rel=1e-4)
    later = scene(path, camera__kind="orthographic", camera__position=(0.0, 0.0, 5.0), emitter__groom__start=4)
    assert later.camera.position[0] == pytest.approx((across.min() + across.max() + 6) / 2, rel=1e-4)


def test_moments_that_cannot_be_read_do_not_hold_up_frames_that_show_others(tmp_path: Path) -> None:
    found = scene(moving(tmp_path, (0.0, 3.0, np.nan)), camera__position=(0.0, 0.0, 5.0))
    whole = tmp_path / "whole"
    whole.mkdir()
    assert found.camera == scene(moving(whole, (0.0, 3.0)), camera__position=(0.0, 0.0, 5.0)).camera
