"""The least value of a function of one number that has a single minimum, by golden-section search."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ....jit import device

CLOSER = np.float32((math.sqrt(5.0) - 1.0) / 2.0)
"""Share of the interval that a step leaves."""


def search(of: Any) -> Any:
    """Return a device function (at, low, high, steps) that finds the least value of of(t, at) for low <= t <= high by
    golden-section search. There must be a single minimum."""

    @device
    def lowest(at, low, high, steps):
        near = high - CLOSER * (high - low)
        far = low + CLOSER * (high - low)
        at_near = of(near, at)
        at_far = of(far, at)
        for _ in range(steps):
            if at_near < at_far:
                high = far
                far = near
                at_far = at_near
                near = high - CLOSER * (high - low)
                at_near = of(near, at)
            else:
                low = near
                near = far
                at_near = at_far
                far = low + CLOSER * (high - low)
                at_far = of(far, at)
        return min(at_near, at_far)

    return lowest
