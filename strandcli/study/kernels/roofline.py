"""What a machine can do at the most: bytes that it moves and operations that it makes, compiled like all else."""

from __future__ import annotations

import numpy as np

from ...jit import parallel, prange

ROUNDS = 256
"""Multiplications and additions of each number of `multiply`."""


@parallel
def copy(source, target):
    """Copy an array (n,) float32 that no cache holds: n times four bytes read and four written."""
    for i in prange(source.shape[0]):
        target[i] = source[i]


@parallel
def multiply(numbers):
    """Change each row of numbers (rows, 64) float32 by x := x a + b, `ROUNDS` times; rows stay in registers."""
    for row in prange(numbers.shape[0]):
        r = np.uint64(row)
        for _ in range(ROUNDS):
            for i in range(np.uint64(64)):
                numbers[r, i] = numbers[r, i] * np.float32(0.999) + np.float32(1e-3)
