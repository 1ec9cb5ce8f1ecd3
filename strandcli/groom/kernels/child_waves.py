"""Strands from the paths of children, a vector of them at a time: segments of the length that they have at rest, waves,
and outside of solids."""

from __future__ import annotations

import numpy as np

from ...constants import VECTOR, W
from ...jit import device, inlined
from ...simd import broadcast, floor, gather8, lane_count, load, load3, movemask, pointer, sqrt, store, store3
from ...simd.turning import cosine_sine
from .inputs import ONSET, ROUNDNESS
from .keep_out import keep_lane_out, move_out

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
TINY = np.float32(1e-30)
LANES = np.arange(VECTOR // 4, dtype=np.float32)
"""The numbers of lanes."""
TOWARD = np.float32(0.3)
"""Share of its lateral distance from the target path that a strand corrects within a segment."""
REST, SHARE, REACH, ACROSS, FIRST_WAVE = 0, 1, 2, 3, 6
"""First rows: segment length, metres; ratio of the length to that of the guides; metres that a strand may go on before
any solid can be met; x, y, z of the unit vector across. Then follow `TURNING` rows of each wave."""
RADIUS, COSINE, SINE, TURN_COSINE, TURN_SINE = 0, 1, 2, 3, 4
"""Rows of a wave: its amplitude, metres; cosine and sine of its angle at a particle, and of the angle to the next."""
TURNING = 5


@device
def load_children(guides, following, waves, own, begin, scratch, lengths):
    """Store what the W children from place ``begin`` of ``own`` on need in the lanes of scratch (rows W,), and their
    segment lengths, metres, in lengths (W,); lanes past the end have the last child. Places are not negative, and none
    is tested."""
    last = np.uint64(own.shape[0] - 1)
    for lane in range(np.uint64(W)):
        i = np.uint64(own[min(np.uint64(begin) + lane, last)])
        rest = ZERO
        for p in range(np.uint64(following.parents.shape[1])):
            rest += following.weights[i, p] * guides.segments[np.uint64(following.parents[i, p])]
        rest *= following.shares[i]
        scratch[np.uint64(REST * W) + lane] = rest
        scratch[np.uint64(SHARE * W) + lane] = following.shares[i]
        scratch[np.uint64(REACH * W) + lane] = ZERO
        for c in range(np.uint64(3)):
            scratch[np.uint64(ACROSS * W) + c * np.uint64(W) + lane] = waves.across[i, c]
        for w in range(np.uint64(waves.forms.shape[0])):
            at = (np.uint64(FIRST_WAVE) + w * np.uint64(TURNING)) * np.uint64(W) + lane
            scratch[at + np.uint64(RADIUS * W)] = waves.radii[i, w]
            scratch[at + np.uint64(COSINE * W)] = waves.phases[i, w]
            scratch[at + np.uint64(TURN_COSINE * W)] = waves.turns[i, w] * rest
        lengths[lane] = rest
    rows = pointer(scratch)
    for first in range(FIRST_WAVE * W, (FIRST_WAVE + waves.forms.shape[0] * TURNING) * W, TURNING * W):
        for k in range(first, first + W, lane_count(rows)):
            turn_wave(rows, k + COSINE * W)
            turn_wave(rows, k + TURN_COSINE * W)


@device
def turn_wave(rows, o):
    """Store the cosines of the angles at place o of rows there, and their sines in the row after it."""
    cosine, sine = cosine_sine(load(rows, o))
    store(rows, o, cosine)
    store(rows, o + W, sine)


@device
def write_strands(waves, solids, solid, paths, size, scratch, out, b, k):
    """Write strands to the lanes from k on of block b of out (blocks, m + 1, 3 W), metres, with row 0 one segment
    before the root: with waves, segments as long as at rest, and outside of solids.

    solid: whether there are solids; paths: rows of ``size`` numbers, one a lane, as `write_path` writes them; scratch:
    that of `load_children`.
    """
    x, own = pointer(out), pointer(scratch)
    m = out.shape[1] - 1
    top = b * (m + 1) * 3 * W + k
    rest, share = load(own, REST * W + k), load(own, SHARE * W + k)
    pace = rest, TOWARD / max(rest, TINY)
    dx, dy, dz, px, py, pz, _, _ = gather8(paths, 0, load(pointer(LANES), 0), size, ZERO)
    dx, dy, dz = unit(dx - px, dy - py, dz - pz)
    store3(x, top, W, px + rest * dx, py + rest * dy, pz + rest * dz)
    store3(x, top + 3 * W, W, px, py, pz)
    ax, ay, az = load3(own, ACROSS * W + k, W)
    # previous and this point of the path, the last one of the target path, and the previous one with waves
    bx, by, bz = px, py, pz
    target = on_path(paths, size, share, np.float32(1), np.float32(m))
    hx, hy, hz = next_point((px, py, pz), (px, py, pz), target, pace)
    wx, wy, wz = px, py, pz
    for j in range(2, m + 1):
        nx, ny, nz = hx, hy, hz
        if j < m:
            past = target
            target = on_path(paths, size, share, np.float32(j), np.float32(m))
            nx, ny, nz = next_point((hx, hy, hz), past, target, pace)
        vx, vy, vz = hx, hy, hz
        if waves.forms.shape[0] > 0:
            ax, ay, az, tx, ty, tz = carried_across(ax, ay, az, nx - bx, ny - by, nz - bz)
            f, g = next_waves(waves, own, FIRST_WAVE * W + k, np.float32(j - 1) / np.float32(m - 1))
            vx = hx + f * ax + g * (ty * az - tz * ay)
            vy = hy + f * ay + g * (tz * ax - tx * az)
            vz = hz + f * az + g * (tx * ay - ty * ax)
        ex, ey, ez = unit(vx - wx, vy - wy, vz - wz)
        wx, wy, wz = vx, vy, vz
        px, py, pz = px + rest * ex, py + rest * ey, pz + rest * ez
        store3(x, top + j * 3 * W, W, px, py, pz)
        if solid:
            reach = load(own, REACH * W + k) - rest
            left = movemask(~(reach > 0.0))
            if left != 0:
                before = load3(x, top + (j - 1) * 3 * W, W)
                px, py, pz, reach, left = move_out(solids, (px, py, pz), before, rest, reach)
                store3(x, top + j * 3 * W, W, px, py, pz)
            store(own, REACH * W + k, reach)
            if left != 0:
                for lane in range(k, k + lane_count(x)):
                    if (left >> (lane - k)) & 1:
                        keep_lane_out(out, b, j, lane, scratch[REST * W + lane], solids)
                px, py, pz = load3(x, top + j * 3 * W, W)
        bx, by, bz = hx, hy, hz
        hx, hy, hz = nx, ny, nz


@inlined
def on_path(paths, size, share, j, m):
    """Return the points of target paths, of ``m`` particles, metres, for particle j of children whose length is that
    share of their guides'."""
    u = min(share * j, m - ONE)
    low = floor(min(u, m - TWO))
    t = u - low
    ax, ay, az, bx, by, bz, _, _ = gather8(paths, 3, load(pointer(LANES), 0), size, low * 3.0)
    return ax + t * (bx - ax), ay + t * (by - ay), az + t * (bz - az)


@inlined
def next_point(p, q, target, pace):
    """Return the points that follow points p of paths, metres, where target paths go from points q to ``target``.

    A segment has the direction of the target path, turned toward that in proportion to the lateral distance from it.
    pace: the segments' length, and how far they turn for each metre."""
    rest, per = pace
    tx, ty, tz = unit(target[0] - q[0], target[1] - q[1], target[2] - q[2])
    ex, ey, ez = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    along = ex * tx + ey * ty + ez * tz
    tx, ty, tz = unit(tx + per * (ex - along * tx), ty + per * (ey - along * ty), tz + per * (ez - along * tz))
    return p[0] + rest * tx, p[1] + rest * ty, p[2] + rest * tz


@inlined
def unit(x, y, z):
    """Return the unit vectors of vectors."""
    size = 1.0 / sqrt(max(x * x + y * y + z * z, TINY))
    return x * size, y * size, z * size


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
