"""Frames as MP4 by ffmpeg: the one on the PATH, else that of the package imageio-ffmpeg."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Sequence
from contextlib import suppress
from fractions import Fraction
from pathlib import Path

from ..common.extras import install
from ..errors import RefusedError, UsageError, said
from . import png
from .files import refusal, temporary_name
from .png import GREY, Rgb, over

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
