"""Animations: true times, and pictures that are still the pictures."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image, ImageSequence

from strandcli.errors import UsageError
from strandcli.output import png
from strandcli.output.animation import durations, write_animation
from strandcli.output.files import write_pieces


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
