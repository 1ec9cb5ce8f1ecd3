"""Damaged pictures: nothing is told beside the line that refuses them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image

OPEN = """
import sys
from strandcli.picture_samples import opened
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
