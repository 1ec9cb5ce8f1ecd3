"""The step of the rod solver over all blocks: predict, iterate, make lengths exact, take the new velocity."""

from __future__ import annotations

import numpy as np

from ...constants import W
from ...jit import function, parallel, prange
from . import contact, rod, rod_long

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-30)


@parallel
def step(
    edges, velocity, before, moved, tension, positions, lengths, stiffness, mass, joint, roots, directions, bends, gust,
    pose, delta, numbers, iterations, solids, whole, scratch, residuals,
):  # fmt: skip
    """Move every strand by one step, in place.

    edges (blocks, N, 3 W): unit vectors; velocity (blocks, N, 3 W) m/s, and the same one step `before` with the last
    displacement `moved` in metres for BDF2, both None for implicit Euler; tension (blocks, N, W): force densities of
    the last step over h²; positions (blocks, N + 2, 3 W) world, row 0 one segment before the root, row 1 the root;
    lengths (blocks, W) of a segment; stiffness (blocks, W): B / (ρ A ℓ⁴) in 1/s²; mass, joint (N,): a particle's mass
    and the rigidity of the joint before an edge, relative (root joint 2, tip mass 1/2); roots, directions
    (blocks, 3 W) in the emitter's frame; bends (blocks, N + 1, 3 W): row 0 a unit vector across each direction, in the
    emitter's frame, then the rest value of c_j in the frame carried along the strand, or None for straight rods; gust
    (blocks, W): factor of the air's velocity, or None; pose, delta (12,): the emitter's rotation by rows and its
    translation, and what they changed by in this step; numbers: [0] step in s, [1:4] gravity m/s², [4:7] velocity of
    the air, [7] drag 1/s, [8] material damping s, [9] 1/3 for BDF2 (0 for the Euler step that it starts with), [10]
    friction; solids: four arrays as in `contact`, or None; whole: segments are caught too; scratch (workers, rows, W);
    residuals (blocks,): greatest | |e| − 1 | before lengths are made exact. All of one floating type.
    """
    workers = scratch.shape[0]
    for task in prange(workers):
        s = scratch[task]
        for b in range(task, edges.shape[0], workers):
            n = edges.shape[1]
            begin(s, n, b, edges, velocity, before, moved, tension, positions, lengths, stiffness, mass, joint, roots,
                  directions, bends, gust, pose, delta, numbers)  # fmt: skip
            rod.iterate(s, n, positions[b, 0], iterations)
            residuals[b] = end(s, n, b, edges, velocity, before, moved, tension, positions, lengths, numbers, solids,
                               whole)  # fmt: skip


@parallel
def step_long(
    edges, velocity, before, moved, tension, positions, lengths, stiffness, mass, joint, roots, directions, bends, gust,
    pose, delta, numbers, iterations, solids, whole, scratch, residuals,
):  # fmt: skip
    """As `step`, in O(N) a strand; wants float64."""
    workers = scratch.shape[0]
    for task in prange(workers):
        s = scratch[task]
        for b in range(task, edges.shape[0], workers):
            n = edges.shape[1]
            begin(s, n, b, edges, velocity, before, moved, tension, positions, lengths, stiffness, mass, joint, roots,
                  directions, bends, gust, pose, delta, numbers)  # fmt: skip
            rod_long.iterate(s, n, positions[b, 0], iterations)
            residuals[b] = end(s, n, b, edges, velocity, before, moved, tension, positions, lengths, numbers, solids,
                               whole)  # fmt: skip


@function
def begin(
    s, n, b, edges, velocity, before, moved, tension, positions, lengths, stiffness, mass, joint, roots, directions,
    bends, gust, pose, delta, numbers,
):  # fmt: skip
    """All of block b's step that comes before the iterations. Row 0 of the positions is the clamped direction from here
    until `end`; where the root moved to is kept in the scratch."""
    shift = s[rod.places(n)[14] + 6 : rod.places(n)[14] + 9].reshape(3 * W)
    clamp = positions[b, 0]
    place_root(roots[b], directions[b], pose, delta, clamp, positions[b, 1], shift)
    weigh(s, n, edges[b], tension[b], lengths[b], stiffness[b], mass, joint, clamp, shift, numbers)
    if before is None:
        if gust is None:
            predict(s, n, velocity[b], None, None, lengths[b], None, numbers)
        else:
            predict(s, n, velocity[b], None, None, lengths[b], gust[b], numbers)
    elif gust is None:
        predict(s, n, velocity[b], before[b], moved[b], lengths[b], None, numbers)
    else:
        predict(s, n, velocity[b], before[b], moved[b], lengths[b], gust[b], numbers)
    if bends is not None:
        recall(s, n, edges[b], bends[b], clamp, pose, numbers[8] / numbers[0])


