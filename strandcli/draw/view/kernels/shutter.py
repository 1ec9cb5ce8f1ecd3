"""Strands at a moment between two frames."""

from __future__ import annotations

from ....jit import parallel, prange


@parallel
def blend(before, after, numbers, lanes, out):
    """out = A · before + B · after + c for every particle.

    before, after, out (blocks, rows, 3 * lanes) float32 metres, x, y and z of every lane after one another; numbers
    (21,) float32: A and B by rows, then c.
    """
    for block in prange(out.shape[0]):
        for row in range(out.shape[1]):
            for c in range(3):
                ax = numbers[3 * c]
                ay = numbers[3 * c + 1]
                az = numbers[3 * c + 2]
                bx = numbers[9 + 3 * c]
                by = numbers[9 + 3 * c + 1]
                bz = numbers[9 + 3 * c + 2]
                shift = numbers[18 + c]
                for k in range(lanes):
                    out[block, row, c * lanes + k] = (
                        (ax * before[block, row, k] + bx * after[block, row, k])
                        + (ay * before[block, row, lanes + k] + by * after[block, row, lanes + k])
                        + (az * before[block, row, 2 * lanes + k] + bz * after[block, row, 2 * lanes + k])
                    ) + shift
