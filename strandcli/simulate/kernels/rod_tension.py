"""The change of the force densities, O(N).

S is never formed. It is the covariance of numbers e_j·z_j where that of a random vector y is H⁻¹. Elimination leaves
such a vector as a process from the root to the tip that remembers a particle and an edge,

    z_j = i κ z_{j−1} − i B y_{j−1} + noise of variance i,    y_j = y_{j−1} + z_j.

So S is factored as Kalman's filter does it (1960): the mean and the covariance of (y_j, z_j) follow from those of
(y_{j−1}, z_{j−1}), and then r_j is what e_j·z_j has been observed to be. What is observed beyond what was expected,
divided by its variance, and the adjoint of the filter, from the tip to the root, give δ = S⁻¹ r (Bryson & Frazier
1963). The variance of what is observed is no less than that of the noise in it.

An observation takes from the covariance a product of two vectors, over the variance. The recurrence is linear, and goes
on to the next segment with the covariance and those vectors apart: then no more than a product and a difference wait
for the division, and half as many operations stand between one division and the next. What the scratch has of a
segment's gain is that on the next.
"""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import broadcast, load, load3, sqrt, store, store3, where
from .rod import DI, FIRST, N1, N2, SEGMENT, TINY, E, G, R, rows_for

SHORT = 1 / 16
"""|e|² below which an edge has hardly a direction left: S then takes this."""
GAIN = 3
"""Vectors of scratch a segment: the gain of the next particle. That of the edge takes the place of the loads G, and
what was observed beyond, over its variance, that of r."""


def size_for(n: int) -> int:
    """Vectors of scratch for ``n`` segments."""
    return rows_for(n) + n * GAIN


@inlined
def gain(n, j):
    """Where a segment's is: apart, for nothing else needs it."""
    return FIRST + (n + 2) * SEGMENT + j * GAIN


@device
def observe(s, n, mass, foreseen):
    """From the root to the tip. Covariances: a of the particle, b of the same with the edge, c of the edge; m, w: their
    means; h, k: what an edge's observation has to do with either. ``foreseen``: r is what is left of it after the
    change that loads ask for, which is taken from the means: it follows the same recurrence."""
    zero = broadcast(s, 0.0)
    noise = load(s, FIRST + DI)
    axx, axy, axz, ayy, ayz, azz = noise, zero, zero, noise, zero, noise
    bxx, bxy, bxz, byx, byy, byz, bzx, bzy, bzz = noise, zero, zero, zero, noise, zero, zero, zero, noise
    cxx, cxy, cxz, cyy, cyz, czz = noise, zero, zero, noise, zero, noise
    wx, wy, wz = zero, zero, zero
    if foreseen:
        wx, wy, wz = load3(s, FIRST + G, 1)
    mx, my, mz = wx, wy, wz
    for j in range(n):
        o = FIRST + j * SEGMENT
        # what is observed: its covariance with both, and its variance
        x, y, z = load3(s, o + E, 1)
        hx, hy, hz = bxx * x + bxy * y + bxz * z, byx * x + byy * y + byz * z, bzx * x + bzy * y + bzz * z
        kx, ky, kz = cxx * x + cxy * y + cxz * z, cxy * x + cyy * y + cyz * z, cxz * x + cyz * y + czz * z
        square = x * x + y * y + z * z
        short = max(SHORT - square, 0.0) * (1 / mass[j])
        least = max(noise * square + short, TINY)
        over = 1.0 / max(short + x * kx + y * ky + z * kz, least)
        seen = (demand(square) - (x * wx + y * wy + z * wz)) * over
        store(s, o + R, seen)
        # on to the next segment, all as if nothing had been observed
        f = load(s, o + SEGMENT + N1)
        g = load(s, o + SEGMENT + N2)
        noise = load(s, o + SEGMENT + DI)
        kx, ky, kz = f * kx - g * hx, f * ky - g * hy, f * kz - g * hz
        hx += kx
        hy += ky
        hz += kz
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
        wx, wy, wz = f * wx - g * mx, f * wy - g * my, f * wz - g * mz
        if foreseen:
            x, y, z = load3(s, o + SEGMENT + G, 1)
            wx += x
            wy += y
            wz += z
        mx += wx
        my += wy
        mz += wz
        # and now what the observation has changed of it: all that waits for the division
        mx += hx * seen
        my += hy * seen
        mz += hz * seen
        wx += kx * seen
        wy += ky * seen
        wz += kz * seen
        dx, dy, dz = hx * over, hy * over, hz * over
        ex, ey, ez = kx * over, ky * over, kz * over
        store3(s, gain(n, j), 1, dx, dy, dz)
        store3(s, o + G, 1, ex, ey, ez)
        axx -= dx * hx
        axy -= dx * hy
        axz -= dx * hz
        ayy -= dy * hy
        ayz -= dy * hz
        azz -= dz * hz
        bxx, bxy, bxz = bxx - dx * kx, bxy - dx * ky, bxz - dx * kz
        byx, byy, byz = byx - dy * kx, byy - dy * ky, byz - dy * kz
        bzx, bzy, bzz = bzx - dz * kx, bzy - dz * ky, bzz - dz * kz
        cxx -= ex * kx
        cxy -= ex * ky
        cxz -= ex * kz
        cyy -= ey * ky
        cyz -= ey * kz
        czz -= ez * kz


@inlined
def recall(s, n, j, ahead):
    """From the tip on, the change of a segment's τ, given of the one ``ahead`` the adjoints of the means and its
    i κ and i B; and the same of this one, as they are before τ changes."""
    (mx, my, mz), (wx, wy, wz), (f, g) = ahead
    o = FIRST + j * SEGMENT
    dx, dy, dz = load3(s, gain(n, j), 1)
    ex, ey, ez = load3(s, o + G, 1)
    change = load(s, o + R) - (dx * mx + dy * my + dz * mz) - (ex * wx + ey * wy + ez * wz)
    wx += mx
    wy += my
    wz += mz
    x, y, z = load3(s, o + E, 1)
    mean = mx - g * wx, my - g * wy, mz - g * wz
    bent = f * wx + x * change, f * wy + y * change, f * wz + z * change
    return change, (mean, bent, (load(s, o + N1), load(s, o + N2)))


@inlined
def demand(q):
    """r of an edge whose length is √q."""
    return where(q > 0.25, q * (sqrt(q) - 1.0), 0.5 * (q - 1.0))
