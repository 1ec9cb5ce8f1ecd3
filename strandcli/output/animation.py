"""An animation, GIF, WebP or MP4 (by ffmpeg: the one on the PATH, else that of the package imageio-ffmpeg), made from
finished frames.

All frames of a GIF share one palette of 256 colours, fitted to frames from the whole film, so that still areas keep
their colour; it is dithered with a fixed pattern, because diffused error makes still areas crawl. Its times, hundredths
of a second, are rounded so that the sum stays right: 24 frames a second are shown for 4, 4, 4, 5, … hundredths.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from ..common.extras import install
from ..errors import RefusedError, UsageError, said
from . import png
from .files import atomic, refusal, temporary_name
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


QUALITY = "17"
"""Of x264, 0 to 51: below 18 a viewer sees no difference."""
ENCODERS = (("-c:v", "libx264", "-crf", QUALITY, "-preset", "medium"), ("-q:v", "2"))
"""x264; what ffmpeg takes by itself where it was built without."""


def ffmpeg() -> str:
    """The path of ffmpeg. Raises ``UsageError`` where there is none."""
    found = shutil.which("ffmpeg")
    if found is not None:
        return found
    try:
        import imageio_ffmpeg

        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except (ImportError, RuntimeError, OSError):
        words = f"install ffmpeg, or imageio-ffmpeg ({install('video')}), or choose gif or webp"
        raise UsageError(f"--animate mp4: there is no ffmpeg; {words}") from None


def write_video(path: Path, images: Sequence[Path], frames: Sequence[int], fps: float, ground: Rgb = GREY) -> float:
    """Write ``path`` from the files ``images`` of ascending frame numbers, each shown until the next one's time, whole
    or not at all; returns the rate, ``fps``. Images with alpha are over the colour ``ground``. Raises ``UsageError``
    and ``RefusedError``."""
    command, trouble = ffmpeg(), ""
    temporary = temporary_name(path)
    try:
        for encoder in ENCODERS:
            words = [command, *arguments(png.size_of(images[0]), fps, encoder, temporary)]
            trouble = _encode(words, images, frames, ground)
            if not trouble:
                os.replace(temporary, path)
                return fps
    except OSError as error:
        raise refusal(error, path) from error
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)
    raise RefusedError(f"{path}: ffmpeg could not write it: {said(trouble)}; choose gif or webp, or another ffmpeg")


def arguments(size: tuple[int, int], fps: float, encoder: Sequence[str], target: Path) -> list[str]:
    """ffmpeg's arguments for raw pictures on its standard input. Sides are made even, as the format wants."""
    width, height = size
    rate = Fraction(fps).limit_denominator(100_000)
    return [
        "-hide_banner", "-loglevel", "error", "-nostdin", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24",
        "-video_size", f"{width}x{height}", "-framerate", f"{rate.numerator}/{rate.denominator}", "-i", "pipe:0",
        "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv", *encoder,
        "-pix_fmt", "yuv420p", "-color_primaries", "bt709", "-color_trc", "iec61966-2-1", "-colorspace", "bt709",
        "-movflags", "+faststart", "-f", "mp4", f"file:{target}",
    ]  # fmt: skip


def _encode(words: Sequence[str], images: Sequence[Path], frames: Sequence[int], ground: Rgb) -> str:
    """Hand all pictures to ffmpeg, called by ``words``; returns its last line where that fails, else ""."""
    process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    assert process.stdin is not None
    assert process.stderr is not None
    try:
        with suppress(BrokenPipeError):  # it has ended by itself and says why
            for place, image in enumerate(images):
                pixels = over(png.read(image), ground).tobytes()
                until = frames[place + 1] if place + 1 < len(frames) else frames[place] + 1
                for _ in range(until - frames[place]):
                    process.stdin.write(pixels)
            process.stdin.close()
        errors = process.stderr.read().decode("utf-8", "replace").strip().splitlines()
        code = process.wait()
    except BaseException:
        process.kill()
        process.wait()
        raise
    finally:
        with suppress(OSError):
            process.stdin.close()
        process.stderr.close()
    return "" if code == 0 else (errors[-1] if errors else f"it ended with code {code}")
