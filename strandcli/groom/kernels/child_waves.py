"""Waves of children, a vector of them at a time, and what comes of their segments: the strands."""

from __future__ import annotations

import numpy as np

from ...constants import W
from ...jit import device, inlined
from ...simd import broadcast, lane_count, load, load3, movemask, pointer, sqrt, store, store3
from .child_path import unit
from .child_scratch import (
    ACROSS,
    COSINE,
    RADIUS,
    REST,
    SINE,
    TURN_COSINE,
    TURN_SINE,
    TURNING,
    WAY,
)
from .inputs import ONSET, ROUNDNESS
from .keep_out import keep_lane_out, way_on

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TINY = np.float32(1e-30)


@device
def write_strands(waves, solids, solid, scratch, first, out, b, k):
    """Turn the paths of children in the lanes from k on of block b of out (blocks, m + 1, 3 W), whose row 0 is the
    direction before the root, into strands: with waves, segments as long as at rest, and outside of solids.

    solid: whether there are solids; scratch: as `child_scratch` says, with the first wave at place ``first``.
    """
    x, own = pointer(out), pointer(scratch)
    m = out.shape[1] - 1
    top = b * (m + 1) * 3 * W + k
    rest = load(own, REST * W + k)
    px, py, pz = load3(x, top + 3 * W, W)
    dx, dy, dz = load3(x, top, W)
    size = rest / sqrt(max(dx * dx + dy * dy + dz * dz, TINY))
    store3(x, top, W, px + size * dx, py + size * dy, pz + size * dz)
    ax, ay, az = load3(own, ACROSS * W + k, W)
    # previous, this and next point of the path, and the previous one with waves
    bx, by, bz = px, py, pz
    wx, wy, wz = px, py, pz
    hx, hy, hz = load3(x, top + min(2, m) * 3 * W, W)
    for j in range(2, m + 1):
        nx, ny, nz = load3(x, top + min(j + 1, m) * 3 * W, W)
        vx, vy, vz = hx, hy, hz
        if waves.forms.shape[0] > 0:
            ax, ay, az, tx, ty, tz = carried_across(ax, ay, az, nx - bx, ny - by, nz - bz)
            f, g = next_waves(waves, own, first + k, np.float32(j - 1) / np.float32(m - 1))
            vx = hx + f * ax + g * (ty * az - tz * ay)
            vy = hy + f * ay + g * (tz * ax - tx * az)
            vz = hz + f * az + g * (tx * ay - ty * ax)
        ex, ey, ez = unit(vx - wx, vy - wy, vz - wz)
        wx, wy, wz = vx, vy, vz
        px, py, pz = px + rest * ex, py + rest * ey, pz + rest * ez
        store3(x, top + j * 3 * W, W, px, py, pz)
        if solid:
            way = load(own, WAY * W + k) - rest
            left = movemask(~(way > 0.0))
            if left != 0:
                way = max(way, way_on(solids, px, py, pz, rest))
                left = movemask(~(way > 0.0))
            store(own, WAY * W + k, way)
            if left != 0:
                for lane in range(k, k + lane_count(x)):
                    if (left >> (lane - k)) & 1:
                        scratch[WAY * W + lane] = keep_lane_out(out, b, j, lane, scratch[REST * W + lane], solids)
                px, py, pz = load3(x, top + j * 3 * W, W)
        bx, by, bz = hx, hy, hz
        hx, hy, hz = nx, ny, nz


@inlined
def carried_across(ax, ay, az, tx, ty, tz):
    """Return unit vectors a of the row before, made perpendicular to tangents t, and these, of unit length."""
    tx, ty, tz = unit(tx, ty, tz)
    d = ax * tx + ay * ty + az * tz
    ax, ay, az = unit(ax - d * tx, ay - d * ty, az - d * tz)
    return ax, ay, az, tx, ty, tz


@inlined
def next_waves(waves, own, first, share):
    """Return how far all waves displace the next particle, at a share of the length, along the vector across and along
    what is perpendicular to that and to the strand, metres. Waves are at place ``first`` of rows; each is turned there
    by the angle to that particle."""
    f = g = broadcast(own, ZERO)
    for w in range(waves.forms.shape[0]):
        at = first + w * TURNING * W
        c, s = load(own, at + COSINE * W), load(own, at + SINE * W)
        tc, ts = load(own, at + TURN_COSINE * W), load(own, at + TURN_SINE * W)
        c, s = c * tc - s * ts, s * tc + c * ts
        store(own, at + COSINE * W, c)
        store(own, at + SINE * W, s)
        size = load(own, at + RADIUS * W) * min(share / max(waves.forms[w, ONSET], TINY), ONE)
        f = f + size * c
        g = g + size * waves.forms[w, ROUNDNESS] * s
    return f, g
