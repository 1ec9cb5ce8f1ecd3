"""A pile of discs without friction, each contact resolved by itself, one after the other."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np


@numba.njit  # type: ignore[misc, unused-ignore]
def settle(up: Any, across: Any, wide: float, steps: int, fall: float, sweeps: int) -> None:
    """Let discs of diameter 1 sink to a floor between two walls that are ``wide`` apart, by ``fall`` at first and by
    less and less; after each step each two that overlap are led apart, ``sweeps`` times, from the lowest on."""
    count = len(up)
    for step in range(steps):
        up -= fall * (1 - step / steps)
        order = np.argsort(up)
        for _ in range(sweeps):
            for a in range(count):
                i = order[a]
                up[i] = max(up[i], 0.5)
                across[i] = min(max(across[i], 0.5 - wide / 2), wide / 2 - 0.5)
                for b in range(a + 1, count):
                    j = order[b]
                    dy, dz = up[j] - up[i], across[j] - across[i]
                    if dy > 1.5:
                        break
                    apart = np.sqrt(dy * dy + dz * dz)
                    if 0 < apart < 1:
                        half = 0.5 * (1 - apart) / apart
                        up[i] -= half * dy
                        across[i] -= half * dz
                        up[j] += half * dy
                        across[j] += half * dz
