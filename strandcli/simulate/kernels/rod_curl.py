"""Rest shapes that are not straight: what they add to a step.

A joint's rest is a vector m_j in the frame of the edge before it, and its energy κ_j |e_j − m_j|² / 2. Frames are
carried along the strand without twist from the clamp, and then turned about their edges by angles ψ_j, of which
differences cost χ κ_j (ψ_j − ψ_{j−1})² / 2. Twist has no inertia: ψ is where torques about
edges balance (Bergou et al. 2008, "Discrete Elastic Rods", §5), by one iteration of Newton's a step from where it was.

A target that is carried along pulls at the edge before the joint as well, and through the frames at all before that:
with the moments T_j = κ_j e_j × m_j and twist q_j the edge j feels

    T_j − T_{j+1} + q_j e_{j−1} / (1 + e_{j−1}·e_j) − q_{j+1} e_{j+1} / (1 + e_j·e_{j+1}).

Without that the force is no gradient, and strands of many curls gain energy from nothing. It enters as c̄, on the edges
as they were before the step, and so no coefficient of the step's matrix changes.
"""

from __future__ import annotations

from ...constants import FOLD
from ...jit import device
from ...simd import broadcast, cosine, load, load3, sine, sqrt, store, store3
from .records import DAMPING, STEP, TORSION
from .rod import AXES, DI, FIRST, N1, N2, PACK, SEGMENT, TINY, C, E, G

MOST = 1.0
"""Radians that ψ changes by in a step at the most."""


@device
def add_rest(s, at, state, material, forcing):
    """Add the rest shape to c̄, and update the twist."""
    numbers = forcing.numbers
    carry_frames(s, at, state, material, forcing.pose, numbers[TORSION])
    react(s, at, state, material, numbers[TORSION], 1 / (1 + numbers[DAMPING] / numbers[STEP]))


@device
def carry_frames(s, at, state, material, pose, torsion):
    """From the root to the tip: G takes what of a target is across the edge before it, for the ψ that there is, and N1
    and N2 the elimination of ψ_{j−1} = N1 + N2 ψ_j."""
    n, bend, bends, joint = at.segments, at.bend, material.bends, material.joint
    tx, ty, tz = load3(s, FIRST - SEGMENT + E, 1)
    x, y, z = load3(bends, bend, PACK)
    ax = pose[0] * x + pose[1] * y + pose[2] * z
    ay = pose[3] * x + pose[4] * y + pose[5] * z
    az = pose[6] * x + pose[7] * y + pose[8] * z
    zero = broadcast(s, 0.0)
    angle = zero
    a = zero
    b = zero
    for j in range(n):
        o = FIRST + j * SEGMENT
        _, v, w = load3(bends, bend + (j + 1) * AXES, PACK)
        c = cosine(angle)
        d = sine(angle)
        v, w = v * c - w * d, v * d + w * c
        bx, by, bz = ty * az - tz * ay, tz * ax - tx * az, tx * ay - ty * ax
        x, y, z = v * ax + w * bx, v * ay + w * by, v * az + w * bz
        store3(s, o + G, 1, x, y, z)
        ex, ey, ez = load3(state.edges, at.edge + j * AXES, PACK)
        if j > 0:
            before = torsion * joint[j - 1]
            after = torsion * joint[j] if j + 1 < n else 0.0
            stiff = joint[j] * max(ex * x + ey * y + ez * z, 0.0)
            turn = (v * bx - w * ax) * ex + (v * by - w * ay) * ey + (v * bz - w * az) * ez
            over = 1.0 / (before * (1.0 - b) + after + stiff)
            a = (joint[j] * turn + stiff * angle + before * a) * over
            b = after * over
            store(s, o + N1, a)
            store(s, o + N2, b)
        store(s, o + DI, angle)
        angle = load(state.twist, at.tension + j * PACK)
        # the rotation that takes t to e takes a to a − (a·e) (t + e) / (1 + t·e)
        f = (ax * ex + ay * ey + az * ez) / max(1.0 + tx * ex + ty * ey + tz * ez, 1e-6)
        ax -= f * (tx + ex)
        ay -= f * (ty + ey)
        az -= f * (tz + ez)
        f = 1.0 / sqrt(max(ax * ax + ay * ay + az * az, TINY))
        ax *= f
        ay *= f
        az *= f
        tx = ex
        ty = ey
        tz = ez


@device
def react(s, at, state, material, torsion, share):
    """From the tip to the root: the new ψ, targets by it, and what they ask of the edges before them."""
    n, joint = at.segments, material.joint
    zero = broadcast(s, 0.0)
    sx, sy, sz = zero, zero, zero  # κ (m − e) of the joint after, and the edge after it
    nx, ny, nz = zero, zero, zero
    bx, by, bz = zero, zero, zero  # Σ of forces on edges so far
    after = zero  # q / (1 + e·e) of the joint after
    angle = zero
    ex, ey, ez = load3(state.edges, at.edge + (n - 1) * AXES, PACK)
    for j in range(n - 1, -1, -1):
        o = FIRST + j * SEGMENT
        if j > 0:
            px, py, pz = load3(state.edges, at.edge + (j - 1) * AXES, PACK)
        else:
            px, py, pz = load3(s, FIRST - SEGMENT + E, 1)
        past = load(s, o + DI)
        now = zero
        q = zero
        if j > 0:
            now = load(s, o + N1) + load(s, o + N2) * angle
            now = past + min(max(now - past, -MOST), MOST)
            store(state.twist, at.tension + (j - 1) * PACK, now)
        if j + 1 < n:
            q = (torsion * joint[j]) * (now - angle)
        q = q / max(1.0 + ex * px + ey * py + ez * pz, FOLD)
        angle = now
        # the joint after: its moment and twist, and the twist of this one
        mx, my, mz = cross(nx, ny, nz, sx, sy, sz)
        fx, fy, fz = cross(
            ex, ey, ez, mx - q * px + after * nx, my - q * py + after * ny, mz - q * pz + after * nz
        )
        f = sx * ex + sy * ey + sz * ez
        bx += fx + sx - f * ex
        by += fy + sy - f * ey
        bz += fz + sz - f * ez
        # this joint's target
        x, y, z = load3(s, o + G, 1)
        c = cosine(now - past)
        d = sine(now - past)
        wx, wy, wz = cross(px, py, pz, x, y, z)
        u = load(material.bends, at.bend + (j + 1) * AXES)
        x = u * px + c * x + d * wx
        y = u * py + c * y + d * wy
        z = u * pz + c * z + d * wz
        f = joint[j]
        sx, sy, sz = f * (x + px - ex), f * (y + py - ey), f * (z + pz - ez)
        f = 1.0 / joint[j]
        cx, cy, cz = load3(s, o + C, 1)
        store3(s, o + C, 1, cx + share * (x + f * bx), cy + share * (y + f * by), cz + share * (z + f * bz))
        nx, ny, nz = ex, ey, ez
        ex, ey, ez = px, py, pz
        after = q


@device
def cross(ax, ay, az, bx, by, bz):
    """Vector product."""
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
