"""The frame writer: whole files or none, on a thread, resumed without mixing two films; and report.json."""

from __future__ import annotations

import errno
import json
import os
import shutil
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from strandcli.cli.render_frames import interrupted
from strandcli.errors import RefusedError, UsageError
from strandcli.output import png
from strandcli.output import report as module
from strandcli.output.frames import FrameWriter, Written, frame_file
from strandcli.output.report import RunReport, finite, read_report, write_report

SIZE = (12, 8)


def picture(frame: int) -> np.ndarray:
    return np.random.default_rng(frame).integers(0, 256, (SIZE[1], SIZE[0], 3), dtype=np.uint8)


def write(directory: Path, numbers: list[int], **options: object) -> FrameWriter:
    with FrameWriter(directory, numbers, SIZE, **options) as writer:  # type: ignore[arg-type]
        for frame in writer.wanted:
            writer.submit(frame, picture(frame))
    return writer


def test_a_picture_may_be_reused_as_soon_as_it_is_handed_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    go = threading.Event()
    encode = png.encode

    def wait(*arguments: object) -> list[bytes]:
        go.wait(10)
        return encode(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(png, "encode", wait)
    image = picture(1)
    with FrameWriter(tmp_path, [1], SIZE) as writer:
        writer.submit(1, image)
        image[:] = 0
        go.set()
    np.testing.assert_array_equal(png.read(tmp_path / frame_file(1)), picture(1))


def test_existing_frames_are_named_and_kept_from_harm(tmp_path: Path) -> None:
    write(tmp_path, [1, 2, 3, 4, 5])
    before = (tmp_path / frame_file(2)).read_bytes()
    with pytest.raises(UsageError, match=r"frame_0002.png, frame_0003.png.* and 1 more; add --overwrite .* --resume"):
        FrameWriter(tmp_path, [2, 3, 4, 5, 6], SIZE)
    assert (tmp_path / frame_file(2)).read_bytes() == before
    assert FrameWriter(tmp_path, [6, 7], SIZE).wanted == (6, 7)
    assert FrameWriter(tmp_path, [2, 6], SIZE, overwrite=True).wanted == (2, 6)


def test_other_files_of_the_run_are_protected_too(tmp_path: Path) -> None:
    (tmp_path / "animation.gif").write_bytes(b"mine")
    with pytest.raises(UsageError, match=r"animation\.gif"):
        FrameWriter(tmp_path, [1], SIZE, also=["animation.gif"])
    assert FrameWriter(tmp_path, [1], SIZE, also=["animation.gif"], overwrite=True).wanted == (1,)


def test_resume_keeps_frames_of_more_pixels_than_pillow_opens(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path, [1, 2, 3], scene="one")
    Image.new("RGB", (50, 50)).save(tmp_path / frame_file(2))
    (tmp_path / frame_file(3)).write_bytes((tmp_path / frame_file(3)).read_bytes()[:-40])
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", SIZE[0] * SIZE[1] // 3)
    with pytest.raises(RefusedError):
        png.load(tmp_path / frame_file(1))
    writer = FrameWriter(tmp_path, [1, 2, 3], SIZE, resume=True, scene="one")
    assert writer.wanted == (2, 3)
    assert writer.written[1].pixels_sha256 == png.pixels_sha256(picture(1))
    assert png.keyword(tmp_path / frame_file(1), png.SCENE) == "one"


def test_a_disk_that_fails_after_other_frames_have_been_written_loses_that_one_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    replace = os.replace

    def refuse(source: object, target: object) -> None:
        if str(target).endswith("frame_0003.png"):
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        replace(source, target)  # type: ignore[arg-type]

    monkeypatch.setattr(os, "replace", refuse)
    words = r"frame_0003.png: [^;]*; choose another place; [0-9]+ finished frames are whole, --resume skips them$"
    with pytest.raises(RefusedError, match=words):
        write(tmp_path, list(range(1, 20)))
    there = sorted(os.listdir(tmp_path))
    assert there[:2] == [frame_file(1), frame_file(2)]
    assert frame_file(3) not in there
    assert not [name for name in there if name.startswith(".")]


def test_a_frame_is_finished_though_no_other_comes(tmp_path: Path) -> None:
    with FrameWriter(tmp_path, [1, 2], SIZE) as writer:
        writer.submit(1, picture(1))
        deadline = time.monotonic() + 10
        while not writer.written and time.monotonic() < deadline:
            time.sleep(0.01)
        assert (tmp_path / frame_file(1)).exists()


def test_frames_of_a_folder_that_is_gone_are_not_counted_as_whole(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    writer = FrameWriter(folder, [1, 2], SIZE)

    def lose() -> None:
        with writer:
            writer.submit(1, picture(1))
            while 1 not in writer.written:
                time.sleep(0.01)
            shutil.rmtree(folder)
            writer.submit(2, picture(2))

    with pytest.raises(RefusedError) as told:
        lose()
    assert "whole" not in str(told.value)
    assert interrupted(writer).endswith("interrupted; 0 finished frames stay, --resume continues")


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
