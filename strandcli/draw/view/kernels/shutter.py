"""Interpolation of strands between two frames."""

from __future__ import annotations

from ....jit import parallel, prange

BEFORE, AFTER, SHIFT = 0, 9, 18
"""Offsets in `numbers` of the matrices A and B, row by row, and of c."""


@parallel
def blend(before, after, numbers, lanes, out):
    """Write A · before + B · after + c for every particle.

    before, after, out (blocks, rows, 3 * lanes) float32 metres: x of all lanes, then y, then z; numbers (21,) float32:
    A, B and c at the offsets above.
    """
    for block in prange(out.shape[0]):
        for row in range(out.shape[1]):
            for c in range(3):
                ax = numbers[BEFORE + 3 * c]
                ay = numbers[BEFORE + 3 * c + 1]
                az = numbers[BEFORE + 3 * c + 2]
                bx = numbers[AFTER + 3 * c]
                by = numbers[AFTER + 3 * c + 1]
                bz = numbers[AFTER + 3 * c + 2]
                shift = numbers[SHIFT + c]
                for k in range(lanes):
                    out[block, row, c * lanes + k] = (
                        (ax * before[block, row, k] + bx * after[block, row, k])
                        + (ay * before[block, row, lanes + k] + by * after[block, row, lanes + k])
                        + (az * before[block, row, 2 * lanes + k] + bz * after[block, row, 2 * lanes + k])
                    ) + shift
