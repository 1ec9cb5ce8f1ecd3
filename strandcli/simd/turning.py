"""Cosine and sine of vectors of angles by polynomials: those of the C library go number by number, would take most of a
curled strand's step, and differ between machines in the last bit."""

from __future__ import annotations

from typing import Any

from numba import types

from ..jit import inlined
from ..jit.pruned import device_where
from .lanes import floor, where

QUARTERS_A_RADIAN = 0.6366197723675814
"""2 / π."""
QUARTER, QUARTER_REST, QUARTER_LAST = 1.5703125, 4.837512969970703e-4, 7.549789954891882e-8
"""π / 2 in three parts, the first two short enough for whole multiples of them to be exact in single precision."""


def _double(kind: Any) -> bool:
    return bool(kind.dtype == types.float64)


# Taylor's series by Horner's rule: coefficients are 1 over factorials, and twice as many of them in double precision


def _short(q):
    even = 1.0 - q * (0.5 - q * (1.0 / 24 - q * (1.0 / 720 - q * (1.0 / 40320))))
    return even, q * (1.0 / 6 - q * (1.0 / 120 - q * (1.0 / 5040 - q * (1.0 / 362880))))


@device_where(_double, _short)
def _to_an_eighth(q):
    """Cosine of √q and 1 less sine over √q, up to an eighth turn, of which 1e-17 is left out; in single precision
    3e-8."""
    even = q * (-1.0 / 3628800 + q * (1.0 / 479001600 - q * (1.0 / 87178291200 - q * (1.0 / 20922789888000))))
    odd = q * (-1.0 / 39916800 + q * (1.0 / 6227020800 - q * (1.0 / 1307674368000 - q * (1.0 / 355687428096000))))
    return (
        1.0 - q * (0.5 - q * (1.0 / 24 - q * (1.0 / 720 - q * (1.0 / 40320 + even)))),
        q * (1.0 / 6 - q * (1.0 / 120 - q * (1.0 / 5040 - q * (1.0 / 362880 + odd)))),
    )


@inlined
def cosine_sine(angle):
    """Cosine and sine of radians, to the last digits of either precision for some thousand turns.

    By the nearest quarter turn and a series about it."""
    quarters = floor(angle * QUARTERS_A_RADIAN + 0.5)
    rest = angle - quarters * QUARTER
    rest = rest - quarters * QUARTER_REST
    rest = rest - quarters * QUARTER_LAST
    even, odd = _to_an_eighth(rest * rest)
    odd = rest - rest * odd
    # which quarter it is, by the fractions of its number over two and four, compared with what they never are
    half = 0.5 * quarters
    swapped = half - floor(half) > 0.25
    negative = 0.5 * half - floor(0.5 * half) > 0.4  # sine, in the third and the fourth quarter
    fourth = 0.25 * (quarters + 1.0)
    behind = fourth - floor(fourth) > 0.4  # cosine, in the second and the third
    cosine, sine = where(swapped, odd, even), where(swapped, even, odd)
    return where(behind, -cosine, cosine), where(negative, -sine, sine)
