"""Curves of USD: stages written by hand are read as Pixar's library reads them, and what is written is read again."""

from __future__ import annotations

import os
import subprocess
import sys
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import exchange_kit as kit
import usd_kit
from strandcli.errors import RefusedError, UsageError
from strandcli.exchange.files import read, write
from strandcli.exchange.strands import Attribute, Strands, TimeSample
from strandcli.exchange.usd import process

STRANDS = [np.arange(12, dtype=np.float32).reshape(4, 3) ** 2 + 100 * i for i in range(3)]
POINTS = np.concatenate(STRANDS)


moments = kit.moments
read_text = partial(kit.read_bytes, suffix=".usda")


def opened(path: Path) -> Any:
    """A stage, and its one prim of curves, as Pixar's library reads them."""
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(str(path))
    return stage, UsdGeom.BasisCurves(stage.GetDefaultPrim())


def test_what_is_written_is_what_the_schema_asks_for(tmp_path: Path) -> None:
    held = kit.of(STRANDS)
    held = Strands(held.first, held.points, {"width": Attribute("strand", np.array([1, 2, 4], np.float32))})
    write(tmp_path / "a.usd", held, [TimeSample(i / 25, held.points + np.float32(i)) for i in range(3)])
    stage, curves = opened(tmp_path / "a.usd")
    from pxr import Usd, UsdGeom

    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode(), stage.GetTimeCodesPerSecond()) == (0, 2, 25)
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1
    assert curves.GetTypeAttr().Get() == "linear"
    assert curves.GetCurveVertexCountsAttr().Get() == [4, 4, 4]
    assert curves.GetWidthsInterpolation() == "uniform"
    assert curves.GetWidthsAttr().Get() == [1, 2, 4]
    for i in range(3):
        points = np.array(curves.GetPointsAttr().Get(Usd.TimeCode(i)))
        assert points.tobytes() == (POINTS + np.float32(i)).tobytes()
        extent = np.array(curves.GetExtentAttr().Get(i))
        assert np.array_equal(extent, [points.min(axis=0) - 2, points.max(axis=0) + 2])


@pytest.mark.parametrize("packed", [False, True])
def test_a_stage_is_read_as_pixar_reads_it(tmp_path: Path, packed: bool) -> None:
    content = usd_kit.text(STRANDS)
    path = tmp_path / "a.usd"
    path.write_bytes(usd_kit.binary(content) if packed else content.encode())
    found = read(path)
    _, curves = opened(path)
    assert found.points.tobytes() == np.array(curves.GetPointsAttr().Get()).tobytes() == POINTS.tobytes()
    assert (found.source.unit, found.source.up) == (0.01, "z")
    assert found.attributes["width"].values.tolist() == [i / 64 for i in range(12)]
    assert found.attributes["colour"].domain == "strand"
    assert found.attributes["colour"].values.tolist() == (np.arange(9).reshape(3, 3) / 64).tolist()


def test_what_moves_is_read_at_all_its_times(tmp_path: Path) -> None:
    path = tmp_path / "a.usda"
    path.write_text(usd_kit.moving(STRANDS))
    found = moments(path)
    assert [one.seconds for one in found] == [1 / 30, 2 / 30, 3 / 30]
    for one, times, shift in zip(found, (1, 1.5, 2), (1, 2, 2), strict=True):
        np.testing.assert_allclose(one.points, times * POINTS + [shift, 2, 3], rtol=1e-6)
    assert read(path).points.tobytes() == found[0].points.tobytes()
    facts = read(path).source.facts
    assert (facts["times"], facts["begin"], facts["end"]) == (3, 1 / 30, 0.1)


