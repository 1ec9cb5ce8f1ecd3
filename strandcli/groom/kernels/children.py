"""Interpolation of children, the drawn strands, from guides, the simulated ones.

Guides are particles g (G, m + 1, 3), subdivided if waves need it; row 0 is one segment before the root, row j + 1 is
particle j. A child at the share u of its guides' length lies at

    c(u) = root + Σ w_k (g_k(u) − g_k(0)),

each clump moves it toward the child at its centre, c += w(u) (c_centre(u) − c), and each wave displaces the result
perpendicular to the path. Segment lengths are restored, root to tip, after clumps and after waves: after clumps,
segments turn toward the displaced particles, so that the tips of a clump still meet; after waves they keep their
directions, so that a wave is not smoothed. Last, particles are moved out of solids.
"""

from __future__ import annotations

import math

import numpy as np

from ...constants import W
from ...jit import device, parallel, prange
from ...solids.kernels import built_in, other
from ...solids.kernels.outside import count as count_solids
from ...solids.kernels.outside import outside
from .inputs import ONSET, ROUNDNESS

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-30)
CLEAR = np.float32(0.1)
"""Distance of particles from solids as a share of a segment: between two particles a curve lies below the surface of a
solid, and triangles may lie above their grid of distances."""
TOWARD = np.float32(0.3)
"""Share of its lateral distance from the target path that a strand corrects within a segment."""
ROUNDS = 3
SURE = np.float32(0.55)
"""Share of the distance from solids that a strand may go on unexamined: distances that are linear along the axes
between nodes of a grid grow by √3 a metre at most."""


