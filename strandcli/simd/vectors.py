"""Algebra of 3-vectors and 3 × 3 matrices, as tuples of vectors of lanes.

Products of vectors of lanes are fused into the sums in which they are written, so a sum of products stands in one
function: `add_scaled`, not a sum with what `scaled` returns. A symmetric matrix is (xx, xy, xz, yy, yz, zz); any other
matrix is its nine elements by rows.
"""

from __future__ import annotations

from ..jit import inlined
from .lanes import where


@inlined
def dot(a, b):
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def cross(a, b):
    """Return the vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inlined
def less(a, b):
    """Return a − b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@inlined
def add_scaled(a, f, b):
    """Return a + f b."""
    return a[0] + f * b[0], a[1] + f * b[1], a[2] + f * b[2]


@inlined
def select(mask, a, b):
    """Return the 3-vector a where a mask is set, else b."""
    return where(mask, a[0], b[0]), where(mask, a[1], b[1]), where(mask, a[2], b[2])


@inlined
def matrix_product(m, v):
    """Return the product of a matrix by rows and a vector."""
    x, y, z = v
    return m[0] * x + m[1] * y + m[2] * z, m[3] * x + m[4] * y + m[5] * z, m[6] * x + m[7] * y + m[8] * z


@inlined
def symmetric_product(m, v):
    """Return the product of a symmetric matrix and a vector."""
    x, y, z = v
    return m[0] * x + m[1] * y + m[2] * z, m[1] * x + m[3] * y + m[4] * z, m[2] * x + m[4] * y + m[5] * z


@inlined
def less_outer(m, a, b):
    """Return m − a bᵀ for a matrix by rows."""
    x, y, z = b
    return (
        m[0] - a[0] * x, m[1] - a[0] * y, m[2] - a[0] * z,
        m[3] - a[1] * x, m[4] - a[1] * y, m[5] - a[1] * z,
        m[6] - a[2] * x, m[7] - a[2] * y, m[8] - a[2] * z,
    )  # fmt: skip


@inlined
def less_symmetric(m, a, b):
    """Return m − a bᵀ for symmetric matrices m and a bᵀ."""
    x, y, z = b
    return (
        m[0] - a[0] * x, m[1] - a[0] * y, m[2] - a[0] * z,
        m[3] - a[1] * y, m[4] - a[1] * z, m[5] - a[2] * z,
    )  # fmt: skip


@inlined
def sum_of(a, b):
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inlined
def scaled(f, a):
    """Return f a."""
    return f * a[0], f * a[1], f * a[2]


@inlined
def combined(f, a, g, b):
    """Return f a − g b."""
    return f * a[0] - g * b[0], f * a[1] - g * b[1], f * a[2] - g * b[2]
