"""Pictures that are damaged or mean harm: refused for their headers, in one line."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from strandcli.files.picture_samples import FLAT, MOST_IN_A_BYTE, opened, require_pixels

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
    tag = (277).to_bytes(2, "little") + (3).to_bytes(2, "little") + (1).to_bytes(4, "little")  # samples a pixel
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
    for kind, tell in (((3).to_bytes(2, "little"), 2), ((4).to_bytes(2, "little"), 4)):  # width, short or long
        tag = (256).to_bytes(2, "little") + kind + (1).to_bytes(4, "little")
        data = data.replace(
            tag + side.to_bytes(tell, "little") + bytes(4 - tell),
            (256).to_bytes(2, "little")
            + (4).to_bytes(2, "little")
            + (1).to_bytes(4, "little")
            + (10**7).to_bytes(4, "little"),
        )
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
