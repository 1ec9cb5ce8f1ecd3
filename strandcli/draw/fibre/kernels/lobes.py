"""Azimuthal tables of a strand's lobes, as both models read them (`strandcli.draw.fibre.marschner`,
`strandcli.draw.fibre.chiang`).

A node holds R, which is colourless, TT and TRT in red, green and blue, and with Chiang's model all that leaves after
more inner reflections.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ....constants import W
from ....jit import device, inlined
from ....simd import any_lane, floor, gather, gather2, gather4, lane_count, load, load3, pointer, store3, where
from ...common.kernels import batch
from ...common.kernels.approximations import exp2, exp2_lanes
from ...common.kernels.batch import ARRIVES, EXTRA, NODE_X, NODE_Y, RADIANCE
from ...common.kernels.light_columns import POWER_B, POWER_G, POWER_R
from ...common.kernels.numbers import ONE, ZERO
from ...coverage.kernels.width_profiles import COLUMNS, azimuth

GROWTH_LIMIT = np.float32(40.0)
"""Of the exponent of 2 in `grown`, so that results are finite."""
ALL = np.int64(0)
"""First of all channels."""
R, TT, TRT, REST = (np.int64(c) for c in (0, 1, 4, 7))
"""Channels of a node."""
PATH_TT, PATH_TRT, PATH_REST = (np.int64(c) for c in range(3))
"""Columns of mean paths."""


@device
def add_lobes(work, n, lights, i, rest, tables):
    """Add what the lobes scatter of light number i to the radiance of the first n vertices of a batch.

    work: rows of `batch`, of which `NODE_X`, `NODE_Y`, R, TT and TRT hold what `longitudinal` gave; rest: the row with
    M of the rest, None with tables that have none; tables: `MarschnerArrays` or `ChiangArrays`, read four channels at
    a time.
    """
    for k in range(n, W):  # the unused lanes of the last vector must read valid nodes, and write nothing
        work[batch.NODE_X + k] = work[batch.NODE_Y + k] = work[ARRIVES + k] = ZERO
    rows = pointer(work)
    for k in range(0, n, lane_count(rows)):
        arrives = load(rows, ARRIVES + k)
        lit = arrives > ZERO
        if not any_lane(lit):
            continue
        m = load(rows, batch.R + k), load(rows, batch.TT + k), load(rows, batch.TRT + k)
        x, y = load(rows, batch.NODE_X + k), load(rows, batch.NODE_Y + k)
        node_x, node_y = floor(x), floor(y)
        place = place_at(node_x, node_y, x - node_x, y - node_y)
        red, green, blue = azimuthal_lanes(m, place, tables, load3(rows, EXTRA + k, W))
        if rest is not None:
            r, g, b = rest_lanes(load(rows, rest + k), place, tables, load3(rows, EXTRA + k, W))
            red, green, blue = red + r, green + g, blue + b
        r, g, b = load3(rows, RADIANCE + k, W)
        store3(
            rows, RADIANCE + k, W,
            where(lit, r + arrives * lights[i, POWER_R] * red, r),
            where(lit, g + arrives * lights[i, POWER_G] * green, g),
            where(lit, b + arrives * lights[i, POWER_B] * blue, b),
        )  # fmt: skip


class Place(NamedTuple):
    """A place in the tables; all numbers are vectors."""

    i: Any
    """Row of nodes."""
    j: Any
    """Node in that row."""
    x: Any
    """How far it is from that row to the next, 0 to 1."""
    w00: Any
    """Weights of the four nodes about it: this row's node j, its node j + 1, the same of the next row."""
    w01: Any
    w10: Any
    w11: Any


@inlined
def place_at(i, j, x, y):
    """Return the place at x and y, 0 to 1, between node (i, j) and the next ones."""
    w11 = x * y
    w01 = y - w11
    return Place(i, j, x, ONE - x - w01, w01, x - w11, w11)