def test_what_is_not_for_pictures_is_left_out_and_told() -> None:
    body = usd_kit.prim(STRANDS[:1], "a") + usd_kit.prim(STRANDS[1:2], "b", more='    token visibility = "invisible"\n')
    body += usd_kit.prim(STRANDS[2:], "c", more='    uniform token purpose = "guide"\n')
    body += 'def PointInstancer "e"\n{\n' + usd_kit.prim(STRANDS[:1], "f") + "}\n"
    body += 'def Xform "g" (\n    payload = @./missing.usd@\n)\n{\n}\n'
    found = read_text(usd_kit.HEAD + body)
    assert found.points.tobytes() == STRANDS[0].tobytes()
    facts = found.source.facts
    assert found.objects == ("/a",)
    assert facts["not_read"] == {"invisible": 1, "PointInstancer": 1, "of purpose guide": 1}
    assert facts["files_not_found"] == 1
    guides = read_text(usd_kit.HEAD + usd_kit.prim(STRANDS, more='    uniform token purpose = "guide"\n'))
    assert guides.source.facts["purpose"] == "guide"
    with pytest.raises(UsageError, match="has no curves that can be read; there are 1 PointInstancer"):
        read_text(usd_kit.HEAD + 'def PointInstancer "d"\n{\n}\n')


def test_instances_are_read_where_they_stand() -> None:
    held = 'class Xform "kept"\n{\n' + usd_kit.prim(STRANDS, "a") + "}\n"
    for name, shift in (("one", 1), ("two", 50)):
        held += f'def Xform "{name}" (\n    instanceable = true\n    references = </kept>\n)\n{{\n'
        held += f"    double3 xformOp:translate = ({shift}, 0, 0)\n"
        held += '    uniform token[] xformOpOrder = ["xformOp:translate"]\n}\n'
    found = read_text(usd_kit.HEAD + held)
    assert found.objects == ("/one/a", "/two/a")
    assert np.array_equal(found.points, np.concatenate([POINTS + np.array(x) for x in ([1, 0, 0], [50, 0, 0])]))


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (usd_kit.prim(STRANDS).replace("[4, 4, 4]", "[4, 4, 5]"), "12 points, the curves have 13"),
        (usd_kit.prim(STRANDS).replace("[4, 4, 4]", "[4, -4, 12]"), "curve 1 has -4 points"),
        (usd_kit.prim([POINTS[:5]], basis="bezier"), "5 points, which make no whole pieces of cubic bezier"),
        (usd_kit.prim(STRANDS, basis="power"), "basis power"),
        (usd_kit.prim(STRANDS).replace("(0, 1, 4)", "(0, nan, 4)"), "points: number 0 is not finite"),
        ('def Xform "a"\n{\n}\n', "has no curves"),
        ("def garbage", "damaged or no .usd file"),
    ],
)  # fmt: skip
def test_damage_is_told_in_a_line(content: str, words: str) -> None:
    kit.refused(usd_kit.HEAD + content, ".usda", words)


def test_what_usd_cannot_hold_is_told(tmp_path: Path) -> None:
    held = kit.of(STRANDS)
    held = Strands(held.first, held.points, {"frame": Attribute("strand", np.ones((3, 9), np.float32))})
    assert write(tmp_path / "a.usd", held) == [".usd cannot store frame: left out"]
    with pytest.raises(RefusedError, match="cannot be written"):
        write(tmp_path / "none" / "a.usd", held)
    samples = [TimeSample(0, held.points), TimeSample(1, held.points[:4])]
    with pytest.raises(UsageError, match="stay the same in number"):
        write(tmp_path / "b.usd", held, samples)
    assert [one.name for one in tmp_path.iterdir()] == ["a.usd"]


def test_a_worker_that_dies_is_begun_anew(tmp_path: Path) -> None:
    write(tmp_path / "a.usd", kit.of(STRANDS))
    assert len(process._idle) == 1
    process._idle[0].process.kill()
    process._idle[0].process.wait()
    assert read(tmp_path / "a.usd").count == 3


