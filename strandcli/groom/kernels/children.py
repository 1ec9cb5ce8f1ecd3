"""Drawn strands from simulated ones: which guides each follows, and where it lies.

Guides come as particles g (G, m + 1, 3), in finer steps than they were simulated where waves want them; row 0 stands
one segment before the root, row j + 1 is particle j. A child at the share u of its guides' length lies at

    c(u) = root + Σ w_k (g_k(u) − g_k(0)),

each clump moves it toward the child in its middle, c += w(u) (c_middle(u) − c), and each wave winds about what has
come of it. Segments get their lengths again, root to tip, after each of the two: after clumps they turn toward where
the particles were moved, so that the tips of a lock still meet; after waves they keep their directions, so that a wave
is not smoothed. Last, particles leave the solids they are in.
"""

from __future__ import annotations

import math

import numpy as np

from ...constants import W
from ...jit import device, parallel, prange
from ...solids.kernels.outside import count as count_solids
from ...solids.kernels.outside import outside

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-30)
CLEAR = np.float32(0.03)
"""Shares of a segment by which particles are kept clear of solids: the segment between two bulges inward."""
TOWARD = np.float32(0.3)
"""Part of its distance from its aim that a strand is turned toward it within a segment."""
ROUNDS = 3


@parallel
def nearest(points, others, order, out, distances):
    """The nearest of others to each point, nearest first.

    points (N, 4), others (G, 4) float32, the latter in the ascending order of their first coordinate, which bounds the
    search; order (G,) int32: what to call each; out (N, K) int32, K <= G; distances (N, K) float32: squared.
    """
    count = others.shape[0]
    most = out.shape[1]
    for i in prange(points.shape[0]):
        found = distances[i]
        names = out[i]
        found[:] = np.float32(np.inf)
        x = points[i, 0]
        low = np.int64(0)
        high = np.int64(count)
        while low < high:
            middle = (low + high) // 2
            if others[middle, 0] < x:
                low = middle + 1
            else:
                high = middle
        right = low
        left = low - 1
        while True:
            before = x - others[left, 0] if left >= 0 else np.float32(np.inf)
            after = others[right, 0] - x if right < count else np.float32(np.inf)
            way = min(before, after)
            if not way * way < found[most - 1]:
                break
            if before < after:
                at = left
                left -= 1
            else:
                at = right
                right += 1
            square = ZERO
            for c in range(4):
                d = points[i, c] - others[at, c]
                square += d * d
            place = most - 1
            if square < found[place]:
                while place > 0 and square < found[place - 1]:
                    found[place] = found[place - 1]
                    names[place] = names[place - 1]
                    place -= 1
                found[place] = square
                names[place] = order[at]


@parallel
def refine(positions, steps, out):
    """Guides (blocks, n + 1, 3 W) in so many steps a segment, on the cubic that central differences give, into
    out (G, (n − 1) steps + 2, 3)."""
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
def grow(
    guides, rests, own, parents, weights, roots, shares, middles, pulls, ramps, waves, radii, turns, phases, across,
    solids, out, lengths,
):  # fmt: skip
    """Place children.

    guides (G, m + 1, 3) and rests (G,), metres a segment; own (N,) int32: which of all A children are placed; of all:
    parents, weights (A, 3), roots (A, 3) metres, shares (A,) of the guides' length, middles (C, A) of their clumps,
    from wide to narrow, pulls (C, A), radii (V, A) metres of waves, turns (V, A) radians a metre, phases (V, A)
    radians, across (A, 3) unit vectors at which waves begin; ramps (C, m): a clump's share along a guide; waves (V, 2):
    roundness, onset; solids packed; out (blocks, m + 1, 3 W) and lengths (blocks, W), the last block padded with copies
    of the last child.
    """
    m = guides.shape[1] - 1
    edge = np.float32(m - 1)
    count = own.shape[0]
    for block in prange(out.shape[0]):
        b = np.int64(block)  # the index is unsigned, and would have `lay` compiled twice
        path = np.empty((m + 1, 3), np.float32)
        for lane in range(W):
            i = own[min(b * W + lane, count - 1)]
            share = shares[i]
            rest = ZERO
            for p in range(parents.shape[1]):
                rest += weights[i, p] * rests[parents[i, p]]
            rest *= share
            for j in range(m):
                u = min(np.float32(j) * share, edge)
                low = min(np.int64(u), m - 2)
                t = u - np.float32(low)
                x, y, z = base(guides, parents, weights, roots, i, low, t)
                for level in range(middles.shape[0] - 1, -1, -1):
                    pull = pulls[level, i] * (ramps[level, low] + t * (ramps[level, low + 1] - ramps[level, low]))
                    if pull > ZERO:
                        ax, ay, az = base(guides, parents, weights, roots, middles[level, i], low, t)
                        x += pull * (ax - x)
                        y += pull * (ay - y)
                        z += pull * (az - z)
                path[j + 1, 0] = x
                path[j + 1, 1] = y
                path[j + 1, 2] = z
            straighten(path, rest)
            # the row before the root: the direction there
            for c in range(3):
                back = ZERO
                for p in range(parents.shape[1]):
                    g = parents[i, p]
                    back += weights[i, p] * (guides[g, 0, c] - guides[g, 1, c])
                path[0, c] = back
            lay(path, i, rest, waves, radii, turns, phases, across, solids, out, b, lane)
            lengths[b, lane] = rest


