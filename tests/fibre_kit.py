"""Light that one strand scatters, as the kernel of its fibre model adds it to a batch of vertices."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from strandcli.constants import W
from strandcli.draw.common.kernels import batch, light_columns
from strandcli.draw.fibre.kernels.highlights import highlights
from strandcli.jit import function

WHITE = np.ones((1, light_columns.COLUMNS), np.float32)


@function
def shade(work, n, lights, tables):
    """The kernel for the first n vertices of a batch."""
    highlights(work, n, lights, 0, tables)


def scattered(
    arrays: Any, tangents: ArrayLike, lights: ArrayLike, eyes: ArrayLike, extra: ArrayLike = (0, 0, 0)
) -> NDArray[np.float32]:
    """S cos θ_l (n, 3) for unit vectors (n, 3) or (3,), and absorption beyond that of the tables, 1/radius."""
    given = np.broadcast_arrays(
        *(np.atleast_2d(np.asarray(one, np.float32)) for one in (tangents, lights, eyes, extra))
    )
    out = np.empty(given[0].shape, np.float32)
    for first in range(0, len(out), W):
        here = slice(first, first + W)
        work = np.zeros((batch.ROWS, W), np.float32)
        count = len(out[here])
        for row, numbers in zip((batch.TX, batch.LX, batch.EX, batch.EXTRA), given, strict=True):
            work[row // W :][:3, :count] = numbers[here].T
        work[batch.ARRIVES // W, :count] = 1
        shade(work.reshape(-1), count, WHITE, arrays)
        out[here] = work[batch.RADIANCE // W :][:3, :count].T
    return out
