"""Cameras of USD: what is written is read again as the same projection; what Pixar's library makes of a camera, and
closed forms, agree with what is read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from camera_kit import POINTS, VIEWS, view
from strandcli.cameras import usd
from strandcli.cameras.pinhole import Pinhole
from strandcli.cameras.read import views_of
from strandcli.errors import UsageError


def write(path: Path, text: str | bytes) -> Path:
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def stage(body: str, head: str = "") -> str:
    return f"#usda 1.0\n(\n{head}\n)\n{body}"


def camera(name: str = "cam", body: str = "") -> str:
    return f'def Camera "{name}"\n{{\n{body}\n}}\n'


def scaled(factors: str) -> str:
    return camera(body=f'float3 xformOp:scale = {factors}\nuniform token[] xformOpOrder = ["xformOp:scale"]')


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10_000), perspective=st.booleans(), count=st.integers(1, 3))
def test_views_written_are_read_as_the_same_projection(
    seed: int, perspective: bool, count: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    views = [view(seed + k, perspective) for k in range(count)]
    found = views_of(write(tmp_path_factory.mktemp("views") / "v.usda", usd.written(views)))
    assert found.own
    assert (found.unit, found.up, found.notes) == (1, "y", ())
    for before, after in zip(views, found.views, strict=True):
        assert (after.name, after.width, after.height) == (before.name, 64, 48)
        assert np.abs(before.project(POINTS) - after.project(POINTS)).max() < 1e-6


def seen_by_pixar(path: Path, name: str, points: Any, size: tuple[int, int], code: float | None = None) -> Any:
    """Pixels at which the frustum of Pixar's library has points (k, 3) of the stage."""
    from pxr import Usd, UsdGeom

    opened = Usd.Stage.Open(str(path))
    moment = Usd.TimeCode.Default() if code is None else Usd.TimeCode(code)
    frustum = UsdGeom.Camera(opened.GetPrimAtPath(name)).GetCamera(moment).frustum
    matrix = np.array(frustum.ComputeViewMatrix() * frustum.ComputeProjectionMatrix())
    clip = np.c_[points, np.ones(len(points))] @ matrix
    ndc = clip[:, :2] / clip[:, 3:]
    return np.stack([(ndc[:, 0] + 1) / 2 * size[0], (1 - ndc[:, 1]) / 2 * size[1]], 1)


@pytest.mark.parametrize("perspective", [True, False])
def test_pixars_library_sees_what_was_written(perspective: bool, tmp_path: Path) -> None:
    views = [view(seed, perspective) for seed in range(4)]
    path = write(tmp_path / "v.usda", usd.written(views))
    for code, before in enumerate(views, 1):
        assert np.abs(seen_by_pixar(path, "/camera", POINTS, (64, 48), code) - before.project(POINTS)).max() < 1e-3


FOREIGN = """
def Xform "rig"
{{
    double3 xformOp:translate = (10, -20, 30)
    double3 xformOp:rotateXYZ = (20, 30, 40)
    double3 xformOp:scale = (2, 2, 2)
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ", "xformOp:scale"]
    def Camera "cam"
    {{
        token projection = "{0}"
        float2 clippingRange = (0.5, 1000)
        float focalLength = 35
        float horizontalAperture = 400
        float verticalAperture = 300
        float horizontalApertureOffset = 37.5
        float verticalApertureOffset = -12.25
        double3 xformOp:translate = (1, 2, 50)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }}
}}
"""


@pytest.mark.parametrize("perspective", [True, False])
@pytest.mark.parametrize("up", ["Y", "Z"])
def test_cameras_of_others_see_what_pixars_library_sees(perspective: bool, up: str, tmp_path: Path) -> None:
    """Rigs, offsets, centimetres, z up: points of the stage are seen where its own frustum has them."""
    text = FOREIGN.format("perspective" if perspective else "orthographic")
    path = write(tmp_path / "a.usda", stage(text, f'metersPerUnit = 0.01\nupAxis = "{up}"'))
    found = views_of(path, (640, 480))
    assert not found.own
    assert (found.unit, found.up) == (0.01, up.lower())
    (only,) = found.views
    points = 10 * POINTS
    world = 0.01 * (points if up == "Y" else points[:, [0, 2, 1]] * [1, 1, -1])
    assert np.abs(only.project(world) - seen_by_pixar(path, "/rig/cam", points, (640, 480))).max() < 1e-9
    assert only.near == pytest.approx(0.005)
    assert only.perspective is perspective


@pytest.mark.parametrize(
    ("conform", "pixel", "size", "focal"),
    [
        ("expandAperture", 1, (400, 100), 500),  # of 20 by 10: the height is kept, 100 / 10 a unit
        ("expandAperture", 1, (200, 200), 500),  # the width is
        ("cropAperture", 1, (400, 100), 1000),
        ("adjustApertureHeight", 1, (400, 100), 1000),
    ],
)
def test_what_is_kept_of_an_aperture_of_another_shape(
    conform: str, pixel: float, size: tuple[int, int], focal: float, tmp_path: Path
) -> None:
    body = camera(body="float focalLength = 50\nfloat horizontalAperture = 20\nfloat verticalAperture = 10")
    body += f'def RenderSettings "any"\n{{\n    uniform int2 resolution = {size}\n'
    body += f'    uniform token aspectRatioConformPolicy = "{conform}"\n'
    body += f"    uniform float pixelAspectRatio = {pixel}\n}}"
    (only,) = views_of(write(tmp_path / "a.usda", stage(body))).views
    assert (only.width, only.height) == size
    assert only.focal == pytest.approx(focal)
    assert only.centre == (size[0] / 2, size[1] / 2)


