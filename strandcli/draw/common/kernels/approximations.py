"""Elementary functions for kernels, float32 to float32, with the same bits on every machine.

A C library's exp, acos and so on differ by a unit in the last place from one CPU or library version to the next. These
use only +, −, ×, /, sqrt and integer shifts, which IEEE 754 fixes to the bit, and a compiler without fastmath keeps
their order. The polynomials are minimax fits made for this file (iteratively reweighted least squares in float64), with
a fixed constant term so that acos(1) = 0, asin(0) = 0 and exp2(0) = 1 hold exactly.

Largest errors over dense samples, against float64 (tests/draw/common/test_approximations.py asserts them):

=============  =========================  ==========================================================
function       domain                     error
=============  =========================  ==========================================================
acos, asin     [-1, 1]                    5e-7 rad, absolute
exp2           [-126, 127]                2.5e-7, relative
exp            [-87, 88]                  (3e-7 + 1.5e-7 |x|), relative (the scaling by log2 e rounds)
=============  =========================  ==========================================================

Arguments outside of a domain, infinities and NaN are clamped to it: the result is always finite.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import function, inlined
from ....simd import floor, power_of_two
from .numbers import ONE, ZERO

PI = np.float32(math.pi)
HALF_PI = np.float32(math.pi / 2)
LOG2_E = np.float32(1.0 / math.log(2.0))

# acos(x) = sqrt(1 - x) (A0 + A1 x + ... + A6 x^6) on [0, 1], absolute error 9.8e-8 before rounding
A0 = HALF_PI
A1 = np.float32(-0.21459423)
A2 = np.float32(0.08886588)
A3 = np.float32(-0.04931616)
A4 = np.float32(0.027986748)
A5 = np.float32(-0.012202997)
A6 = np.float32(0.0026794104)

# 2^f = 1 + E1 f + ... + E5 f^5 on [-1/2, 1/2], relative error 9.1e-8 before rounding
E1 = np.float32(0.693147)
E2 = np.float32(0.24022242)
E3 = np.float32(0.055507336)
E4 = np.float32(0.009671513)
E5 = np.float32(0.0013264726)
EXPONENT_LOW = np.float32(-126.0)
EXPONENT_HIGH = np.float32(127.0)
EXPONENT_BIAS = np.float32(127.0)
ROUNDING = np.float32(127.5)  # bias + 1/2, so that truncation rounds to the nearest biased exponent
MANTISSA_BITS = np.int32(23)


@function
def clamp(x: np.float32, low: np.float32, high: np.float32) -> np.float32:
    """Return ``x`` limited to [low, high]. NaN becomes ``high``, so an index from the result is always in range."""
    y = x if x < high else high
    return y if y > low else low


@function
def acos(x: np.float32) -> np.float32:
    """Return the angle in [0, π], in radians, whose cosine is ``x``."""
    a = abs(x)
    a = a if a < ONE else ONE  # in this order NaN becomes 1
    p = (((((A6 * a + A5) * a + A4) * a + A3) * a + A2) * a + A1) * a + A0
    r = np.sqrt(ONE - a) * p
    return r if x >= ZERO else PI - r


@function
def asin(x: np.float32) -> np.float32:
    """Return the angle in [-π/2, π/2], in radians, whose sine is ``x``."""
    a = abs(x)
    a = a if a < ONE else ONE  # in this order NaN becomes 1
    p = (((((A6 * a + A5) * a + A4) * a + A3) * a + A2) * a + A1) * a + A0
    r = HALF_PI - np.sqrt(ONE - a) * p
    return r if x >= ZERO else -r


@function
def exp2(x: np.float32) -> np.float32:
    """Return 2 to the power ``x``: the nearest integer goes into the exponent bits, the rest through a polynomial."""
    y = clamp(x, EXPONENT_LOW, EXPONENT_HIGH)
    biased = np.int32(y + ROUNDING)
    f = y - (np.float32(biased) - EXPONENT_BIAS)
    p = ((((E5 * f + E4) * f + E3) * f + E2) * f + E1) * f + ONE
    scale = np.int32(biased << MANTISSA_BITS).view(np.float32)
    return p * scale


@function
def exp(x: np.float32) -> np.float32:
    """Return e to the power ``x``."""
    return exp2(x * LOG2_E)


@inlined
def exp_lanes(x):
    """Return e to the power of each lane of a vector of float32, to the bit that `exp` gives."""
    return exp2_lanes(x * LOG2_E)


@inlined
def exp2_lanes(x):
    """Return 2 to the power of each lane of a vector of float32, to the bit that `exp2` gives."""
    y = max(EXPONENT_LOW, min(EXPONENT_HIGH, x))
    biased = floor(y + ROUNDING)
    f = y - (biased - EXPONENT_BIAS)
    p = ((((E5 * f + E4) * f + E3) * f + E2) * f + E1) * f + ONE
    return p * power_of_two(biased - EXPONENT_BIAS)