@function
def end(s, n, b, edges, velocity, before, moved, tension, positions, lengths, numbers, solids, whole):
    """All that comes after; returns the greatest | |e| − 1 |."""
    shift = s[rod.places(n)[14] + 6 : rod.places(n)[14] + 9].reshape(3 * W)
    residual = finish(s, n, tension[b], numbers[0])
    sweep(s, n, lengths[b], positions[b], solids, whole, numbers[10])
    if before is None:
        settle(s, n, edges[b], velocity[b], None, None, lengths[b], shift, numbers)
    else:
        settle(s, n, edges[b], velocity[b], before[b], moved[b], lengths[b], shift, numbers)
    clamp = positions[b, 0]
    root = positions[b, 1]
    for c in range(3):
        for k in range(W):
            clamp[c * W + k] = root[c * W + k] - lengths[b, k] * clamp[c * W + k]
    return residual


@function
def place_root(local, direction, pose, delta, clamp, root, shift):
    """The root in the world, by how much it moved, and the clamped direction (kept in `clamp` during the step)."""
    for k in range(W):
        x = local[k]
        y = local[W + k]
        z = local[2 * W + k]
        for c in range(3):
            root[c * W + k] = pose[3 * c] * x + pose[3 * c + 1] * y + pose[3 * c + 2] * z + pose[9 + c]
            shift[c * W + k] = delta[3 * c] * x + delta[3 * c + 1] * y + delta[3 * c + 2] * z + delta[9 + c]
        x = direction[k]
        y = direction[W + k]
        z = direction[2 * W + k]
        for c in range(3):
            clamp[c * W + k] = pose[3 * c] * x + pose[3 * c + 1] * y + pose[3 * c + 2] * z


@function
def weigh(s, n, edges, tension, lengths, stiffness, mass, joint, clamp, shift, numbers):
    """Fill the scratch: the coefficients of the step, in units of a segment, and edges as they are when the root has
    moved and nothing else. Internal damping pulls each joint to the bend that it had."""
    E, U, Y, A, C, T, TB, M, K, D, L1, L2, DEL, S, X = rod.places(n)
    h = numbers[0]
    damping = numbers[8] / h
    drag = numbers[7] * h
    share = damping / (ONE + damping)
    for j in range(n):
        heavy = mass[j] * (ONE + drag)
        stiff = h * h * joint[j] * (ONE + damping)
        for k in range(W):
            s[T + j, k] = max(tension[j, k] * h * h, ZERO)
            s[M + j, k] = heavy
            s[K + j, k] = stiffness[k] * stiff
        for c in range(3):
            o = 3 * j + c
            row = c * W
            for k in range(W):
                s[E + o, k] = edges[j, row + k]
                s[U + o, k] = ZERO
            if j == 0:
                for k in range(W):
                    s[C + o, k] = share * (edges[0, row + k] - clamp[row + k])
            else:
                for k in range(W):
                    s[C + o, k] = share * (edges[j, row + k] - edges[j - 1, row + k])
    for c in range(3):
        for k in range(W):
            s[E + c, k] -= shift[c * W + k] / lengths[k]


@function
def predict(s, n, velocity, before, moved, lengths, gust, numbers):
    """u*: where particles would go alone, in units of a segment.

    BDF2 is an Euler step of h = 2/3 Δt from extrapolated values: x̂ = x_n + (x_n − x_{n−1}) / 3, v̂ likewise.
    """
    A = rod.places(n)[3]
    h = numbers[0]
    third = numbers[9]
    drag = numbers[7] * h
    rest = ONE / (ONE + drag)
    for j in range(n):
        for c in range(3):
            o = A + 3 * j + c
            row = c * W
            fall = h * numbers[1 + c]
            for k in range(W):
                per = h / lengths[k]
                air = numbers[4 + c] if gust is None else numbers[4 + c] * gust[k]
                if before is None:
                    s[o, k] = per * (velocity[j, row + k] + fall + drag * air) * rest
                else:
                    hat = moved[j, row + k] * third / lengths[k]
                    v = velocity[j, row + k] + (velocity[j, row + k] - before[j, row + k]) * third
                    s[o, k] = hat + per * (v + fall + drag * air) * rest


