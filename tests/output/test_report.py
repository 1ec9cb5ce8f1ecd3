"""report.json: the keys of the design page, and nothing made up."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from strandcli.output import report as module
from strandcli.output.frames import Written
from strandcli.output.report import RunReport, finite, read_report, write_report

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
    empty = RunReport("hair", None, None).as_dict("failed", {}, None, None)
    assert (empty["plan"], empty["machine"], empty["frames"]) == (None, None, [])


def test_it_is_written_whole_and_read_again(tmp_path: Path) -> None:
    assert read_report(tmp_path) is None
    write_report(tmp_path, {"schema_version": 1, "frames": []})
    assert read_report(tmp_path) == {"schema_version": 1, "frames": []}
    foreign = ('{"schema_version": 1, "frames": [{"frame": 1, "file": "../frame_0001.png"}]}', '{"frames": []}')
    for text in (*foreign, '{"schema_version": 1, "frames": 3}', '{"frames"', "[]", "[" * 100_000):
        (tmp_path / module.FILE).write_text(text)
        assert read_report(tmp_path) is None
