"""Blender opens what is written here, with the same points, and what it writes is read: `make check-against-blender`.

Blender's z axis is up and Alembic's y: Blender turns points as it reads and writes, which is exact. Its radius is half
of the width.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("bpy", reason="Blender is not installed: make check-against-blender")

import bpy

import exchange_kit as kit
from strandcli.exchange.files import read, write
from strandcli.exchange.strands import Attribute, Strands, TimeSample


def empty() -> None:
    """Begin a scene of nothing, of 24 frames a second."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = 24


def curves_in_scene() -> Any:
    """The one object of curves, as it is at the frame that is set."""
    there = [one for one in bpy.data.objects if one.type == "CURVES"]
    assert len(there) == 1
    assert np.array_equal(np.array(there[0].matrix_world), np.eye(4))
    return there[0].evaluated_get(bpy.context.evaluated_depsgraph_get()).data


def values(data: Any, attribute: str, field: str, width: int) -> Any:
    """An attribute of points (P, width)."""
    told = data.attributes[attribute].data
    found = np.empty(len(told) * width, np.float32)
    told.foreach_get(field, found)
    return found.reshape(-1, width)


def points_of(data: Any) -> Any:
    """Points (P, 3), their y axis up."""
    found = values(data, "position", "vector", 3)
    return np.stack([found[:, 0], found[:, 2], -found[:, 1]], axis=1)


def strands() -> Strands:
    """Strands of other lengths, with a width and more."""
    generator = np.random.default_rng(4)
    found = kit.of([generator.normal(size=(count, 3)).astype(np.float32) for count in (2, 9, 3, 30)])
    width = generator.random(found.points.shape[0], np.float32)
    more = {"width": Attribute("point", width), "root_uv": Attribute("strand", generator.random((4, 2), np.float32))}
    return Strands(found.first, found.points, more)


def test_blender_plays_the_same_points(tmp_path: Path) -> None:
    held = strands()
    told = [TimeSample(frame / 24, held.points * np.float32(frame)) for frame in range(3, 9)]
    write(tmp_path / "a.abc", held, told)
    empty()
    bpy.ops.wm.alembic_import(filepath=str(tmp_path / "a.abc"), as_background_job=False, set_frame_range=True)
    assert (bpy.context.scene.frame_start, bpy.context.scene.frame_end) == (3, 8)
    for frame in range(3, 9):
        bpy.context.scene.frame_set(frame)
        assert np.array_equal(points_of(curves_in_scene()), told[frame - 3].points)
    data = curves_in_scene()
    assert [len(one.points) for one in data.curves] == held.counts().tolist()
    assert np.array_equal(values(data, "radius", "value", 1)[:, 0], held.attributes["width"].values / 2)


def usd_import(path: Path) -> Any:
    """The one object of curves of a stage."""
    empty()
    bpy.ops.wm.usd_import(filepath=str(path), apply_unit_conversion_scale=False)
    there = [one for one in bpy.data.objects if one.type == "CURVES"]
    assert len(there) == 1
    return there[0]


def usd_points(held: Any) -> Any:
    """Points (P, 3) of an object at the frame that is set, their y axis up; Blender turns by the object."""
    data = held.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    turn = np.array(held.matrix_world)
    assert np.array_equal(np.round(turn), [[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
    return values(data, "position", "vector", 3)


def test_blender_plays_the_same_points_of_usd(tmp_path: Path) -> None:
    held = strands()
    told = [TimeSample(frame / 24, held.points * np.float32(frame)) for frame in range(3, 9)]
    write(tmp_path / "a.usd", held, told)
    found = usd_import(tmp_path / "a.usd")
    assert [len(one.points) for one in found.data.curves] == held.counts().tolist()
    assert np.array_equal(values(found.data, "radius", "value", 1)[:, 0], held.attributes["width"].values / 2)
    for frame in range(3, 9):
        bpy.context.scene.frame_set(frame)
        assert np.array_equal(usd_points(found), told[frame - 3].points)


def test_what_blender_writes_as_usd_is_read(tmp_path: Path) -> None:
    export(tmp_path / "a.abc")
    bpy.ops.wm.usd_export(filepath=str(tmp_path / "a.usdc"), export_animation=True)
    found = read(tmp_path / "a.usdc")  # Blender's curves are Catmull-Rom splines through their points
    assert (found.source.up, found.source.facts["times"]) == ("z", 3)
    each = max(found.source.facts["points_a_piece"])
    counts = found.counts().tolist()
    assert sorted(counts) == sorted((n - 1) * each + 1 if n > 2 else 2 for n in (3, 4, 5, 2, 2))
    begin = found.first[counts.index(2 * each + 1)]
    place = np.arange(3, dtype=np.float32)
    want = np.stack([place, place**2 / 8, 1 / (place + 1)], axis=1)
    assert np.array_equal(found.points[begin : begin + 2 * each + 1 : each], want)


def export(path: Path) -> None:
    """Write two objects of curves, of which one is scaled and moves; `from_blender.abc` was made by it."""
    empty()
    place = np.arange(12, dtype=np.float32)
    points = np.stack([place, place**2 / 8, 1 / (place + 1)], axis=1)
    for name, counts in (("a", [3, 4, 5]), ("b", [2, 2])):
        data = bpy.data.hair_curves.new(name)
        data.add_curves(counts)
        data.attributes["position"].data.foreach_set("vector", points[: sum(counts)].reshape(-1))
        radius = data.attributes.get("radius") or data.attributes.new("radius", "FLOAT", "POINT")
        radius.data.foreach_set("value", (place[: sum(counts)] + 1) / 16)
        bpy.context.scene.collection.objects.link(bpy.data.objects.new(name, data))
    moving = bpy.data.objects["b"]
    moving.scale = (2, 2, 2)
    for frame, x in ((1, 1.0), (3, 5.0)):
        moving.location = (x, 2, 3)
        moving.keyframe_insert("location", frame=frame)
    bpy.context.scene.frame_set(1)
    bpy.ops.wm.alembic_export(filepath=str(path), start=1, end=3, as_background_job=False)
