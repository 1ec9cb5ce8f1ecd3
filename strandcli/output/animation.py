"""An animation, GIF, WebP or MP4, made from finished frames.

All frames of a GIF share one palette of 256 colours, fitted to frames from the whole film, so that still areas keep
their colour; it is dithered with a fixed pattern, because diffused error makes still areas crawl. Its times, hundredths
of a second, are rounded so that the sum stays right: 24 frames a second are shown for 4, 4, 4, 5, … hundredths.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from . import png
from .files import atomic
from .png import GREY, Rgb, over

COLOURS = 255  # one entry of 256 is left for pixels that stay as they were
PALETTE_FRAMES = 12
PALETTE_PIXELS = 400_000
DITHER = 4.0  # peak of the pattern, in 8-bit units: about the distance of neighbouring palette entries
GIF_SHORTEST = 2  # hundredths; browsers slow down anything shorter
WEBP_QUALITY = 85
WEBP_METHOD = 2  # 0 fast … 6 small; above 2 the time doubles for a few per cent


def write_animation(path: Path, images: Sequence[Path], frames: Sequence[int], fps: float, ground: Rgb = GREY) -> float:
    """Write ``path`` (its suffix says what) from the files ``images`` of the ascending frame numbers ``frames``.

    Images with alpha are over the colour ``ground``, but in WebP, which has alpha too. Frame f stands until the time
    of the next one, so that a film of every fifth frame runs at its true speed.
    Returns the mean rate that is shown, in film frames a second; it is below ``fps`` where the format is too slow.
    Raises ``UsageError`` for images that cannot be read, ``RefusedError`` if the file cannot be written.
    """
    if path.suffix == ".mp4":
        from .video import write_video

        return write_video(path, images, frames, fps, ground)
    unit, shortest = (10, GIF_SHORTEST) if path.suffix == ".gif" else (1, 1)
    times = durations(frames, fps, unit, shortest)
    settings: dict[str, Any] = {"save_all": True, "duration": times if len(times) > 1 else times[0], "loop": 0}
    if path.suffix == ".gif":
        pictures = _paletted(images, ground)
        settings |= {"format": "GIF", "optimize": False, "disposal": 1}
    elif path.suffix == ".webp":
        pictures = (png.load(image) for image in images)
        settings |= {"format": "WEBP", "quality": WEBP_QUALITY, "method": WEBP_METHOD}
    else:
        raise ValueError(f"{path}: neither .gif nor .webp nor .mp4")
    first = next(pictures)
    with atomic(path) as file:
        first.save(file, append_images=pictures, **settings)
    return 1000.0 * _span(frames) / sum(times)


def durations(frames: Sequence[int], fps: float, unit: int, shortest: int) -> list[int]:
    """Milliseconds for which each frame is shown: multiples of ``unit``, at least ``shortest`` units, the ends of all
    of them as near to their true times as rounding allows. The last frame is shown as long as one film frame."""
    ends = [frame - frames[0] for frame in frames[1:]]
    ends.append(_span(frames))
    shown: list[int] = []
    clock = 0
    for end in ends:
        ticks = max(shortest, round(1000.0 * end / (fps * unit)) - clock)
        shown.append(ticks * unit)
        clock += ticks
    return shown


def _span(frames: Sequence[int]) -> int:
    return frames[-1] - frames[0] + 1


def _paletted(images: Sequence[Path], ground: Rgb) -> Iterator[Any]:
    from PIL import Image

    palette = _palette(images, ground)
    pattern: Any = None
    for path in images:
        pixels = over(png.read(path), ground)
        if pattern is None or pattern.shape[:2] != pixels.shape[:2]:
            pattern = _pattern(pixels.shape[0], pixels.shape[1])
        dithered = np.clip(pixels + pattern, 0, 255).astype(np.uint8)
        yield Image.fromarray(dithered).quantize(palette=palette, dither=Image.Dither.NONE)


def _palette(images: Sequence[Path], ground: Rgb) -> Any:
    """An image whose palette suits all of ``images``: median cut over evenly chosen frames, refined by k-means."""
    from PIL import Image

    step = max(1, -(-len(images) // PALETTE_FRAMES))
    chosen = [over(png.read(path), ground) for path in images[::step]]
    pixels = np.concatenate([image.reshape(-1, 3) for image in chosen])
    pixels = pixels[:: max(1, len(pixels) // PALETTE_PIXELS)]
    return Image.fromarray(pixels[None]).quantize(COLOURS, method=Image.Quantize.MEDIANCUT, kmeans=1)


def _pattern(height: int, width: int) -> Any:
    """Bayer's 8x8 ordered dither, int16, (height, width, 1), of mean zero and peak ``DITHER``."""
    tile = np.zeros((1, 1))
    for _ in range(3):
        tile = np.block([[4 * tile, 4 * tile + 2], [4 * tile + 3, 4 * tile + 1]])
    centred = (tile + 0.5) / tile.size - 0.5
    rows, columns = -(-height // 8), -(-width // 8)
    wide = np.tile(np.rint(2 * DITHER * centred), (rows, columns))[:height, :width, None]
    return wide.astype(np.int16)