@parallel
def refine(positions, steps, out):
    """Write guides (blocks, n + 1, 3 W), subdivided into `steps` parts a segment on cubic Hermite curves with central
    differences, to out (G, (n − 1) steps + 2, 3)."""
    n = positions.shape[1] - 1
    per = ONE / np.float32(steps)
    for s in prange(out.shape[0]):
        block = positions[s // W]
        lane = s % W
        for c in range(3):
            k = c * W + lane
            a = block[1, k]
            out[s, 0, c] = a + (block[0, k] - a) * per
            out[s, 1, c] = a
            first = HALF * (block[2, k] - block[0, k])
            for i in range(1, n):
                b = block[i + 1, k]
                last = HALF * (block[i + 2, k] - a) if i + 1 < n else b - a
                e = b - a
                for j in range(1, steps):
                    t = np.float32(j) * per
                    bend = (first + last - e - e) * t + (e + e + e - first - first - last)
                    out[s, 1 + (i - 1) * steps + j, c] = a + t * (first + t * bend)
                out[s, 1 + i * steps, c] = b
                first = last
                a = b


@parallel
def grow(guides, own, following, clumps, waves, solids, out, lengths):
    """Write children of `Guides` to out (blocks, m + 1, 3 W), metres, and their segment lengths to lengths (blocks, W).

    own (N,) int32: numbers of the children to write; `Following`, `Clumps` and `Waves` hold all A children; solids:
    packed `Solids`. The last block is padded with copies of the last child.
    """
    m = guides.particles.shape[1] - 1
    edge = np.float32(m - 1)
    count = own.shape[0]
    for block in prange(out.shape[0]):
        b = np.int64(block)  # the index is unsigned, and would have `write_strand` compiled twice
        path = np.empty((m + 1, 3), np.float32)
        for lane in range(W):
            i = own[min(b * W + lane, count - 1)]
            share = following.shares[i]
            rest = segment_length(guides, following, i) * share
            for j in range(m):
                u = min(np.float32(j) * share, edge)
                low = min(np.int64(u), m - 2)
                t = u - np.float32(low)
                x, y, z = interpolate_guides(guides, following, i, low, t)
                for level in range(clumps.middles.shape[0] - 1, -1, -1):
                    ramp = clumps.ramps[level, low]
                    pull = clumps.pulls[level, i] * (ramp + t * (clumps.ramps[level, low + 1] - ramp))
                    if pull > ZERO:
                        ax, ay, az = interpolate_guides(guides, following, clumps.middles[level, i], low, t)
                        x += pull * (ax - x)
                        y += pull * (ay - y)
                        z += pull * (az - z)
                path[j + 1, 0] = x
                path[j + 1, 1] = y
                path[j + 1, 2] = z
            restore_lengths(path, rest)
            # row 0: the direction at the root
            for c in range(3):
                back = ZERO
                for p in range(following.parents.shape[1]):
                    g = following.parents[i, p]
                    back += following.weights[i, p] * (guides.particles[g, 0, c] - guides.particles[g, 1, c])
                path[0, c] = back
            write_strand(path, i, rest, waves, solids, out, b, lane)
            lengths[b, lane] = rest


@device
def segment_length(guides, following, i):
    """Return the segment length of child i, metres, without its own share of the length."""
    rest = ZERO
    for p in range(following.parents.shape[1]):
        rest += following.weights[i, p] * guides.segments[following.parents[i, p]]
    return rest


@device
def interpolate_guides(guides, following, i, low, t):
    """Return the point of child i at the share t between particles low and low + 1 of its guides, metres, before clumps
    and waves."""
    particles = guides.particles
    x = following.roots[i, 0]
    y = following.roots[i, 1]
    z = following.roots[i, 2]
    for p in range(following.parents.shape[1]):
        g = following.parents[i, p]
        w = following.weights[i, p]
        if w > ZERO:
            x += w * (interpolate(particles, g, low, np.int64(0), t) - particles[g, 1, 0])
            y += w * (interpolate(particles, g, low, np.int64(1), t) - particles[g, 1, 1])
            z += w * (interpolate(particles, g, low, np.int64(2), t) - particles[g, 1, 2])
    return x, y, z


@device
def interpolate(guides, g, low, c, t):
    """Return coordinate c of guide g of guides (G, m + 1, 3) at the share t between particles low and low + 1."""
    a = guides[g, low + 1, c]
    return a + t * (guides[g, low + 2, c] - a)


@device
def restore_lengths(path, rest):
    """Set the segments of a path (m + 1, 3) from row 1 on to the length ``rest``, root to tip. Each keeps its
    direction, turned toward the original path in proportion to the lateral distance from it."""
    qx = path[1, 0]
    qy = path[1, 1]
    qz = path[1, 2]
    per = TOWARD / max(rest, TINY)
    for j in range(2, path.shape[0]):
        px = path[j - 1, 0]
        py = path[j - 1, 1]
        pz = path[j - 1, 2]
        tx, ty, tz = unit(path[j, 0] - qx, path[j, 1] - qy, path[j, 2] - qz)
        ex = qx - px
        ey = qy - py
        ez = qz - pz
        along = ex * tx + ey * ty + ez * tz
        qx = path[j, 0]
        qy = path[j, 1]
        qz = path[j, 2]
        tx, ty, tz = unit(tx + per * (ex - along * tx), ty + per * (ey - along * ty), tz + per * (ez - along * tz))
        path[j, 0] = px + rest * tx
        path[j, 1] = py + rest * ty
        path[j, 2] = pz + rest * tz


@device
def write_strand(path, i, rest, waves, solids, out, b, lane):
    """Write child i to a lane of block b of out: its path (m + 1, 3), whose row 0 is the direction before the root,
    with waves, segments of the length ``rest``, and outside of solids."""
    m = path.shape[0] - 1
    solid = count_solids(solids) > 0
    mixed = built_in.count(solids) > 0
    free = ZERO  # metres that the strand may go on before any solid can be met
    # previous points of the path with waves (w), and of the strand (p)
    wx = px = path[1, 0]
    wy = py = path[1, 1]
    wz = pz = path[1, 2]
    ax = waves.across[i, 0]
    ay = waves.across[i, 1]
    az = waves.across[i, 2]
    size = rest / math.sqrt(max(path[0, 0] ** 2 + path[0, 1] ** 2 + path[0, 2] ** 2, TINY))
    for c in range(3):
        out[b, 0, c * W + lane] = path[1, c] + size * path[0, c]
        out[b, 1, c * W + lane] = path[1, c]
    for j in range(2, m + 1):
        x = path[j, 0]
        y = path[j, 1]
        z = path[j, 2]
        if waves.forms.shape[0] > 0:
            ax, ay, az, x, y, z = add_waves(path, j, i, rest, waves, ax, ay, az)
        ex, ey, ez = unit(x - wx, y - wy, z - wz)
        wx = x
        wy = y
        wz = z
        ox = px
        oy = py
        oz = pz
        px += rest * ex
        py += rest * ey
        pz += rest * ez
        if solid:
            free -= rest
            if not free > ZERO:
                if not mixed:
                    free = SURE * (other.least_distance(solids, px, py, pz) - CLEAR * rest)
                if not free > ZERO:
                    px, py, pz = keep_out(px, py, pz, ox, oy, oz, rest, solids)
        out[b, j, lane] = px
        out[b, j, W + lane] = py
        out[b, j, 2 * W + lane] = pz


@device
def add_waves(path, j, i, rest, waves, ax, ay, az):
    """Return the normal vector of child i at row j of its path, by parallel transport of that at row j − 1,
    (ax, ay, az), and row j displaced by the waves, metres."""
    m = path.shape[0] - 1
    after = min(j + 1, m)
    tx, ty, tz = unit(path[after, 0] - path[j - 1, 0], path[after, 1] - path[j - 1, 1],
                      path[after, 2] - path[j - 1, 2])  # fmt: skip
    d = ax * tx + ay * ty + az * tz
    ax, ay, az = unit(ax - d * tx, ay - d * ty, az - d * tz)
    bx = ty * az - tz * ay
    by = tz * ax - tx * az
    bz = tx * ay - ty * ax
    along = np.float32(j - 1)
    share = along / np.float32(m - 1)
    x = path[j, 0]
    y = path[j, 1]
    z = path[j, 2]
    for w in range(waves.forms.shape[0]):
        angle = waves.phases[w, i] + waves.turns[w, i] * along * rest
        size = waves.radii[w, i] * min(share / max(waves.forms[w, ONSET], TINY), ONE)
        f = size * math.cos(angle)
        g = size * waves.forms[w, ROUNDNESS] * math.sin(angle)
        x += f * ax + g * bx
        y += f * ay + g * by
        z += f * az + g * bz
    return ax, ay, az, x, y, z


@device
def keep_out(x, y, z, ox, oy, oz, rest, solids):
    """Return a particle (x, y, z), moved out of solids and to the distance ``rest`` from the particle before it,
    (ox, oy, oz), as nearly as `ROUNDS` iterations achieve; metres."""
    clear = CLEAR * rest
    for _ in range(ROUNDS):  # out of one solid may be into another, and changes the length
        qx, qy, qz = outside(x, y, z, clear, solids)
        if qx == x and qy == y and qz == z:
            break
        ex, ey, ez = unit(qx - ox, qy - oy, qz - oz)
        x, y, z = outside(ox + rest * ex, oy + rest * ey, oz + rest * ez, clear, solids)
    return x, y, z


@device
def unit(x, y, z):
    """Return the unit vector of a vector."""
    size = ONE / math.sqrt(max(x * x + y * y + z * z, TINY))
    return x * size, y * size, z * size