def test_without_the_library_it_is_said_how_to_get_it(tmp_path: Path) -> None:
    program = (
        "import sys, importlib.util; sys.path[:] = sys.argv[2].split(':'); find = importlib.util.find_spec\n"
        "importlib.util.find_spec = lambda name, *more: None if name == 'pxr' else find(name, *more)\n"
        "from pathlib import Path; from strandcli.errors import UsageError; from strandcli.exchange.files import read\n"
        "try: read(Path(sys.argv[1]))\n"
        "except UsageError as error: print(error)"
    )
    (tmp_path / "a.usda").write_text(usd_kit.text(STRANDS))
    command = [sys.executable, "-c", program, str(tmp_path / "a.usda"), ":".join(sys.path)]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    assert " install " in run.stdout
    assert run.stdout.endswith("'usd-core>=24.11'\n")


CURVES = """def BasisCurves "c" {
    int[] curveVertexCounts = [4]
    point3f[] points = [(0,0,0), (0,1,0), (0,2,0), (0,3,0)]
}"""
CLIPS = """def Xform "b" (
    clips = {
        dictionary default = {
            asset[] assetPaths = [@./pipe.usd@]
            string primPath = "/b"
            double2[] active = [(0, 0)]
            double2[] times = [(0, 0), (1, 1)]
        }
    }
) {
CURVES
}"""


@pytest.mark.parametrize(
    "text",
    [
        "(\n subLayers = [@./pipe.usd@]\n)\nCURVES", 'def "b" (\n references = @./pipe.usd@\n) {}\nCURVES',
        'def "b" (\n payload = @./other.usda@</b>\n) {}\nCURVES', CLIPS,
    ],
)  # fmt: skip
def test_a_pipe_that_a_stage_names_is_refused_at_once(
    text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(process, "SECONDS", 15.0)
    os.mkfifo(tmp_path / "pipe.usd")
    (tmp_path / "other.usda").write_text('#usda 1.0\ndef "b" (\n references = @./pipe.usd@\n) {}\n')
    (tmp_path / "a.usda").write_text("#usda 1.0\n" + text.replace("CURVES", CURVES))
    with pytest.raises(UsageError, match=r"names \./pipe.usd, which is no file but a pipe or a device"):
        read(tmp_path / "a.usda")


def test_what_has_one_moment_alone_is_read_at_that(tmp_path: Path) -> None:
    """Widths with times beside points without any, and a place of one time."""
    line = np.array([[0, 0, 0], [0, 1, 0], [0, 2, 0]])
    body = usd_kit.prim([line], more="    float[] widths.timeSamples = {\n 1: [.25],\n 3: [.5],\n }\n")
    place = "    double3 xformOp:translate.timeSamples = {\n 7: (1, 2, 3),\n }\n"
    place += '    uniform token[] xformOpOrder = ["xformOp:translate"]\n'
    path = tmp_path / "a.usda"
    path.write_text(usd_kit.HEAD + f'def Xform "world"\n{{\n{place}{body}}}\n')
    found = read(path)
    np.testing.assert_array_equal(found.points, line + np.array([1, 2, 3]))
    assert found.attributes["width"].values.tolist() == [0.25]


@pytest.mark.parametrize("place", ["its own", "that of what holds it"])
def test_visibility_that_changes_or_hides_is_told_wherever_it_is(place: str, tmp_path: Path) -> None:
    changes = '    token visibility.timeSamples = { 1: "inherited", 2: "invisible" }\n'
    hidden = '    token visibility = "invisible"\n'
    body = ""
    for name, words in (("shown", changes), ("hidden", hidden)):
        own, held = (words, "") if place == "its own" else ("", words)
        body += f'def Xform "{name}"\n{{\n{held}' + usd_kit.prim(STRANDS[:1], "a", more=own) + "}\n"
    path = tmp_path / "a.usda"
    path.write_text(usd_kit.HEAD + body)
    found = read(path)
    assert found.objects == ("/shown/a",)
    assert found.source.facts["not_read"] == {"invisible": 1}
    assert found.source.facts["changing"] == ["visibility"]
