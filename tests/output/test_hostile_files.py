"""Files that are no files, are damaged or mean harm: one clear line, at once, and never a hang."""

from __future__ import annotations

import os
import struct
import subprocess
import sys
import tracemalloc
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from strandcli.draw.lighting import environment
from strandcli.errors import MismatchError, UsageError
from strandcli.files.picture_samples import FLAT, MOST_IN_A_BYTE, opened, require_pixels
from strandcli.output import png
from strandcli.output.compare import compare_files
from strandcli.output.files import read_json
from strandcli.output.layers import is_of
from strandcli.output.positions import PositionsWriter, read_positions
from strandcli.output.report import read_report


def test_a_pipe_or_a_device_as_report_is_none(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "report.json")
    assert read_report(tmp_path) is None
    (tmp_path / "report.json").unlink()
    (tmp_path / "report.json").symlink_to("/dev/zero")
    assert read_report(tmp_path) is None
    with pytest.raises(UsageError, match="pipe or a device"):
        read_json(tmp_path / "report.json")


def test_a_pipe_as_picture_is_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "frame_0001.png")
    assert png.keyword(tmp_path / "frame_0001.png", "scene") is None
    with pytest.raises(UsageError, match="not an image that can be read: it is no file"):
        png.load(tmp_path / "frame_0001.png")


def test_a_pipe_as_layer_or_positions_is_refused(tmp_path: Path) -> None:
    for name in ("depth_0001.npz", "positions_0001.npz", "frame_0001.exr"):
        os.mkfifo(tmp_path / name)
    assert not any(is_of(path, "scene") for path in tmp_path.iterdir())
    with pytest.raises(UsageError, match="is no file but a pipe"):
        read_positions(tmp_path / "positions_0001.npz", (2, 3, 3))
    writer = PositionsWriter(tmp_path, [1], 2, 3, overwrite=False, resume=True)
    writer.write(1, np.zeros((2, 3, 3), np.float32))
    writer.write_manifest("a", None, 24.0, "complete")
    assert writer.earlier == []
    assert read_positions(tmp_path / "positions_0001.npz", (2, 3, 3)).shape == (2, 3, 3)


def test_sizes_are_compared_before_pixels_are_decoded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    Image.new("RGB", (3, 2)).save(tmp_path / "a.png")
    Image.new("RGB", (2, 2)).save(tmp_path / "b.png")

    def never(path: Path) -> None:
        raise AssertionError("decoded")

    monkeypatch.setattr(png, "read_samples", never)
    with pytest.raises(MismatchError, match="sizes differ: 3x2 against 2x2"):
        compare_files(tmp_path / "a.png", tmp_path / "b.png")


@pytest.mark.parametrize("kind", ["longer than it is", "cut off", "wider than it can be", "a sky"])
def test_pictures_that_are_too_short_for_their_pixels_are_refused(kind: str, tmp_path: Path) -> None:
    path = tmp_path / ("a.hdr" if kind == "a sky" else "a.png")
    Image.new("RGB", (16, 16)).save(tmp_path / "a.png")
    data = bytearray((tmp_path / "a.png").read_bytes())
    if kind == "longer than it is":
        data[33:37] = struct.pack(">I", 2**31 - 100)
    elif kind == "cut off":
        del data[-15:]
    elif kind == "a sky":
        data = bytearray(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8192 +X 8192\n" + bytes(100))
    else:
        data[16:24] = struct.pack(">II", 8000, 8000)
        data[29:33] = struct.pack(">I", zlib.crc32(data[12:29]))
    path.write_bytes(data)
    tracemalloc.start()
    if kind != "a sky":
        with pytest.raises(UsageError, match="ends"):
            png.read(path)
    with pytest.raises(UsageError, match="ends"):
        environment.read(str(path))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 2_000_000


OPEN = """
import sys
from strandcli.files.picture_samples import opened
try:
    with opened(sys.argv[1]) as image:
        image.load()
except Exception:
    print("refused")
"""


def test_a_tiff_that_pillow_would_log_is_refused_in_silence(tmp_path: Path) -> None:
    path = tmp_path / "a.tif"
    Image.fromarray(np.zeros((2, 3, 3), np.uint8)).save(path)
    data = path.read_bytes()
    tag = struct.pack("<HHI", 277, 3, 1)  # samples a pixel
    assert data.count(tag) == 1
    path.write_bytes(data.replace(tag + b"\3\0", tag + b"\0\x08"))
    found = subprocess.run([sys.executable, "-c", OPEN, path], capture_output=True, text=True, check=True)
    assert (found.stdout, found.stderr) == ("refused\n", "")


@pytest.mark.parametrize("packing", ["raw", "tiff_lzw", "tiff_deflate", "packbits"])
def test_a_tiff_of_few_bytes_has_few_pixels(packing: str, tmp_path: Path) -> None:
    path = tmp_path / "a.tif"
    side = 4096 if packing == "raw" else 8
    Image.fromarray(np.zeros((8, side), np.uint8)).save(path, compression=packing)
    with opened(path) as image:
        assert require_pixels(image).size == (side, 8)
    data = path.read_bytes()
    for kind in (3, 4):  # width, short or long
        data = data.replace(struct.pack("<HHII", 256, kind, 1, side), struct.pack("<HHII", 256, 4, 1, 10**7))
    path.write_bytes(data)
    assert MOST_IN_A_BYTE[packing] * len(data) < 8 * 10**7
    with opened(path) as image, pytest.raises(ValueError, match="ends long before its 10000000 x 8 pixels"):
        require_pixels(image)


def test_a_webp_of_one_colour_may_be_small(tmp_path: Path) -> None:
    path, side = tmp_path / "a.webp", int(FLAT**0.5)
    Image.new("RGB", (side, side), "red").save(path, lossless=True)
    with opened(path) as image:
        assert require_pixels(image).width == side
    Image.new("RGB", (4000, 4000), "red").save(path, lossless=True, method=0)
    with opened(path) as image, pytest.raises(ValueError, match="ends long before"):
        require_pixels(image)


def test_fax_in_a_tiff_is_named(tmp_path: Path) -> None:
    path = tmp_path / "a.tif"
    Image.new("1", (8, 8)).save(path, compression="group4")
    with opened(path) as image, pytest.raises(ValueError, match="packed by group4 is not read; save it as PNG"):
        require_pixels(image)


def test_no_format_is_read_for_which_pillow_runs_programs(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    Image.new("RGB", (4, 4)).save(path, "EPS")
    with Image.open(path) as image:
        assert image.format == "EPS"
    with pytest.raises(ValueError, match="of a format that is not read"), opened(path):
        pass
