"""Tone curves as tables, the background, and haze.

Haze: strands and solids fade with distance into the background behind them. Of light that travels d metres through
homogeneous air, e^(−d / distance) arrives (Beer and Lambert); in-scattered light with the colour of the background
replaces the rest. d is the depth along the camera's axis. Shaded values are changed, so that kernels of shading are the
same with and without haze.
"""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common import srgb
from ..coverage.kernels.width_profiles import Profiles
from ..view.camera import View
from .kernels import film as kernel

GREY = 0.18
CONTRAST = 1.3
WHITE = 254.5
"""8-bit level from which on nothing is dithered."""
LEVELS = 4096


def filmic(light: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the film-like response xᶜ / (xᶜ + k) (Naka and Rushton 1966), c = 1.3, with k such that mid grey, 0.18, is
    unchanged. White is never reached: light 1 becomes 0.67, light 4 0.93, light 16 0.99. Around mid grey the contrast
    is 1.3 · 0.82 = 1.07 times that of the scene."""
    power = np.asarray(light, np.float64) ** CONTRAST
    return np.asarray(power / (power + GREY**CONTRAST * (1 / GREY - 1)))


@functools.cache
def curve_of(tone: str) -> tuple[NDArray[np.uint8], np.float32]:
    """Return the table (65536,) of a tone curve to 8-bit sRGB (IEC 61966-2-1) for `kernels.film.develop`, and 1 if its
    argument is x / (1 + x) of light x, else 0.

    Of light in [0, 1], in even steps, a step is at most 0.05 levels, at black where the slope is 12.92, so the table's
    error is that of rounding. Near black x / (1 + x) ≈ x, so the steps of `filmic` are as fine."""
    if tone != "filmic":
        return _levels(np.arange(65536) / 65535), np.float32(0)
    rolled = np.arange(65536) / 65536
    return _levels(filmic(rolled / (1 - rolled))), np.float32(1)


def dithered(
    rows: NDArray[np.float32], width: int, samples: int, tone: str, exposure: float, corner: tuple[int, int] = (0, 0)
) -> NDArray[np.float32]:
    """Return a picture (height, width, 3) of the rows of light (height, 3), with noise of ± half an 8-bit level, equal
    in all samples of a pixel. Without it, a gradient over the whole picture would show bands. ``samples``: along each
    side of a pixel; ``corner`` (x, y): position in the full picture, pixels, so that a crop window has the same noise.
    """
    lines = rows.reshape(-1, samples, 3).mean(1, dtype=np.float64)
    step = np.maximum(1e-3 * lines, 1e-5)
    slope = (_response(lines + step, tone, exposure) - _response(lines - step, tone, exposure)) / (2 * step)
    x, y = np.arange(width // samples, dtype=np.uint32), np.arange(len(lines), dtype=np.uint32)
    noise = _noise(x + np.uint32(corner[0]), (y + np.uint32(corner[1]))[:, None])[..., None] - 0.5
    white = _response(lines, tone, exposure) >= WHITE  # where noise of any size would only make it darker
    spread = np.where(white, 0.0, 1.0 / np.maximum(slope, 1e-3))[:, None] * noise
    if samples > 1:
        spread = np.repeat(np.repeat(spread, samples, 0), samples, 1)
    spread += rows[:, None]
    return np.maximum(spread, 0, out=spread).astype(np.float32)


@functools.cache
def level_sizes(tone: str) -> NDArray[np.float32]:
    """Return a table (LEVELS,) over x / (1 + x) of exposed light x, in even steps over [0, 1]: how much light makes one
    8-bit level more there; 0 where the picture is white."""
    rolled = (np.arange(LEVELS) + 0.5) / LEVELS
    light = rolled / (1 - rolled)
    known = np.concatenate([[0.0], np.geomspace(1e-7, light[-1], 20_000)])
    levels = _response(known, tone, 0.0)
    rising = levels < WHITE
    here = np.minimum(_response(light, tone, 0.0), WHITE)
    ends = [np.interp(here + side, levels[rising], known[rising]) for side in (-0.5, 0.5)]
    return np.asarray(np.where(here < WHITE, ends[1] - ends[0], 0.0), np.float32)


def grain_of(image: Any) -> tuple[NDArray[np.float32], NDArray[np.float32]] | None:
    """Return levels and frame of `strandcli.draw.lighting.kernels.inputs.Screen`; None where backdrop and solids are
    not dithered."""
    if image.horizon is None or image.has_alpha:
        return None
    x, y = (image.crop or (0, 0))[:2]
    frame = [image.supersample, x, y, 2.0**image.exposure, 2.0**-image.exposure]
    return level_sizes(image.tone), np.array(frame, np.float32)


def associated(image: NDArray[np.float32], through: NDArray[np.float32], samples: int) -> NDArray[np.float32]:
    """Return the pixels (height, width, 4) of a picture without background, light (premultiplied) and alpha, from light
    and transmittance (samples · height, samples · width, 3). Light that is no number becomes black."""
    height, width, _ = image.shape
    shape = height // samples, samples, width // samples, samples
    found = np.empty((shape[0], shape[2], 4), np.float32)
    light = image.reshape(*shape, 3).mean((1, 3), dtype=np.float32)
    found[..., :3] = np.where(np.isfinite(light), light, np.float32(0))
    found[..., 3] = np.clip(1 - through[..., 0].reshape(shape).mean((1, 3), dtype=np.float32), 0, 1)
    return found


def straight(pixels: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """Return the light (height, width, 3) of what covers each of the `associated` pixels, divided by its alpha, and
    alpha (height, width) of 8 bits; where that is 0 the light is black."""
    alpha = np.rint(255 * pixels[..., 3]).astype(np.uint8)
    return np.where(alpha[..., None] > 0, pixels[..., :3] / np.maximum(pixels[..., 3:], 1e-6), np.float32(0)), alpha


def develop(
    settings: Any, image: NDArray[np.float32], out: NDArray[np.uint8], through: NDArray[np.float32] | None
) -> None:
    """Convert a linear picture, in samples, to sRGB pixels (height, width, 3) of 8 bits, written to ``out``; with a
    transmittance to pixels with straight alpha (height, width, 4): the tone curve is that of what covers a pixel, and
    not of its light, which alpha scales. settings: the scene's `image`."""
    curve, roll = curve_of(settings.tone)
    samples = settings.supersample
    if through is not None:
        image, out[..., 3] = straight(associated(image, through, samples))
        samples = 1
    kernel.develop(image, samples, np.float32(2.0**settings.exposure), curve, roll, out)


def _noise(x: NDArray[np.uint32], y: NDArray[np.uint32]) -> NDArray[np.float64]:
    """Return uniform noise in [0, 1) that depends on the pixel's position alone (Wellons's `lowbias32` hash)."""
    bits = x + np.uint32(0x9E3779B9) * y
    for shift, factor in ((16, 0x7FEB352D), (15, 0x846CA68B), (16, 1)):
        bits = (bits ^ (bits >> np.uint32(shift))) * np.uint32(factor)
    return bits / 2.0**32


def _response(light: NDArray[np.float64], tone: str, exposure: float) -> NDArray[np.float64]:
    """Return the 8-bit levels of light before rounding."""
    exposed = np.maximum(light, 0) * 2.0**exposure
    linear = filmic(exposed) if tone == "filmic" else np.minimum(exposed, 1)
    return 255 * srgb.encoded(linear)


def _levels(linear: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Linear [0, 1] to 8-bit sRGB."""
    return np.rint(255 * srgb.encoded(linear)).astype(np.uint8)


def gradient(top: NDArray[np.float32], bottom: NDArray[np.float32], height: int) -> NDArray[np.float32]:
    """Return (height, 3) the background's colour in each row, linear from top to bottom."""
    t = (np.arange(height, dtype=np.float32)[:, None] + np.float32(0.5)) / np.float32(height)
    return np.asarray(top + t * (bottom - top))


@functools.lru_cache(maxsize=1)
def backdrop_of(image: Any) -> NDArray[np.float32]:
    """Return the background (height, width, 3), linear, in samples, read-only; black where there is
    none."""
    samples, (width, height) = image.supersample, image.drawn
    if image.has_alpha:
        return np.zeros((height * samples, width * samples, 3), np.float32)
    crop = image.crop or (0, 0, *image.size)
    top = np.array(image.background, np.float32)
    bottom = top if image.horizon is None else np.array(image.horizon, np.float32)
    rows = gradient(top, bottom, image.size[1] * samples)[crop[1] * samples :][: height * samples]
    if image.horizon is not None:
        return dithered(rows, width * samples, samples, image.tone, image.exposure, crop[:2])
    return np.ascontiguousarray(np.broadcast_to(rows[:, None], (height * samples, width * samples, 3)))


NO_SLOTS, NO_PROFILE = np.zeros(0, np.int32), np.zeros((0, 0, 3), np.float32)
MOST_RATE = 1e30
"""Halvings of light a metre in the thickest haze, which single precision holds."""


def veil_strands(
    haze: float, view: View, backdrop: NDArray[np.float32], screen: NDArray[np.float32], marks: NDArray[np.uint8],
    colours: NDArray[np.float32], body: Profiles | None,
) -> None:  # fmt: skip
    """Blend the colours (V, 3) of marked vertices with the backdrop (height, width, 3) behind them, and scale their
    width profiles alike.

    haze: distance, metres, at which 1 / e of the light is left; screen (V, 3); marks (V,): non-zero for vertices to
    change; body: profiles of wide strands, or None."""
    slots, profile = (NO_SLOTS, NO_PROFILE) if body is None else (body.slots, body.profile)
    kernel.veil_strands(_air(haze, view), backdrop, screen, marks, colours, slots, profile)


def veil_solids(
    haze: float, view: View, behind: NDArray[np.float32], keys: NDArray[np.uint64], image: NDArray[np.float32],
    hidden: NDArray[np.uint8],
) -> None:  # fmt: skip
    """Blend the solids in a picture (height, width, 3) with the picture ``behind`` them, of the same shape; keys
    (height * width,): z-buffer of the solids; hidden (height * width,): non-zero for pixels that are not changed, (0,):
    there are none."""
    kernel.veil_solids(_air(haze, view), behind.reshape(-1, 3), keys, hidden, image.reshape(-1, 3))


def _air(haze: float, view: View) -> kernel.Air:
    rate = -min(1 / (haze * math.log(2.0)), MOST_RATE)
    return kernel.Air(*map(np.float32, (rate, view.perspective, view.near, view.far - view.near)))
