"""Azimuthal tables of a strand's lobes, as both models read them (`strandcli.draw.fibre.marschner`,
`strandcli.draw.fibre.chiang`).

A node holds R, which is colourless, TT and TRT in red, green and blue, and with Chiang's model all that leaves after
more inner reflections.
"""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device
from ...common.kernels import batch
from ...common.kernels.approximations import exp2
from ...common.kernels.batch import ARRIVES, EXTRA, RADIANCE
from ...common.kernels.light_columns import POWER_B, POWER_G, POWER_R

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
GROWTH_LIMIT = np.float32(40.0)
R, TT, TRT, REST = (np.int64(c) for c in (0, 1, 4, 7))  # for each literal `mix` would be compiled anew
"""Channels of a node."""
PATH_TT, PATH_TRT, PATH_REST = (np.int64(c) for c in range(3))
"""Columns of mean paths."""


@device
def add_lobes(work, n, lights, i, rest, tables):
    """Add what the lobes scatter of light number i to the radiance of the first n vertices of a batch.

    work: rows of `batch`, of which `NODE_X`, `NODE_Y`, R, TT and TRT hold what `longitudinal` gave; rest: the row with
    M of the rest, None with tables that have none; tables: `MarschnerArrays` or `ChiangArrays`.
    """
    for k in range(n):
        arrives = work[ARRIVES + k]
        if arrives > ZERO:
            r, g, b = azimuthal(
                work[batch.NODE_X + k], work[batch.NODE_Y + k],
                (work[batch.R + k], work[batch.TT + k], work[batch.TRT + k]), None if rest is None else work[rest + k],
                tables.nodes, tables.paths, (work[EXTRA + k], work[EXTRA + W + k], work[EXTRA + 2 * W + k]),
            )  # fmt: skip
            work[RADIANCE + k] += arrives * lights[i, POWER_R] * r
            work[RADIANCE + W + k] += arrives * lights[i, POWER_G] * g
            work[RADIANCE + 2 * W + k] += arrives * lights[i, POWER_B] * b


@device
def azimuthal(x, y, m, m_rest, nodes, paths, extra):
    """S cos θ_l in red, green and blue, 1/sr: the tables at (x, y), weighted with what `longitudinal` gave.

    m: M of R, TT and TRT; m_rest: that of the rest, or None with tables that have none; nodes (n_θ, n_φ, 8 or more);
    paths (n_θ, n_φ, 2 or more), without nodes where every strand has the tables' absorption; extra: this strand's
    absorption less that of the tables, in red, green and blue, 1/radius. All numbers are float32.
    """
    i = int(x)
    j = int(y)
    x -= np.float32(i)
    y -= np.float32(j)
    w11 = x * y
    w10 = x - w11
    w01 = y - w11
    w00 = ONE - x - w01
    m_r, m_tt, m_trt = m
    r = m_r * mix(nodes, i, j, R, w00, w01, w10, w11)
    tt_r = m_tt * mix(nodes, i, j, TT, w00, w01, w10, w11)
    tt_g = m_tt * mix(nodes, i, j, TT + 1, w00, w01, w10, w11)
    tt_b = m_tt * mix(nodes, i, j, TT + 2, w00, w01, w10, w11)
    trt_r = m_trt * mix(nodes, i, j, TRT, w00, w01, w10, w11)
    trt_g = m_trt * mix(nodes, i, j, TRT + 1, w00, w01, w10, w11)
    trt_b = m_trt * mix(nodes, i, j, TRT + 2, w00, w01, w10, w11)
    if paths.shape[0] > 0:
        l_tt = mix(paths, i, j, PATH_TT, w00, w01, w10, w11)
        l_trt = mix(paths, i, j, PATH_TRT, w00, w01, w10, w11)
        tt_r *= grown(extra[0], l_tt)
        tt_g *= grown(extra[1], l_tt)
        tt_b *= grown(extra[2], l_tt)
        trt_r *= grown(extra[0], l_trt)
        trt_g *= grown(extra[1], l_trt)
        trt_b *= grown(extra[2], l_trt)
    red = r + tt_r + trt_r
    green = r + tt_g + trt_g
    blue = r + tt_b + trt_b
    if m_rest is not None:
        # what is left has no azimuth
        near = ONE - x
        rest_r = m_rest * (near * nodes[i, j, REST] + x * nodes[i + 1, j, REST])
        rest_g = m_rest * (near * nodes[i, j, REST + 1] + x * nodes[i + 1, j, REST + 1])
        rest_b = m_rest * (near * nodes[i, j, REST + 2] + x * nodes[i + 1, j, REST + 2])
        if paths.shape[0] > 0:
            l_rest = near * paths[i, j, PATH_REST] + x * paths[i + 1, j, PATH_REST]
            rest_r *= grown(extra[0], l_rest)
            rest_g *= grown(extra[1], l_rest)
            rest_b *= grown(extra[2], l_rest)
        red += rest_r
        green += rest_g
        blue += rest_b
    return red, green, blue


@device
def grown(extra, length):
    """What absorption beyond the tables' leaves of light along a path, its length times log₂ e; less than theirs makes
    it grow, within limits."""
    return exp2(min(GROWTH_LIMIT, -extra * length))


@device
def mix(table, i, j, c, w00, w01, w10, w11):
    """Channel c of a table (A, B, C), weighted among the four nodes of a cell. By indices: a row would be a view, and
    views are counted by an atomic instruction."""
    return w00 * table[i, j, c] + w01 * table[i, j + 1, c] + w10 * table[i + 1, j, c] + w11 * table[i + 1, j + 1, c]