@device
def azimuthal_lanes(m, place, tables, extra):
    """Return S cos θ_l in red, green and blue, 1/sr, without the rest: the tables at a `Place`, weighted with m, M of
    R, TT and TRT. Vectors.

    tables: nodes (n_θ, n_φ, 8 or more) and paths (n_θ, n_φ, 2 or more), without nodes where every strand has the
    tables' absorption; extra: this strand's absorption less that of the tables, 1/radius.
    """
    _, tt_r, tt_g, tt_b = first = mixed(tables.nodes, ALL, place)
    trt_r, trt_g, trt_b, _ = mixed(tables.nodes, TRT, place)
    m_r, m_tt, m_trt = m
    tt_r, tt_g, tt_b = m_tt * tt_r, m_tt * tt_g, m_tt * tt_b
    trt_r, trt_g, trt_b = m_trt * trt_r, m_trt * trt_g, m_trt * trt_b
    if tables.paths.shape[0] > 0:
        l_tt, l_trt = mixed_pair(tables.paths, ALL, place)
        tt_r = tt_r * left_of(extra[0], l_tt)
        tt_g = tt_g * left_of(extra[1], l_tt)
        tt_b = tt_b * left_of(extra[2], l_tt)
        trt_r = trt_r * left_of(extra[0], l_trt)
        trt_g = trt_g * left_of(extra[1], l_trt)
        trt_b = trt_b * left_of(extra[2], l_trt)
    r = m_r * first[0]
    return r + tt_r + trt_r, r + tt_g + trt_g, r + tt_b + trt_b


@device
def rest_lanes(m, place, tables, extra):
    """Return what the rest adds to `azimuthal_lanes`; m: its M. It does not vary along a row of nodes, so it is
    interpolated between two rows."""
    rows, paths, width = pointer(tables.nodes), pointer(tables.paths), tables.nodes.shape[2]
    node, next_row = place.i * np.float32(tables.nodes.shape[1]) + place.j, tables.nodes.shape[1]
    a, b = gather4(rows, REST, node, width, ZERO), gather4(rows, REST + width * next_row, node, width, ZERO)
    near, x = ONE - place.x, place.x
    red, green, blue = m * (near * a[0] + x * b[0]), m * (near * a[1] + x * b[1]), m * (near * a[2] + x * b[2])
    if tables.paths.shape[0] > 0:
        width = tables.paths.shape[2]
        low = gather(paths, PATH_REST, node, width, ZERO)
        length = near * low + x * gather(paths, PATH_REST + width * next_row, node, width, ZERO)
        red, green, blue = (
            red * left_of(extra[0], length), green * left_of(extra[1], length), blue * left_of(extra[2], length)
        )  # fmt: skip
    return red, green, blue


@inlined
def mixed(table, c, place):
    """Return channels c to c + 3 of a table (A, B, C), weighted among the four nodes of a cell. Vectors."""
    rows, width = pointer(table), table.shape[2]
    node = place.i * np.float32(table.shape[1]) + place.j
    across = c + width * table.shape[1]
    a, b = gather4(rows, c, node, width, ZERO), gather4(rows, c + width, node, width, ZERO)
    d, e = gather4(rows, across, node, width, ZERO), gather4(rows, across + width, node, width, ZERO)
    w00, w01, w10, w11 = place.w00, place.w01, place.w10, place.w11
    return (
        w00 * a[0] + w01 * b[0] + w10 * d[0] + w11 * e[0], w00 * a[1] + w01 * b[1] + w10 * d[1] + w11 * e[1],
        w00 * a[2] + w01 * b[2] + w10 * d[2] + w11 * e[2], w00 * a[3] + w01 * b[3] + w10 * d[3] + w11 * e[3],
    )  # fmt: skip


@inlined
def mixed_pair(table, c, place):
    """Return channels c and c + 1 of a table, as `mixed`."""
    rows, width = pointer(table), table.shape[2]
    node = place.i * np.float32(table.shape[1]) + place.j
    across = c + width * table.shape[1]
    a, b = gather2(rows, c, node, width, ZERO), gather2(rows, c + width, node, width, ZERO)
    d, e = gather2(rows, across, node, width, ZERO), gather2(rows, across + width, node, width, ZERO)
    w00, w01, w10, w11 = place.w00, place.w01, place.w10, place.w11
    return (
        w00 * a[0] + w01 * b[0] + w10 * d[0] + w11 * e[0], w00 * a[1] + w01 * b[1] + w10 * d[1] + w11 * e[1]
    )  # fmt: skip


@inlined
def left_of(extra, length):
    """As `grown`, with vectors."""
    return exp2_lanes(min(GROWTH_LIMIT, -extra * length))


@device
def grown(extra, length):
    """What absorption beyond the tables' leaves of light along a path, its length times log₂ e; less than theirs makes
    it grow, within limits."""
    return exp2(min(GROWTH_LIMIT, -extra * length))


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
            m_r = light * work[batch.R + k]
            m_tt = light * work[batch.TT + k]
            m_trt = light * work[batch.TRT + k]
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
