"""Commands that write and read cameras of USD."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import dataset_kit as kit
import groom_file_kit
import strandcli
from camera_kit import POINTS
from cli_runs import Runner
from strandcli.cameras.read import views_at, views_of
from tests.cameras.test_usd_cameras import camera, seen_by_pixar, stage, write

SMALL = ("--set", "lights.0.shadow.size=64", "--set", "ambient_occlusion=null", "--no-progress")


def test_an_exported_preset_has_its_camera(tmp_path: Path, run: Runner) -> None:
    text = (
        "time: {frames: 3, fps: 25}\nemitter: {strands: 20, particles: 3, length: 1}\nrules: []\nlights: []\n"
        "image: {size: 40x30}\ncamera: {axis_x: 0.4, near: 0.25, keys: [{time: 0, position: [0, 0, 7], fov: 30}, "
        "{time: 0.08, position: [1, 2, 6], fov: 20}]}\n"
    )
    (tmp_path / "one.yaml").write_text(text)
    for name in ("out.usda", "out.usdc"):
        run.fine("export", tmp_path / "one.yaml", tmp_path / name, "--no-progress")
        found = views_of(tmp_path / name)
        wanted = views_at(strandcli.load(str(tmp_path / "one.yaml")), [1, 2, 3])
        assert found.own
        assert [one.name for one in found.views] == ["0001", "0002", "0003"]
        for before, after in zip(wanted, found.views, strict=True):
            assert np.abs(before.project(POINTS) - after.project(POINTS)).max() < 1e-6
            assert after.near == pytest.approx(0.25)
    assert math.isclose(wanted[2].focal, 15 / math.tan(math.radians(10)))
    run.fine("render", tmp_path / "one.yaml", "--cameras", tmp_path / "out.usda", "-o", tmp_path / "f", *SMALL[2:])
    assert "--camera: names" in run("render", "hair", "--camera", "a").err


def test_a_data_set_has_cameras_of_usd(tmp_path: Path, run: Runner) -> None:
    groom = groom_file_kit.write(tmp_path / "some.data", groom_file_kit.hanging([12] * 40))
    made = tmp_path / "set"
    for layout, size in (("nerfstudio", ("--size", "40x32")), ("hairstep", ("--size", "32x32"))):
        run.fine("dataset", groom, "--layout", layout, "--views", 2, *size, "-o", made / layout, *SMALL)
        found = views_of(made / layout / "cameras.usda")
        wanted = views_of(made / layout / "dataset.json")
        assert found.own
        for before, after in zip(wanted.views, found.views, strict=True):
            assert (before.name, before.perspective) == (after.name, after.perspective)
            assert np.abs(before.project(POINTS) - after.project(POINTS)).max() < 1e-6
    again = tmp_path / "again"
    cameras = made / "nerfstudio" / "cameras.usda"
    run.fine("dataset", groom, "--layout", "nerfstudio", "--cameras", cameras, "-o", again, *SMALL)
    first, second = (
        np.array([one["camera"]["eye"] for one in kit.manifest(part)["views"]]) for part in (made / "nerfstudio", again)
    )
    assert np.abs(first - second).max() < 1e-9


@pytest.mark.parametrize("suffix", [".data", ".usda"])
def test_strands_and_cameras_of_a_stage_stand_as_there(suffix: str, tmp_path: Path, run: Runner) -> None:
    """A stage in centimetres with z up: strands of the same coordinates are seen where the stage's camera sees them."""
    strands = [100 * one[:, [0, 2, 1]] * np.float32([1, -1, 1]) for one in groom_file_kit.hanging([12] * 40)]
    if suffix == ".usda":
        import usd_kit

        groom = write(tmp_path / "g.usda", usd_kit.HEAD + usd_kit.prim(strands))
    else:
        groom = groom_file_kit.write(tmp_path / f"g{suffix}", strands)
    places = np.concatenate(strands).astype(np.float64)
    middle = 0.5 * (places.min(0) + places.max(0))
    eye = middle - np.array([0, 400, 0])
    body = "float focalLength = 20\nfloat horizontalAperture = 20\nfloat verticalAperture = 20\n"
    body += f"double3 xformOp:translate = {tuple(eye.tolist())}\nfloat xformOp:rotateX = 90\n"
    body += 'uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateX"]'
    path = write(tmp_path / "c.usda", stage(camera(body=body), 'metersPerUnit = 0.01\nupAxis = "Z"'))
    run.fine("render", groom, "--cameras", path, "--size", "64x64", "-o", tmp_path / "o", "--aov", "mask", *SMALL)
    mask = np.load(tmp_path / "o" / "mask_0001.npz")["mask"]
    rows, columns = np.nonzero(mask > 0.02)
    seen = seen_by_pixar(path, "/cam", places, (64, 64))
    assert len(rows) > 20
    assert abs(columns.mean() + 0.5 - seen[:, 0].mean()) < 2
    assert np.ptp(seen[:, 0]) == pytest.approx(np.ptp(columns), abs=4)
    assert np.ptp(seen[:, 1]) == pytest.approx(np.ptp(rows), abs=4)
