"""Cameras that stand where they see the strands of a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from groom_file_kit import hanging, scene, write
from strandcli.groom_file import from_file
from strandcli.scene.motion import emitter_pose


@pytest.mark.parametrize("size", [(64, 48), (48, 64), (200, 20)])
@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
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
    assert "far from all others" in told[1]
    assert "far from" not in told[0]
