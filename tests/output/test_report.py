"""report.json: the keys of the design page, and nothing made up."""

from __future__ import annotations

import dataclasses
import json
import os
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from strandcli.output import report as module
from strandcli.output.frames import Written
from strandcli.output.report import RunReport, finite, read_report, write_report
from strandcli.run.fingerprint import fingerprint
from strandcli.scene.model import Emitter, GroomFile, Image, Scene, Time

PLAN = SimpleNamespace(
    used=[SimpleNamespace(stage="raster", why="draws")], left_out=[SimpleNamespace(stage="shadow", why="no light")]
)
FRAME = {
    "seconds": {"simulate": 0.25, "curves": None, "raster": 0.5, "total": 99.0},
    "counts": {"strands": np.int64(3)},
    "error": {"stretch_max": np.float32(0.5), "penetration_max": None, "curve_px_max": float("nan")},
}


def test_the_keys_are_those_of_the_design_page() -> None:
    run = RunReport("hair", "abc", PLAN)
    run.add(2, FRAME)
    done = {2: Written(2, "frame_0002.png", "f00", 0.125)}
    data = finite(run.as_dict("complete", done, {"cpu": "x"}, 1.5))
    assert data["schema_version"] == 1
    assert data["status"] == "complete"
    assert data["preset"] == {"name": "hair", "sha256": "abc"}
    assert data["plan"] == {
        "used": [{"stage": "raster", "why": "draws"}],
        "left_out": [{"stage": "shadow", "why": "no light"}],
    }
    assert data["machine"] == {"cpu": "x"}
    assert data["compile_seconds"] == 1.5
    assert data["frames"] == [
        {
            "frame": 2,
            "file": "frame_0002.png",
            "pixels_sha256": "f00",
            "seconds": {"simulate": 0.25, "curves": None, "raster": 0.5, "write": 0.125, "total": 0.875},
            "counts": {"strands": 3},
            "error": {"stretch_max": 0.5, "penetration_max": None, "curve_px_max": None},
        }
    ]
    assert set(data["totals"]) == {"seconds", "frames_per_second", "peak_rss_bytes"}
    assert data["totals"]["peak_rss_bytes"] > 10_000_000
    json.dumps(data, allow_nan=False)


def test_what_was_not_finished_is_not_reported() -> None:
    run = RunReport("hair", None, None)
    run.add(1, FRAME)
    run.add(2, FRAME)
    data = run.as_dict("interrupted", {1: Written(1, "frame_0001.png", "a", 0.1)}, None, None)
    assert [entry["frame"] for entry in data["frames"]] == [1]
    empty = RunReport("hair", None, None).as_dict("failed", {}, None, None)
    assert empty["frames"] == []
    assert empty["totals"]["frames_per_second"] is None
    assert empty["machine"] is None
    assert empty["plan"] is None
    assert empty["compile_seconds"] is None


def test_a_resumed_run_takes_over_what_is_known_of_the_frames_it_kept() -> None:
    previous = {
        "frames": [{"frame": 1, "pixels_sha256": "a", "seconds": {"total": 9}}, {"frame": 2, "pixels_sha256": "b"}]
    }
    written = {1: Written(1, "frame_0001.png", "a", None), 2: Written(2, "frame_0002.png", "other", None)}
    entries = RunReport("hair", None, None).as_dict("complete", written, None, None, previous)["frames"]
    assert entries[0] == {"frame": 1, "pixels_sha256": "a", "seconds": {"total": 9}, "kept": True}
    assert entries[1] == {"frame": 2, "file": "frame_0002.png", "pixels_sha256": "other", "kept": True}


def test_it_is_written_whole_and_read_again(tmp_path: Path) -> None:
    assert read_report(tmp_path) is None
    write_report(tmp_path, {"frames": []})
    assert read_report(tmp_path) == {"frames": []}
    (tmp_path / module.FILE).write_text('{"frames": 3}')
    assert read_report(tmp_path) is None
    for text in ('{"frames"', "[" * 100_000):
        (tmp_path / module.FILE).write_text(text)
        assert read_report(tmp_path) is None


SCENE = Scene(emitter=Emitter(strands=5), image=Image(size=(4, 4)))


@pytest.mark.parametrize(
    "changed",
    [
        dataclasses.replace(SCENE, seed=1),
        dataclasses.replace(SCENE, time=Time(fps=25.0)),
    ],
)
def test_whatever_changes_pixels_changes_the_fingerprint(changed: Scene) -> None:
    assert fingerprint(changed) != fingerprint(SCENE)


def test_what_changes_no_pixel_does_not() -> None:
    same = dataclasses.replace(SCENE, source="/elsewhere", sha256="x", title="y", time=Time(frames=99))
    assert fingerprint(same) == fingerprint(SCENE)
    assert fingerprint(SCENE, "cache") != fingerprint(SCENE)


def test_a_file_that_changed_changes_the_fingerprint(tmp_path: Path) -> None:
    path = tmp_path / "a.data"

    def found() -> str:
        groom = replace(SCENE.emitter, groom=GroomFile(str(path)))
        return fingerprint(replace(SCENE, emitter=groom))

    none = found()
    path.write_bytes(b"one")
    one = found()
    os.utime(path, ns=(0, 0))
    assert found() == one != none
    path.write_bytes(b"two")
    assert found() != one