@device
def base(guides, parents, weights, roots, i, low, t):
    """Child number i between rows low and low + 1 of its guides, without clumps and waves."""
    x = roots[i, 0]
    y = roots[i, 1]
    z = roots[i, 2]
    for p in range(parents.shape[1]):
        g = parents[i, p]
        w = weights[i, p]
        if w > ZERO:
            x += w * (mix(guides, g, low, np.int64(0), t) - guides[g, 1, 0])
            y += w * (mix(guides, g, low, np.int64(1), t) - guides[g, 1, 1])
            z += w * (mix(guides, g, low, np.int64(2), t) - guides[g, 1, 2])
    return x, y, z


@device
def mix(guides, g, low, c, t):
    """Coordinate c of guide g between two particles."""
    a = guides[g, low + 1, c]
    return a + t * (guides[g, low + 2, c] - a)


@device
def straighten(path, rest):
    """Give the segments of a path (m + 1, 3), of which row 0 does not count, the length ``rest``, root to tip: each in
    its own direction, turned toward where the path was before by its distance across."""
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
def lay(path, i, rest, waves, radii, turns, phases, across, solids, out, b, lane):
    """Wind the waves about a path, root to tip, give its segments their length, and write it."""
    m = path.shape[0] - 1
    solid = count_solids(solids) > 0
    clear = CLEAR * rest
    # where the wound path was, and where the strand is
    wx = px = path[1, 0]
    wy = py = path[1, 1]
    wz = pz = path[1, 2]
    ax = across[i, 0]
    ay = across[i, 1]
    az = across[i, 2]
    size = rest / math.sqrt(max(path[0, 0] ** 2 + path[0, 1] ** 2 + path[0, 2] ** 2, TINY))
    for c in range(3):
        out[b, 0, c * W + lane] = path[1, c] + size * path[0, c]
        out[b, 1, c * W + lane] = path[1, c]
    for j in range(2, m + 1):
        x = path[j, 0]
        y = path[j, 1]
        z = path[j, 2]
        if waves.shape[0] > 0:
            after = min(j + 1, m)
            tx, ty, tz = unit(path[after, 0] - path[j - 1, 0], path[after, 1] - path[j - 1, 1],
                              path[after, 2] - path[j - 1, 2])  # fmt: skip
            # carried along without a turn about the path
            d = ax * tx + ay * ty + az * tz
            ax, ay, az = unit(ax - d * tx, ay - d * ty, az - d * tz)
            bx = ty * az - tz * ay
            by = tz * ax - tx * az
            bz = tx * ay - ty * ax
            along = np.float32(j - 1)
            share = along / np.float32(m - 1)
            for w in range(waves.shape[0]):
                angle = phases[w, i] + turns[w, i] * along * rest
                size = radii[w, i] * min(share / max(waves[w, 1], TINY), ONE)
                f = size * math.cos(angle)
                g = size * waves[w, 0] * math.sin(angle)
                x += f * ax + g * bx
                y += f * ay + g * by
                z += f * az + g * bz
        ex, ey, ez = unit(x - wx, y - wy, z - wz)
        wx = x
        wy = y
        wz = z
        px += rest * ex
        py += rest * ey
        pz += rest * ez
        if solid:
            for _ in range(ROUNDS):  # out of one solid may be into another, and off the segment's length
                qx, qy, qz = outside(px, py, pz, clear, solids)
                if qx == px and qy == py and qz == pz:
                    break
                ox = out[b, j - 1, lane]
                oy = out[b, j - 1, W + lane]
                oz = out[b, j - 1, 2 * W + lane]
                ex, ey, ez = unit(qx - ox, qy - oy, qz - oz)
                px, py, pz = outside(
                    ox + rest * ex, oy + rest * ey, oz + rest * ez, clear, solids
                )
        out[b, j, lane] = px
        out[b, j, W + lane] = py
        out[b, j, 2 * W + lane] = pz


@device
def unit(x, y, z):
    """A vector's direction."""
    size = ONE / math.sqrt(max(x * x + y * y + z * z, TINY))
    return x * size, y * size, z * size
