"""Counts of the samples that lines pass through; no buffer changes."""

from __future__ import annotations

import numpy as np

from ....jit import parallel, prange

ZERO = np.float32(0.0)
HALF = np.float32(0.5)


@parallel
def count_samples(first, screen, width, height, counts):
    """Write to counts (S,) int64 through how many samples of a picture each strand's middle line passes: for each
    segment one a column, or a row where it is steeper, whose centre lies between the segment's ends.

    first (S + 1,); screen (V, 3): x, y in samples, and the depth number of `project.points`.
    """
    for s in prange(counts.shape[0]):
        found = np.int64(0)
        for v in range(first[s] + 1, first[s + 1]):
            if screen[v - 1, 2] <= ZERO or screen[v, 2] <= ZERO:
                continue
            flat = abs(screen[v, 0] - screen[v - 1, 0]) >= abs(screen[v, 1] - screen[v - 1, 1])
            along = np.int64(0) if flat else np.int64(1)
            side, across = (width, height) if flat else (height, width)
            low, high = min(screen[v - 1, along], screen[v, along]), max(screen[v - 1, along], screen[v, along])
            if not high - low > ZERO:
                continue
            begin = np.int64(max(np.ceil(low - HALF), ZERO))
            end = np.int64(min(np.ceil(high - HALF), np.float32(side)))
            slope = (screen[v, 1 - along] - screen[v - 1, 1 - along]) / (screen[v, along] - screen[v - 1, along])
            for place in range(begin, end):
                other = screen[v - 1, 1 - along] + (np.float32(place) + HALF - screen[v - 1, along]) * slope
                found += np.int64(ZERO <= other < np.float32(across))
        counts[s] = found
