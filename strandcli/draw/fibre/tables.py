"""Tables of a fibre model: what both shipped models hold, and how they come by the mean paths inside a strand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..coverage.kernels.width_profiles import COLUMNS
from .kernels.lobes import CHANNELS

PATH_FLOOR = 1e-6
NO_PATHS = np.zeros((0, 0, 2), np.float32)
N_THETA, N_PHI, OFFSETS = 24, 49, 8
"""Nodes of the tables, and offsets a column."""
STEP = np.pi / (N_PHI - 1)
"""Radians from node to node over φ."""
THETA = np.minimum(np.linspace(0.0, 0.5 * np.pi, N_THETA), 0.5 * np.pi - 1e-4)
"""Inclinations of the nodes."""
_COUNT = COLUMNS * OFFSETS
GAMMA = -np.arcsin((np.arange(_COUNT) + 0.5) * (2.0 / _COUNT) - 1.0)
"""Angles at which rays enter; one that enters on the side of b is at a negative angle in Φ."""


@dataclass(frozen=True, slots=True)
class FibreTables:
    """A model's tables, and what they were built for. Arrays are float32 in C order, as ``kind`` says."""

    kind: Callable[..., Any]
    """The NamedTuple that kernels read them as: `MarschnerArrays` or `ChiangArrays`."""
    lobes: NDArray[np.float32]
    nodes: NDArray[np.float32]
    paths: NDArray[np.float32] | None
    """None where no colour varies."""
    absorption: NDArray[np.float64]
    """(3,) σ_a of the tables, in 1/radius."""

    @property
    def arrays(self) -> Any:
        """As kernels read them."""
        return self.kind(self.lobes, self.nodes, NO_PATHS if self.paths is None else self.paths)

    @property
    def nbytes(self) -> int:
        """Of the arrays."""
        return sum(array.nbytes for array in self.arrays)


def add_paths(rays: NDArray[np.float64], length: NDArray[np.float64]) -> NDArray[np.float64]:
    """R, TT rgb and TRT rgb (n_θ, 7, n), and behind them TT and TRT, the mean of rgb, weighted with their paths'
    lengths; length (n_θ, n): of a chord."""
    tt = rays[:, 1:4].mean(axis=1) * length
    trt = rays[:, 4:7].mean(axis=1) * length * 2.0
    return np.concatenate([rays[:, :7], np.stack([tt, trt], 1)], 1)


def mean_paths(n: NDArray[np.float64], theta: NDArray[np.float64], eta: float) -> NDArray[np.float64]:
    """(n_θ, n_φ, 2) mean path lengths of TT and TRT, in radii, of N (n_θ, n_φ, 9) with the channels of `add_paths`;
    where nothing is seen, that of a ray through the middle."""
    mean = np.stack([n[..., 1:4].mean(axis=-1), n[..., 4:7].mean(axis=-1)], axis=-1)
    plain = np.array([1.0, 2.0]) * (2.0 * eta / np.sqrt(eta**2 - np.sin(theta) ** 2))[:, None, None]
    known = mean > PATH_FLOOR * mean.max(axis=(0, 1))
    return np.clip(np.where(known, n[..., 7:] / np.where(known, mean, 1.0), plain), 0.0, plain)


def table_of(
    rays: NDArray[np.float64], out: NDArray[np.float64],
    detector: Callable[[NDArray[np.float64]], NDArray[np.float64]], scales: NDArray[np.float64],
) -> NDArray[np.float32]:  # fmt: skip
    """(n_θ, n_φ, columns, 8): what the azimuthal functions of R, TT rgb and TRT rgb depart from their averages in each
    column of h, light on the side where h is positive, φ in [0, π].

    rays (n_θ, 7 or more, rays) that entered at `GAMMA`: what is left of each; out (n_θ, 3, rays): angles at which R, TT
    and TRT leave; detector: its response to an angle, no narrower than a cell; scales (7,) of the channels.
    """
    phi = np.linspace(0.0, np.pi, N_PHI)
    table = np.zeros((N_THETA, N_PHI, COLUMNS, CHANNELS), np.float32)
    for lobe, channels in enumerate(((0,), (1, 2, 3), (4, 5, 6))):
        apart = phi[None, :, None] - out[:, lobe, None]  # (θ, φ, rays)
        apart -= 2.0 * np.pi * np.round(apart / (2.0 * np.pi))
        seen = detector(apart)
        for c in channels:
            light = (seen * rays[:, None, c]).reshape(N_THETA, N_PHI, COLUMNS, OFFSETS).mean(-1)
            table[..., c] = scales[c] * (light - light.mean(-1, keepdims=True))
    return table
