"""The body of strands near the camera: light that varies across their width.

Everywhere else a strand's light is the average over its width, which is all that a pixel shows of a thin strand. Where
strands are wider than two pixels the average is resolved: into columns of the offset h ∈ [−1, 1], each with its own
part of the azimuthal functions,

    N_p(θ, φ) = ½ ∫ A_p(θ, h) D(φ − Φ_p(h)) dh,

so that R is a narrow streak on the side of the light, TT the glow of a strand before it, TRT the coloured streaks
beside them. What is no lobe, the light from strand to strand, is rounded off by a cosine. Only departures from the
average are kept, and they add up to nothing over the width: a strand's whole light is what it is far away, and between
two and four pixels departures grow from nothing, so that nothing jumps as the camera comes near. A pixel's share of the
width is averaged exactly, so that a strand three pixels wide does not flicker.

Where a light's shadows are exact they have their edges across the width too, and departures begin at a thirtieth of a
pixel: shadows are traced along lines on the side that the camera sees, and each sample has the light and the shadow of
the part of the width and of the length that it shows. With dual scattering shadows stay those of the whole width.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from . import chiang, marschner
from .curves import Polylines
from .kernels import body as kernel
from .kernels.lit import LINES
from .pigment import absorption_of
from .scratch import Scratch

if TYPE_CHECKING:
    from ..scene.model import Material

N_THETA, N_PHI, OFFSETS = 24, 49, 8
"""Nodes of the tables, and offsets a column."""
START, FULL = 2.0, 4.0
"""Widths in pixels from which profiles count, and count fully;"""
EXACT = 0.03, 0.06
"""where shadows are exact: there they vary across the width."""


@dataclass(frozen=True)
class Body:
    """The vertices of some strands that are wide."""

    screen: NDArray[np.float32]
    widths: NDArray[np.float32]
    slots: NDArray[np.int32]
    """(V,) number of the vertex' profile, or −1."""
    profile: NDArray[np.float32]
    """(1 + lights, n, columns + 1, 3)"""
    samples: np.float32
    """Along each side of a pixel."""
    start: np.float32
    full: np.float32
    """Widths in pixels from which profiles count, and count fully."""
    shades: NDArray[np.uint64] | None
    """(lights, n, LINES) what exact shadows darken of the piece after each; None without such lights."""

    def over_seen(self, keys: NDArray[np.uint64], base: int, lines: Polylines, image: NDArray[np.float32]) -> None:
        """Add departures where the z-buffer ``keys`` shows these polylines, whose vertices are numbered from
        ``base``."""
        kernel.over_seen(
            keys, base, lines.per, lines.stride, self.screen, self.widths, self.samples, self.start, self.full,
            self.slots, self.profile, self.shades, image,
        )  # fmt: skip


def body_of(
    lines: Polylines, screen: NDArray[np.float32], widths: NDArray[np.float32] | None, samples: int, scratch: Scratch,
    traced: int = 0, marks: NDArray[np.uint8] | None = None,
) -> Body | None:  # fmt: skip
    """What is wide of polylines (V,) with these widths in samples; None where nothing is. ``traced``: lights with exact
    shadows, under which only the vertices with ``marks`` (V,) matter: they are many."""
    start, full = EXACT if traced else (START, FULL)
    if widths is None or not len(widths) or not float(widths.max()) > start * samples:
        return None
    wide = (widths > np.float32(start * samples)) & (screen[:, 2] > 0)
    if marks is not None:
        wide &= marks != 0
    count = int(np.count_nonzero(wide))
    if count == 0:
        return None
    slots = scratch.take("slots", len(widths), np.int32)
    slots.fill(-1)
    slots[wide] = np.arange(count, dtype=np.int32)
    profile = scratch.take("profile", (1 + traced, count, kernel.COLUMNS + 1, 3), np.float32)
    shades = scratch.take("shades", (traced, count, LINES), np.uint64) if traced else None
    return Body(screen, widths, slots, profile, np.float32(samples), np.float32(start), np.float32(full), shades)


def columns_of(material: Material) -> NDArray[np.float32] | None:
    """(n_θ, n_φ, columns, 8): what the azimuthal functions of R, TT rgb and TRT rgb depart from their averages in each
    column of h, light on the side where h is positive. θ is what the model's tables have, φ is in [0, π]. Lobes
    narrower than a cell are drawn as wide as one. None where there are no highlights."""
    if material.specular == 0:
        return None
    theta = np.minimum(np.linspace(0.0, 0.5 * np.pi, N_THETA), 0.5 * np.pi - 1e-4)
    phi = np.linspace(0.0, np.pi, N_PHI)
    count = kernel.COLUMNS * OFFSETS
    offset = (np.arange(count) + 0.5) * (2.0 / count) - 1.0
    gamma = -np.arcsin(offset)  # a ray that enters on the side of b is at a negative angle in Φ
    step = np.pi / (N_PHI - 1)
    if material.model == "chiang":
        sigma = absorption_of(material, material.beta_n)
        rays, _, out = chiang.passages(theta, gamma, material.eta, sigma)
        s = max(chiang.logistic_scale(material.beta_n), 0.5 * step)
        scales = np.ones(7)
    else:
        sigma = absorption_of(material, marschner.azimuthal_beta(material.azimuthal))
        rays, _, out = marschner.passages(theta, gamma, material.eta, sigma)
        s = max(math.radians(material.azimuthal), 0.75 * step)
        scales = np.repeat(marschner.peaks(material), (1, 3, 3))
    table = np.zeros((N_THETA, N_PHI, kernel.COLUMNS, kernel.CHANNELS), np.float32)
    for lobe, channels in enumerate(((0,), (1, 2, 3), (4, 5, 6))):
        apart = phi[None, :, None] - out[:, lobe, None]  # (θ, φ, rays)
        apart -= 2.0 * np.pi * np.round(apart / (2.0 * np.pi))
        seen = _logistic(apart, s) if material.model == "chiang" else _gaussian(apart, s)
        for c in channels:
            light = (seen * rays[:, None, c]).reshape(N_THETA, N_PHI, kernel.COLUMNS, OFFSETS).mean(-1)
            table[..., c] = scales[c] * (light - light.mean(-1, keepdims=True))
    return table


def _logistic(angle: NDArray[np.float64], s: float) -> NDArray[np.float64]:
    fall = np.exp(-np.abs(angle) / s)
    return np.asarray(fall / (s * (1.0 + fall) ** 2) / math.tanh(0.5 * np.pi / s))


def _gaussian(angle: NDArray[np.float64], deviation: float) -> NDArray[np.float64]:
    turns = [np.exp(-0.5 * ((angle + turn) / deviation) ** 2) for turn in (-2.0 * np.pi, 0.0, 2.0 * np.pi)]
    return np.asarray(sum(turns) / (math.sqrt(2.0 * np.pi) * deviation))
