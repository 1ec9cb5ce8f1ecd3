"""Tables of a fibre model: what both shipped models hold, and how they come by the mean paths inside a strand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

PATH_FLOOR = 1e-6
NO_PATHS = np.zeros((0, 0, 2), np.float32)


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
