"""Positions on disk: what was written is read, and nothing else is."""

from __future__ import annotations

import errno
import os
import zipfile
from pathlib import Path

import numpy as np
import pytest

from strandcli.errors import RefusedError, UsageError
from strandcli.output.positions import MANIFEST, PositionCache, PositionsWriter, positions_file

SHAPE = (5, 4, 3)


def positions(frame: int) -> np.ndarray:
    return np.random.default_rng(frame).normal(size=SHAPE).astype(np.float32)


@pytest.fixture
def cache(tmp_path: Path) -> Path:
    writer = PositionsWriter(tmp_path / "p", [1, 2, 4], 5, 4, overwrite=False, resume=False)
    for frame in (1, 2, 4):
        writer.write(frame, positions(frame))
    writer.write_manifest("hair", "abc", 24.0, "complete")
    return tmp_path / "p"


def test_missing_frames_are_named_before_anything_is_drawn(cache: Path) -> None:
    with pytest.raises(UsageError, match="no positions for frames 3, 5"):
        PositionCache(cache, [1, 3, 5], 5, 4)
    (cache / positions_file(2)).unlink()
    with pytest.raises(UsageError, match="no positions for frame 2"):
        PositionCache(cache, [1, 2], 5, 4)


@pytest.mark.parametrize(
    ("array", "words"),
    [
        (np.zeros((5, 3, 3), np.float32), r"shape \(5, 3, 3\), but the scene has 5 strands of 4 particles"),
        (np.zeros(SHAPE, np.float64), "float64, not float32; run 'strandcli simulate' again"),
        (np.zeros(SHAPE, object), "object, not float32"),
    ],
)
def test_wrong_shapes_and_types_are_refused_up_front(cache: Path, array: np.ndarray, words: str) -> None:
    np.savez(cache / positions_file(2), positions=array)
    with pytest.raises(UsageError, match=rf"positions_0002.npz: .*{words}"):
        PositionCache(cache, [1, 2], 5, 4)


@pytest.mark.parametrize("value", [np.nan, -np.inf])
def test_numbers_that_are_none_are_refused_with_the_strand(cache: Path, value: float) -> None:
    bad = positions(2)
    bad[3, 1, 2] = value
    np.savez(cache / positions_file(2), positions=bad)
    found = PositionCache(cache, [1, 2], 5, 4)
    np.testing.assert_array_equal(found(1), positions(1))
    with pytest.raises(UsageError, match=r"positions_0002.npz: positions of strand 3 are not finite; simulate"):
        found(2)


def test_a_header_of_another_program_is_refused_and_not_warned_of(cache: Path) -> None:
    with zipfile.ZipFile(cache / positions_file(2)) as archive:
        member = archive.read("positions.npy")
    assert b", 3), }" in member
    with zipfile.ZipFile(cache / positions_file(2), "w") as archive:
        archive.writestr("positions.npy", member.replace(b", 3), }", b", 3L),}"))
    with pytest.raises(UsageError, match=r"not a file of positions: .*Python 2.*[^.]; run"):
        PositionCache(cache, [2], 5, 4)


def test_a_cut_file_is_refused(cache: Path) -> None:
    path = cache / positions_file(1)
    data = bytearray(path.read_bytes())
    data[200] ^= 0xFF
    path.write_bytes(bytes(data))
    with pytest.raises(UsageError, match=r"positions_0001.npz: "):
        PositionCache(cache, [1], 5, 4)(1)


@pytest.mark.parametrize(
    "manifest",
    [None, "", "[]", "{}", "[" * 100_000, '{"frames": [1]}', '{"frames": [{"frame": 1, "file": "../x.npz"}]}'],
)
def test_a_folder_that_is_none_of_ours_is_refused(cache: Path, manifest: str | None) -> None:
    (cache / MANIFEST).unlink()
    if manifest is not None:
        (cache / MANIFEST).write_text(manifest)
    with pytest.raises(UsageError, match=r"manifest\.json"):
        PositionCache(cache, [1], 5, 4)


def test_a_disk_that_fills_up_keeps_what_was_finished(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*arguments: object, **more: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    writer = PositionsWriter(cache, [1, 2, 3], 5, 4, overwrite=False, resume=True)
    monkeypatch.setattr(np.lib.format, "write_array", fail)
    with pytest.raises(RefusedError, match=r"disk is full.*; 2 finished frames are whole, --resume skips them"):
        writer.write(3, np.zeros((5, 4, 3), np.float32))
