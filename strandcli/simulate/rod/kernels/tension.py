"""The Newton step of the force densities and of the forces of contact, in O(N) by a Kalman filter and smoother.

Elimination leaves a random vector y whose covariance is H⁻¹ as a process from the root to the tip, whose state is a
particle and an edge,

    z_j = i κ z_{j−1} − i B y_{j−1} + noise of variance i,    y_j = y_{j−1} + z_j.

S is the covariance of e_j·z_j, and the filter factorises it: r_j is an observation of e_j·z_j. The innovations over
their variances, and the adjoint of the filter from the tip to the root, give δ = S⁻¹ r (Bryson & Frazier 1963). The
variance of an observation is no less than that of the noise in it. A contact is three more observations of the same
state (`contact.law`).

An observation takes from the covariance an outer product over the variance. The recurrence is linear, and goes on to
the next segment with the covariance and the vectors of that product apart: then no more than a product and a difference
wait for the division. So the gain that the scratch holds of a segment is the one transported to the next.
"""

from __future__ import annotations

from ....jit import device, inlined
from ....simd import any_lane, load, load3, sqrt, store, store3, where
from ....simd.vectors import (
    add_scaled,
    combined,
    dot,
    less_outer,
    less_symmetric,
    matrix_product,
    scaled,
    sum_of,
    symmetric_product,
)
from ...contact.kernels import law

TINY = 1e-30
HELD = 1e-3
"""Least variance of an edge whose place is observed, too, as a share of that of its noise."""
SHORT = 1 / 16
"""|e|² below which an edge has hardly a direction left: its observation then has at least this variance."""


@device
def filter_forward(s, n, mass, foreseen, touching, whole):
    """Kalman filter from the root to the tip: set innovations and gains. ``foreseen``: means are those of the negated
    change, by the loads, so that r is what is left after that change. ``touching``: whether solids touch some
    segment, and ``whole`` ones."""
    noise = load(s.pivot, 0)
    zero = noise * 0.0
    # covariances of the state before the observation, as `vectors` has matrices
    particle = noise, zero, zero, noise, zero, noise
    mixed = noise, zero, zero, zero, noise, zero, zero, zero, noise
    edge = noise, zero, zero, noise, zero, noise
    mean_edge = zero, zero, zero
    if foreseen:
        mean_edge = load3(s.load, 0, 1)
    mean_particle = mean_edge
    for j in range(n):
        least = noise
        if touching and any_lane(load(s.active, j) > 0.0):
            least = where(load(s.active, j) > 0.0, HELD * noise, noise)
            (particle, mixed, edge), (mean_particle, mean_edge) = law.observe(
                s, j, (particle, mixed, edge), (mean_particle, mean_edge), whole
            )
        direction = load3(s.edge, 3 * j, 1)
        # covariances of the observation with both parts of the state
        h = matrix_product(mixed, direction)
        k = symmetric_product(edge, direction)
        precision, seen = observe(direction, k, mean_edge, least, mass[j])
        store(s.innovation, j, seen)
        # transport to the next segment as if nothing had been observed
        f = load(s.edge_factor, j + 1)
        g = load(s.particle_factor, j + 1)
        noise = load(s.pivot, j + 1)
        z = combined(f, k, g, h)
        h, k = sum_of(h, z), z
        particle, mixed, edge = transport_covariance(particle, mixed, edge, f, g, noise)
        mean_edge = combined(f, mean_edge, g, mean_particle)
        if foreseen:
            mean_edge = sum_of(mean_edge, load3(s.load, 3 * j + 3, 1))
        mean_particle = sum_of(mean_particle, mean_edge)
        # what the observation changes, all that waits for the division
        mean_particle = add_scaled(mean_particle, seen, h)
        mean_edge = add_scaled(mean_edge, seen, k)
        gain, edge_gain = scaled(precision, h), scaled(precision, k)
        store3(s.particle_gain, 3 * j, 1, gain[0], gain[1], gain[2])
        store3(s.edge_gain, 3 * j, 1, edge_gain[0], edge_gain[1], edge_gain[2])
        particle = less_symmetric(particle, gain, h)
        mixed = less_outer(mixed, gain, k)
        edge = less_symmetric(edge, edge_gain, k)


@inlined
def observe(direction, k, mean_edge, noise, mass):
    """1 over the variance of the observation of e·z, and the innovation over that variance. ``k``: covariance of the
    observation with the edge's change z, whose mean is ``mean_edge``; ``noise``: the least variance of an edge of unit
    length."""
    square = dot(direction, direction)
    short = max(SHORT - square, 0.0) * (1 / mass)
    least = max(noise * square + short, TINY)
    precision = 1.0 / max(short + direction[0] * k[0] + direction[1] * k[1] + direction[2] * k[2], least)
    residual = where(square > 0.25, square * (sqrt(square) - 1.0), 0.5 * (square - 1.0))
    return precision, (residual - dot(direction, mean_edge)) * precision


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
def smooth_backward(s, j, ahead, mass, touching, whole):
    """Change segment j's τ, and the force of contact on it; return what the segment before it is handed as ``ahead``:
    the adjoints of the means of its particle and its edge, i κ and i B. Called from the tip to the root; the first gets
    zeros."""
    particle, edge, (f, g) = ahead
    change = load(s.innovation, j) - dot(load3(s.particle_gain, 3 * j, 1), particle)
    change = change - dot(load3(s.edge_gain, 3 * j, 1), edge)
    store(s.tension, j, load(s.tension, j) + change)
    edge = sum_of(edge, particle)
    particle = add_scaled(particle, -g, edge)
    edge = add_scaled(scaled(f, edge), change, load3(s.edge, 3 * j, 1))
    if touching and any_lane(load(s.active, j) > 0.0):
        particle, edge = law.change_force(s, j, particle, edge, mass, whole)
    return particle, edge, (load(s.edge_factor, j), load(s.particle_factor, j))
