"""Frames from scenes: which, in which order, with what; the same bits whatever the number of threads."""

from __future__ import annotations

import dataclasses
import functools
from typing import Any

import numba
import numpy as np
import pytest

from strand_kit import frames_of, moved, need_frames_at_once, require_alike, scene_of
from strandcli.constants import W
from strandcli.groom import children
from strandcli.run.frame import Frame
from strandcli.run.panels import GAP, join
from strandcli.run.pipeline import ONE_BY_ONE, render
from strandcli.scene import Scene
from tests.run.test_pipeline_extremes import EVERYTHING, UNLIT

THREADS = int(numba.config.NUMBA_NUM_THREADS)


def changed(scene: Scene, **emitter: object) -> Scene:
    return dataclasses.replace(scene, emitter=dataclasses.replace(scene.emitter, **emitter))  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def everything() -> Scene:
    """A scene that uses every stage, high enough for several bands of rows, with strands wider than a pixel."""
    scene = scene_of(EVERYTHING + "detail: {near: 3}\n")
    scene = dataclasses.replace(
        scene,
        image=dataclasses.replace(scene.image, size=(200, 260)),
        material=dataclasses.replace(scene.material, width=0.03),
    )
    return changed(scene, strands=700)


@pytest.fixture(scope="module")
def frames(everything: Scene) -> list[Frame]:
    return frames_of(everything, 1, 4, threads=1)


def test_a_strand_does_not_depend_on_the_others(everything: Scene) -> None:
    many = moved(everything, 3, plain=False)
    for count in (1, W, W + 1, 300):
        np.testing.assert_array_equal(moved(changed(everything, strands=count), 3, plain=False), many[:count])


def test_portions_of_a_large_groom_give_the_same_picture(
    everything: Scene, frames: list[Frame], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("strandcli.draw.strand_batches.BATCH_VERTICES", 200)
    require_alike(frames, frames_of(everything, 1, 4))


def test_frames_come_once_and_in_order_and_nothing_depends_on_what_else_is_asked_for(everything: Scene) -> None:
    some = frames_of(everything, 3, 1, 3, 2)
    assert [frame.number for frame in some] == [1, 2, 3]
    require_alike([some[2]], frames_of(everything, 3))
    short = scene_of(UNLIT + "time: {frames: 4}\n")
    assert [frame.number for frame in render(short)] == [1, 2, 3, 4]
    assert list(render(short, [])) == []


@pytest.mark.skipif(THREADS < 2, reason="this machine has one core")
def test_what_children_follow_is_found_once_however_many_frames_are_drawn_at_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    need_frames_at_once()
    found: list[int] = []

    class Counted(children.Children):
        @functools.cached_property
        def family(self) -> Any:
            found.append(self.count)
            return super().family

    monkeypatch.setattr("strandcli.run.stages.Children", Counted)
    monkeypatch.setattr("strandcli.draw.renderer.Children", Counted)
    monkeypatch.setattr("strandcli.run.pipeline._frames_at_once", lambda *args: 2)
    scene = scene_of(UNLIT + "time: {frames: 6}\nchildren: {count: 3}\n")
    frames = list(render(scene, threads=2))
    assert [frame.number for frame in frames] == [1, 2, 3, 4, 5, 6]
    assert found == [60]


@pytest.mark.skipif(THREADS < 2, reason="this machine has one core")
def test_where_threads_cannot_run_kernels_at_once_frames_are_drawn_one_by_one_and_it_is_told_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("strandcli.run.pipeline._frames_at_once", lambda *args: 2)
    monkeypatch.setattr("strandcli.run.pipeline.ordered_map", lambda *args, **options: pytest.fail("several at once"))
    monkeypatch.setattr(numba, "threading_layer", lambda: "workqueue")
    told: list[str] = []
    scene = scene_of(UNLIT + "time: {frames: 5}\n")
    assert [frame.number for frame in render(scene, threads=2, notify=told.append)] == [1, 2, 3, 4, 5]
    assert [line for line in told if "libgomp1" in line] == [ONE_BY_ONE]
    told.clear()
    assert len(list(render(scene, [1, 2], threads=2, notify=told.append))) == 2
    assert ONE_BY_ONE not in told


def test_panels_stand_side_by_side() -> None:
    text = UNLIT + "panels: [{label: one}, {label: two, set: {image.size: [10, 30]}}, {set: {emitter.strands: 7}}]\n"
    (panels,) = frames_of(scene_of(text), 2)
    single = frames_of(scene_of(UNLIT), 2)[0]
    assert panels.positions is None
    width = 20 + GAP + 10 + GAP + 20
    assert panels.image.shape == (30 + 24, width, 3)
    np.testing.assert_array_equal(panels.image[:16, :20], single.image)
    assert panels.report["counts"]["strands"] == 20 + 20 + 7
    assert panels.report["seconds"]["raster"] > 0


def test_labels_stand_below_their_pictures_and_need_no_room_where_there_are_none() -> None:
    pictures = [np.full((40, 50, 3), level, np.uint8) for level in (90, 180)]
    plain = join(pictures, ["", ""])
    assert plain.shape == (40, 50 + GAP + 50, 3)
    assert (plain[:, :50] == 90).all()
    assert (plain[:, -50:] == 180).all()
    labelled = join(pictures, ["left", ""])
    assert labelled.shape == (64, 50 + GAP + 50, 3)
    strip = labelled[40:]
    assert (strip[:, :50].max(0) > 150).any()
    assert strip[:, -50:].max() < 60