@function
def recall(s, n, edges, bends, clamp, pose, damping):
    """Add the rest shape to c̄: bends are carried along by a frame that is transported without twist from the clamp, on
    the edges as they were before the step."""
    E, U, Y, A, C, T, TB, M, K, D, L1, L2, DEL, S, X = rod.places(n)
    share = ONE / (ONE + damping)
    for k in range(W):
        tx = clamp[k]
        ty = clamp[W + k]
        tz = clamp[2 * W + k]
        x = bends[0, k]
        y = bends[0, W + k]
        z = bends[0, 2 * W + k]
        ax = pose[0] * x + pose[1] * y + pose[2] * z
        ay = pose[3] * x + pose[4] * y + pose[5] * z
        az = pose[6] * x + pose[7] * y + pose[8] * z
        for j in range(n):
            bx = ty * az - tz * ay
            by = tz * ax - tx * az
            bz = tx * ay - ty * ax
            u = bends[j + 1, k] * share
            v = bends[j + 1, W + k] * share
            w = bends[j + 1, 2 * W + k] * share
            s[C + 3 * j, k] += u * tx + v * ax + w * bx
            s[C + 3 * j + 1, k] += u * ty + v * ay + w * by
            s[C + 3 * j + 2, k] += u * tz + v * az + w * bz
            ex = edges[j, k]
            ey = edges[j, W + k]
            ez = edges[j, 2 * W + k]
            # the rotation that takes t to e takes a to a − (a·e) (t + e) / (1 + t·e)
            f = (ax * ex + ay * ey + az * ez) / max(ONE + tx * ex + ty * ey + tz * ez, np.float32(1e-6))
            ax -= f * (tx + ex)
            ay -= f * (ty + ey)
            az -= f * (tz + ez)
            f = ONE / np.sqrt(max(ax * ax + ay * ay + az * az, TINY))
            ax *= f
            ay *= f
            az *= f
            tx = ex
            ty = ey
            tz = ez


@function
def finish(s, n, tension, h):
    """Keep τ / h² for the next step; the greatest error of a length."""
    E, U, Y, A, C, T, TB, M, K, D, L1, L2, DEL, S, X = rod.places(n)
    worst = h * ZERO
    for j in range(n):
        e = E + 3 * j
        for k in range(W):
            tension[j, k] = s[T + j, k] / (h * h)
            size = np.sqrt(s[e, k] * s[e, k] + s[e + 1, k] * s[e + 1, k] + s[e + 2, k] * s[e + 2, k])
            worst = max(worst, abs(size - ONE))
    return worst


@function
def sweep(s, n, lengths, positions, solids, whole, friction):
    """Root to tip: every edge takes its own length along the way to where the iterations put its particle, and is
    turned off the solids. The rows from Y on become the unit edges, the world positions are written."""
    E, U, Y, A, C, T, TB, M, K, D, L1, L2, DEL, S, X = rod.places(n)
    # how far the particle before has been moved from where the iterations put it, in segments
    for c in range(3):
        for k in range(W):
            s[X + c, k] = ZERO
    for j in range(n):
        e = E + 3 * j
        y = Y + 3 * j
        q = positions[j + 1]
        p = positions[j + 2]
        if solids is not None:
            for c in range(3):
                for k in range(W):
                    s[X + 3 + c, k] = p[c * W + k]
        for k in range(W):
            ex = s[e, k] - s[X, k]
            ey = s[e + 1, k] - s[X + 1, k]
            ez = s[e + 2, k] - s[X + 2, k]
            f = ONE / np.sqrt(max(ex * ex + ey * ey + ez * ez, TINY))
            s[y, k] = ex * f
            s[y + 1, k] = ey * f
            s[y + 2, k] = ez * f
            p[k] = q[k] + lengths[k] * (ex * f)
            p[W + k] = q[W + k] + lengths[k] * (ey * f)
            p[2 * W + k] = q[2 * W + k] + lengths[k] * (ez * f)
        if solids is not None:
            contact.touch(s, y, X + 3, q, p, lengths, solids[0], solids[1], solids[2], solids[3], whole, friction)
        for k in range(W):
            s[X, k] += s[y, k] - s[e, k]
            s[X + 1, k] += s[y + 1, k] - s[e + 1, k]
            s[X + 2, k] += s[y + 2, k] - s[e + 2, k]


@function
def settle(s, n, edges, velocity, before, moved, lengths, shift, numbers):
    """New edges, and the velocity that led to them: (u − û) / h, with u summed up from the changes of edges."""
    E, U, Y, A, C, T, TB, M, K, D, L1, L2, DEL, S, X = rod.places(n)
    h = numbers[0]
    third = numbers[9]
    for c in range(3):
        for k in range(W):
            s[X, k] = shift[c * W + k]
        for j in range(n):
            row = c * W
            for k in range(W):
                fresh = s[Y + 3 * j + c, k]
                s[X, k] += lengths[k] * (fresh - edges[j, row + k])
                edges[j, row + k] = fresh
            if before is None:
                for k in range(W):
                    velocity[j, row + k] = s[X, k] / h
            else:
                for k in range(W):
                    v = velocity[j, row + k]
                    velocity[j, row + k] = (s[X, k] - moved[j, row + k] * third) / h
                    before[j, row + k] = v
                    moved[j, row + k] = s[X, k]
