"""Curves of Alembic: archives written from the description alone are read, and what is written is taken apart again."""

from __future__ import annotations

import struct
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import abc_kit
import exchange_kit as kit
from abc_kit import FROM_BLENDER, Builder, Tree
from strandcli.errors import UsageError
from strandcli.exchange.files import read, write
from strandcli.exchange.strands import Attribute, Strands, TimeSample

STRANDS = [np.arange(12, dtype=np.float32).reshape(4, 3) + 100 * i for i in range(3)]
POINTS = np.concatenate(STRANDS)
COUNTS = [4, 4, 4]


moments = kit.moments
read_bytes = partial(kit.read_bytes, suffix=".abc")


def test_what_is_written_has_the_layout_of_alembic(tmp_path: Path) -> None:
    path = tmp_path / "a.abc"
    held = kit.of(STRANDS)
    held = Strands(held.first, held.points, kit.attributes(3, 12))
    write(path, held, [TimeSample(i / 25, held.points + np.float32(i)) for i in range(3)])
    tree = Tree(path.read_bytes())
    assert tree.objects == {"/strands": abc_kit.XFORM, "/strands/strandsShape": abc_kit.CURVES}
    assert tree.metadata == "_ai_Application=strandcli;_ai_DCC_FPS=25"
    assert tree.samplings == struct.pack("<IdId", 0, 1.0, 1, 0.0) + struct.pack("<IdId", 3, 1 / 25, 1, 0.0)
    geom = "/strands/strandsShape/.geom"
    told = {path.removeprefix(geom): one for path, one in tree.properties.items()}
    assert told[""].metadata == "schema=AbcGeom_Curve_v2;schemaBaseType=AbcGeom_GeomBase_v1"
    # kind 2, array; type 10, float32_t; bit 8 a time sampling; bit 10 one size; three numbers an element
    assert told["/P"].info & 0xFFFFF == 2 | 10 << 4 | 1 << 8 | 1 << 10 | 3 << 12
    assert told["/P"].metadata == "geoScope=vtx;interpretation=point"
    assert told["/P"].stored == [(held.points + np.float32(i)).tobytes() for i in range(3)]
    # type 6, int32_t; bit 11, the same at all times
    assert told["/nVertices"].info & 0xFFFFF == 2 | 6 << 4 | 1 << 8 | 1 << 10 | 1 << 11 | 1 << 12
    assert told["/nVertices"].stored == [np.array(COUNTS, "<i4").tobytes()]
    assert told["/nVertices"].samples == 3
    # kind 1, a scalar; type 1, uint8_t: linear, not periodic, no basis
    assert told["/curveBasisAndType"].info & 0xFFFFF == 1 | 1 << 4 | 1 << 8 | 1 << 10 | 1 << 11 | 4 << 12
    assert told["/curveBasisAndType"].stored == [bytes([1, 0, 0, 0])]
    assert told["/.selfBnds"].metadata == "interpretation=box"
    boxes = [struct.unpack("<6d", one) for one in told["/.selfBnds"].stored]
    assert boxes == [(i, 1.0 + i, 2.0 + i, 209.0 + i, 210.0 + i, 211.0 + i) for i in range(3)]
    parameter = "arrayExtent=1;geoScope={};interpretation={};isGeomParam=true;podExtent={};podName={}"
    assert told["/width"].metadata == parameter.format("vtx", "", 1, "float32_t")
    assert told["/uv"].metadata == parameter.format("uni", "vector", 2, "float32_t")
    assert told["/N"].metadata == parameter.format("vtx", "normal", 3, "float32_t")
    assert told["/.arbGeomParams/groom_root_uv"].metadata == parameter.format("uni", "vector", 2, "float32_t")
    assert told["/.arbGeomParams/number"].metadata == parameter.format("uni", "", 1, "int64_t")
    assert told["/.arbGeomParams/transparency"].metadata == parameter.format("con", "", 1, "float32_t")


def test_times_that_are_not_even_are_told_each(tmp_path: Path) -> None:
    path = tmp_path / "a.abc"
    held = kit.of(STRANDS)
    times = [0.25, 0.5, 1.5]
    write(path, held, [TimeSample(time, held.points * np.float32(time)) for time in times])
    assert [one.seconds for one in moments(path)] == times
    assert Tree(path.read_bytes()).samplings[24:] == struct.pack("<IdI3d", 3, np.finfo(float).max / 32, 3, *times)


def test_what_stands_still_is_stored_once(tmp_path: Path) -> None:
    held = kit.of(STRANDS)
    write(tmp_path / "a.abc", held, [TimeSample(i / 24, held.points) for i in range(9)])
    tree = Tree((tmp_path / "a.abc").read_bytes())
    told = tree.properties["/strands/strandsShape/.geom/P"]
    assert (told.samples, len(told.stored)) == (9, 1)
    assert told.info & 1 << 11
    back = [held.points, held.points + np.float32(1), held.points]
    write(tmp_path / "b.abc", held, [TimeSample(i / 24, one) for i, one in enumerate(back)])
    assert [one.points.tobytes() for one in moments(tmp_path / "b.abc")] == [one.tobytes() for one in back]
    assert (tmp_path / "b.abc").read_bytes().count(held.points.tobytes()) == 1


def test_widths_of_strands_become_those_of_their_points(tmp_path: Path) -> None:
    """Blender takes no others."""
    held = kit.of([STRANDS[0], STRANDS[1][:2]])
    widths = {"width": Attribute("strand", np.array([0.5, 0.25], np.float32))}
    write(tmp_path / "a.abc", Strands(held.first, held.points, widths))
    found = read(tmp_path / "a.abc").attributes["width"]
    assert (found.domain, found.values.tolist()) == ("point", [0.5] * 4 + [0.25] * 2)


