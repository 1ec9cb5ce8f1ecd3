"""Pictures that `fuzz` damages: of every format that textures, skies or `compare` read."""

from __future__ import annotations

import contextlib
import io
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from fuzz_presets import GOOD, command
from strandcli.draw.lighting import environment
from strandcli.errors import StrandError
from strandcli.mesh_file import maps

OTHERS = ("TIFF", "GIF", "BMP", "TGA", "PPM", "WEBP", "ICO", "PCX")


@cache
def pictures() -> dict[str, list[bytes]]:
    """Whole pictures by the end of their names."""
    generator = np.random.default_rng(3)
    colour = Image.fromarray(generator.integers(0, 255, (8, 16, 3), np.uint8))
    grey = Image.fromarray(generator.integers(0, 65535, (8, 16), np.uint16))

    def saved(image: Image.Image, kind: str, **more: Any) -> bytes:
        file = io.BytesIO()
        image.save(file, kind, **more)
        return file.getvalue()

    rows = generator.integers(0, 255, (8, 16, 4), np.uint8)
    head = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n"
    packed = b"".join(bytes([2, 2, 0, 16]) + b"".join(b"\x10" + row[:, k].tobytes() for k in range(4)) for row in rows)
    runs = b"".join(bytes([2, 2, 0, 16]) + bytes([128 + 16, 100]) * 4 for _ in rows)
    return {
        ".png": [
            saved(colour, "PNG"), saved(grey, "PNG"), saved(colour.quantize(16), "PNG", transparency=3),
            saved(colour.convert("LA"), "PNG"), saved(colour.convert("1"), "PNG"),
            saved(colour, "PNG", save_all=True, append_images=[colour]),
        ],
        ".jpg": [
            saved(colour, "JPEG"), saved(colour.convert("CMYK"), "JPEG"), saved(colour.convert("L"), "JPEG"),
            saved(colour, "JPEG", progressive=True),
        ],
        ".hdr": [head + rows.tobytes(), head + packed, head + runs],
        ".any": [saved(colour, kind) for kind in OTHERS],
    }  # fmt: skip


def attempt_picture(content: bytes, folder: Path, suffix: str) -> str:
    """Compare it with a whole one, and read it as texture and as sky, each of which may refuse it."""
    path, whole = folder / f"a{suffix}", folder / f"whole{suffix}"
    path.write_bytes(content)
    if suffix != ".hdr":
        whole.write_bytes(pictures()[suffix][0])
        found = command("compare", path, whole, "-q", good={**GOOD, 3: "read"})
        if found not in ("read", "refused"):
            return found
        with contextlib.suppress(StrandError):
            maps.pyramid(maps.picture(str(path)))
    sky = environment.coefficients(environment.read(str(path)))
    return "read" if np.isfinite(sky).all() else "light that is not finite"
