"""Tables of a strand's light across its width: what each column of the offset h departs from the average.

How these are used: `strandcli.draw.coverage.width_profiles`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..coverage.kernels.width_profiles import COLUMNS
from .kernels.width_highlights import CHANNELS

N_THETA, N_PHI, OFFSETS = 24, 49, 8
"""Nodes of the tables, and offsets a column."""
STEP = np.pi / (N_PHI - 1)
"""Radians from node to node over φ."""
THETA = np.minimum(np.linspace(0.0, 0.5 * np.pi, N_THETA), 0.5 * np.pi - 1e-4)
"""Inclinations of the nodes."""
_COUNT = COLUMNS * OFFSETS
GAMMA = -np.arcsin((np.arange(_COUNT) + 0.5) * (2.0 / _COUNT) - 1.0)
"""Angles at which rays enter; one that enters on the side of b is at a negative angle in Φ."""


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
