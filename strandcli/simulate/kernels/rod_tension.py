"""The Newton step of the force densities, δ = S⁻¹ r, in O(N) by a Kalman filter and smoother.

S is never formed. It is the covariance of numbers e_j·z_j where that of a random vector y is H⁻¹. Elimination leaves
such a vector as a process from the root to the tip, whose state is a particle and an edge,

    z_j = i κ z_{j−1} − i B y_{j−1} + noise of variance i,    y_j = y_{j−1} + z_j.

So Kalman's filter (1960) factorises S: the mean and the covariance of (y_j, z_j) follow from those of (y_{j−1},
z_{j−1}), and then r_j is an observation of e_j·z_j. The innovations over their variances, and the adjoint of the filter
from the tip to the root, give δ (Bryson & Frazier 1963). The variance of an observation is no less than that of the
noise in it.

An observation takes from the covariance an outer product over the variance. The recurrence is linear, and goes on to
the next segment with the covariance and the vectors of that product apart: then no more than a product and a difference
wait for the division, and half as many operations stand between one division and the next. So the gain that the scratch
holds of a segment is the one transported to the next.
"""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import broadcast, load, load3, sqrt, store, store3, where
from .rod_scratch import (
    EDGE,
    EDGE_FACTOR,
    EDGE_GAIN,
    FIRST_SEGMENT,
    INNOVATION,
    INVERSE_PIVOT,
    LOAD,
    PARTICLE_FACTOR,
    SEGMENT,
    vectors_for,
)
from .vectors import (
    add_scaled,
    combined,
    less_outer,
    less_symmetric,
    matrix_product,
    scaled,
    sum_of,
    symmetric_product,
)

TINY = 1e-30
SHORT = 1 / 16
"""|e|² below which an edge has hardly a direction left: its observation then has at least this variance."""
GAIN = 3
"""Vectors of scratch that this module adds a segment: the Kalman gain of the next particle."""
FORCE = 4
"""Vectors of scratch a segment after those: `firm_force`."""
CHANGE = 6
"""Vectors of scratch a segment after `lasting_share`: `force_change`."""
KEPT = 22
"""Vectors of scratch a segment after those: `kept`."""

SPARE, POINT = 10, 6
"""Vectors of scratch a segment after those, and of one more segment: `spare`, and then `point`."""


def scratch_size(n: int) -> int:
    """Vectors of scratch for ``n`` segments."""
    return vectors_for(n) + n * (GAIN + FORCE + 1 + CHANGE + KEPT) + (n + 1) * (SPARE + POINT)


@inlined
def particle_gain(n, j):
    """Place of the gain of the particle after segment j. They lie apart, since hardly anything else reads them."""
    return FIRST_SEGMENT + (n + 2) * SEGMENT + j * GAIN


@inlined
def firm_force(n, j):
    """Place of the force on edge j (3) that keeps it where motion leads it, in the units of τ, and of its size, by
    which τ is the greater in a step; of strands that are not curled nothing reads them."""
    return FIRST_SEGMENT + (n + 2) * SEGMENT + n * GAIN + j * FORCE


@inlined
def lasting_share(n, j):
    """Place of the share of the force of contact on the particle after segment j that is no impact's, and lasts."""
    return FIRST_SEGMENT + (n + 2) * SEGMENT + n * (GAIN + FORCE) + j


@inlined
def force_change(n, j):
    """Place of the change of the acceleration by contact of the particle after segment j in a round (3), and of the
    normal (3)."""
    return FIRST_SEGMENT + (n + 2) * SEGMENT + n * (GAIN + FORCE + 1) + j * CHANGE


@inlined
def kept(n, j):
    """Place of what `rod_parts` keeps of segment j; nothing else reads it."""
    return FIRST_SEGMENT + (n + 2) * SEGMENT + n * (GAIN + FORCE + 1 + CHANGE) + j * KEPT


@inlined
def spare(n, j):
    """Place of what `rod_descent` keeps of segment j; nothing else reads it."""
    return kept(n, n) + j * SPARE


@inlined
def point(n, j):
    """Place of the edge and the inertial residual of segment j that a line search of `rod_descent` starts from."""
    return spare(n, n + 1) + j * POINT


@device
def filter_forward(s, n, mass, foreseen, inexact, rounding):
    """Kalman filter from the root to the tip: set `INNOVATION` and the gains, `EDGE_GAIN` taking the place of the
    loads.

    ``foreseen``: loads are subtracted from the means, which follow the same recurrence, so that r is what is left after
    the change that they lead to. ``inexact``: None where edges count as of exact length, and r is of loads alone.
    ``rounding``: None, or a share of the edge's variance that an observation has at least: where stiff joints leave it
    less, it is rounding, which would grow from one to the next.
    """
    zero = broadcast(s, 0.0)
    noise = load(s, FIRST_SEGMENT + INVERSE_PIVOT)
    # covariances of the state before the observation, as `vectors` has matrices
    particle = noise, zero, zero, noise, zero, noise
    mixed = noise, zero, zero, zero, noise, zero, zero, zero, noise
    edge = noise, zero, zero, noise, zero, noise
    mean_edge = zero, zero, zero
    if foreseen:
        mean_edge = load3(s, FIRST_SEGMENT + LOAD, 1)
    mean_particle = mean_edge
    for j in range(n):
        o = FIRST_SEGMENT + j * SEGMENT
        direction = load3(s, o + EDGE, 1)
        # covariances of the observation with both parts of the state
        h = matrix_product(mixed, direction)
        k = symmetric_product(edge, direction)
        precision, seen = observe(direction, (k, edge), mean_edge, noise, mass[j], inexact, rounding)
        store(s, o + INNOVATION, seen)
        # transport to the next segment as if nothing had been observed
        f = load(s, o + SEGMENT + EDGE_FACTOR)
        g = load(s, o + SEGMENT + PARTICLE_FACTOR)
        noise = load(s, o + SEGMENT + INVERSE_PIVOT)
        h, k = transport(h, k, f, g)
        particle, mixed, edge = transport_covariance(particle, mixed, edge, f, g, noise)
        mean_edge = combined(f, mean_edge, g, mean_particle)
        if foreseen:
            mean_edge = sum_of(mean_edge, load3(s, o + SEGMENT + LOAD, 1))
        mean_particle = sum_of(mean_particle, mean_edge)
        # what the observation changes, all that waits for the division
        mean_particle = add_scaled(mean_particle, seen, h)
        mean_edge = add_scaled(mean_edge, seen, k)
        gain, edge_gain = scaled(precision, h), scaled(precision, k)
        store3(s, particle_gain(n, j), 1, gain[0], gain[1], gain[2])
        store3(s, o + EDGE_GAIN, 1, edge_gain[0], edge_gain[1], edge_gain[2])
        particle = less_symmetric(particle, gain, h)
        mixed = less_outer(mixed, gain, k)
        edge = less_symmetric(edge, edge_gain, k)