def test_times_that_do_not_rise_and_other_strands_are_refused(tmp_path: Path) -> None:
    held = kit.of(STRANDS)
    for samples, message in (
        ([TimeSample(1.0, held.points), TimeSample(1.0, held.points)], "times must rise"),
        ([TimeSample(1.0, held.points[1:])], "11 points at 1 s, the strands have 12"),
        ([], "no moment"),
    ):
        with pytest.raises(UsageError, match=message):
            write(tmp_path / "a.abc", held, samples)
    assert not list(tmp_path.iterdir())


def test_samples_that_repeat_are_not_stored(tmp_path: Path) -> None:
    """Of eight samples only the third to the fifth are stored beside the first."""
    made = Builder()
    stored = [POINTS + np.float32(i) for i in range(4)]
    points = made.array("P", *stored, changes=(3, 5), count=8)
    told = [points, made.array("nVertices", np.array(COUNTS, "<i4"))]
    (tmp_path / "a.abc").write_bytes(made.finish(made.object("c", abc_kit.CURVES, [made.compound(".geom", told)])))
    found = moments(tmp_path / "a.abc")
    assert [one.seconds for one in found] == [0.0, 3.0, 4.0, 5.0]
    assert [one.points.tolist() for one in found] == [one.tolist() for one in stored]


def test_objects_of_curves_follow_one_another() -> None:
    made = Builder()
    ones = np.ones(12, "<f4")
    first = [made.array("width", ones, meta="geoScope=vtx"), made.array("uv", np.ones((3, 2), "<f4"))]
    second = [made.array("width", ones[:1] * 2), made.array("N", np.ones((1, 3), "<f4"))]
    content = made.finish(
        made.object("mesh", "schema=AbcGeom_PolyMesh_v1"), made.curves("a", POINTS, COUNTS, first),
        made.curves("b", POINTS[:5].astype("<f8"), [2, 1, 2], second),
    )  # fmt: skip
    found = read_bytes(content)
    assert found.counts().tolist() == [4, 4, 4, 2, 2]
    assert found.points.tolist() == np.concatenate([POINTS, POINTS[:2], POINTS[3:5]]).tolist()
    assert {name: one.domain for name, one in found.attributes.items()} == {"width": "point", "object": "strand"}
    assert found.attributes["width"].values.tolist() == [1.0] * 12 + [2.0] * 4
    assert found.objects == ("/a", "/b")
    assert found.attributes["object"].values.tolist() == [0, 0, 0, 1, 1]
    assert found.source.facts["attributes_not_read"] == ["normal", "uv"]
    assert found.source.skipped == {"fewer than two points": 1}
    assert found.source.version == "1.7.9"


def test_attributes_by_index_and_of_many_types() -> None:
    made = Builder()
    values, indices = np.array([[1, 2], [3, 4]], "<f4"), np.array([1, 0, 1], "<u4")
    indexed = [made.array(".vals", values), made.array(".indices", indices)]
    added = [
        made.array("half", np.arange(12).astype("<f2"), meta="geoScope=var", width=2),
        made.array("yes", np.array([True, False, True]), meta="geoScope=uni"),
        made.array("none", np.zeros(7, "<f4")), made.array("long" * 90, np.arange(3, dtype="<i8"), width=1),
    ]  # fmt: skip
    more = [made.compound("uv", indexed, "geoScope=uni"), made.compound(".arbGeomParams", added)]
    found = read_bytes(made.finish(made.curves("a", POINTS, COUNTS, more)))
    assert found.attributes["uv"].values.tolist() == [[3, 4], [1, 2], [3, 4]]
    assert found.attributes["uv"].domain == found.attributes["yes"].domain == "strand"
    assert found.attributes["half"].values.dtype == np.float32
    assert found.attributes["half"].values.tolist() == list(range(12))
    assert found.attributes["yes"].values.tolist() == [1, 0, 1]
    assert found.attributes["long" * 90].values.tolist() == [0, 1, 2]
    assert found.source.facts["attributes_not_read"] == ["none"]


def test_what_blender_writes_is_read() -> None:
    """Made by `test_blender.export`, whose points are told there; Blender's z axis is up, the archive's y."""
    found = read(FROM_BLENDER)
    place = np.arange(12, dtype=np.float32)
    points = np.stack([place, place**2 / 8, 1 / (place + 1)], axis=1)
    there = np.concatenate([points, 2 * points[:4] + np.float32([1, 2, 3])])
    order = abc_kit.rows_from_blender(found.counts())
    np.testing.assert_allclose(found.points[order], there[:, [0, 2, 1]] * [1, 1, -1], rtol=2e-7, atol=2e-7)
    assert sorted(found.objects) == ["/a/a", "/b/b"]
    assert found.source.facts["application"] == "Blender"
    widths = np.concatenate([(place + 1) / 8, (place[:4] + 1) / 4])
    np.testing.assert_allclose(found.attributes["width"].values[order], widths, rtol=2e-7)
    seen = moments(FROM_BLENDER)
    np.testing.assert_allclose([one.seconds for one in seen], [1 / 24, 2 / 24, 3 / 24], rtol=1e-6)
    end = np.concatenate([points, 2 * points[:4] + np.float32([5, 2, 3])])
    np.testing.assert_allclose(seen[-1].points[order], end[:, [0, 2, 1]] * [1, 1, -1], rtol=2e-7, atol=1e-6)
