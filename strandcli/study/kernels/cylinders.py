"""Light between strands, exactly: parallel rays against every piece of every strand, in double precision."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...jit import inlined, parallel, prange


class Pieces(NamedTuple):
    """Cylinders with round ends, N of them; all but strands float64."""

    begins: NDArray[np.float64]
    """(N, 3) metres."""
    ends: NDArray[np.float64]
    """(N, 3) metres."""
    radii: NDArray[np.float64]
    """(N,) metres."""
    lengths: NDArray[np.float64]
    """(N,) metres."""
    strands: NDArray[np.int64]
    """(N,) that they are of."""


@parallel
def transmittance(pieces, probes, own, frames, reaches, jitter, wide, out):
    """Share of each probe's rays that meet no strand but its own, by halves of the rays.

    `Pieces`; probes (P, 3); own (P,) the strand that each probe is on, or −1; frames (P, 3, 3): two axes across the
    light and the direction to it; reaches (P,) metres to the light; jitter (R, 2): where the rays start across, in
    units of wide (P,) metres; out (P, 2): of the even and the odd rays. Seen along the rays a piece is a flat band: a
    ray meets it where its point lies within the radius of the band's middle line, and not behind the probe or the
    light.
    """
    rays = jitter.shape[0]
    most = 0.0
    for k in range(rays):
        most = max(most, math.sqrt(jitter[k, 0] ** 2 + jitter[k, 1] ** 2))
    for p in prange(probes.shape[0]):
        hit = np.zeros(rays, np.uint8)
        for i in range(pieces.strands.shape[0]):
            ax, ay, az = seen(frames, probes, p, pieces.begins, i)
            room = most * wide[p] + pieces.radii[i]
            near = room + pieces.lengths[i]
            if abs(ax) > near or abs(ay) > near or pieces.strands[i] == own[p]:
                continue
            bx, by, bz = seen(frames, probes, p, pieces.ends, i)
            aside = min(ax, bx) > room or max(ax, bx) < -room or min(ay, by) > room or max(ay, by) < -room
            if aside or max(az, bz) <= 0.0 or min(az, bz) >= reaches[p]:
                continue
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
                if gx * gx + gy * gy < pieces.radii[i] ** 2 and depth > 0.0 and depth < reaches[p]:
                    hit[k] = 1
        for half in range(2):
            blocked = 0
            for k in range(half, rays, 2):
                blocked += hit[k]
            out[p, half] = 1.0 - blocked / max((rays + 1 - half) // 2, 1)


@inlined
def seen(frames, probes, p, points, i):
    """Point i of points (n, 3) as a probe's rays see it."""
    x = points[i, 0] - probes[p, 0]
    y = points[i, 1] - probes[p, 1]
    z = points[i, 2] - probes[p, 2]
    return (
        frames[p, 0, 0] * x + frames[p, 0, 1] * y + frames[p, 0, 2] * z,
        frames[p, 1, 0] * x + frames[p, 1, 1] * y + frames[p, 1, 2] * z,
        frames[p, 2, 0] * x + frames[p, 2, 1] * y + frames[p, 2, 2] * z,
    )
