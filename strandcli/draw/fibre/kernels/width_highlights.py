"""The lobes of wide strands across their width, from tables (see `strandcli.draw.fibre.tables`)."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device
from ...common.kernels.batch import ARRIVES, EXTRA, NODE_X, NODE_Y, TRT, TT, R
from ...common.kernels.light_columns import POWER_R
from ...common.kernels.numbers import ZERO
from ...coverage.kernels.width_profiles import COLUMNS, azimuth
from .lobes import PATH_TRT, PATH_TT, grown

CHANNELS = 8
"""Of a column in the tables: R, TT in red, green and blue, TRT, and padding."""


@device
def width_highlights(work, n, which, lights, one, tables, profiles, columns):
    """Add the lobes across the strand to the profiles of wide vertices, from what `highlights` left in the batch.

    which (W,): vertices of the batch; tables: of the fibre model, with nodes and paths; profiles: `WidthProfiles`;
    columns: theirs, which have the same ranges as nodes, or None where the model has no tables over the width.
    """
    if columns is None:
        return
    per_x = np.float32(columns.shape[0] - 1) / np.float32(tables.nodes.shape[0] - 1)
    per_y = np.float32(columns.shape[1] - 1) / np.float32(tables.nodes.shape[1] - 1)
    for k in range(n):
        slot = profiles.slots[which[k]]
        arrives = work[ARRIVES + k]
        if slot < 0 or arrives <= ZERO:
            continue
        x = work[NODE_X + k] * per_x
        y = work[NODE_Y + k] * per_y
        i = min(np.int64(x), columns.shape[0] - 2)
        j = min(np.int64(y), columns.shape[1] - 2)
        x -= np.float32(i)
        y -= np.float32(j)
        _, sine = azimuth(work, k)
        a = np.int64(work[NODE_X + k])
        b = np.int64(work[NODE_Y + k])
        for c in range(3):
            light = arrives * lights[one, POWER_R + c]
            m_r = light * work[R + k]
            m_tt = light * work[TT + k]
            m_trt = light * work[TRT + k]
            if tables.paths.shape[0] > 0:  # strands with a colour of their own; a node's path is near enough here
                m_tt *= grown(work[EXTRA + c * W + k], tables.paths[a, b, PATH_TT])
                m_trt *= grown(work[EXTRA + c * W + k], tables.paths[a, b, PATH_TRT])
            for q in range(COLUMNS):
                h = q if sine >= ZERO else COLUMNS - 1 - q
                profiles.profile[slot, q + 1, c] += (
                    m_r * cell(columns, i, j, h, 0, x, y)
                    + m_tt * cell(columns, i, j, h, 1 + c, x, y)
                    + m_trt * cell(columns, i, j, h, 4 + c, x, y)
                )


@device
def cell(columns, i, j, h, c, x, y):
    """Bilinear among four nodes."""
    low = columns[i, j, h, c] + y * (columns[i, j + 1, h, c] - columns[i, j, h, c])
    high = columns[i + 1, j, h, c] + y * (columns[i + 1, j + 1, h, c] - columns[i + 1, j, h, c])
    return low + x * (high - low)
