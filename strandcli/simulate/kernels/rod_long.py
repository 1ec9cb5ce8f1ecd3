"""The change of the force densities for long strands: O(N) where `rod_dense` is O(N³).

S is never formed. It is the covariance of numbers z_j = e_j·(y_j − y_{j−1}) where that of a random vector y is H⁻¹.
With H = L diag(d) Lᵀ such a vector is a process from the tip to the root that remembers two particles,

    y_{j−1} = N1 y_j + N2 y_{j+1} + noise of variance 1 / d_{j−1},    N the bands of −L.

So S is factored as Kalman's filter does it (1960): the mean and the covariance of (y_{j−1}, y_j) follow from those of
(y_j, y_{j+1}), and then r_j is what z_j has been observed to be. What is observed beyond what was expected, divided by
its variance, and the adjoint of the filter, from the root to the tip, give δ = S⁻¹ r (Bryson & Frazier 1963). The
variance of z_j is no less than that of the noise in it. For long strands H is badly conditioned (as N⁴): these kernels
want float64.
"""

from __future__ import annotations

from ...jit import inner
from .rod import DI, FIRST, N1, N2, SEGMENT, TINY, E, M, R, T, rows_for
from .rod_dense import SHORT
from .simd import get, get3, put, put3, spread

GAIN = 7
"""Vectors of scratch a segment: the gain, three a particle, and what was observed beyond, over its variance."""


def size_for(n: int) -> int:
    """Vectors of scratch for ``n`` segments."""
    return rows_for(n) + n * GAIN


@inner
def newton(s, n):
    """τ += S⁻¹ r."""
    observe(s, n)
    recall(s, n)


@inner
def observe(s, n):
    """From the tip to the root. Covariances: a of the nearer particle, b of the nearer with the farther one, c of the
    farther one; m, w: their means."""
    o = FIRST + (n - 1) * SEGMENT
    zero = spread(s, 0.0)
    axx = get(s, o + DI)
    axy, axz, ayy, ayz, azz = zero, zero, axx, zero, axx
    bxx, bxy, bxz, byx, byy, byz, bzx, bzy, bzz = zero, zero, zero, zero, zero, zero, zero, zero, zero
    cxx, cxy, cxz, cyy, cyz, czz = zero, zero, zero, zero, zero, zero
    mx, my, mz, wx, wy, wz = zero, zero, zero, zero, zero, zero
    for j in range(n - 1, -1, -1):
        o = FIRST + j * SEGMENT
        p = get(s, o - SEGMENT + N1)
        q = get(s, o - SEGMENT + N2)
        noise = get(s, o - SEGMENT + DI)
        # of the particle before with the farther one, and with the nearer one
        fxx, fxy, fxz = p * bxx + q * cxx, p * bxy + q * cxy, p * bxz + q * cxz
        fyy, fyz, fzz = p * byy + q * cyy, p * byz + q * cyz, p * bzz + q * czz
        gxx, gxy, gxz = p * axx + q * bxx, p * axy + q * byx, p * axz + q * bzx
        gyx, gyy, gyz = p * axy + q * bxy, p * ayy + q * byy, p * ayz + q * bzy
        gzx, gzy, gzz = p * axz + q * bxz, p * ayz + q * byz, p * azz + q * bzz
        cxx, cxy, cxz, cyy, cyz, czz = axx, axy, axz, ayy, ayz, azz
        axx = p * gxx + q * fxx + noise
        axy = p * gxy + q * fxy
        axz = p * gxz + q * fxz
        ayy = p * gyy + q * fyy + noise
        ayz = p * gyz + q * fyz
        azz = p * gzz + q * fzz + noise
        ux, uy, uz = p * mx + q * wx, p * my + q * wy, p * mz + q * wz
        wx, wy, wz = mx, my, mz
        # what is observed: the covariance of z with both particles, its variance, and the gain
        x, y, z = get3(s, o + E, 1)
        hx = (gxx - axx) * x + (gxy - axy) * y + (gxz - axz) * z
        hy = (gyx - axy) * x + (gyy - ayy) * y + (gyz - ayz) * z
        hz = (gzx - axz) * x + (gzy - ayz) * y + (gzz - azz) * z
        kx = (cxx - gxx) * x + (cxy - gyx) * y + (cxz - gzx) * z
        ky = (cxy - gxy) * x + (cyy - gyy) * y + (cyz - gzy) * z
        kz = (cxz - gxz) * x + (cyz - gyz) * y + (czz - gzz) * z
        square = x * x + y * y + z * z
        short = max(SHORT - square, 0.0) / get(s, o + M)
        variance = max(x * (kx - hx) + y * (ky - hy) + z * (kz - hz), noise * square) + short
        over = 1.0 / max(variance, TINY)
        seen = get(s, o + R) - (x * (wx - ux) + y * (wy - uy) + z * (wz - uz))
        dx, dy, dz = hx * over, hy * over, hz * over
        ex, ey, ez = kx * over, ky * over, kz * over
        here = FIRST + (n + 2) * SEGMENT + j * GAIN
        put3(s, here, 1, dx, dy, dz)
        put3(s, here + 3, 1, ex, ey, ez)
        put(s, here + 6, seen * over)
        mx, my, mz = ux + dx * seen, uy + dy * seen, uz + dz * seen
        wx, wy, wz = wx + ex * seen, wy + ey * seen, wz + ez * seen
        axx -= dx * hx
        axy -= dx * hy
        axz -= dx * hz
        ayy -= dy * hy
        ayz -= dy * hz
        azz -= dz * hz
        bxx, bxy, bxz = gxx - dx * kx, gxy - dx * ky, gxz - dx * kz
        byx, byy, byz = gyx - dy * kx, gyy - dy * ky, gyz - dy * kz
        bzx, bzy, bzz = gzx - dz * kx, gzy - dz * ky, gzz - dz * kz
        cxx -= ex * kx
        cxy -= ex * ky
        cxz -= ex * kz
        cyy -= ey * ky
        cyz -= ey * kz
        czz -= ez * kz


@inner
def recall(s, n):
    """From the root to the tip; m, w: the adjoints of the means."""
    zero = spread(s, 0.0)
    mx, my, mz, wx, wy, wz = zero, zero, zero, zero, zero, zero
    for j in range(n):
        o = FIRST + j * SEGMENT
        here = FIRST + (n + 2) * SEGMENT + j * GAIN
        dx, dy, dz = get3(s, here, 1)
        ex, ey, ez = get3(s, here + 3, 1)
        change = get(s, here + 6) + (dx * mx + dy * my + dz * mz) + (ex * wx + ey * wy + ez * wz)
        put(s, o + T, get(s, o + T) + change)
        x, y, z = get3(s, o + E, 1)
        x *= change
        y *= change
        z *= change
        mx += x
        my += y
        mz += z
        p = get(s, o - SEGMENT + N1)
        q = get(s, o - SEGMENT + N2)
        mx, my, mz, wx, wy, wz = (
            p * mx + (wx - x), p * my + (wy - y), p * mz + (wz - z), q * mx, q * my, q * mz,
        )  # fmt: skip