def test_a_moving_camera_has_a_view_a_frame(tmp_path: Path) -> None:
    """Frames of 24 a second where there are 48 time codes; between samples cameras move in straight lines."""
    body = "double3 xformOp:translate.timeSamples = { 0: (0, 0, 5), 8: (4, 0, 5) }\n"
    body += 'uniform token[] xformOpOrder = ["xformOp:translate"]\n'
    body += "float focalLength.timeSamples = { 0: 50, 8: 90 }"
    head = "startTimeCode = 2\nendTimeCode = 10\ntimeCodesPerSecond = 48\nframesPerSecond = 24"
    found = views_of(write(tmp_path / "a.usda", stage(camera(body=body), head)), (64, 48)).views
    assert [one.eye[0] for one in found] == [1, 2, 3, 4, 4]
    assert [one.focal for one in found] == pytest.approx([64 / 20.955 * f for f in (60, 70, 80, 90, 90)])
    bare = views_of(write(tmp_path / "b.usda", stage(camera(body=body), "timeCodesPerSecond = 24")), (64, 48)).views
    assert [one.eye[0] for one in bare] == [k / 2 for k in range(9)]


def test_a_lens_that_another_program_changes_counts(tmp_path: Path) -> None:
    text = usd.written(VIEWS[:1]).decode()
    line = next(one for one in text.splitlines() if "float focalLength" in one)
    changed = views_of(write(tmp_path / "a.usda", text.replace(line, "    float focalLength = 72"))).views[0]
    assert changed.focal == pytest.approx(64 * 72 / 36)
    assert changed.centre == VIEWS[0].centre


@pytest.mark.parametrize(
    ("body", "name", "words"),
    [
        ('def Xform "a"\n{\n}\ndef Mesh "b"\n{\n}', "", "has no camera; there are 1 Xform, 1 Mesh"),
        (camera("a") + camera("b"), "", "holds 2 cameras: /a, /b; choose one"),
        (camera("a") + camera("b"), "c", "has no camera c; there are /a, /b"),
        ('def Xform "x"\n{\n' + camera() + '}\ndef Xform "y"\n{\n' + camera() + "}", "cam", "2 cameras are called cam"),
        (camera(body="float focalLength = 0"), "", "/cam: focalLength 0"),
        (camera(body="float horizontalApertureOffset = nan"), "", "all finite"),
        (camera(body="float focalLength.timeSamples = { 1: 50, 3: inf }"), "", "time code 2"),
        (camera(body='token projection = "o\x01"'), "", "projection o\\x01 is not drawn"),
        (scaled("(0, 0, 0)"), "", "is no r"),
        (scaled("(-1, 1, 1)"), "", "mirrors"),
    ],
)  # fmt: skip
def test_cameras_that_cannot_be_drawn_are_refused_in_one_line(body: str, name: str, words: str, tmp_path: Path) -> None:
    path = write(tmp_path / "a.usda", stage(body))
    with pytest.raises(UsageError) as error:
        views_of(path, (64, 48), name=name)
    assert str(error.value).startswith(str(path))
    assert words in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("head", "words"),
    [
        ("metersPerUnit = nan", "metersPerUnit nan"),
        ("startTimeCode = 5\nendTimeCode = 1", "from time code 5 to 1"),
        ("startTimeCode = 0\nendTimeCode = 1e300", "100,000 are read at the most"),
    ],
)
def test_stages_that_cannot_be_meant_are_refused(head: str, words: str, tmp_path: Path) -> None:
    body = camera(body="float focalLength.timeSamples = { 1: 50, 3: 60 }")
    with pytest.raises(UsageError) as error:
        views_of(write(tmp_path / "a.usda", stage(body, head)), (64, 48))
    assert words in str(error.value)


def test_of_several_cameras_one_is_chosen(tmp_path: Path) -> None:
    lens = "float focalLength = {}"
    rig = 'def Xform "rig"\n{\n' + camera("b", lens.format(60)) + "}\n"
    text = stage(camera("a", lens.format(50)) + rig)
    path = write(tmp_path / "a.usda", text)
    for name, focal in (("a", 50), ("/a", 50), ("b", 60), ("rig/b", 60), ("/rig/b", 60)):
        assert views_of(path, (64, 48), name=name).views[0].focal == pytest.approx(64 * focal / 20.955)
    settings_prim = 'def RenderSettings "s"\n{\n    rel camera = </rig/b>\n    uniform int2 resolution = (64, 48)\n}'
    path = write(tmp_path / "b.usda", text + settings_prim)
    assert views_of(path).views[0].focal == pytest.approx(64 * 60 / 20.955)
    with pytest.raises(UsageError, match="only files of USD have several cameras"):
        views_of(write(tmp_path / "transforms.json", "{}"), name="a")


def test_a_place_that_has_one_time_alone_counts(tmp_path: Path) -> None:
    still = FOREIGN.format("perspective")
    timed = still.replace("translate = (10, -20, 30)", "translate.timeSamples = { 3: (10, -20, 30) }")
    assert timed != still
    first, other = (views_of(write(tmp_path / "a.usda", stage(text)), (64, 48)).views for text in (still, timed))
    assert len(first) == len(other) == 1
    np.testing.assert_array_equal(other[0].project(POINTS), first[0].project(POINTS))


def test_views_of_several_kinds_are_not_one_camera() -> None:
    other = Pinhole("b", 10, 10, 5.0, (5.0, 5.0), np.eye(3), np.zeros(3))
    with pytest.raises(UsageError, match="one size and projection"):
        usd.written([VIEWS[0], other])
