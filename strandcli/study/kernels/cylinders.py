"""Light between strands, exactly: parallel rays against every piece of every strand, in double precision.

Strands are gone through in runs of some pieces, each with a ball about it, so that what is far away takes one look.
"""

from __future__ import annotations

import math

import numpy as np

from ...jit import function, inlined, parallel, prange

RUN = 8
"""Pieces of a run."""
X, Y, Z, RADIUS = range(4)
"""Columns of the bounding balls of runs, metres."""


@parallel
def transmittance(first, world, radii, probes, own, frames, reaches, jitter, wide, out):
    """Share of each probe's rays that meet no strand but its own, by halves of the rays.

    first (S + 1,) int64, world (V, 3), radii (V,): polylines as cylinders with round ends; probes (P, 3); own (P,) the
    strand that each probe is on, or −1; frames (P, 3, 3): two axes across the light and the way to it; reaches (P,)
    metres to the light; jitter (R, 2): where the rays start across, in units of wide (P,) metres; out (P, 2): of the
    even and the odd rays. All but indices float64. Seen along the rays a piece is a flat band: a ray meets it where its
    point lies within the radius of the band's middle line, and not behind the probe or the light.
    """
    rays = jitter.shape[0]
    most = 0.0
    for k in range(rays):
        most = max(most, math.sqrt(jitter[k, 0] ** 2 + jitter[k, 1] ** 2))
    runs = np.zeros(first.shape[0], np.int64)
    balls = np.empty((count_runs(first, runs), 4))
    enclose(first, runs, world, radii, balls)
    for p in prange(probes.shape[0]):
        hit = np.zeros(rays, np.uint8)
        for s in range(first.shape[0] - 1):
            if s == own[p]:
                continue
            for run in range(runs[s], runs[s + 1]):
                bx, by, bz = seen(frames, probes, p, balls[run, X], balls[run, Y], balls[run, Z])
                radius = balls[run, RADIUS]
                room = most * wide[p] + radius
                if bx * bx + by * by > room * room or bz + radius < 0.0 or bz - radius > reaches[p]:
                    continue
                start = first[s] + (run - runs[s]) * RUN
                ax, ay, az = 0.0, 0.0, 0.0
                for v in range(start, min(start + RUN + 1, first[s + 1])):
                    bx, by, bz = seen(frames, probes, p, world[v, 0], world[v, 1], world[v, 2])
                    if v > start:
                        r = 0.5 * (radii[v - 1] + radii[v])
                        room = most * wide[p] + r
                        aside = min(ax, bx) > room or max(ax, bx) < -room or min(ay, by) > room or max(ay, by) < -room
                        if not aside and max(az, bz) > 0.0 and min(az, bz) < reaches[p]:
                            ex = bx - ax
                            ey = by - ay
                            e = ex * ex + ey * ey
                            for k in range(rays):
                                dx = wide[p] * jitter[k, 0] - ax
                                dy = wide[p] * jitter[k, 1] - ay
                                t = min(max((dx * ex + dy * ey) / e, 0.0), 1.0) if e > 0.0 else 0.5
                                gx = dx - t * ex
                                gy = dy - t * ey
                                depth = az + t * (bz - az)
                                if gx * gx + gy * gy < r * r and depth > 0.0 and depth < reaches[p]:
                                    hit[k] = 1
                    ax, ay, az = bx, by, bz
        for half in range(2):
            blocked = 0
            for k in range(half, rays, 2):
                blocked += hit[k]
            out[p, half] = 1.0 - blocked / max((rays + 1 - half) // 2, 1)


@inlined
def seen(frames, probes, p, x, y, z):
    """A point as a probe's rays see it."""
    x -= probes[p, 0]
    y -= probes[p, 1]
    z -= probes[p, 2]
    return (
        frames[p, 0, 0] * x + frames[p, 0, 1] * y + frames[p, 0, 2] * z,
        frames[p, 1, 0] * x + frames[p, 1, 1] * y + frames[p, 1, 2] * z,
        frames[p, 2, 0] * x + frames[p, 2, 1] * y + frames[p, 2, 2] * z,
    )


@function
def count_runs(first, runs):
    """Into runs (S + 1,): where the runs of each strand begin. Returns how many there are."""
    for s in range(first.shape[0] - 1):
        runs[s + 1] = runs[s] + (first[s + 1] - first[s] - 1 + RUN - 1) // RUN
    return runs[first.shape[0] - 1]


@function
def enclose(first, runs, world, radii, balls):
    """Into balls (runs, 4): the middle of each run's box, and how far its pieces, radii included, reach from there."""
    for s in range(first.shape[0] - 1):
        for run in range(runs[s], runs[s + 1]):
            start = first[s] + (run - runs[s]) * RUN
            end = min(start + RUN + 1, first[s + 1])
            for c in range(3):
                low = high = world[start, c]
                for v in range(start + 1, end):
                    low = min(low, world[v, c])
                    high = max(high, world[v, c])
                balls[run, c] = 0.5 * (low + high)
            far = 0.0
            for v in range(start, end):
                x = world[v, 0] - balls[run, X]
                y = world[v, 1] - balls[run, Y]
                z = world[v, 2] - balls[run, Z]
                far = max(far, math.sqrt(x * x + y * y + z * z) + radii[v])
            balls[run, RADIUS] = far