@inlined
def observe(direction, covariances, mean_edge, noise, mass, inexact, rounding):
    """1 over the variance of the observation of e·z, and the innovation over that variance. ``covariances`` are
    that of the observation with the edge's change z, whose mean is ``mean_edge``, and that of z; ``noise`` is the
    variance of the edge's noise; ``inexact`` and ``rounding``: as of `filter_forward`."""
    x, y, z = direction
    (kx, ky, kz), edge = covariances
    square = x * x + y * y + z * z
    short = max(SHORT - square, 0.0) * (1 / mass)
    least = max(noise * square + short, TINY)
    if rounding is not None:
        least = max(least, rounding * square * (edge[0] + edge[3] + edge[5]))
    precision = 1.0 / max(short + x * kx + y * ky + z * kz, least)
    wx, wy, wz = mean_edge
    seen = -(x * wx + y * wy + z * wz)
    if inexact is not None:
        seen = length_residual(square) - (x * wx + y * wy + z * wz)
    return precision, seen * precision


@inlined
def length_residual(square):
    """r of an edge with the square |e|²: |e|² (|e| − 1), and where |e| < 1/2, (|e|² − 1) / 2."""
    return where(square > 0.25, square * (sqrt(square) - 1.0), 0.5 * (square - 1.0))


@inlined
def transport(particle, edge, f, g):
    """A state (y, z), three coordinates each, one segment on without noise: z' = f z − g y, y' = y + z'."""
    z = combined(f, edge, g, particle)
    return sum_of(particle, z), z


@inlined
def transport_covariance(particle, mixed, edge, f, g, noise):
    """Covariances of the state (y, z) one segment on, z' = f z − g y + noise, y' = y + z': of y, of y with z, of z."""
    axx, axy, axz, ayy, ayz, azz = particle
    bxx, bxy, bxz, byx, byy, byz, bzx, bzy, bzz = mixed
    cxx, cxy, cxz, cyy, cyz, czz = edge
    # of z' with y
    pxx, pxy, pxz = f * bxx - g * axx, f * byx - g * axy, f * bzx - g * axz
    pyx, pyy, pyz = f * bxy - g * axy, f * byy - g * ayy, f * bzy - g * ayz
    pzx, pzy, pzz = f * bxz - g * axz, f * byz - g * ayz, f * bzz - g * azz
    cxx = f * (f * cxx - g * bxx) - g * pxx + noise
    cxy = f * (f * cxy - g * bxy) - g * pxy
    cxz = f * (f * cxz - g * bxz) - g * pxz
    cyy = f * (f * cyy - g * byy) - g * pyy + noise
    cyz = f * (f * cyz - g * byz) - g * pyz
    czz = f * (f * czz - g * bzz) - g * pzz + noise
    bxx, bxy, bxz = pxx + cxx, pyx + cxy, pzx + cxz
    byx, byy, byz = pxy + cxy, pyy + cyy, pzy + cyz
    bzx, bzy, bzz = pxz + cxz, pyz + cyz, pzz + czz
    axx += pxx + bxx
    axy += pxy + bxy
    axz += pxz + bxz
    ayy += pyy + byy
    ayz += pyz + byz
    azz += pzz + bzz
    return (
        (axx, axy, axz, ayy, ayz, azz),
        (bxx, bxy, bxz, byx, byy, byz, bzx, bzy, bzz),
        (cxx, cxy, cxz, cyy, cyz, czz),
    )


@inlined
def smooth_backward(s, n, j, ahead):
    """The change δ of segment j's τ, and what the segment before it is handed as ``ahead``: the adjoints of the means
    of its particle and its edge, i κ and i B. Called from the tip to the root, before τ changes; the first gets
    zeros."""
    (mx, my, mz), (wx, wy, wz), (f, g) = ahead
    o = FIRST_SEGMENT + j * SEGMENT
    dx, dy, dz = load3(s, particle_gain(n, j), 1)
    ex, ey, ez = load3(s, o + EDGE_GAIN, 1)
    change = load(s, o + INNOVATION) - (dx * mx + dy * my + dz * mz) - (ex * wx + ey * wy + ez * wz)
    wx += mx
    wy += my
    wz += mz
    x, y, z = load3(s, o + EDGE, 1)
    particle = mx - g * wx, my - g * wy, mz - g * wz
    edge = f * wx + x * change, f * wy + y * change, f * wz + z * change
    return change, (particle, edge, (load(s, o + EDGE_FACTOR), load(s, o + PARTICLE_FACTOR)))
