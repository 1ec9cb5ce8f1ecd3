"""Contact sheets have every image in its place, labelled; animations have true times and true pictures."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image, ImageSequence

from strandcli.errors import RefusedError, UsageError
from strandcli.output import png
from strandcli.output import sheet as module
from strandcli.output.animation import durations, write_animation
from strandcli.output.files import write_pieces
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


@given(st.floats(0.5, 400), st.lists(st.integers(1, 30), min_size=0, max_size=40))
def test_no_frame_is_ever_further_from_its_time_than_rounding(fps: float, gaps: list[int]) -> None:
    frames = [1]
    for gap in gaps:
        frames.append(frames[-1] + gap)
    shown = durations(frames, fps, 1, 0)
    ends = np.cumsum(shown)
    true = [1000 * (frame - 1) / fps for frame in frames[1:]] + [1000 * frames[-1] / fps]
    assert np.abs(ends - true).max() <= 0.5 + 1e-6


@pytest.fixture
def pictures(tmp_path: Path) -> list[Path]:
    """A gradient that changes a little from frame to frame in one half, and stays in the other."""
    y, x = np.mgrid[0:40, 0:64]
    paths = []
    for number in range(1, 6):
        image = np.stack([x * 3, 40 + y * 2, np.where(x < 32, 60, 30 * number)], axis=2).astype(np.uint8)
        paths.append(tmp_path / f"frame_{number:04d}.png")
        write_pieces(paths[-1], png.encode(image))
    return paths


@pytest.mark.parametrize(("suffix", "worst_rmse"), [("gif", 8.0), ("webp", 8.0)])
def test_the_film_shows_the_frames_in_order_and_loops(
    tmp_path: Path, pictures: list[Path], suffix: str, worst_rmse: float
) -> None:
    path = tmp_path / f"animation.{suffix}"
    rate = write_animation(path, pictures, range(1, 6), 10.0)
    assert rate == pytest.approx(10.0)
    with Image.open(path) as film:
        assert film.info.get("loop") == 0
        shown = [np.asarray(one.convert("RGB")).astype(float) for one in ImageSequence.Iterator(film)]
    assert len(shown) == 5
    for image, source in zip(shown, pictures, strict=True):
        assert np.sqrt(np.mean((image - png.read(source)) ** 2)) < worst_rmse


def test_still_areas_of_a_gif_stay_still(tmp_path: Path, pictures: list[Path]) -> None:
    write_animation(tmp_path / "animation.gif", pictures, range(1, 6), 24.0)
    with Image.open(tmp_path / "animation.gif") as film:
        halves = [np.asarray(one.convert("RGB"))[:, :32] for one in ImageSequence.Iterator(film)]
    for half in halves[1:]:
        np.testing.assert_array_equal(half, halves[0])


def test_the_times_in_the_file_are_the_planned_ones(tmp_path: Path, pictures: list[Path]) -> None:
    write_animation(tmp_path / "animation.gif", pictures, [1, 2, 3, 10, 11], 24.0)
    with Image.open(tmp_path / "animation.gif") as film:
        shown = [one.info["duration"] for one in ImageSequence.Iterator(film)]
    assert shown == durations([1, 2, 3, 10, 11], 24.0, 10, 2)
    assert shown[2] in (290, 300)


def test_a_rate_that_gif_cannot_show_is_told(tmp_path: Path, pictures: list[Path]) -> None:
    assert write_animation(tmp_path / "animation.gif", pictures, range(1, 6), 120.0) == pytest.approx(50.0)
    assert write_animation(tmp_path / "animation.webp", pictures, range(1, 6), 120.0) == pytest.approx(120, rel=0.03)


def test_a_single_frame_is_a_film_too(tmp_path: Path, pictures: list[Path]) -> None:
    for suffix in ("gif", "webp"):
        write_animation(tmp_path / f"animation.{suffix}", pictures[:1], [7], 24.0)
        with Image.open(tmp_path / f"animation.{suffix}") as film:
            assert film.size == (64, 40)


def test_a_missing_frame_leaves_no_half_film(tmp_path: Path, pictures: list[Path]) -> None:
    pictures[3].unlink()
    with pytest.raises(UsageError, match=r"frame_0004.png: no such image"):
        write_animation(tmp_path / "animation.webp", pictures, range(1, 6), 24.0)
    assert not [name for name in os.listdir(tmp_path) if "animation" in name]
