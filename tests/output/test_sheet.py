"""Contact sheets: every image is there, in its place, unscaled or scaled down, and labelled."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from strandcli.errors import RefusedError, UsageError
from strandcli.output import sheet as module
from strandcli.output.sheet import GAP, PAPER, gather, make_sheet, write_sheet

COLOURS = [(200, 30, 40), (20, 180, 60), (50, 60, 220), (210, 200, 30), (190, 40, 190)]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "in").mkdir()
    for number, colour in enumerate(COLOURS):
        Image.new("RGB", (60, 40), colour).save(tmp_path / "in" / f"{'abcde'[number]}.png")
    return tmp_path / "in"


def test_images_stand_in_order_row_by_row(folder: Path) -> None:
    sheet = make_sheet(gather([folder]), 3, 400)
    assert sheet.shape[1] == GAP + 3 * (60 + GAP)
    for number, colour in enumerate(COLOURS):
        left = GAP + (number % 3) * (60 + GAP)
        tops = np.flatnonzero((sheet[:, left + 5] == colour).all(axis=1))
        assert len(tops) == 40
        np.testing.assert_array_equal(sheet[tops[0] : tops[0] + 40, left : left + 60], np.full((40, 60, 3), colour))
    under = sheet[GAP + 40 : GAP + 60, GAP : GAP + 60]
    assert (under != PAPER).any(), "the label"


def test_wide_images_are_scaled_down_and_small_ones_left(folder: Path) -> None:
    Image.new("RGB", (600, 300), (9, 200, 9)).save(folder / "f.png")
    sheet = make_sheet(gather([folder]), 6, 100)
    assert sheet.shape[1] == GAP + 6 * (100 + GAP)
    assert int((sheet == (9, 200, 9)).all(axis=2).sum()) == 100 * 50
    assert int((sheet == COLOURS[0]).all(axis=2).sum()) == 60 * 40


def test_a_folder_of_folders_gives_the_last_frame_of_each(tmp_path: Path) -> None:
    for name in ("fig02", "fig03"):
        (tmp_path / name).mkdir()
        for number in (1, 2):
            Image.new("RGB", (4, 4)).save(tmp_path / name / f"frame_000{number}.png")
        Image.new("RGB", (4, 4)).save(tmp_path / name / "animation.gif")
    assert [cell.path.parent.name for cell in gather([tmp_path / "fig03", tmp_path / "fig02"])] == ["fig03", "fig02"]
    assert [cell.label for cell in gather([tmp_path / "fig03"])] == ["frame_0001", "frame_0002"]
    cells = gather([tmp_path, tmp_path / "fig02" / "frame_0001.png"])
    assert [(cell.path.parent.name, cell.path.name, cell.label) for cell in cells] == [
        ("fig02", "frame_0002.png", "fig02"),
        ("fig03", "frame_0002.png", "fig03"),
        ("fig02", "frame_0001.png", "frame_0001"),
    ]


def test_the_sheet_does_not_take_itself_in(folder: Path) -> None:
    output = folder / "sheet.png"
    first = write_sheet(output, gather([folder], leave_out=output), 2, 400)
    assert write_sheet(output, gather([folder], leave_out=output), 2, 400) == first


def test_sources_without_images_are_named(tmp_path: Path, folder: Path) -> None:
    (tmp_path / "empty").mkdir()
    with pytest.raises(UsageError, match="empty: has no images"):
        gather([folder, tmp_path / "empty"])
    with pytest.raises(UsageError, match="lost: no such file or folder"):
        gather([tmp_path / "lost"])
    (folder / "a.png").write_bytes(b"no image")
    with pytest.raises(UsageError, match=r"a\.png: not an image"):
        make_sheet(gather([folder]), 2, 100)


def test_a_sheet_too_big_is_refused(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "LARGEST", 300)
    with pytest.raises(RefusedError, match="too big"):
        make_sheet(gather([folder]), 5, 400)


def test_files_are_labelled_by_name_and_by_folder_where_two_have_one(tmp_path: Path) -> None:
    names = ("a/frame_0001.png", "b/frame_0001.png", "b/frame_0002.png", "c/x.png", "d/frame_0001.png")
    for name in names:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    cells = gather([*(tmp_path / name for name in names[:4]), tmp_path / "d"])
    assert [cell.label for cell in cells] == ["a/frame_0001", "b/frame_0001", "frame_0002", "x", "d"]
    assert [cell.label for cell in gather([tmp_path / name for name in names[1:3]])] == ["frame_0001", "frame_0002"]
