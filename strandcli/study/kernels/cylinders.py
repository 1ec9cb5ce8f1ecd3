"""Light between strands, exactly: parallel rays against every piece of every strand, in double precision."""

from __future__ import annotations

import math

import numpy as np

from ...jit import parallel, prange


@parallel
def transmittance(first, world, radii, probes, own, frames, reaches, jitter, out):
    """Share of each probe's rays that meet no strand but its own, by halves of the rays.

    first (S + 1,) int64, world (V, 3), radii (V,): polylines as cylinders with round ends; probes (P, 3); own (P,) the
    strand that each probe is on, or −1; frames (P, 3, 3): two axes across the light and the way to it; reaches (P,)
    metres to the light; jitter (R, 2) metres across: where the rays start; out (P, 2): of the even and the odd rays.
    All but indices float64. Seen along the rays a piece is a flat band: a ray meets it where its point lies within the
    radius of the band's middle line, and not behind the probe or the light.
    """
    rays = jitter.shape[0]
    wide = 0.0
    for k in range(rays):
        wide = max(wide, math.sqrt(jitter[k, 0] ** 2 + jitter[k, 1] ** 2))
    for p in prange(probes.shape[0]):
        hit = np.zeros(rays, np.uint8)
        for s in range(first.shape[0] - 1):
            if s == own[p]:
                continue
            ax, ay, az = 0.0, 0.0, 0.0
            for v in range(first[s], first[s + 1]):
                x = world[v, 0] - probes[p, 0]
                y = world[v, 1] - probes[p, 1]
                z = world[v, 2] - probes[p, 2]
                bx = frames[p, 0, 0] * x + frames[p, 0, 1] * y + frames[p, 0, 2] * z
                by = frames[p, 1, 0] * x + frames[p, 1, 1] * y + frames[p, 1, 2] * z
                bz = frames[p, 2, 0] * x + frames[p, 2, 1] * y + frames[p, 2, 2] * z
                if v > first[s]:
                    r = 0.5 * (radii[v - 1] + radii[v])
                    room = wide + r
                    aside = (min(ax, bx) > room or max(ax, bx) < -room) or (min(ay, by) > room or max(ay, by) < -room)
                    if not aside and max(az, bz) > 0.0 and min(az, bz) < reaches[p]:
                        ex = bx - ax
                        ey = by - ay
                        e = ex * ex + ey * ey
                        for k in range(rays):
                            dx = jitter[k, 0] - ax
                            dy = jitter[k, 1] - ay
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
